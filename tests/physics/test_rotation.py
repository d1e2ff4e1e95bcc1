"""A free elastic block that turns as a rigid body: nothing but its inertia strains it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from small_scenes import NOTHING

from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.simulation import Simulation

pytestmark = pytest.mark.long

WIDTH, DENSITY, RATE = 12.0, 1964.0, 1.0
"""Width and height (m), density (kg/m3) and angular velocity (1/s) of the block."""
TURN = 1.6
"""Angle that it turns by, about a right one."""
BOX: dict[str, Any] = {
    "geometry": {
        "shape": "bodies",
        "width": 3.0 * WIDTH,
        "height": 3.0 * WIDTH,
        "bodies": [{"kind": "polygon", "points": [[WIDTH * x, WIDTH * y] for x, y in ((1, 1), (2, 1), (2, 2), (1, 2))]}],
    },
    "numerics": {"short_range_repulsion": {}},
}
"""Walls that the block never feels, and a repulsion for which no particles come near enough."""
PAPER = merge(
    BOX, {"scheme": "paper", "walls": {"base": "fixed"}, "numerics": {"artificial_viscosity": {"alpha": 0.0}, "smoothing_ratio": 1.3}}
)
"""The terms of the spin with corrected gradients in ``test_conservation.py``."""
BESIDE_A_SEAM = merge(
    BOX,
    {
        "walls": {"base": "no_slip", "sides": "free_slip"},
        "seams": {"seam": {"points": [[WIDTH - 1.0, WIDTH + 0.1], [WIDTH + 0.1, WIDTH + 0.1]], "cohesion": 1.0, "friction_angle": 0.0}},
    },
)
"""The terms of ``test_block_on_seam.py``, by a seam that cuts off no particle."""


class Turned(NamedTuple):
    """After the turn, over the values before it, and the largest stress on the way over that of inertia, rho (omega R)^2 / 2."""

    momentum: float
    energy: float
    stress: float
    radius: tuple[float, float]


def turn(stiffness: float, changes: dict[str, Any]) -> Turned:
    """Turn the block, of a Young's modulus in MPa, with changes to the scene."""
    scene = make_scene(
        merge(
            {
                "name": "turning",
                "duration": TURN / RATE,
                "geometry": {"shape": "block", "width": WIDTH, "height": WIDTH},
                "walls": {"base": "none", "sides": "none"},
                "soil": {
                    "density": DENSITY,
                    "youngs_modulus": 1e3 * stiffness,
                    "poisson_ratio": 0.346,
                    "cohesion": 1e6,
                    "friction_angle": 0.0,
                    "viscosity": 2.0,
                },
                "coupling": {"S_R": 0.5, "gamma": 1.0},
                "damping": NOTHING["damping"],
                "gravity": {"acceleration": 0.0, "ramp": 0.0, "duration": 0.01, "damping": 0.0},
                "numerics": {"spacing": 1.0, "time_step": 5e-4, "adaptive_step": None, "short_range_repulsion": None},
                "probes": {},
                "outputs": {"frame_interval": TURN / RATE, "series_interval": 0.01},
            },
            changes,
        )
    )
    simulation = Simulation(scene)
    simulation.prepare()
    state, soil = simulation.state, slice(simulation.particles.n_soil)
    mass = simulation.particles.mass[soil]

    def seen() -> tuple[float, float, np.ndarray]:
        x, y = state.x[soil] - state.x[soil].mean(), state.y[soil] - state.y[soil].mean()
        vx, vy = state.vx[soil], state.vy[soil]
        return float((mass * (x * vy - y * vx)).sum()), float(0.5 * (mass * (vx**2 + vy**2)).sum()), np.hypot(x, y)

    state.vx[soil] = -RATE * (state.y[soil] - state.y[soil].mean())
    state.vy[soil] = RATE * (state.x[soil] - state.x[soil].mean())
    momentum, energy, radius = seen()
    stress = 0.0
    for _ in range(scene.steps(scene.duration) // 50):
        simulation.advance_steps(50)
        stress = max(stress, float(np.abs(simulation.cauchy_stress()[soil]).max()))
    after = seen()
    ratio = after[2] / radius
    inertia = 0.5 * DENSITY * (RATE * 0.5 * WIDTH) ** 2
    return Turned(after[0] / momentum, after[1] / energy, stress / inertia, (float(ratio.min()), float(ratio.max())))


@pytest.mark.parametrize("reference", ["initial", "current"])
@pytest.mark.parametrize("stiffness", [20.0, 1675.0])
def test_a_block_turns_as_a_rigid_body_with_corrected_gradients(stiffness: float, reference: str) -> None:
    # Its stress is that of its inertia: rho (omega a)^2 / 2 in the middle of a strip that turns steadily, and twice that here, since the
    # block starts without stress and swings.  A quarter more is allowed; plain gradients have hundreds of times as much.
    corrected = {"numerics": {"reference": reference, "gradient_correction": {"min_determinant": 0.05}}}
    turned = turn(stiffness, merge(PAPER if reference == "current" else {}, corrected))
    assert turned.momentum == pytest.approx(1.0, abs=0.005) and turned.energy == pytest.approx(1.0, abs=0.005)
    assert turned.stress < 2.5
    assert turned.radius == (pytest.approx(1.0, abs=0.005), pytest.approx(1.0, abs=0.005))


@pytest.mark.xfail(strict=True, reason="plain gradients take a free surface that turns for one that is sheared: docs/model/limits.md")
def test_a_block_turns_as_a_rigid_body_with_plain_gradients() -> None:
    turned = turn(1675.0, BESIDE_A_SEAM)
    assert turned.momentum == pytest.approx(1.0, abs=0.05) and turned.stress < 2.5
