"""A search as a file: its trials along ``trial``; bracket, scene and versions in the attributes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from sph import trajectory
from sph.scene import Scene, make_scene
from sph.stability.safety import critical_strength_ratio, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial

SEARCHES: dict[str, Callable[..., Search]] = {
    "factor_of_safety": factor_of_safety,
    "critical_strength_ratio": critical_strength_ratio,
    "yield_acceleration": yield_acceleration,
}
"""What can be searched for, by name."""


def run_search(scene: Mapping[str, Any], by: str, report: Callable[[Trial], None] | None = None) -> xr.Dataset:
    """Search the limit of a scene by one of ``SEARCHES``; a limit that does not exist is NaN, with the reason in the attributes."""
    built = make_scene(scene)
    try:
        found, reason = SEARCHES[by](built, report=report), ""
    except ValueError as error:
        found, reason = Search(math.nan, math.nan, ()), str(error)
    return search_dataset(built, by, found, reason)


def search_dataset(scene: Scene, by: str, found: Search, reason: str = "") -> xr.Dataset:
    """The trials of a search."""
    columns = {name: ("trial", np.array([getattr(trial, name) for trial in found.trials])) for name in Trial._fields}
    columns["stands"] = ("trial", columns["stands"][1].astype("int8"))
    cost = math.fsum(trial.wall_time for trial in found.trials)
    facts = {"by": by, "stood": found.stood, "failed": found.failed, "value": found.value, "reason": reason, "wall_time_s": cost}
    return xr.Dataset(columns, attrs=trajectory.run_attributes(scene) | facts)
