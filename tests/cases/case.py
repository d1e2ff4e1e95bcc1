"""A reference case: a problem with a known answer, how it is set up, and what is measured of its runs beside that answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from sph.scene.configuration import merge, read_scene
from sph.scene.schema import Scene
from sph.solver.particles import SOIL
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.runs import SIMULATION

ROOT = Path(__file__).parents[2]
COMPUTATION = "computation"
"""A case of functions alone, which leaves no file."""


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

    def within(self, tolerance: float) -> bool:
        """Whether it meets its reference; NaN does not."""
        return abs(self.error) <= tolerance


class Quantity(NamedTuple):
    """What is asked of a number: errors are relative to the reference, absolute where that is 0."""

    kind: Kind
    tolerance: float
    """largest error on the finest level"""
    coarse: float
    """largest error on the coarsest level, which the tests run"""
    reason: str
    """why these tolerances"""


class Case(NamedTuple):
    """A problem with a known answer; each of its ``runs`` is made at each of its ``levels`` of resolution."""

    title: str
    scene: str
    """file of the repository"""
    source: str
    """where the reference comes from"""
    measure: Callable[[Level], dict[str, Found]]
    """what is found on a level, by quantity"""
    draw: Callable[[Mapping[str, Level]], Figure]
    """picture of all levels, by label, from coarse to fine; the first paragraph of its docstring is the caption"""
    quantities: Mapping[str, Quantity]
    by: str = SIMULATION
    """or a search of ``sph.stability.record.SEARCHES``, or ``COMPUTATION``"""
    reference: Literal["published", "formula", "own"] = "own"
    """what the source gives: published values, a published formula or method with our numbers in it, or a closed form of our own"""
    ours: str = "all"
    """which numbers of the problem are not from the source"""
    size: Literal["numerics.spacing", "numerics.time_step"] = "numerics.spacing"
    """key in which the levels differ"""
    compared: Literal["finest", "extrapolated"] = "finest"
    """value that is compared: that of the finest level, or that of the two finest extrapolated to spacing 0, as by ``sph fos``"""
    runs: Mapping[str, Mapping[str, Any]] = {"run": {}}
    """scene keys of each variant"""
    levels: Mapping[str, Mapping[str, Any]] = {"only": {}}
    """scene keys of each resolution, by label, from coarse to fine"""

    def scenes(self) -> dict[tuple[str, str], dict[str, Any]]:
        """Scene of every run as a mapping, by level and name of the run, from coarse to fine."""
        scene = read_scene(str(ROOT / self.scene))
        return {(level, run): merge(merge(scene, keys), finer) for level, finer in self.levels.items() for run, keys in self.runs.items()}

    def size_of(self, level: Level) -> float:
        """Spacing (m) or time step (s) of a level."""
        section, field = self.size.split(".")
        return float(getattr(getattr(next(iter(level.values())).scene, section), field))

    def found(self, level: Level) -> dict[str, Found]:
        """What is measured on a level; NaN for all of it where a run diverged.

        Raises ValueError where other quantities are measured than are asked for.
        """
        found = self.measure(level)
        if set(found) != set(self.quantities):
            raise ValueError(f"quantities {sorted(self.quantities)} are asked for, {sorted(found)} are measured")
        if any(result.data.attrs.get("status") == Status.DIVERGED for result in level.values()):
            return {quantity: each._replace(computed=math.nan) for quantity, each in found.items()}
        return found


def at_spacings(spacings: Mapping[str, float]) -> dict[str, dict[str, Any]]:
    """Levels that differ in the spacing alone, m, by label."""
    return {label: {"numerics": {"spacing": spacing}} for label, spacing in spacings.items()}


def at_time_steps(steps: Mapping[str, float]) -> dict[str, dict[str, Any]]:
    """Levels that differ in the time step alone, s, by label."""
    return {label: {"numerics": {"time_step": step}} for label, step in steps.items()}


def read_result(path: Path | str) -> Result:
    """Result of a run or a search from its file; ValueError names a file that is not one."""
    data = trajectory.read(path).dataset()
    return Result(trajectory.scene_of(data, str(path)), data, None if "by" in data.attrs else trajectory.read_restart(path).dataset())
