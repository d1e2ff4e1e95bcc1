"""Shear tests: reading them, the strength that they show, and its loss with slip as the solver has it.

The peak strength of a test is its largest stress, the residual strength the mean over the last quarter of its slip.  The slip is the
displacement without its elastic part, the stress over the stiffness of the branch that rises.  All tests share the slips at which strength
begins to fall and is lost (``coupling.softening``), which are fitted to the stresses from the peak on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.scene.cells import COMMENT, cells, check_commas, listed, names, words
from sph.scene.configuration import one_line, read_text
from sph.scene.units import Units, read_head

LENGTHS = Units({"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6}, r"[kdn]m|ft|in|inch(es)?|yd|deg(rees?)?|°|s|min|h|k?n|%", "mm, cm, m or µm")
STRESSES = Units(
    {"kpa": 1.0, "pa": 1e-3, "mpa": 1e3, "knm2": 1.0, "nmm2": 1e3},
    r"[gh]pa|psi|ksi|k?n|psf|ksf|tsf|bar|kgf?|kgf?cm2|tm2|mm|%",
    "kPa, Pa or MPa",
)
SAID = {
    "displacement": {"displacement", "displacements", "disp", "slip", "travel"},
    "normal": {"normal", "vertical", "sigma", "σ"},
    "stress": {"stress", "strength", "shear", "tau", "τ", "resistance"},
}
"""Words of the columns' names; the first that is said counts, and vertical displacements are left out like other columns."""
ELASTIC = 0.5
"""Share of the peak up to which the rising branch is elastic."""
LAST = 0.25
"""Share of the slip, at its end, over which the residual strength is the mean."""
STEADY = 0.05
"""Share of the loss by which the stress may fall within the last half of the slip where the residual strength has been reached; and that
which is still to come at D_95."""
SAME = 0.05
"""Relative change of the normal stress in a file from which on another test begins."""
BACK = 0.01
"""Part of the largest displacement by which it may go back, from noise."""
MIN_AFTER = 4
"""Fewest points after the peak."""
LEVEL = 0.95
"""Level of confidence of the bounds."""


class Curve(NamedTuple):
    """A curve of strength against slip, as a law of ``sph.solver.physics.loss_by_slip`` has it for one particle."""

    weight: Callable[[np.ndarray], np.ndarray]  # (n,) of the peak strength, by the passed share (n,) of the slip from peak to residual
    D_95: float  # that share at which 5 % of the loss is still to come


CURVES = {
    "linear": Curve(lambda passed: np.maximum(1.0 - passed, 0.0), 1.0 - STEADY),
    "exponential": Curve(lambda passed: np.exp(-3.0 * passed), math.log(1.0 / STEADY) / 3.0),
}
"""The curves that are fitted, by the name that scenes give them (``coupling.softening.shape``)."""


class ShearTest(NamedTuple):
    """One test."""

    name: str
    normal: float | None  # stress, kPa
    slip: np.ndarray  # (n,) m
    stress: np.ndarray  # (n,) kPa
    stiffness: float | None  # of the elastic part, kPa/m; None where the test begins above it

    @property
    def after(self) -> slice:
        """The points from the peak on."""
        return slice(int(self.stress.argmax()), None)

    @property
    def slip_at_peak(self) -> float:
        """Slip at the largest stress, m."""
        return float(self.slip[self.after][0])

    @property
    def peak(self) -> float:
        """Peak strength, kPa."""
        return float(self.stress.max())

    @property
    def residual(self) -> float:
        """Residual strength, kPa."""
        return float(self.stress[self._last].mean())

    @property
    def _last(self) -> np.ndarray:
        start, end = self.slip_at_peak, self.slip[-1]
        last: np.ndarray = self.slip >= end - LAST * (end - start)
        return last

    @property
    def falling(self) -> float:
        """Fall of the mean stress from the third to the last quarter of the slip after the peak, as a share of the loss."""
        start, end = self.slip_at_peak, self.slip[-1]
        before = (self.slip >= end - 2.0 * LAST * (end - start)) & ~self._last
        earlier = self.stress[before].mean() if before.any() else self.stress[~self._last][-1]
        return float((earlier - self.residual) / (self.peak - self.residual))

    @property
    def D_95(self) -> float:
        """Slip at which 5 % of the loss is still to come, by the falling stresses that are nearest to those from the peak on, m."""
        falling = scipy.optimize.isotonic_regression(self.stress[self.after], increasing=False).x
        return float(np.interp(-(self.residual + STEADY * (self.peak - self.residual)), -falling, self.slip[self.after]))


