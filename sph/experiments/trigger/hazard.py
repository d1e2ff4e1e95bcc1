"""The hazard of a site: annual frequency H(x) with which an intensity x of the shaking is exceeded, from a file, and what it makes of a
fragility.

The annual frequency of an event with the probability P(x) at the intensity x is the integral of P |dH| (Cornell 1968, Bulletin of the
Seismological Society of America 58 (5), 1583-1606; McGuire 2004, Seismic Hazard and Risk Analysis, EERI).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.scene.cells import cells, names
from sph.scene.configuration import one_line, read_text
from sph.scene.ground_motion.units import unit_of_column
from sph.scene.units import LENGTH, Units, unit_of

SPEEDS = Units({"ms": 1.0, "mps": 1.0, "cms": 0.01, "cmps": 0.01}, rf"{LENGTH}p?s|{LENGTH}p?ss|g|gals?", "m/s or cm/s")
"""Units of a peak velocity and of an Arias intensity."""
UNITS: dict[str, tuple[Callable[[str], float | None], str]] = {
    "m/s2": (unit_of_column, "'amplitude (g)' or 'amplitude (m/s2)'"),
    "m/s": (partial(unit_of, units=SPEEDS), "'PGV (cm/s)' or 'Arias intensity (m/s)'"),
}
"""How the unit of an intensity is found in the name of its column, and examples of names."""
NO_ANNUAL = re.compile(r"period|%|percent|(?:[2-9]|\d\d)[\s_-]*(?:y|yrs?|years?|a)(?![a-z])", re.I)
"""Names of a return period, and of what is meant for more than a year."""
PROBABILITY, OF_A_YEAR = re.compile(r"prob|(?<![a-z])poe(?![a-z])", re.I), re.compile(r"annual|year|yr|/a(?![a-z])", re.I)


class Hazard(NamedTuple):
    """A hazard curve, linear in the logarithms between its rows."""

    intensity: np.ndarray
    """(n,) increasing"""
    frequency: np.ndarray
    """(n,) 1/year, never increasing"""

    def at(self, intensity: float) -> float:
        """The frequency at an intensity between the first and the last, 1/year."""
        return float(np.exp(np.interp(math.log(intensity), np.log(self.intensity), np.log(self.frequency))))

    def exceeded(self, intensities: np.ndarray) -> np.ndarray:
        """The frequencies (n,) at intensities (n,), 1/year; beyond an end of the curve that of the end."""
        return np.array([self.at(x) for x in np.clip(intensities, self.intensity[0], self.intensity[-1])])

    def between(self, lowest: float, highest: float) -> Hazard:
        """The part of the curve between two intensities, of which some lies in its range."""
        low, high = max(lowest, float(self.intensity[0])), min(highest, float(self.intensity[-1]))
        inside = (self.intensity > low) & (self.intensity < high)
        rows = [low, *self.intensity[inside], high]
        return Hazard(np.array(rows), np.array([self.at(row) for row in rows]))


def read_hazard(path: Path | str, unit: str) -> Hazard:
    """The curve in a file whose first line has names: intensities, and the annual frequency with which each is exceeded.

    ``unit`` of the intensity; where it is m/s2 or m/s, the name of the first column says its unit in brackets, such as g or cm/s.
    Raises ValueError with file, line and what is wanted.
    """
    try:
        lines = [line for line in read_text(Path(path)).splitlines() if line.strip() and not line.lstrip().startswith("#")]
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as a hazard curve: {error}") from error
    head = names(lines[0], lines[1]) if len(lines) > 1 else []
    if len(head) != 2 or not all(name[:1].isalpha() for name in head):
        raise ValueError(f"{path}: the first line must name two columns, as 'intensity,annual frequency', and rows must follow it")
    size = _size(path, head[0], unit)
    if NO_ANNUAL.search(head[1]) or PROBABILITY.search(head[1]) and not OF_A_YEAR.search(head[1]):
        raise ValueError(
            f"{path}: the name of the second column, {head[1]!r}, must be that of an annual frequency: -ln(1 - p) / t for a probability "
            "p in t years, 1 / T for a return period T"
        )
    rows = list[tuple[float, float]]()
    for line in lines[1:]:
        try:
            intensity, frequency = map(float, cells(line))
        except ValueError as error:
            raise ValueError(f"{path}: {one_line(line, 60)!r}: must be two numbers, intensity and annual frequency") from error
        if not (0.0 < intensity < math.inf and 0.0 < frequency < math.inf):
            raise ValueError(f"{path}: {one_line(line, 60)!r}: both numbers must be above 0")
        if rows and not (size * intensity > rows[-1][0] and frequency <= rows[-1][1]):
            raise ValueError(f"{path}: {one_line(line, 60)!r}: intensities must increase from row to row, and frequencies must not")
        rows.append((size * intensity, frequency))
    if len(rows) < 2:
        raise ValueError(f"{path}: holds {len(rows)} row; a hazard curve has at least two")
    return Hazard(*np.array(rows).T)


def _size(path: Path | str, name: str, unit: str) -> float:
    """The unit that a name says, in that of the intensity."""
    if unit not in UNITS:
        return 1.0
    known, example = UNITS[unit]
    try:
        size = known(name)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    if size is None:
        raise ValueError(f"{path}: the name of the first column, {name!r}, must state the unit, as in {example}")
    return size


def annual_frequency(fits: np.ndarray, hazard: Hazard) -> np.ndarray:
    """Integral of P |dH| over the hazard curve (m,), 1/year, of lognormal fragilities with medians and dispersions (m, 2).

    Between two rows H = c x^-k.  By parts, with the density p of the fragility,

        integral of P |dH| = -[P H] + c integral of x^-k p dx
                           = -[P H] + c exp(-k mu + k^2 beta^2 / 2) [Phi((ln x - mu + k beta^2) / beta)],   mu = ln theta

    in which brackets are values at the upper row less those at the lower.
    """
    logs, levels = np.log(hazard.intensity), np.log(hazard.frequency)
    slope = -np.diff(levels) / np.diff(logs)
    mu, beta = np.log(fits[:, :1]), fits[:, 1:]
    reach = (logs - mu) / beta
    by_parts = np.diff(scipy.special.ndtr(reach) * hazard.frequency, axis=1)
    low, high = reach[:, :-1] + slope * beta, reach[:, 1:] + slope * beta
    turned = low > 0.0  # in the upper tail the difference is that of the other side
    below, above = np.where(turned, -high, low), np.where(turned, -low, high)
    between = scipy.special.log_ndtr(above) + np.log1p(-np.exp(scipy.special.log_ndtr(below) - scipy.special.log_ndtr(above)))
    moment = np.exp(levels[:-1] + slope * (logs[:-1] - mu) + 0.5 * (slope * beta) ** 2 + between)
    return np.sum(moment - by_parts, axis=1)
