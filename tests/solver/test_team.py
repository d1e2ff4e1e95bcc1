"""Threads that share a scene: they meet, they cover every row once, and their number does not change a bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comparison import VARIANTS, same_bits
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import SceneBuilder

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.threads import BLOCK, make_team, own_blocks, together, wait
from sph.solver.integration import advance
from sph.solver.run import Result, run
from sph.solver.simulation import Simulation
from sph.storage import trajectory


@jit
def exchange(board, rounds, team):  # type: ignore[no-untyped-def]
    """Write the round's number, meet, read everybody's, meet; how often another number stood there."""
    wrong = 0
    for number in range(1, rounds + 1):
        board[team.rank] = number
        wait(team)
        for rank in range(team.size):
            wrong += board[rank] != number
        wait(team)
    return wrong


@pytest.mark.parametrize("size", [2, 3, pytest.param(5, marks=pytest.mark.long)])
def test_threads_meet(size: int) -> None:
    # Also with more threads than cores, where a waiting thread must let others run.
    team = make_team(size, 1, 1)
    for _ in range(3):
        assert together(exchange, team, np.zeros(size, np.int64), 2000) == [0] * size


def test_one_thread_passes_without_a_look_at_the_barrier() -> None:
    team = make_team(1, 1, 1)
    assert together(exchange, team, np.zeros(1, np.int64), 10) == [0]
    assert not team[0].barrier.any()


@given(size=st.integers(1, 20), n=st.integers(1, 20 * BLOCK))
def test_every_block_is_taken_once(size: int, n: int) -> None:
    team = make_team(size, n, 1)
    taken = [block for member in team for block in range(*own_blocks(member))]
    assert taken == list(range(-(-n // BLOCK)))


# ---------------------------------------------------------------- a scene of several blocks

MANY_BLOCKS = {
    "numerics.spacing": 1.4,
    "numerics.smoothing_ratio": 1.3,
    "duration": 2.0,
    "coupling.S_R": 0.1,
    "coupling.gamma": 100.0,
}


def many_blocks(small_slope: SceneBuilder, overrides: dict[str, Any]) -> Scene:
    """A slope of at least five blocks of rows, shaken until some of it fails."""
    return small_slope(MANY_BLOCKS | overrides)


@pytest.fixture(scope="module")
def alone(small_slope: SceneBuilder) -> Result:
    """By one thread."""
    return run(many_blocks(small_slope, {}), threads=1)


OTHERS = sorted(VARIANTS.keys() - {"default", "at rest"})
"""What has other code than the default."""


@pytest.mark.parametrize("variant", ["default", *(pytest.param(name, marks=pytest.mark.long) for name in OTHERS)])
def test_number_of_threads_does_not_change_a_bit(small_slope: SceneBuilder, alone: Result, variant: str) -> None:
    scene = many_blocks(small_slope, VARIANTS[variant])
    one = alone if variant == "default" else run(scene, threads=1)
    assert one.trajectory.sizes["particle"] > 4 * BLOCK
    assert 0.1 < float(one.trajectory["failed_fraction"][-1]) < 0.9, "failed and unfailed rows for the test to mean something"
    for threads in (2, 3) if variant == "default" else (3,):
        same_bits(one, run(scene, threads=threads))


@pytest.mark.parametrize(("first", "second"), [(3, 2), pytest.param(1, 3, marks=pytest.mark.long)])
def test_a_run_goes_on_with_another_number_of_threads(
    tmp_path: Path, small_slope: SceneBuilder, alone: Result, first: int, second: int
) -> None:
    paused = run(many_blocks(small_slope, {}), until="first_failure", threads=first)
    assert paused.status == "paused"
    trajectory.write(tmp_path / "paused.nc", paused.trajectory, paused.restart)
    same_bits(alone, run(many_blocks(small_slope, {}), restart=tmp_path / "paused.nc", threads=second))


@pytest.mark.parametrize("row", [0, 2 * BLOCK + 17, 4 * BLOCK + 3], ids=["first thread", "second thread", "third thread"])
def test_not_a_number_in_one_threads_rows_stops_all(small_slope: SceneBuilder, row: int) -> None:
    simulation = Simulation(many_blocks(small_slope, {}), threads=3)
    simulation.prepare()
    assert row < simulation.particles.n_soil
    owner = next(m.rank for m in simulation.team if own_blocks(m)[0] <= row // BLOCK < own_blocks(m)[1])
    assert owner == min(row // BLOCK // 2, 2)
    simulation.state.vy[row] = np.nan
    results = together(
        advance, simulation.team, simulation.state, simulation.candidates, simulation.pairs, simulation.terms,
        simulation.particles.mass, simulation.loading, 0, 50, False,
    )  # fmt: skip
    assert [(done, spent) for _, done, spent, _ in results] == [(0, False)] * 3
