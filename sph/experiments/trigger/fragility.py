"""Fragility: the probability that a class is reached at an intensity, from the brackets of a search over many motions.

The values at which a search was made (records, seeds of a synthetic motion, soils) are a sample.  Their critical intensities are taken as
lognormal, P = Phi(ln(x / theta) / beta), with median theta and dispersion beta of greatest likelihood.  A bracket counts by the probability
between its ends, one that is open by that beyond its only end (Baker 2015, Earthquake Spectra 31 (1), 579-599, of truncated analyses).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]

from sph.experiments.trigger.boundaries import who_reaches_what
from sph.experiments.trigger.critical import AT_LOWEST, BRACKETED, BRAKED, NEVER, UNDECIDED
from sph.experiments.trigger.hazard import log_between
from sph.experiments.trigger.points import CASE_COLUMN, CLASS_COLUMN, names
from sph.scene.units import GRAVITY
from sph.storage.trajectory import Variable
from sph.study.dimensions import shown_unit
from sph.study.tables import count_column, number_column, text_column

RESAMPLES = 1000
"""Samples drawn from the fit for the intervals."""
SEED = 1
"""Of these and of the check of the fit."""
CONFIDENCE = 0.9
"""Share of the samples whose results lie in an interval."""
DISPERSIONS = (1e-3, 9.0)
"""Least and largest dispersion of a fit; beyond them there is none."""
ITERATIONS, HALVINGS, CONVERGED = 60, 30, 1e-9
"""Most steps of the fit and most divisions of each, and the relative step at which it has converged."""
TAILS = (0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE)
POINTS = 200
"""Points of a curve."""
FEWEST = 4
"""Fewest brackets whose distribution is checked."""


class Lognormal(NamedTuple):
    """Distribution of the critical intensities; NaN where the brackets do not determine it."""

    median: float
    dispersion: float

    def exceedance(self, intensity: np.ndarray) -> np.ndarray:
        """Probability that the class is reached at intensities (n,) above 0."""
        return scipy.special.ndtr(np.log(intensity / self.median) / self.dispersion)


NO_FIT = Lognormal(math.nan, math.nan)


def fitted(lower: np.ndarray, upper: np.ndarray) -> Lognormal:
    """The lognormal distribution of greatest likelihood for values (n,) known to lie between ends; 0 and infinity are open.

    ``NO_FIT`` where one value lies in all brackets or at their ends, to which any small dispersion fits, and where the likelihood has no
    greatest value.
    """
    return Lognormal(*map(float, fits(lower[None], upper[None])[0]))


def fits(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Median and dispersion (m, 2) of greatest likelihood for m samples of brackets (m, n), as by ``fitted``; NaN where there is no fit.

    By Newton's method in 1 / beta and ln(theta) / beta, in which the logarithm of the likelihood is concave (Burridge 1981, Journal of the
    Royal Statistical Society B 43 (1), 41-45).  ``scipy.stats.lognorm.fit`` of ``CensoredData`` finds the same to the fifth digit in
    0.6 to 1.2 s a sample (SciPy 1.17); the ``RESAMPLES`` of an interval take 0.3 to 0.8 s here together, on the same processor.
    """
    parameters = np.full((len(lower), 2), math.nan)
    rows = np.flatnonzero(lower.max(axis=1, initial=0.0) > upper.min(axis=1, initial=math.inf))
    if lower.shape[1] < 2 or not rows.size:
        return parameters
    with np.errstate(divide="ignore"):
        logs = np.log(np.stack([lower[rows], upper[rows]]))
    known = np.isfinite(logs)
    centre = logs[known].mean()
    ends = np.where(known, logs - centre, logs)
    slope = np.full(rows.size, 1.0 / max(float(ends[known].std()), 0.05))
    at = np.stack([slope, np.zeros(rows.size)], axis=1)
    value, gradient, curvature = _likelihood(ends, at)
    open_rows = np.ones(rows.size, bool)
    for _ in range(ITERATIONS):
        determinant = curvature[:, 0, 0] * curvature[:, 1, 1] - curvature[:, 0, 1] ** 2
        open_rows &= determinant > 0.0
        inverse = np.stack([curvature[:, 1, 1], -curvature[:, 0, 1], -curvature[:, 0, 1], curvature[:, 0, 0]], axis=1).reshape(-1, 2, 2)
        step = np.zeros_like(at)
        step[open_rows] = -np.einsum("mij,mj->mi", inverse[open_rows], gradient[open_rows]) / determinant[open_rows, None]
        if not (np.abs(step) > CONVERGED * (1.0 + np.abs(at))).any():
            break
        for _ in range(HALVINGS):
            tried = at + step
            tried_value, gradient, curvature = _likelihood(ends, np.where(tried[:, :1] > 0.0, tried, at))
            worse = ~((tried[:, 0] > 0.0) & (tried_value >= value - 1e-12 * np.abs(value)))
            if not worse.any():
                break
            step[worse] *= 0.5
        step[worse] = 0.0
        at = at + step
        open_rows &= ~worse & (at[:, 0] > 0.5 / DISPERSIONS[1])
        value, gradient, curvature = _likelihood(ends, at)
    dispersion = 1.0 / at[:, 0]
    settled = (np.abs(step) <= CONVERGED * (1.0 + np.abs(at))).all(axis=1)
    inside = settled & (dispersion > DISPERSIONS[0]) & (dispersion < DISPERSIONS[1])
    parameters[rows[inside]] = np.stack([np.exp(centre + at[:, 1] * dispersion), dispersion], axis=1)[inside]
    return parameters


