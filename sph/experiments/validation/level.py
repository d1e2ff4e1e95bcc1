"""What a case measures on: the results of one level, and numbers found beside their references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
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


class Kind(StrEnum):
    """What a quantity is a number of, by which rows of the table are chosen."""

    AMPLIFICATION = "amplification"
    ANGLE = "angle"
    CRITICAL_AMPLITUDE = "critical_amplitude"
    CRITICAL_STRENGTH_RATIO = "critical_strength_ratio"
    DAMPING_RATIO = "damping_ratio"
    DISPLACEMENT = "displacement"
    ENERGY = "energy"
    FACTOR_OF_SAFETY = "factor_of_safety"
    FREQUENCY = "frequency"
    HEIGHT = "height"
    INFINITE_SLOPE_FACTOR = "infinite_slope_factor"
    """factor of safety of a slope without end, which slips along a plane"""
    LENGTH = "length"
    MOMENTUM = "momentum"
    PERIOD = "period"
    PIECES = "pieces"
    PROFILE = "profile"
    RUNOUT = "runout"
    SPEED = "speed"
    STRENGTH = "strength"
    STRESS = "stress"
    TRACTION = "traction"
    WATER_LEVEL = "water_level"
    WAVE_SPEED = "wave_speed"
    YIELD_ACCELERATION = "yield_acceleration"


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
