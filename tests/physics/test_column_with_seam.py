"""A seam as strong as the soil changes nothing: a column under gravity, between sides that it meets."""

from __future__ import annotations

import numpy as np
import pytest
from small_scenes import NOTHING

from sph.scene.schema import make_scene
from sph.solver.run import run

THROUGH, BESIDE = [[-5.0, 10.0], [25.0, 10.0]], [[-1.0, 19.9], [0.1, 19.9]]
"""Lines of a seam, one of which cuts off no particle: the soil is then without a seam and has the terms of a block on one."""


def settled(line: list[list[float]]) -> tuple[float, np.ndarray]:
    """Settlement of the top (m) and horizontal stress of the soil (n,) further than 3 spacings from the sides, Pa."""
    scene = make_scene(
        {
            "name": "column",
            "duration": 3.0,
            "geometry": {"shape": "block", "width": 20.0, "height": 20.0},
            "walls": {"base": "no_slip", "sides": "free_slip"},
            "soil": {"density": 2000, "youngs_modulus": 2e5, "poisson_ratio": 0.3, "cohesion": 5000, "friction_angle": 30, "viscosity": 2},
            "seams": {"seam": {"points": line, "cohesion": 5000.0, "friction_angle": 30.0}},
            "coupling": {"S_R": 1.0, "gamma": 0.0},
            "damping": NOTHING["damping"],
            "numerics": {"spacing": 1.0},
            "probes": {"A": [10.0, 19.5]},
        }
    )
    data = run(scene).trajectory
    inner = (data["kind"].values == 0) & (np.abs(data["x0"].values - 10.0) < 7.0)
    return float(data["probe_displacement_y"][-1, 0]), data["stress_xx"].values[-1][inner]


@pytest.mark.long
def test_a_strong_level_seam_changes_nothing() -> None:
    (without, stress), (with_it, seamed) = settled(BESIDE), settled(THROUGH)
    np.testing.assert_allclose(with_it, without, rtol=0.01)
    np.testing.assert_allclose(seamed, stress, atol=0.1 * np.abs(stress).mean())
