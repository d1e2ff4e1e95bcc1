"""The hazard of a site: annual frequency H(x) with which an intensity x of the shaking is exceeded, from a file, and what it makes of a
fragility.

The annual frequency of an event with the probability P(x) at the intensity x is the integral of P |dH| (Cornell 1968, Bulletin of the
Seismological Society of America 58 (5), 1583-1606; McGuire 2004, Seismic Hazard and Risk Analysis, EERI).
"""

from __future__ import annotations

import math
import re
import unicodedata
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.scene.cells import cells, names
from sph.scene.configuration import one_line, read_text
from sph.scene.ground_motion.units import ACCELERATIONS
from sph.scene.units import LENGTH, Units, read_head

SPEEDS = Units({"ms": 1.0, "mps": 1.0, "cms": 0.01, "cmps": 0.01}, rf"{LENGTH}p?s|{LENGTH}p?ss|{LENGTH}p?s2|g|%g|gals?|%", "m/s or cm/s")
"""Units of a peak velocity and of an Arias intensity."""
NONE = Units({}, rf"{SPEEDS.others}|{ACCELERATIONS.others}|{'|'.join((*SPEEDS.known, *ACCELERATIONS.known))}", "a number without a unit")
"""Of a factor."""


class Scaling(NamedTuple):
    """What scales the shaking, and how the head of a column of it is written."""

    power: float
    """in proportion to which of its powers the accelerations are"""
    units: Units
    names: str
    """words, of which one names the intensity"""
    beside: str
    """words that may stand beside it"""
    example: str


BESIDE = "peak ground horizontal rock outcrop maximum max mean median of in at the"
INTENSITIES = {
    "amplitude": Scaling(1.0, ACCELERATIONS, "amplitude pga pha acceleration accel acc a", f"{BESIDE} intensity level", "PGA (g)"),
    "motion.factor": Scaling(1.0, NONE, "factor", "motion record scale scaling on of the", "factor"),
    "motion.peak_velocity": Scaling(1.0, SPEEDS, "velocity vel pgv", BESIDE, "PGV (cm/s)"),
    "motion.arias_intensity": Scaling(0.5, SPEEDS, "arias ia", f"{BESIDE} intensity", "Arias intensity (m/s)"),
    "motion.spectral_acceleration.value": Scaling(1.0, ACCELERATIONS, "sa", "in", "SA(0.5 s) (g)"),
}
"""What can be searched, by dimension."""
PERIOD = re.compile(
    r"\s*(?:p?sa|spectral[\s_]+acc\w*)[\s_]*[(\[]?\s*(?:t\s*=\s*)?(\d+\.?\d*|\.\d+)\s*(?:s|sec)?(?![a-z\d.])\s*[)\]]?(.*)", re.I
)
"""The name of a spectral acceleration with its period, and what stands behind it."""
RATE = re.compile("frequency|frequencies|rates?|lambda|λ|h|afe|mafe|afoe|maf|mare|aroe")
PROBABILITY, OF_A_YEAR = re.compile("probability|prob|poe|apoe|aep"), re.compile("annual|yearly|year|yr|y|a|apoe|aep")
"""Words of the head of the second column: an annual frequency or a probability, and that it is one in a year."""
BESIDE_RATE = re.compile("mean|of|the|in|per|exceed[ae]nces?|exceeding|being|exceeded|1")
"""What else may stand there: with any other word or number the column is another quantity, of another time, or has a factor."""


class Hazard(NamedTuple):
    """A hazard curve, linear in the logarithms between its rows."""

    intensity: np.ndarray
    """(n,) increasing"""
    frequency: np.ndarray
    """(n,) 1/year, never increasing"""
    period: float | None = None
    """of the oscillator whose spectral acceleration is the intensity, s"""

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
        return Hazard(np.array(rows), np.array([self.at(row) for row in rows]), self.period)


