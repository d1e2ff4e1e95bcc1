"""What a case measures on: the results of one level, and numbers found beside their references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sph.scene.schema import Scene
from sph.solver.particles import SOIL
from sph.storage import trajectory


class Result(NamedTuple):
    """What one run left: its scene, its trajectory or the trials of its search, and its restart state where it has one."""

    scene: Scene
    data: xr.Dataset
    restart: xr.Dataset | None = None

    @property
    def soil(self) -> np.ndarray:
        """Mask (particles,) of the soil."""
        return self.data["kind"].values == SOIL

    def frame(self, name: str, frame: int = -1) -> np.ndarray:
        """Values of the soil (n,) in a frame, double precision."""
        return self.data[name].values[frame, self.soil].astype(float)

    def start(self, name: str) -> np.ndarray:
        """Initial ``x0`` or ``y0``, or ``mass``, of the soil (n,)."""
        return self.data[name].values[self.soil]


Level = Mapping[str, Result]
"""The results of a level, by the name of the run."""


class Found(NamedTuple):
    """A number beside its reference."""

    text: str
    units: str
    computed: float
    reference: float

    @property
    def error(self) -> float:
        """Difference over the reference; where that is zero the difference."""
        return (self.computed - self.reference) / (abs(self.reference) or 1.0)


Measure = Callable[[Level], dict[str, Found]]
Draw = Callable[[Mapping[str, Level]], Figure]
"""Draws a case from its levels, by label, from coarse to fine."""


def read_result(path: Path | str) -> Result:
    """Result of a run from its trajectory; ValueError names a file that is not one."""
    data = trajectory.read(path)
    return Result(trajectory.scene_of(data, str(path)), data, trajectory.read_restart(path))
