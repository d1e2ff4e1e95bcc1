"""Factors, metrics and observations as they are analysed: their values, units and words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sph.measures.metrics import METRIC_BY_NAME
from sph.scene.schema import Scene
from sph.study.dimensions import as_written, shown_unit, value_at, value_of

ENDS = ("low", "high")
"""Ends of a factor's range, in the order of its bounds."""


class Axis(NamedTuple):
    """A factor, ready for use."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    log: bool
    base: float  # value in the scene as it is
    levels: tuple[str, ...] = ()
    """names of the levels; a value is the number of one then, from 1"""

    @property
    def moved(self) -> dict[str, float]:
        """The values that the tornado moves it to, by name: the ends of the range, or all levels but the scene's own."""
        if self.levels:
            return {str(number): float(number) for number in range(1, len(self.levels) + 1) if number != self.base}
        return dict(zip(ENDS, (self.low, self.high), strict=True))

    @property
    def meaning(self) -> str:
        """Its values in tables."""
        numbered = "; ".join(f"{number}: {level}" for number, level in enumerate(self.levels, 1))
        return f"factor: {self.label}" + (f", the number of its level: {numbered}" if self.levels else "")

    def value(self, share: float) -> float:
        """Value at a share, 0 to 1, of the range; levels have equal parts of it."""
        if self.levels:
            return float(min(int(share * len(self.levels) + 1e-9), len(self.levels) - 1) + 1)
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return self.low + share * (self.high - self.low)

    def share(self, value: np.ndarray) -> np.ndarray:
        """Share of the range below values (n,); of a level the middle of its part."""
        if self.levels:
            return (value - 0.5) / len(self.levels)
        if self.log:
            return np.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def span(self, low: float, high: float) -> str:
        """Two of its values with their unit."""
        return f"{short(low)} to {with_unit(high, self.unit)}"

    def snapped(self, shares: np.ndarray) -> np.ndarray:
        """Shares (n,) of the range, those of levels in the middle of their parts."""
        return self.share(np.array([self.value(share) for share in shares])) if self.levels else shares


class Quantity(NamedTuple):
    """A metric as it is analysed."""

    metric: str
    log_offset: float | None

    @property
    def metric_unit(self) -> str:
        """Unit of the metric."""
        return METRIC_BY_NAME[self.metric].units

    @property
    def text(self) -> str:
        """What is analysed, in words."""
        return self.metric if self.log_offset is None else f"log10({self.metric} + {self.log_offset:g} {self.metric_unit})"

    @property
    def unit(self) -> str:
        """Unit of what is analysed: a decade of the sum on the logarithmic scale."""
        return self.metric_unit if self.log_offset is None else "decade"

    def of(self, values: np.ndarray) -> np.ndarray:
        """What is analysed, from metrics (n,); NaN stays NaN."""
        return values if self.log_offset is None else np.log10(values + self.log_offset)

    def metric_of(self, analysed: np.ndarray) -> np.ndarray:
        """Metrics (n,) from what is analysed."""
        return analysed if self.log_offset is None else 10.0**analysed - self.log_offset


class Observation(NamedTuple):
    """An observed metric."""

    quantity: Quantity
    value: float
    error: float
    """its standard deviation"""

    @property
    def analysed(self) -> tuple[float, float]:
        """Value and standard deviation of what is analysed; of a logarithm the latter to first order."""
        offset = self.quantity.log_offset
        error = self.error if offset is None else self.error / ((self.value + offset) * math.log(10.0))
        return float(self.quantity.of(np.array(self.value))), error


def short(value: float) -> str:
    """A value in three digits."""
    return f"{value:.3g}".replace("e+0", "e").replace("e-0", "e-")


def with_unit(value: float, unit: str) -> str:
    """A value in three digits with its unit."""
    return f"{short(value)} {shown_unit(unit)}".rstrip()


def level_axis(name: str, label: str, scene: Scene, levels: Mapping[str, Sequence[str]], where: str) -> Axis:
    """A factor of levels; ValueError, which begins with ``where``, where no level has the scene's own values."""
    own = {path: value_at(scene, path, f"{where}: levels")[0] for path in levels}
    words = [", ".join(values) for values in zip(*levels.values(), strict=True)]
    rows = [tuple(map(value_of, values)) for values in zip(*levels.values(), strict=True)]
    if tuple(own.values()) not in rows:
        values = ", ".join(f"{path}: {as_written(value)}" for path, value in own.items())
        raise ValueError(f"{where}: levels: {', '.join(words)} do not hold the scene's own value, {values}; add it, or set it in overrides")
    return Axis(name, label, "-", 1.0, float(len(words)), False, rows.index(tuple(own.values())) + 1.0, tuple(words))