def read_hazard(path: Path | str, dimension: str) -> Hazard:
    """The curve in a file whose first line has names: intensities, and the annual frequency with which each is exceeded.

    ``dimension`` is the intensity, one of ``INTENSITIES``.  The heads name it with its unit, and an annual frequency or a probability p in
    a year, of which -ln(1 - p) is the frequency; every word of a head must be known.  Raises ValueError with file, line and what is wanted.
    """
    try:
        lines = [(at, line) for at, line in enumerate(read_text(Path(path)).splitlines(), 1) if line.strip() and line.lstrip()[:1] != "#"]
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as a hazard curve: {error}") from error
    head = names(lines[0][1], lines[1][1]) if len(lines) > 1 else []
    if len(head) != 2 or not all(name[:1].isalpha() for name in head):
        raise ValueError(f"{path}: the first line must name two columns, as 'PGA (g),annual frequency', and rows must follow it")
    where = f"{path}, line {lines[0][0]}"
    size, period = _intensity(f"{where}, first column", head[0], dimension)
    probable = _is_probability(f"{where}, second column", head[1])
    rows = list[tuple[float, float]]()
    for at, line in lines[1:]:
        where = f"{path}, line {at}: {one_line(line, 60)!r}"
        try:
            intensity, frequency = map(float, cells(line))
        except ValueError as error:
            raise ValueError(f"{where}: must be two numbers, intensity and annual frequency") from error
        if not (0.0 < intensity < math.inf and 0.0 < frequency < (1.0 if probable else math.inf)):
            raise ValueError(f"{where}: both numbers must be above 0{', a probability below 1' if probable else ''}")
        if probable:
            frequency = -math.log1p(-frequency)
        if rows and not (size * intensity > rows[-1][0] and frequency <= rows[-1][1]):
            raise ValueError(f"{where}: intensities must increase from row to row, and frequencies must not")
        rows.append((size * intensity, frequency))
    if len(rows) < 2:
        raise ValueError(f"{path}: holds {len(rows)} row; a hazard curve has at least two")
    return Hazard(*np.array(rows).T)._replace(period=period)


def _intensity(where: str, name: str, dimension: str) -> tuple[float, float | None]:
    """The unit (SI) of the intensities below a head, and the period of a spectral acceleration (s)."""
    wanted, spectral = INTENSITIES[dimension], PERIOD.fullmatch(name)
    period = float(spectral[1]) if spectral else None
    try:
        size, rest = read_head(f"SA {spectral[2]}" if spectral else name, wanted.units)
    except ValueError as error:
        raise ValueError(f"{where}: {error}; name the column as in {wanted.example!r}") from error
    if size is None and wanted.units.known:
        raise ValueError(f"{where}: {name!r} must state the unit, as in {wanted.example!r}")
    said, known = _said(rest), set(wanted.names.split())
    if not said & known or said - known - set(wanted.beside.split()) or bool(period) != (wanted.names == "sa"):
        raise ValueError(
            f"{where}: {name!r} must name {dimension}, the intensity that is searched, as {wanted.example!r}, and nothing else"
        )
    return 1.0 if size is None else size, period


def _is_probability(where: str, name: str) -> bool:
    """Whether the numbers below a head are probabilities in a year, and not annual frequencies; ValueError for other quantities."""
    said = _said(name)
    rate, probability, of_a_year, beside = (
        {word for word in said if pattern.fullmatch(word)} for pattern in (RATE, PROBABILITY, OF_A_YEAR, BESIDE_RATE)
    )
    if said - rate - probability - of_a_year - beside or not (rate or probability and of_a_year):
        raise ValueError(
            f"{where}: {name!r} must be the name of an annual frequency, as 'annual frequency (1/yr)', and nothing else: convert the "
            "numbers to -ln(1 - p) / t for a probability p in t years, 1 / T for a return period T, r / 100 for a rate r per century, and "
            "those with a factor to numbers without it"
        )
    return bool(probability)


def _said(name: str) -> set[str]:
    """Words and numbers of a head, signs of operations among them."""
    plain = re.sub("(?<=[a-z]{2})(?=[A-Z])", " ", unicodedata.normalize("NFKC", name))
    return set(re.findall(r"\d+|[^\W\d_]+|[%‰*×^·]", plain.casefold()))


def log_between(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Natural logarithm of the standard normal probability between two values, arrays of one shape."""
    turned = low > 0.0  # in the upper tail the difference is that of the other side
    below, above = scipy.special.log_ndtr(np.where(turned, -high, low)), scipy.special.log_ndtr(np.where(turned, -low, high))
    return above + np.log1p(-np.exp(below - above))


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
    moment = np.exp(levels[:-1] + slope * (logs[:-1] - mu) + 0.5 * (slope * beta) ** 2 + log_between(low, high))
    return np.sum(moment - by_parts, axis=1)
