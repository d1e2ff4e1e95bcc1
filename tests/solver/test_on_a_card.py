"""Whole runs on a graphics card against the processor's solver; skipped, with the reason, on a machine without one.

``pytest -n 4 --dist load tests/solver/test_on_a_card.py`` with the extra ``cuda``; takes minutes, most of them to compile.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from comparison import VARIANTS, same_bits
from small_scenes import SLOPE

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.backends import run_many
from sph.solver.cuda import ensemble
from sph.solver.run import Result, Run, run
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED


def why_not() -> str:
    """Why nothing can be run on a card here; empty where it can."""
    try:
        ensemble.card()
    except ValueError as error:
        return str(error)
    return "numba's simulator is no card" if ensemble.simulated() else ""


pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not() or "a card is there")


def scene_of(changes: dict[str, Any]) -> Scene:
    """A slope of some hundreds of particles."""
    return make_scene(merge(SLOPE, dotted({"numerics.spacing": 3.0, "numerics.time_step": 5e-4} | changes)))


def perturbed(scene: Scene) -> Result:
    """The run on the processor from velocities of 1e-12 m/s: how far apart runs of the same physics come."""
    started = Run(scene)
    generator = np.random.default_rng(1)
    soil = slice(0, started.simulation.particles.n_soil)
    started.simulation.state.vx[soil] += 1e-12 * generator.normal(size=started.simulation.particles.n_soil)
    return started.go()


def apart(one: Result, other: Result) -> float:
    """Largest distance of a particle at any frame, m."""
    x, y = (np.abs(one.stored[name].values - other.stored[name].values).max() for name in ("x", "y"))
    return float(max(x, y))


@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_whole_runs_are_those_of_the_processor(precision: str) -> None:
    scenes = [
        scene_of({"coupling.S_R": strength, "motion.amplitude": amplitude, "numerics.precision": precision})
        for strength in (0.1, 0.5, 0.9)
        for amplitude in (4.0, 8.0)
    ]
    for scene, on_card in zip(scenes, run_many(scenes), strict=True):
        by_processor = run(scene)
        assert on_card.status == by_processor.status
        allowed = 1e-6 + 10.0 * apart(perturbed(scene), by_processor)
        assert apart(on_card, by_processor) <= allowed
        if allowed < 2e-6:
            phases = [result.stored_restart["phase"].values for result in (on_card, by_processor)]
            assert np.array_equal(*phases)


def test_bits_repeat_whatever_runs_beside() -> None:
    scene, other = scene_of({"duration": 2.0}), scene_of({"duration": 1.5, "coupling.S_R": 0.1})
    first, second, _ = run_many([scene, scene, other])
    (alone,) = run_many([scene])
    same_bits(first, second)
    same_bits(first, alone)


@pytest.mark.parametrize("variant", VARIANTS)
def test_terms_on_a_card(variant: str) -> None:
    scene = scene_of(VARIANTS[variant] | {"duration": 1.3})
    (on_card,), by_processor = run_many([scene]), run(scene)
    assert apart(on_card, by_processor) <= 1e-6 + 10.0 * apart(perturbed(scene), by_processor)


def test_a_run_of_many_blocks() -> None:
    # More rows than threads fit: blocks meet, and a thread takes several rows.
    scene = scene_of({"numerics.spacing": 0.27, "numerics.time_step": 5e-5})
    on = ensemble.Ensemble(1)
    made: list[Simulation] = [on.simulation(scene, enforce_limit=False), Simulation(scene, enforce_limit=False)]
    for simulation in made:
        simulation.prepare()
        soil = np.arange(simulation.particles.n_soil)
        simulation.state.vx[soil] = np.sin(0.01 * soil)
        assert simulation.advance_steps(400)[1] == 400
    assert on.renewed.all() and not (made[0].state.phase == FAILED).any()
    assert made[0].state.x.size > 20_000
    assert np.abs(made[0].state.x - made[1].state.x).max() < 1e-9
