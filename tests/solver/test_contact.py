"""Contact walls: soil may leave them, lies on them as on a no-slip wall, and slides as its own strength allows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.measures.metrics import MetricSettings, measure
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.gradient_correction import power
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.renewal import make_lists
from sph.solver.run import run
from sph.solver.terms import make_terms, only

BOX: dict[str, Any] = {
    "scheme": "paper",
    "name": "box",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 8.0, "height": 6.0},
    "walls": {"base": "contact", "sides": "contact", "top": "contact"},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "precision": "double"},
}


def box(**overrides: Any) -> Scene:
    return make_scene(merge(BOX, dotted({name.replace("__", "."): value for name, value in overrides.items()})))


@pytest.mark.uncompiled
@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.3}], ids=["plain", "corrected"])
@pytest.mark.parametrize("top", ["contact", "no_slip"])
def test_contact_takes_no_energy_whoever_is_let_go(top: str, correction: dict[str, float] | None) -> None:
    scene = box(walls__top=top, numerics__gradient_correction=correction)
    particles = place_particles(scene)
    state, terms, n = initial_state(particles, scene), make_terms(scene, particles), particles.n_soil
    generator = np.random.default_rng(5)
    for name in ("vx", "vy", "sxx", "syy", "sxy", "syx"):
        getattr(state, name)[:n] = generator.normal(size=n)
    if correction is None:
        state.syx[:] = state.sxy
    pairs: Any = make_lists(state, terms)[1]
    gradient = np.zeros((4, state.x.size))
    plain = only(terms, "gradient_correction", "no_slip", "contact")
    velocity_gradients(state, pairs, plain, gradient, 0, state.x.size)
    stress_accelerations(state, pairs, plain, gradient, 0, n)
    touching = np.hypot(pairs.contact[:n, 0], pairs.contact[:n, 1]) > 0.0
    gone = pairs.contact[:n, 2] > 0.0
    assert 0 < gone.sum() < touching.sum() and not gone[~touching].any()
    forces = terms.cell_mass * sum(float(a[:n] @ v[:n]) for a, v in ((state.ax, state.vx), (state.ay, state.vy)))
    stresses = terms.cell_mass * sum(power(terms.gradient_correction, state, gradient, i) for i in range(n))
    assert abs(forces) > 1.0
    assert forces + stresses == pytest.approx(0.0, abs=1e-11 * abs(forces))


@pytest.mark.uncompiled
@pytest.mark.parametrize(
    ("stress", "velocity", "tension", "leaves"),
    [
        (1.0, 1.0, 0.0, True),  # pulled, and moving up
        (1.0, -1.0, 0.0, False),  # pulled, but coming down
        (-1.0, 1.0, 0.0, False),  # pressed
        (1.0, 1.0, 1.01, False),  # pulled by less than the wall bears
        (1.0, 1.0, 0.99, True),
    ],
)
def test_the_wall_lets_go_of_what_it_would_pull(stress: float, velocity: float, tension: float, leaves: bool) -> None:
    # A stress of so many kPa, and a velocity away from the base.
    scene = box(walls__sides="none", walls__top="none", walls__tension=tension)
    particles = place_particles(scene)
    state, terms, n = initial_state(particles, scene), make_terms(scene, particles), particles.n_soil
    state.syy[:n] = 1e3 * stress / scene.soil.density**2
    state.vy[:n] = velocity
    pairs: Any = make_lists(state, terms)[1]
    plain = only(terms, "no_slip", "contact")
    velocity_gradients(state, pairs, plain, np.zeros((4, state.x.size)), 0, state.x.size)
    stress_accelerations(state, pairs, plain, np.zeros((3, state.x.size)), 0, n)
    lowest = (state.y[:n] < 1.0) & (np.abs(state.x[:n] - 4.0) < 1.0)
    assert np.all(pairs.contact[:n, 2][lowest] == float(leaves))
    # Bonded, constant stress is in equilibrium there; let go, the free surface pulls upwards.
    unit = 1e3 / scene.soil.density**2 * np.abs(pairs.wall).max()
    assert np.all((state.ay[:n][lowest] > 0.1 * unit) == leaves)


def thrown(base: str) -> float:
    """How high (m) a block rises that starts upwards from a base at 2 m/s."""
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "thrown",
            "duration": 0.2,
            "geometry": {"shape": "bodies", "width": 8.0, "height": 6.0, "bodies": [{"kind": "polygon", "points": BLOCK}]},
            "walls": {"base": base, "sides": "none"},
            "soil": {"cohesion": 1e4, "youngs_modulus": 5e3},
            "gravity": {"ramp": 0.0, "duration": 0.01, "damping": 0.0},
            "initial_velocity": {"along": "y", "position": [0.0], "x": [0.0], "y": [2.0]},
            "numerics": {"spacing": 0.5, "smoothing_ratio": 1.3, "time_step": 5e-4},
            "outputs": {"frame_interval": 0.1, "series_interval": 0.01},
        }
    )
    trajectory = run(scene).trajectory
    soil = trajectory["kind"].values == 0
    y = trajectory["y"].values[:, soil].astype(float)
    # Letting go costs at most the power of a step: 1.6, 0.75 and 0.36 % at 1e-3, 5e-4 and 2.5e-4 s.
    assert measure(trajectory, MetricSettings())["energy_error"] < 0.01
    return float((y[-1] - y[0]).mean())


BLOCK = [[2.0, 0.0], [6.0, 0.0], [6.0, 3.0], [2.0, 3.0]]


@pytest.mark.long
def test_a_block_leaves_a_contact_base_and_hangs_on_a_bonded_one() -> None:
    # The wall holds the block for the first step, and what it stretches by then goes on as a vibration.
    free = 2.0 * 0.2 - 0.5 * 9.81 * 0.2**2
    assert thrown("contact") == pytest.approx(free, rel=0.1)
    assert thrown("no_slip") < 0.5 * free


def test_a_tension_without_contact_walls_is_refused() -> None:
    with pytest.raises(ValueError, match=r"walls\.tension: 2\.0 kPa .*contact"):
        box(walls={"base": "no_slip", "sides": "none", "top": "none", "tension": 2.0})
