"""Small scenes shared by the solver's tests, built through ``make_scene`` like any other."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings
from small_scenes import FREE_BLOCK, SLOPE

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene

# On CI the same examples every time, so that a red run is the change's fault; elsewhere hypothesis explores.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

SceneBuilder = Callable[[dict[str, Any]], Scene]


@pytest.fixture(scope="session")
def small_slope() -> SceneBuilder:
    """Builder of ``SLOPE`` with dotted overrides."""
    return lambda overrides: make_scene(merge(SLOPE, dotted(overrides)))


@pytest.fixture(scope="session")
def free_block() -> SceneBuilder:
    """Builder of ``FREE_BLOCK`` with dotted overrides."""
    return lambda overrides: make_scene(merge(FREE_BLOCK, dotted(overrides)))