def _likelihood(ends: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Logarithm of the likelihood (m,), its gradient (m, 2) and second derivatives (m, 2, 2) in 1 / beta and mean / beta, from the
    logarithms of the ends (2, m, n)."""
    low, high = at[:, :1] * ends - at[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        between = log_between(low, high)
        density = np.exp(-0.5 * np.stack([low, high]) ** 2 - 0.5 * math.log(2.0 * math.pi) - between)
    signed = np.array([-1.0, 1.0])[:, None, None] * density
    finite = np.isfinite(ends)
    by_end = np.stack([np.where(finite, ends, 0.0), -np.ones_like(ends)])  # derivatives of the ends in the two parameters
    gradient = np.einsum("emn,pemn->mp", signed, by_end)
    score = np.einsum("emn,pemn->pmn", signed, by_end)
    scaled = np.where(finite, np.stack([low, high]), 0.0) * signed
    curvature = -np.einsum("emn,pemn,qemn->mpq", scaled, by_end, by_end) - np.einsum("pmn,qmn->mpq", score, score)
    return between.sum(axis=1), gradient, curvature


class Conversion(NamedTuple):
    """What a measure of the shaking is for an intensity x that a motion is scaled to: factor x^power."""

    factor: np.ndarray
    """(n,) of every motion"""
    power: float

    def measured(self, intensity: np.ndarray) -> np.ndarray:
        """The measure at intensities (..., n); 0 and infinity stay."""
        return self.factor * intensity**self.power

    def intensity(self, measured: np.ndarray) -> np.ndarray:
        """The intensity at values (..., n) of the measure."""
        return (measured / self.factor) ** (1.0 / self.power)


AS_SEARCHED = Conversion(np.array(1.0), 1.0)
"""The intensity that is searched is the measure."""


class Fit(NamedTuple):
    """The distribution of greatest likelihood, and those of samples like the brackets."""

    best: Lognormal
    samples: np.ndarray
    """median and dispersion (m, 2) of the samples that determine them"""
    without: int
    """samples that do not"""

    def interval(self, values: np.ndarray) -> np.ndarray:
        """Ends (2, ...) of the interval of what the samples give (m, ...); NaN without samples."""
        return np.quantile(values, TAILS, axis=0) if len(values) else np.full((2, *values.shape[1:]), math.nan)


def fit_brackets(lower: np.ndarray, upper: np.ndarray, conversion: Conversion = AS_SEARCHED) -> Fit:
    """The fit to brackets (n,), of the measure that ``conversion`` makes of the intensity, with its samples (``resampled``)."""
    best = fitted(conversion.measured(lower), conversion.measured(upper))
    drawn = np.empty((0, 2)) if math.isnan(best.median) else resampled(lower, upper, conversion=conversion)
    kept = drawn[~np.isnan(drawn[:, 0])]
    return Fit(best, kept, len(drawn) - len(kept))


def resampled(
    lower: np.ndarray, upper: np.ndarray, resamples: int = RESAMPLES, seed: int = SEED, conversion: Conversion = AS_SEARCHED
) -> np.ndarray:
    """Median and dispersion (resamples, 2) that samples like the brackets (n,) leave possible; NaN where there is no fit.

    The brackets are of the intensity that is searched, median and dispersion of the measure that ``conversion`` makes of it.

    Parametric bootstrap: n values are drawn from the fit and bracketed as those given, see ``bracketed_alike``.  With the fit of a sample
    (theta*, beta*) and the own one, ln(theta* / theta) / beta* and beta* / beta depend on n alone where values are known exactly; solved
    for the unknown median and dispersion they give intervals that hold for few motions also, where quantiles of theta* and beta*
    themselves are too narrow.
    """
    fit = fitted(conversion.measured(lower), conversion.measured(upper))
    if math.isnan(fit.median):
        return np.full((resamples, 2), math.nan)
    values = fit.median * np.exp(fit.dispersion * np.random.default_rng(seed).normal(size=(resamples, lower.size)))
    ends = bracketed_alike(conversion.intensity(values), lower, upper)
    median, dispersion = fits(*map(conversion.measured, ends)).T
    ratio = fit.dispersion / dispersion
    return np.stack([fit.median * (fit.median / median) ** ratio, fit.dispersion * ratio], axis=1)


def bracketed_alike(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the brackets in which a search would find values (m, n), from those (n,) that it found.

    Cells are as wide as the median of the closed brackets and lie as the first of them.  A value is open below the end of those open
    below, and above that of those open above.
    """
    closed = (lower > 0.0) & (upper < math.inf)
    below, above = values, values
    if closed.any():
        width, first = float(np.median((upper - lower)[closed])), float(lower[closed][0])
        below = np.maximum(first + width * np.floor((values - first) / width), 0.0)
        above = first + width * (np.floor((values - first) / width) + 1.0)
    lowest, highest = upper[lower == 0.0].max(initial=0.0), lower[upper == math.inf].min(initial=math.inf)
    under, over = values < lowest, values >= highest
    return np.where(under, 0.0, np.where(over, highest, below)), np.where(over, math.inf, np.where(under, lowest, above))


def lognormality(values: np.ndarray) -> tuple[float, float]:
    """Distance of Kolmogorov and Smirnov of values (n,) from the lognormal distribution of their mean and spread, and its p-value.

    The p-value is by simulation, since mean and spread are those of the values (Lilliefors 1967); NaN for fewer than ``FEWEST``, and for
    values that are all the same.
    """
    if values.size < FEWEST or np.ptp(values) == 0.0:
        return math.nan, math.nan
    test = scipy.stats.goodness_of_fit(scipy.stats.norm, np.log(values), statistic="ks", n_mc_samples=999, rng=np.random.default_rng(SEED))
    return float(test.statistic), float(test.pvalue)


def fit_columns(units: str) -> tuple[Variable, ...]:
    """The columns of the fits, with the unit of the intensity."""
    share = f"{CONFIDENCE:.0%} interval by {RESAMPLES} samples drawn from the fit (parametric bootstrap)"
    return (
        CASE_COLUMN,
        CLASS_COLUMN,
        text_column("intensity", "the dimension that is searched"),
        count_column("motions", "motions, or other values, at which it was searched"),
        count_column("bracketed", f"those with outcome {BRACKETED}"),
        count_column("at_lowest", f"those with outcome {AT_LOWEST}: only an upper end is known"),
        count_column("never", f"those with outcome {NEVER}: censored, only a lower end is known"),
        count_column("undecided", f"those with outcome {UNDECIDED}, which say nothing of the fit"),
        count_column("braked", f"those with outcome {BRAKED}: at most an upper end is known"),
        count_column("not_monotone", "motions for which the class is reached, but not at a higher intensity"),
        count_column("diverged", "diverged runs at all motions"),
        number_column("median", units, "theta, the intensity at which half of the motions reach the class; NaN where there is no fit"),
        number_column("median_lower", units, f"lower end of its {share}"),
        number_column("median_upper", units, "upper end"),
        number_column("dispersion", "1", "beta, standard deviation of the logarithm of the critical intensity"),
        number_column("dispersion_lower", "1", "lower end of its interval, likewise"),
        number_column("dispersion_upper", "1", "upper end"),
        count_column("resamples_without_fit", "samples that do not determine a distribution, which the intervals leave out"),
        number_column(
            "distance", "1", "Kolmogorov-Smirnov distance of the bracket midpoints from a lognormal distribution; NaN if any is open"
        ),
        number_column("p_value", "1", "probability of a larger distance if they are lognormal (Lilliefors)"),
        text_column("sentence", "the result in words"),
    )


def brackets(rows: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Ends (n,) of the brackets in rows of the table of critical intensities; 0 and infinity where open.  Those without: left out."""
    known = decided(rows)
    return known["lower"].fillna(0.0).to_numpy(float), known["upper"].fillna(math.inf).to_numpy(float)


def decided(rows: pd.DataFrame) -> pd.DataFrame:
    """Those of the rows that have a bracket, open or not."""
    return rows[rows[["lower", "upper"]].notna().any(axis=1)]


def curve_columns(units: str) -> tuple[Variable, ...]:
    """The columns of the curves, with the unit of the intensity."""
    return (
        CASE_COLUMN,
        CLASS_COLUMN,
        number_column("intensity", units, "intensity of the shaking"),
        number_column("probability", "1", "probability that the class is reached"),
        number_column("probability_lower", "1", f"lower end of its {CONFIDENCE:.0%} interval by the same samples as that of the median"),
        number_column("probability_upper", "1", "upper end"),
    )


def fragility(critical: pd.DataFrame, unit: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Fits, one row per case and class, and their curves, from critical intensities (``read_critical``) in a ``unit`` as printed."""
    rows, curves = [], list[pd.DataFrame]()
    highest = 1.2 * float(critical[["lower", "upper"]].max().max())
    for (case, name, intensity), group in critical.groupby(["case", "collapse_class", "intensity"], sort=False):
        fit = fit_brackets(*brackets(group))
        ends = fit.interval(fit.samples)
        if len(fit.samples):
            at = np.linspace(highest / POINTS, highest, POINTS)
            band = fit.interval(np.array([Lognormal(*sample).exceedance(at) for sample in fit.samples]))
            values = (case, name, at, fit.best.exceedance(at), *band)
            curves.append(pd.DataFrame(dict(zip(names(curve_columns("1")), values, strict=True))))
        closed = (group["outcome"] == BRACKETED).all()
        distance, p_value = lognormality(group["critical_intensity"].to_numpy(float)) if closed else (math.nan, math.nan)
        counts = {label: int((group["outcome"] == outcome).sum()) for label, outcome in OUTCOMES.items()}
        row = {
            "case": case, "collapse_class": name, "intensity": intensity, "motions": len(group), **counts,
            "not_monotone": int((group["changes"] > 1).sum()), "diverged": int(group["diverged"].sum()),
            "median": fit.best.median, "median_lower": ends[0, 0], "median_upper": ends[1, 0],
            "dispersion": fit.best.dispersion, "dispersion_lower": ends[0, 1], "dispersion_upper": ends[1, 1],
            "resamples_without_fit": fit.without, "distance": distance, "p_value": p_value,
        }  # fmt: skip
        rows.append(row | {"sentence": sentence(row, unit)})
    drawn = pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(columns=names(curve_columns("1")))
    return pd.DataFrame(rows, columns=names(fit_columns("1"))), drawn


OUTCOMES = {"bracketed": BRACKETED, "at_lowest": AT_LOWEST, "never": NEVER, "undecided": UNDECIDED, "braked": BRAKED}
"""Outcomes of a search by the names of the columns that count them."""


def sentence(row: dict[str, object], unit: str) -> str:
    """What a row says, with the ``unit`` as it is printed; accelerations in g as well."""
    who, what = who_reaches_what(str(row["collapse_class"]))
    counted = f"{row['motions']} motions, {row['never'] or 'none'} of them never reaching it up to the highest intensity"
    if row["braked"]:
        counted += f", {row['braked']} with debris that is braked before it and might reach it"
    median, low, high = (float(str(row[name])) for name in ("median", "median_lower", "median_upper"))
    if math.isnan(median):
        return f"The brackets of {counted}, do not determine the shaking at which {who} has a 50 % chance of reaching {what}."
    level = f"{median:.3g} {unit}".rstrip()
    if unit == shown_unit("m/s2"):
        low, high, unit = low / GRAVITY, high / GRAVITY, "g"
        level = f"{level} or {median / GRAVITY:.3g} g"
    span = f"{low:.3g} to {high:.3g} {unit}".rstrip()
    return f"Under these assumptions {who} has a 50 % chance of reaching {what} at {level} ({span}, {CONFIDENCE:.0%} interval); {counted}."


def steps(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ends (m,) of the brackets in the order of their middles, and the share (m,) of all motions up to each; open ones are not drawn."""
    ends = np.array([(low, high) for low, high in zip(lower, upper, strict=True) if low > 0.0 and high < math.inf]).reshape(-1, 2)
    ends = ends[np.argsort(ends.sum(axis=1), kind="stable")]
    below = int(sum(low == 0.0 for low in lower))
    return ends[:, 0], ends[:, 1], (below + np.arange(1, len(ends) + 1) - 0.5) / max(len(lower), 1)
