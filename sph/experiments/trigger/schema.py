"""The configuration of the searches for the shaking that triggers failure (``config/trigger.yaml``)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from sph.experiments.base import Label, Overrides, check_file_names
from sph.experiments.trigger.boundaries import Boundary, DamageClass
from sph.experiments.trigger.hazard import INTENSITIES
from sph.experiments.trigger.refinement import Span
from sph.scene.configuration import Section, key
from sph.scene.names import check_known
from sph.scene.scheme import has_key
from sph.scene.units import acceleration
from sph.study.dimensions import Values, check_names, in_order, in_si, scene_key, scene_keys, value_of

MAX_RUNS = 10_000
"""Most points of an undivided lattice."""
MAX_LEVELS = 12
"""Most divisions of a cell."""
MIN_STEP = 1e-5
"""Smallest step of a lattice over its largest value: labels have six digits."""

At = Annotated[dict[str, Values], BeforeValidator(in_si)]


class Intensity(Span):
    """The intensity of the shaking that is searched."""

    dimension: str = key(f"what is searched, one of {', '.join(INTENSITIES)}; all but the first need a record", default="amplitude")

    def bracket(self, level: int) -> float:
        """Width of the widest bracket after ``level`` divisions, below the smallest intensity or in the last cell."""
        return max(self.widest(level), self.lowest * 0.5**level)


class Confirm(Section):
    """Brackets whose ends are repeated at another fidelity."""

    fidelity: str = key("the fidelity, one of the study's", default="standard")
    cases: tuple[str, ...] | None = key("cases to confirm; null: all", default=None, min_length=1)
    at: At = key(
        "values at which to confirm them, among those searched, by dimension; all values of a dimension that is left out", default={}
    )
    collapse_class: Boundary = key("the class whose brackets are confirmed", default="collapse")


class Maps(Section):
    """The lattice of some dimensions and the intensity."""

    cases: tuple[str, ...] | None = key("cases to map; null: all", default=None, min_length=1)
    over: dict[str, Span] = key("ranges of the dimensions to map besides the intensity, by dimension", min_length=1)
    classes: tuple[DamageClass, ...] = key(
        "cells whose corners differ in reaching one of these classes are divided", default=("collapse",), min_length=1
    )
    levels: int = key("how often a cell is divided", ge=0, le=4, default=2)


class Trigger(Section):
    """The configuration."""

    fidelity: str | None = key("fidelity of the search, one of the study's; null: that of the study", default=None)
    cases: dict[Label, Overrides] = key("scene keys of each case, by label", min_length=1)
    intensity: Intensity = key("the intensities of the shaking, of all searches")
    tolerance: float = key("largest width of the bracket of a critical intensity", "that of the intensity", gt=0, le=1e4)
    classes: tuple[Boundary, ...] = key(
        "what has to be reached at a critical intensity: classes, 'runout: NAME' for a place of metrics.places, 'runout: LENGTH' and "
        "'displacement: LENGTH' in m",
        default=("collapse",),
        min_length=1,
    )
    at: At = key("values at which they are searched, by dimension, every combination; none: at the scene's own", default={})
    periods: tuple[Annotated[float, Field(gt=0, le=100)], ...] = key(
        "periods at which the fragility is compared in the spectral acceleration, with 5 % damping", "s", default=(), max_length=50
    )
    hazard: str | None = key(
        "file of the site's hazard curve, relative to the working folder or the workflow's: a line of names, then rows of the "
        "intensity that is searched and the annual frequency with which it is exceeded; null: none",
        default=None,
        min_length=1,
        max_length=1000,
    )
    confirm: Confirm | None = key("brackets whose ends are repeated at another fidelity; null: none", default=None)
    maps: Maps | None = key("maps over some dimensions and the intensity; null: none", default=None)

    @model_validator(mode="before")
    @classmethod
    def _in_si(cls, values: Any) -> Any:
        """Intensities that are accelerations may be written with their units."""
        span = values.get("intensity") if isinstance(values, Mapping) else None
        if not isinstance(span, Mapping) or scene_keys().get(scene_key(str(span.get("dimension", "amplitude")))) != "m/s2":
            return values
        ends = {name: acceleration(span[name]) for name in ("lowest", "highest") if name in span}
        return {**values, "tolerance": acceleration(values.get("tolerance")), "intensity": {**span, **ends}}

    @model_validator(mode="after")
    def _known(self) -> Trigger:
        check_file_names("cases", self.cases)
        check_known("intensity.dimension", [self.intensity.dimension], INTENSITIES)
        check_names("at", self.at)
        if self.intensity.dimension in self.at:
            raise ValueError(f"at.{self.intensity.dimension}: is the intensity that is searched; leave it out of at")
        if self.maps and set(self.maps.over) != set(self.at):
            raise ValueError(f"maps.over: {', '.join(self.maps.over)}: must be the dimensions of at ({', '.join(self.at) or 'none'})")
        for name, values in self.at.items():
            if len({value_of(value) for value in values}) < len(values):
                raise ValueError(f"at.{name}: {list(values)} contains the same value twice")
        for case, overrides in self.cases.items():
            for name in self.dimensions:
                if has_key(overrides, scene_key(name)):
                    raise ValueError(f"cases.{case}: {scene_key(name)} is what is searched, see {name}")
        check_known("confirm.cases", self.confirm.cases if self.confirm else (), self.cases)
        check_known("maps.cases", self.maps.cases if self.maps else (), self.cases)
        for name, values in (self.confirm.at if self.confirm else {}).items():
            check_known("confirm.at", [name], self.at)
            searched = {value_of(value) for value in self.at[name]}
            for value in values:
                if value_of(value) not in searched:
                    raise ValueError(f"confirm.at.{name}: {value} is not one of those searched, {', '.join(self.at[name])}")
        check_known("confirm.collapse_class", [self.confirm.collapse_class] if self.confirm else (), self.classes)
        if self.levels > MAX_LEVELS:
            raise ValueError(f"tolerance: {self.tolerance:g} must be at least {self.intensity.bracket(MAX_LEVELS):.2g} with this lattice")
        self._check_extent()
        return self

    def _check_extent(self) -> None:
        spans: list[tuple[str, Span, int]] = [("intensity", self.intensity, self.levels)]
        points = {"at": len(self.cases) * math.prod(map(len, self.at.values())) * (self.intensity.cells + 1)}
        if self.maps:
            own = {**self.maps.over, "intensity": self.intensity}
            spans += [(f"maps.over.{name}", span, self.maps.levels) for name, span in own.items()]
            points["maps"] = len(self.maps.cases or self.cases) * math.prod(span.cells + 1 for span in own.values())
        for where, span, levels in spans:
            if span.widest(levels) <= MIN_STEP * span.highest:
                raise ValueError(f"{where}: steps of {span.widest(levels):.2g} at {span.highest:g} are too small for labels of six digits")
        for where, count in points.items():
            if count > MAX_RUNS:
                raise ValueError(f"{where}: the undivided lattice has {count:,} points, at most {MAX_RUNS:,}")

    @property
    def dimensions(self) -> tuple[str, ...]:
        """The dimensions of the searches, in the order of file names and tables."""
        return tuple(in_order([*self.at, self.intensity.dimension]))

    @property
    def levels(self) -> int:
        """How often a cell of intensities is divided until all are within the tolerance; ``MAX_LEVELS`` + 1 if that is not enough."""
        narrow = (level for level in range(MAX_LEVELS + 1) if self.intensity.bracket(level) <= self.tolerance * (1.0 + 1e-9))
        return next(narrow, MAX_LEVELS + 1)
