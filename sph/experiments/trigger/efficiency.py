"""Which intensity measure predicts best whether a class is reached: the one whose critical values scatter least.

Motions scale in proportion, so that every critical intensity is also a critical peak acceleration, peak velocity, Arias intensity and
spectral acceleration of the same motion.  Fragility is fitted to each.  A measure that grows with the p-th power of the accelerations has
p times the dispersion that one of the first power has for the same scatter; beta / p compares them, and the least is the most efficient
(Luco and Cornell 2007, Earthquake Spectra 23 (2), 357-392).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.fragility import CONFIDENCE, RESAMPLES, Conversion, brackets, decided, fit_brackets
from sph.experiments.trigger.hazard import INTENSITIES
from sph.experiments.trigger.points import CASE_COLUMN, CLASS_COLUMN, Key, label_columns, names
from sph.scene.ground_motion.measures import measure
from sph.scene.ground_motion.spectrum import DAMPING, pseudo_acceleration
from sph.scene.loading import loading_of
from sph.scene.motion import ConstantAcceleration
from sph.scene.schema import Scene
from sph.study.tables import count_column, number_column, text_column

PGA, PGV, ARIAS = "peak acceleration", "peak velocity", "Arias intensity"
POWERS = {ARIAS: 2.0}
"""Power of the accelerations to which a measure grows, where it is not the first."""
UNITS = {PGV: "m s-1", ARIAS: "m s-1"}
"""Units of the measures that are no accelerations."""
SAME = {"amplitude": PGA, "motion.peak_velocity": PGV, "motion.arias_intensity": ARIAS}
"""Measures that are searched under the name of a dimension."""

MEASURE_COLUMNS = (
    CASE_COLUMN,
    CLASS_COLUMN,
    count_column("rank", "rank in the case and class by scatter, beta over the power; 1: the least"),
    text_column(
        "measure", f"measure of the horizontal motion; spectral acceleration with {DAMPING:.0%} damping, or the intensity searched"
    ),
    text_column("unit", "unit of the measure and its median"),
    count_column("searched", "1 for the intensity that is searched"),
    count_column("motions", "motions, or other values, whose brackets are fitted"),
    number_column("power", "1", "power p of the acceleration with which the measure grows"),
    number_column(
        "median", "that of the measure", "theta, the value at which half of the motions reach the class; NaN where there is no fit"
    ),
    number_column("dispersion", "1", "beta, standard deviation of the logarithm of the critical values"),
    number_column("dispersion_lower", "1", f"lower end of its {CONFIDENCE:.0%} interval by {RESAMPLES} samples drawn from the fit"),
    number_column("dispersion_upper", "1", "upper end"),
    number_column("dispersion_over_power", "1", "beta / p, by which the measures are compared and the rows are sorted"),
)
"""The columns of the table of measures."""


def motion_measures(scene: Scene, periods: Sequence[float]) -> dict[str, float]:
    """Measures of a scene's horizontal motion over its duration, m/s2 and m/s, by name; none of a load that stays, which has no peak
    velocity nor spectrum of its own."""
    if isinstance(scene.motion, ConstantAcceleration):
        return {}
    loading = loading_of(scene)
    interval = float(loading.time[1])
    measured = measure(loading.ground, interval)
    spectrum = pseudo_acceleration(loading.ground, interval, np.array(periods)) if periods else ()
    own = {PGA: measured.peak_acceleration, PGV: measured.peak_velocity, ARIAS: measured.arias_intensity}
    return own | {f"spectral acceleration at {period:g} s": float(value) for period, value in zip(periods, spectrum, strict=True)}


def measures_table(
    critical: pd.DataFrame, motions: Mapping[Key, Mapping[str, float]], reference: float, searched: Searched
) -> pd.DataFrame:
    """One row per case, class and measure, the most efficient first, from critical intensities (``read_critical``).

    ``motions``: measures by case and values of the other dimensions, at the ``reference`` intensity.  No rows for a case with a motion
    without measures, or one that stands still.
    """
    at, rows = names(label_columns(searched.others)), []
    own, grows = searched.intensity_name, INTENSITIES[searched.intensity_name].power
    for (case, name), group in critical.groupby(["case", "collapse_class"], sort=False):
        known = decided(group)
        measured = pd.DataFrame([motions[tuple(map(str, key))] for key in known[at].itertuples(index=False, name=None)])
        if not len(measured.columns) or not (measured.to_numpy() > 0.0).all():
            continue
        fits = {SAME.get(own, own): Conversion(np.ones(len(known)), 1.0)}
        for label in (name for name in measured.columns if name not in fits):
            power = grows * POWERS.get(label, 1.0)
            fits[label] = Conversion(measured[label].to_numpy() / reference**power, power)
        of_class = []
        for label, conversion in fits.items():
            fit = fit_brackets(*brackets(group), conversion)
            ends = fit.interval(fit.samples[:, 1])
            is_searched = label == SAME.get(own, own)
            power = 1.0 / grows if is_searched else POWERS.get(label, 1.0)
            unit = searched.intensity.variable(listed=False).units if is_searched else UNITS.get(label, "m s-2")
            median, beta = fit.best
            of_class.append((case, name, 0, label, unit, int(is_searched), len(known), power, median, beta, *ends, beta / power))
        made = pd.DataFrame(of_class, columns=names(MEASURE_COLUMNS)).sort_values("dispersion_over_power", kind="stable")
        rows.append(made.assign(rank=np.arange(1, len(made) + 1)))
    return pd.concat(rows, ignore_index=True) if rows else pd.DataFrame(columns=names(MEASURE_COLUMNS))