def read_tests(path: Path, normal: float | None = None) -> list[ShearTest]:
    """The tests in a file, at its own normal stress or at the one given, kPa; ValueError names file and line."""
    try:
        table, of_normal = _table(read_text(path))
        if of_normal and normal is not None:
            raise ValueError(f"it has a column of normal stress, and --normal-stress gives {normal:g} kPa; give one of them")
        steps = [0, *_changes(table[:, 2]), len(table)] if of_normal else [0, len(table)]
        parts = [table[first:end] for first, end in zip(steps, steps[1:], strict=False)]
        tests = []
        for part in parts:
            own = float(part[:, 2].mean()) if of_normal else normal
            name = f"{path.name}, {own:.4g} kPa" if len(parts) > 1 else path.name
            tests.append(_test(name, own, part[:, 0], part[:, 1]))
        return tests
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: {getattr(error, 'strerror', None) or error}") from error


def _changes(normal: np.ndarray) -> list[int]:
    """Rows at which another normal stress begins."""
    changes: list[int] = []
    first = normal[0]
    for row, value in enumerate(normal):
        if abs(value - first) > SAME * abs(first):
            changes.append(row)
            first = value
    return changes


def _table(text: str) -> tuple[np.ndarray, bool]:
    """Displacement (m), stress and normal stress (kPa), of which the last may be NaN, (n, 3); and whether that is given."""
    lines = [
        (number, line) for number, line in enumerate(text.splitlines(), 1) if any(cells(line)) and not line.lstrip().startswith(COMMENT)
    ]
    check_commas(line for _, line in lines)
    if len(lines) < 2:
        raise ValueError("it holds no table; expected a line of names, as displacement (mm),stress (kPa), and a line for each reading")
    (number, head), rows = lines[0], lines[1:]
    heads = names(head, rows[0][1])
    kinds = [_quantity(name) for name in heads]
    for kind in ("displacement", "stress"):
        if kinds.count(kind) != 1:
            raise ValueError(
                f"line {number}: {kinds.count(kind) or 'no'} column{'s' * (kinds.count(kind) > 1)} of {kind} (columns {listed(heads)}); "
                "name one, as displacement (mm),stress (kPa), with the unit in brackets"
            )
    if kinds.count("normal") > 1:
        raise ValueError(f"line {number}: {kinds.count('normal')} columns of normal stress (columns {listed(heads)}); leave one")
    wanted = [kinds.index(kind) if kind in kinds else None for kind in ("displacement", "stress", "normal")]
    sizes = [1.0 if at is None else _size(number, heads[at], LENGTHS if kind == 0 else STRESSES) for kind, at in enumerate(wanted)]
    table = np.full((len(rows), 3), math.nan)
    for row, (number, line) in enumerate(rows):
        texts = cells(line)
        try:
            table[row] = [math.nan if at is None else size * float(texts[at]) for at, size in zip(wanted, sizes, strict=True)]
        except (ValueError, IndexError) as error:
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: expected a number in each of {listed(heads)}") from error
        if not np.isfinite(table[row][[at is not None for at in wanted]]).all():
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: expected finite numbers")
    return table, wanted[2] is not None


def _quantity(name: str) -> str | None:
    said = set(words(name))
    kind = next((kind for kind, known in SAID.items() if said & known), None)
    return None if kind == "displacement" and said & SAID["normal"] else kind


def _size(number: int, name: str, units: Units) -> float:
    """Size of a column's unit; ValueError where it says none."""
    try:
        size = read_head(name, units).size
        if size is None:
            raise ValueError(f"{name.strip()[:80]!r} does not say its unit; write {units.allowed} in brackets behind it")
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from error
    return size


def _test(name: str, normal: float | None, displacement: np.ndarray, stress: np.ndarray) -> ShearTest:
    """A test, without the elastic part of its displacement."""
    largest, at = float(stress.max()), int(stress.argmax())
    if not largest > 0.0:
        raise ValueError(f"{name}: its largest stress is {largest:g} kPa; give shear stresses as positive numbers")
    if normal is not None and not normal > 0.0:
        raise ValueError(f"{name}: normal stress {normal:g} kPa: must be above 0; give compression as a positive number")
    back = np.diff(displacement).min(initial=0.0)
    if back < -BACK * np.ptp(displacement):
        raise ValueError(
            f"{name}: the displacement goes back by {-1e3 * back:.3g} mm; of a test with reversals give the displacement summed over "
            "them, and of several tests a column with the normal stress of each, or a file each"
        )
    if len(stress) - 1 - at < MIN_AFTER:
        raise ValueError(
            f"{name}: {len(stress) - 1 - at} points after the largest stress, at least {MIN_AFTER} are needed to fit the loss of strength; "
            "give the whole test, up to large displacements"
        )
    above = np.flatnonzero(stress[: at + 1] > ELASTIC * largest)[0]
    rising = slice(0, max(int(above), 2) if above else 0)
    stiffness, start = None, float(displacement[0])
    if above and np.ptp(displacement[rising]) > 0.0:
        slope, level = np.polyfit(displacement[rising], stress[rising], 1)
        if slope > 0.0:
            stiffness, start = float(slope), float(-level / slope)
    slip = displacement - start - (0.0 if stiffness is None else stress / stiffness)
    test = ShearTest(name, normal, slip, stress, stiffness)
    if not 0.0 <= test.residual < test.peak:
        raise ValueError(
            f"{name}: residual stress {test.residual:.4g} kPa, must be below the peak of {test.peak:.4g} kPa and not below 0: no strength "
            "is lost here that softening could describe"
        )
    return test


