"""Strength below water: soil that slides on its base with the friction of effective stress, and geostatic stress that stays."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_scenes import NOTHING

from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.run import run

FRICTION, G = 20.0, 9.81
LAYER: dict[str, Any] = {
    "name": "layer",
    "duration": 0.25,
    "geometry": {"shape": "block", "width": 0.2, "height": 0.05},
    "walls": {"base": "no_slip", "sides": "periodic"},
    "soil": {
        "density": 2000.0,
        "youngs_modulus": 840.0,
        "poisson_ratio": 0.3,
        "cohesion": 0.0,
        "friction_angle": FRICTION,
        "viscosity": 0.0,
    },
    "coupling": {"S_R": 1.0, "gamma": 100.0, "initial_state": "fluid"},
    "gravity": {"ramp": 0.0, "duration": 0.01, "damping": 0.0, "initial_stress": "geostatic"},
    "damping": NOTHING["damping"],
    "initial_velocity": {"along": "y", "position": [0.0], "x": [1.0], "y": [0.0]},
    "numerics": {"spacing": 0.005, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
}
"""Failed soil that moves on its base at 1 m/s."""
WATER: dict[str, dict[str, Any]] = {
    "ratio by place": {"pressure": "by_place", "r_u": 0.5},
    "ratio carried": {"pressure": "carried", "r_u": 0.5},
    "level by place": {"pressure": "by_place", "level": 0.05},
    "standing": {"pressure": "by_place", "level": 0.08},
}
EFFECTIVE = {
    "ratio by place": 0.5,
    "ratio carried": 0.5,
    "level by place": 1.0 - 9810.0 / (2000.0 * G),
    "standing": 1.0 - 9810.0 / (2000.0 * G),
}
"""Effective over total weight."""


def deceleration(water: dict[str, Any]) -> float:
    """Of the failed layer between 0.1 and 0.2 s, m/s2.

    Soil below the base, where there is none, makes the terms those of ``test_weak_on_strong.py``, by place those of ``test_at_rest.py``.
    """
    below = {"region": {"kind": "elevation", "top": -1.0}, "soil": {"cohesion": 1.0 if water["pressure"] == "carried" else 0.0}}
    ds = run(make_scene(merge(LAYER, {"water": water, "layers": {"below": below}}))).trajectory
    soil = ds["kind"].values == 0
    speed = ds["velocity_x"].values[:, soil].astype(float).mean(axis=1)
    first, last = (int(np.searchsorted(ds["time"].values, time - 1e-9)) for time in (0.1, 0.2))
    return float((speed[first] - speed[last]) / (ds["time"].values[last] - ds["time"].values[first]))


@pytest.mark.long
@pytest.mark.parametrize("kind", WATER)
def test_failed_soil_slides_with_the_friction_of_effective_stress(kind: str) -> None:
    # Soil that does not dilate mobilises sin(phi) on the plane along which it is sheared (V8): 10 %, as there.
    assert deceleration(WATER[kind]) == pytest.approx(EFFECTIVE[kind] * G * math.sin(math.radians(FRICTION)), rel=0.10)


@pytest.mark.uncompiled
@pytest.mark.long
@pytest.mark.parametrize("pressure", ["by_place", "carried"])
def test_geostatic_effective_stress_stays(pressure: str) -> None:
    # Level ground is in equilibrium under it with either kind of pressure, while waves pass it five times.  Rows alternate by some per
    # cent (V1).
    block: dict[str, Any] = {
        "name": "column",
        "scheme": "paper",
        "duration": 0.2,
        "geometry": {"shape": "block", "width": 4.0, "height": 20.0},
        "walls": {"base": "fixed", "sides": "free_slip", "layers": 3},
        "soil": {"density": 2000.0, "cohesion": 1e5},
        "gravity": {"ramp": 0.0, "duration": 0.1, "initial_stress": "geostatic"},
        "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 5e-4},
        "outputs": {"frame_interval": 0.05},
    }
    ds = run(make_scene(merge(block, {"water": {"pressure": pressure, "level": 20.0}})), until="gravity").trajectory
    soil = ds["kind"].values == 0
    depth = 20.0 - ds["y0"].values[soil]
    inner = (depth > 5.0) & (depth < 15.0)
    effective = (2000.0 * G - 9810.0) * depth[inner]
    for frame in (0, -1):
        np.testing.assert_allclose(-ds["stress_yy"].values[frame, soil][inner], effective, rtol=0.05)
