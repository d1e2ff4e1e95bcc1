"""Small scenes shared by the solver's tests, built through ``make_scene`` like any other."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings

from sph.configuration import dotted, merge
from sph.scene import Scene, make_scene

# On CI the same examples every time, so that a red run is the change's fault; elsewhere hypothesis explores.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

SceneBuilder = Callable[[dict[str, Any]], Scene]

SLOPE: dict[str, Any] = {
    "name": "small_slope",
    "duration": 3.0,
    "geometry": {"shape": "slope"},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "amplitude": 8.0, "start": 1.0, "ramp": 0.5, "decay_start": 2.0, "end": 2.5},
    "numerics": {"spacing": 5.0, "time_step": 1e-3},
    "outputs": {"frame_interval": 0.25, "series_interval": 0.01},
}
"""The paper's slope with 163 particles, shaken to failure within three seconds."""

FREE_BLOCK: dict[str, Any] = {
    "name": "free_block",
    "duration": 1.0,
    "geometry": {"shape": "block", "width": 10.0, "height": 10.0},
    "walls": {"base": "none", "sides": "none"},
    "soil": {"cohesion": 1e6},
    "gravity": {"acceleration": 0.0, "ramp": 0.0, "duration": 0.01, "damping": 0.0},
    "numerics": {"spacing": 1.0, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
}
"""A block that floats: no walls, no gravity, too strong to yield."""


@pytest.fixture(scope="session")
def small_slope() -> SceneBuilder:
    """Builder of ``SLOPE`` with dotted overrides."""
    return lambda overrides: make_scene(merge(SLOPE, dotted(overrides)))


@pytest.fixture(scope="session")
def free_block() -> SceneBuilder:
    """Builder of ``FREE_BLOCK`` with dotted overrides."""
    return lambda overrides: make_scene(merge(FREE_BLOCK, dotted(overrides)))