class Bounded(NamedTuple):
    """A number with its bounds at ``LEVEL``; NaN where the tests are too few to give them."""

    value: float
    low: float = math.nan
    high: float = math.nan


class Strength(NamedTuple):
    """A Mohr-Coulomb strength."""

    cohesion: Bounded  # kPa
    friction_angle: Bounded  # degree


def strength(normal: Sequence[float], stress: Sequence[float]) -> Strength:
    """The line c + sigma tan(phi) with the least squares through stresses at normal stresses, both (n,) kPa, neither c nor phi below 0.

    At a single normal stress c is 0.  Bounds are those of Student's t for what is not held at 0.
    """
    sigma, tau = np.asarray(normal, float), np.asarray(stress, float)
    columns = np.column_stack([np.ones_like(sigma), sigma])
    single = bool(np.ptp(sigma) <= SAME * sigma.max())
    columns[:, 0] *= not single
    fitted, misfit = scipy.optimize.nnls(columns, tau)
    free = fitted > 0.0
    left = tau.size - int(free.sum())
    spread = np.zeros(2)
    if left > 0:
        inverse = np.linalg.inv(columns[:, free].T @ columns[:, free])
        spread[free] = scipy.stats.t.ppf(0.5 + 0.5 * LEVEL, left) * np.sqrt(misfit**2 / left * np.diag(inverse))
    low, high = (fitted - spread, fitted + spread) if left > 0 else np.full((2, 2), math.nan)
    cohesion = Bounded(float(fitted[0]), max(float(low[0]), 0.0), float(high[0]))
    angle = Bounded(*(math.degrees(math.atan(each)) for each in (fitted[1], max(low[1], 0.0), high[1])))
    return Strength(Bounded(0.0) if single else cohesion, angle)


class Loss(NamedTuple):
    """Loss of strength with slip: the weight of the peak strength over the residual one is 1 up to the peak's slip."""

    shape: str
    slip_at_peak: float  # m
    slip_at_residual: float  # m
    misfit: float  # root mean square, kPa
    peaks: tuple[float, ...]  # strength of each test before the loss, free of the noise of its largest reading, kPa

    def weight(self, slip: np.ndarray) -> np.ndarray:
        """Weight (n,) of the peak strength at slips (n,), as ``sph.solver.physics.loss_by_slip`` has it."""
        return _weight(self.shape, slip, self.slip_at_peak, self.slip_at_residual - self.slip_at_peak)

    @property
    def D_95(self) -> float:
        """Slip at which 5 % of the loss is still to come, m."""
        return self.slip_at_peak + CURVES[self.shape].D_95 * (self.slip_at_residual - self.slip_at_peak)


def _weight(shape: str, slip: np.ndarray, peak: float, span: float) -> np.ndarray:
    return CURVES[shape].weight(np.maximum(slip - peak, 0.0) / span)


def fit_loss(tests: Sequence[ShearTest], shape: str) -> Loss:
    """The slips of a shape with the least squares to the stresses of all tests from the peak on, and the peaks that go with them.

    The slip at the peak is at least the smallest at which a test has its largest stress.
    """
    points = [(test.slip[test.after], test.stress[test.after] - test.residual) for test in tests]
    first, end = max(min(test.slip_at_peak for test in tests), 1e-6), max(float(test.slip[-1]) for test in tests)

    def drops(peak: float, span: float) -> list[float]:
        """Peak over residual strength of each test with the least squares, kPa; 0 of one without a point before the end of the loss."""
        weights = [_weight(shape, slip, peak, span) for slip, _ in points]
        return [float(weight @ stress / (weight @ weight or 1.0)) for weight, (_, stress) in zip(weights, points, strict=True)]

    def errors(slips: np.ndarray) -> np.ndarray:
        fitted = zip(points, drops(*slips), strict=True)
        return np.concatenate([drop * _weight(shape, slip, *slips) - stress for (slip, stress), drop in fitted])

    spread = end - first
    starts = [
        np.array([first + more, span]) for more in spread * np.geomspace(1e-3, 0.5, 12) for span in spread * np.geomspace(1e-2, 2.0, 24)
    ]
    start = min(starts, key=lambda each: float(np.square(errors(each)).sum()))
    bounds = ([first, 1e-4 * spread], [end, 10.0 * spread])
    fitted = scipy.optimize.least_squares(errors, start, bounds=bounds, x_scale=start, xtol=1e-12, ftol=1e-12)
    peak, span = (float(each) for each in fitted.x)
    peaks = tuple(test.residual + drop for test, drop in zip(tests, drops(peak, span), strict=True))
    return Loss(shape, peak, peak + span, float(np.sqrt(np.mean(np.square(fitted.fun)))), peaks)
