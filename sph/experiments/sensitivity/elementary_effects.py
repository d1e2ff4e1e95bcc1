"""Screening of factors by elementary effects (Morris 1991; mu* after Campolongo, Cariboni and Saltelli 2007).

An elementary effect is the change of the quantity between two neighbouring runs of a trajectory, which differ in one factor, over the
change of that factor as a share of its range; levels have no range, and the change from one to another is the effect.  mu* is the mean of
the absolute values, sigma their standard deviation: small where the factor acts evenly and by itself, large where it acts unevenly or
together with others.

``SALib.analyze.morris`` gives the same mu, mu* and sigma, but no interval of sigma, and after one diverged run nothing of any factor
(SALib 1.6), where here the two effects are left out to which it belongs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sph.experiments.sensitivity.factors import ENDS, Axis, Quantity
from sph.experiments.sensitivity.tables import diverged_runs
from sph.storage.trajectory import Variable
from sph.study.tables import ROW, number_column, text_column

INTERVAL = (2.5, 97.5)
"""Percentiles at the ends of an interval."""

MORRIS: tuple[Variable, ...] = (
    text_column("metric", "metric, as in study.csv"),
    text_column("quantity", "what is analysed: the metric, or a logarithm of it"),
    text_column("units", "unit of the quantity, in which the effects over the whole range of a factor are given"),
    text_column("factor", "the factor"),
    number_column("mu_star", "as units", "mean absolute elementary effect"),
    *(number_column(f"mu_star_{end}", "as units", f"{end} end of its 95 % interval, bootstrap over the trajectories") for end in ENDS),
    number_column("mu", "as units", "mean elementary effect, with sign"),
    number_column("sigma", "as units", "standard deviation of the elementary effects"),
    *(number_column(f"sigma_{end}", "as units", f"{end} end of its 95 % interval") for end in ENDS),
    number_column("share", "1", "mu_star over the largest of the metric"),
    Variable("effects", ROW, "i4", "1", "number of elementary effects behind the row"),
    Variable("dropped", ROW, "i4", "1", "number of elementary effects left out because one of their two runs diverged"),
    Variable("runs", ROW, "i4", "1", "runs of the design"),
    Variable("diverged", ROW, "i4", "1", "diverged runs among them"),
)
"""The columns."""


def elementary_effects(shares: np.ndarray, values: np.ndarray, leveled: Sequence[bool] = ()) -> np.ndarray:
    """Effects (r, k) of trajectories of shares of the ranges (r, k + 1, k) and values (r, k + 1); NaN where a value is NaN.

    Of ``leveled`` factors (k,), whose levels have no distance, the whole change from one level to another.
    Raises ValueError where neighbouring points differ in other than one factor.
    """
    change = np.diff(shares, axis=1)
    moved = np.abs(change) > 1e-9
    if not (moved.sum(axis=2) == 1).all() or not (moved.sum(axis=1) == 1).all():
        raise ValueError("shares: a trajectory must move every factor once, one at a step")
    if any(leveled):
        change = np.where(leveled, np.sign(change), change)
    step = moved.argmax(axis=1)  # (r, k), at which each factor moves
    return np.take_along_axis(np.diff(values, axis=1), step, 1) / np.take_along_axis(change, step[:, None], 1)[:, 0]


def morris_table(sample: pd.DataFrame, axes: Sequence[Axis], quantities: Sequence[Quantity], resamples: int, seed: int) -> pd.DataFrame:
    """One row per metric and factor, from the runs of all trajectories in their order."""
    shares = np.column_stack([axis.share(sample[axis.name].to_numpy()) for axis in axes]).reshape(-1, len(axes) + 1, len(axes))
    rows = []
    for quantity in quantities:
        values = quantity.of(sample[quantity.metric].to_numpy()).reshape(shares.shape[:2])
        effects = elementary_effects(shares, values, [bool(axis.levels) for axis in axes])
        by_factor = [_statistics(effects[:, place], resamples, seed) for place in range(len(axes))]
        largest = np.nanmax([statistics["mu_star"] for statistics in by_factor], initial=0.0)
        for axis, statistics in zip(axes, by_factor, strict=True):
            share = statistics["mu_star"] / largest if largest > 0 else 0.0
            words = {"metric": quantity.metric, "quantity": quantity.text, "units": quantity.unit, "factor": axis.name}
            rows.append(words | statistics | {"share": share, "runs": len(sample), "diverged": diverged_runs(sample)})
    return pd.DataFrame(rows, columns=[column.name for column in MORRIS])


def _statistics(effects: np.ndarray, resamples: int, seed: int) -> dict[str, float]:
    """Statistics of the effects (r,) of a factor; NaN where fewer than two are left."""
    known = effects[np.isfinite(effects)]
    counts = {"effects": known.size, "dropped": effects.size - known.size}
    if known.size < 2:
        return dict.fromkeys([column.name for column in MORRIS if column.dtype == "f8"], np.nan) | counts
    drawn = known[np.random.default_rng(seed).integers(known.size, size=(resamples, known.size))]
    mu_star_ends = np.percentile(np.abs(drawn).mean(axis=1), INTERVAL)
    sigma_ends = np.percentile(drawn.std(axis=1, ddof=1), INTERVAL)
    return {
        "mu_star": float(np.abs(known).mean()),
        "mu_star_low": mu_star_ends[0],
        "mu_star_high": mu_star_ends[1],
        "mu": float(known.mean()),
        "sigma": float(known.std(ddof=1)),
        "sigma_low": sigma_ends[0],
        "sigma_high": sigma_ends[1],
        **counts,
    }


def influential(table: pd.DataFrame, share: float) -> list[str]:
    """Factors whose mu* is at least ``share`` of the largest for some metric, in the table's order."""
    return list(dict.fromkeys(table["factor"][table.groupby("factor")["share"].transform("max") >= share]))
