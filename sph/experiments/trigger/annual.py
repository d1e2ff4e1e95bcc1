"""How often a year the slope reaches each class: the fragility integrated over the hazard of the site."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from sph.experiments.trigger.boundaries import who_reaches_what
from sph.experiments.trigger.fragility import CONFIDENCE, brackets, fit_brackets
from sph.experiments.trigger.hazard import Hazard, annual_frequency
from sph.experiments.trigger.points import CASE_COLUMN, CLASS_COLUMN, names
from sph.storage.trajectory import Variable
from sph.study.tables import number_column, text_column

PER_YEAR = "year-1"
RARE = 1e-3
"""Probability at the first row of the hazard curve below which weaker shaking is not worth a word."""


def annual_columns(units: str) -> tuple[Variable, ...]:
    """The columns of the annual frequencies, with the unit of the intensity."""
    return (
        CASE_COLUMN,
        CLASS_COLUMN,
        number_column(
            "frequency", PER_YEAR, "annual frequency with which it is reached by shaking within the hazard curve; NaN without a fit"
        ),
        number_column(
            "frequency_lower",
            PER_YEAR,
            f"lower end of its {CONFIDENCE:.0%} interval by the samples of the fit; the hazard is taken as known",
        ),
        number_column("frequency_upper", PER_YEAR, "upper end"),
        number_column(
            "frequency_least",
            PER_YEAR,
            "lower bound from the brackets alone, for shaking above the first intensity of the hazard curve: a motion reaches the class "
            "only above the upper end of its bracket, one without an upper end never",
        ),
        number_column(
            "frequency_most",
            PER_YEAR,
            "upper bound likewise: every motion reaches the class above the lower end of its bracket, one without a lower end always; "
            "beyond the last intensity of the curve the frequency there counts",
        ),
        number_column(
            "share_searched", "1", "share of the frequency from intensities between the lowest and the highest that were searched"
        ),
        number_column("first", units, "first intensity of the hazard curve; weaker shaking is left out"),
        number_column("probability_at_first", "1", "probability that the class is reached there; it is smaller for weaker shaking"),
        number_column("last", units, "last intensity of the hazard curve; stronger shaking is left out"),
        number_column("beyond_last", PER_YEAR, "annual frequency of stronger shaking, which is the most that it can add"),
        text_column("sentence", "the result in words"),
    )


def annual_table(critical: pd.DataFrame, hazard: Hazard, lowest: float, highest: float, unit: str) -> pd.DataFrame:
    """One row per case and class, from critical intensities (``read_critical``) searched between two ends, in a ``unit`` as printed."""
    rows, columns = [], names(annual_columns("1"))
    searched = hazard.between(lowest, highest)
    for (case, name), group in critical.groupby(["case", "collapse_class"], sort=False):
        fit, row = fit_brackets(*brackets(group)), dict.fromkeys(columns, math.nan) | {"case": case, "collapse_class": name}
        row |= {"first": hazard.intensity[0], "last": hazard.intensity[-1], "beyond_last": hazard.frequency[-1]}
        if not math.isnan(fit.best.median):
            (own,), (within,) = (annual_frequency(np.array([fit.best]), curve) for curve in (hazard, searched))
            low, high = fit.interval(annual_frequency(fit.samples, hazard))
            row |= {"frequency": own, "frequency_lower": low, "frequency_upper": high}
            row |= {"share_searched": within / own if own > 0.0 else math.nan}
            row |= {"probability_at_first": float(fit.best.exceedance(hazard.intensity[:1])[0])}
        row |= dict(zip(("frequency_least", "frequency_most"), frequency_bounds(group, hazard), strict=True))
        rows.append(row | {"sentence": sentence(row, unit)})
    return pd.DataFrame(rows, columns=columns)


def frequency_bounds(critical: pd.DataFrame, hazard: Hazard) -> tuple[float, float]:
    """Least and most annual frequency (1/year) that the brackets of equally likely motions leave possible.

    ``critical``: rows of the table of critical intensities.  A motion whose critical intensity is x reaches it H(x) times a year;
    beyond the last intensity of the curve that is between 0 and its frequency there.  Shaking weaker than the first is left out.
    """
    lower, upper = critical["lower"].fillna(0.0).to_numpy(float), critical["upper"].fillna(math.inf).to_numpy(float)
    known = upper <= hazard.intensity[-1]
    return float(np.mean(known * hazard.exceeded(upper))), float(np.mean(hazard.exceeded(lower)))


def sentence(row: dict[str, object], unit: str) -> str:
    """What a row says."""
    who, what = who_reaches_what(str(row["collapse_class"]))
    frequency, low, high, first, at_first, last, beyond = (
        float(str(row[name]))
        for name in ("frequency", "frequency_lower", "frequency_upper", "first", "probability_at_first", "last", "beyond_last")
    )
    if math.isnan(frequency):
        least, most = (float(str(row[name])) for name in ("frequency_least", "frequency_most"))
        return (
            f"The brackets do not determine a fit. From them alone, {who} reaches {what} between {least:.2g} and {most:.2g} times a year "
            "under this hazard curve."
        )
    weaker = ""
    if at_first >= RARE:
        weaker = f" Weaker shaking than {first:.3g} {unit}".rstrip() + f", at which the chance is {at_first:.2g}, is left out."
    years = f", once in {_two_digits(1.0 / frequency)} years on average" if frequency > 0.0 else ""
    return (
        f"Under these assumptions and this hazard curve {who} reaches {what} {frequency:.2g} times a year ({low:.2g} to {high:.2g}, "
        f"{CONFIDENCE:.0%} interval of the fit){years}."
        + weaker
        + f" Stronger shaking than {last:.3g} {unit}".rstrip()
        + f" adds at most {beyond:.2g} a year."
    )


def _two_digits(value: float) -> str:
    """A number in two digits, without an exponent: ``390`` of 391."""
    return f"{float(f'{value:.2g}'):,.10g}"
