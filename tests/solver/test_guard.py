"""The guard: what it sees, and what it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.ground_line import GroundLine
from sph.scene.schema import Scene
from sph.solver.guard import PARTS, Fault, Trouble, likely_cause, trouble
from sph.solver.initial_state import initial_state
from sph.solver.particles import locate_probes, place_particles
from sph.solver.terms import State

BOXED = {"walls.base": "fixed", "walls.sides": "fixed", "walls.layers": 2}
AT_REST = {name: [0.0, 0.0, 0.0] for name in (*PARTS, "shaking_work")}


def parts(scene: Scene) -> tuple[Any, State]:
    particles = place_particles(scene)
    assert locate_probes(scene, particles)
    return particles, initial_state(particles, scene)


@pytest.fixture
def boxed(free_block: SceneBuilder) -> tuple[Scene, Any, State]:
    scene = free_block(BOXED)
    return scene, *parts(scene)


def test_a_sound_run_is_left_alone(boxed: tuple[Scene, Any, State]) -> None:
    assert trouble(*boxed, AT_REST) is None


@pytest.mark.parametrize("name", ["x", "vy", "density", "ax"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_a_number(boxed: tuple[Scene, Any, State], name: str, value: float) -> None:
    getattr(boxed[2], name)[37] = value
    found = trouble(*boxed, AT_REST)
    assert found is not None and (found.fault, found.particle) == (Fault.NOT_A_NUMBER, 37)
    assert str(found).startswith("particle 37, at first at (") and str(found).endswith(" m, is not a number")


def test_a_particle_is_named_by_its_place_in_the_survey(boxed: tuple[Scene, Any, State]) -> None:
    scene, particles, state = boxed
    state.x[37] = np.nan
    ground = GroundLine(
        shape="ground_line", points=((400.0, 60.0), (405.0, 60.0), (410.0, 55.0), (420.0, 55.0)), base=50.0, downhill="right"
    )
    found = trouble(scene.model_copy(update={"geometry": ground}), particles, state, AT_REST)
    assert found is not None and found.place == pytest.approx((420.0 - particles.x[37], 50.0 + particles.y[37]))


def test_a_jump_names_the_particle_that_moved_furthest(boxed: tuple[Scene, Any, State]) -> None:
    boxed[2].x[[3, 41]] += (0.1, 0.4)
    found = trouble(*boxed, AT_REST, jumped=True)
    assert found is not None and (found.fault, found.particle) == (Fault.JUMPED, 41)
    assert trouble(*boxed, AT_REST) is None


def test_faster_than_the_p_wave(boxed: tuple[Scene, Any, State]) -> None:
    speed = boxed[0].soil.p_wave_speed
    boxed[2].vx[12] = 0.9 * speed
    assert trouble(*boxed, AT_REST) is None
    boxed[2].vy[12] = -0.9 * speed
    found = trouble(*boxed, AT_REST)
    assert found is not None and found[:3] == (Fault.TOO_FAST, speed, 12)
    assert str(found).endswith(f"is faster than V_p, {speed:.0f} m/s")


@pytest.mark.parametrize(
    ("place", "outside"),
    [
        ((5.0, -1.9), False),  # among the base's two layers of 1 m
        ((5.0, -2.1), True),
        ((-1.9, 5.0), False),
        ((-2.1, 5.0), True),
        ((12.1, 5.0), True),
        ((12.1, 30.0), False),  # thrown over the wall, which is 10 m high
        ((12.1, -5.0), True),
        ((5.0, 99.0), False),
    ],
)
def test_behind_the_walls(boxed: tuple[Scene, Any, State], place: tuple[float, float], outside: bool) -> None:
    boxed[2].x[7], boxed[2].y[7] = place
    found = trouble(*boxed, AT_REST)
    assert (found and (found.fault, found.particle)) == ((Fault.LEFT_THE_BOX, 7) if outside else None)


def test_soil_that_ran_off_an_open_end(free_block: SceneBuilder) -> None:
    scene = free_block(BOXED | {"walls.sides": "none"})
    particles, state = parts(scene)
    state.x[7], state.y[7] = 15.0, -1.9
    assert trouble(scene, particles, state, AT_REST) is None, "over the edge, not yet below the base"
    state.y[7] = -2.1
    found = trouble(scene, particles, state, AT_REST)
    assert found is not None and found.fault == Fault.LEFT_THE_BOX and str(found).endswith("has left the box")


def test_without_walls_nothing_is_behind_them(free_block: SceneBuilder) -> None:
    scene = free_block({})
    particles, state = parts(scene)
    state.x[7], state.y[7] = -500.0, -500.0
    assert trouble(scene, particles, state, AT_REST) is None


def test_energy_that_nobody_put_in(boxed: tuple[Scene, Any, State]) -> None:
    # 100 cells of 1964 kg at 1.16 m/s are 0.13 MJ: below that nothing is judged.
    def series(**energies: float) -> dict[str, list[float]]:
        return {name: [0.0, 0.0, energies.get(name, 0.0)] for name in AT_REST}

    put_in = {"kinetic_energy": 4e6, "dissipated_energy": 1e6, "shaking_work": 5e6}
    assert trouble(*boxed, series(**put_in)) is None
    assert "budget is open by 40%" in str(trouble(*boxed, series(**put_in | {"shaking_work": 3e6})))
    made = {"kinetic_energy": 5e6, "dissipated_energy": -3e6, "shaking_work": 2e6}
    assert "energy was made" in str(trouble(*boxed, series(**made)))
    assert trouble(*boxed, series(kinetic_energy=1e4)) is None, "a small gap in a run at rest"


@pytest.mark.parametrize(
    ("ratio", "keys", "wrong", "word"),
    [
        (1.3, {}, Fault.LEFT_THE_BOX, "1.30 times its measured limit"),
        (0.9, {"numerics.artificial_viscosity": None}, Fault.NOT_A_NUMBER, "artificial viscosity"),
        (0.9, {"numerics.artificial_viscosity": None}, Fault.LEFT_THE_BOX, "widen the box"),
        (0.9, {}, Fault.NOT_A_NUMBER, "finer spacing"),
    ],
)
def test_the_likely_cause(free_block: SceneBuilder, ratio: float, keys: dict[str, Any], wrong: Fault, word: str) -> None:
    assert word in likely_cause(free_block(keys), ratio, Trouble(wrong))
