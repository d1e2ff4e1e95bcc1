"""How far the slope moves: the share of the motions whose run-out, displacement or depth of debris at a place exceeds a length, at given
intensities of the shaking, and the width that most of them do not pass.

An empirical curve, no distribution is fitted.  It is taken at the intensities at which all values of the search were run, the ends of its
first cells at least: those at which only some were run are near their critical intensities, a choice that would distort the share.
A diverged run has no length: it may exceed any, and counts in the upper share alone.  So does a run whose debris is braked, of a length
that it does not exceed: with more rows of particles it might.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from sph.checks.after_run import held
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.points import CASE_COLUMN, label_columns, names
from sph.measures.metrics import UNDETERMINED
from sph.measures.places import DEPTH, column_of, places_in
from sph.storage.trajectory import Variable
from sph.study.tables import count_column, number_column, text_column

LENGTHS = ("runout", "displacement_magnitude")
"""The metrics whose exceedance is counted."""


def exceedance_columns(units: str) -> tuple[Variable, ...]:
    """The columns of the exceedance, with the unit of the intensity."""
    return (
        CASE_COLUMN,
        number_column("intensity", units, "intensity of the shaking at which all values of the search were run"),
        text_column("metric", f"{' or '.join(LENGTHS)}, or the depth of debris at a place"),
        number_column("exceeded", "m", "the length that may be exceeded: 0, and the value of each run"),
        count_column("motions", "runs at this intensity, one of every motion or other value"),
        count_column("exceeding", "those with a larger value"),
        count_column("diverged", "diverged ones, whose value is not known"),
        count_column("still_moving", "others that are still moving at their end: their value may become larger"),
        count_column("braked", "others whose debris is braked: their value is a lower bound"),
        number_column("share_lower", "1", "exceeding over motions, as if no diverged or braked run exceeded more than is known"),
        number_column("share_upper", "1", "exceeding, diverged and braked over motions, as if all of them did"),
    )


def _shaken_alike(points: pd.DataFrame, searched: Searched) -> Iterator[tuple[str, float, pd.DataFrame]]:
    """Case, intensity and runs, for each intensity at which all values of a case were run."""
    at = names(label_columns(searched.others))
    for case, line in points.groupby("case", sort=False):
        values = len(line[at].drop_duplicates())
        for intensity, runs in sorted(line.groupby(line[searched.intensity_name].astype(float))):
            if len(runs) == values:
                yield str(case), intensity, runs


def exceedance(points: pd.DataFrame, searched: Searched) -> pd.DataFrame:
    """One row per case, intensity, metric and length, from the points of a search (``read_points``).

    No rows for a metric that runs of a case lack without having diverged, as the run-out of a shape without a slope.
    """
    rows = []
    depths = [column_of(place, DEPTH) for place in places_in(points.columns)]
    of_class = points[points["collapse_class"] != UNDETERMINED].groupby("case", sort=False)
    lacking = {(case, name) for case, line in of_class for name in (*LENGTHS, *depths) if line[name].isna().any()}
    for case, intensity, runs in _shaken_alike(points, searched):
        diverged = runs["collapse_class"] == UNDETERMINED
        moving = int((~diverged & (runs["still_moving"] > 0)).sum())
        braked = held(runs[~diverged]).to_numpy(bool)
        for name in (name for name in (*LENGTHS, *depths) if (case, name) not in lacking):
            lengths = runs.loc[~diverged, name].to_numpy(float)
            for length in np.unique(np.append(lengths, 0.0)):
                beyond = lengths > length
                counts = (len(runs), int(beyond.sum()), int(diverged.sum()), moving, int(braked.sum()))
                shares = (beyond.sum() / len(runs), ((beyond | braked).sum() + diverged.sum()) / len(runs))
                rows.append((case, intensity, name, float(length), *counts, *shares))
    return pd.DataFrame(rows, columns=names(exceedance_columns("1")))


SHARES = (0.5, 0.84, 0.95)
"""Shares of the runs whose widths are given."""


def width_within(runouts: np.ndarray, share: float) -> float:
    """The smallest of the run-outs (n,), m, that at least this share of the runs does not pass; infinite where too many are not known
    (NaN), NaN without any."""
    ordered = np.sort(np.where(np.isnan(runouts), np.inf, runouts))
    return float(ordered[max(math.ceil(share * ordered.size - 1e-9) - 1, 0)]) if ordered.size else math.nan


def width_columns(units: str) -> tuple[Variable, ...]:
    """The columns of the widths, with the unit of the intensity."""
    return (
        CASE_COLUMN,
        number_column("intensity", units, "intensity of the shaking at which all values of the search were run"),
        count_column("motions", "runs at this intensity, one of every motion or other value"),
        count_column("diverged", "diverged ones, which count as if their run-out were unlimited"),
        count_column("still_moving", "others that are still moving at their end: their run-out may become larger"),
        count_column("braked", "others whose debris is braked, which count as diverged ones do: their run-out is a lower bound"),
        *(
            number_column(
                f"width_{100.0 * share:.0f}",
                "m",
                f"smallest run-out that {share:.0%} of the runs do not pass; infinite: too many are unknown",
            )
            for share in SHARES
        ),
        number_column("widest", "m", "largest run-out of those that did not diverge"),
    )


def widths(points: pd.DataFrame, searched: Searched) -> pd.DataFrame:
    """One row per case and intensity at which all values were run; none for a case without run-out."""
    rows = []
    for case, intensity, runs in _shaken_alike(points, searched):
        runouts, diverged = runs["runout"].to_numpy(float), runs["collapse_class"] == UNDETERMINED
        if np.isnan(runouts).sum() == diverged.sum():
            widest = float(np.nanmax(runouts)) if not diverged.all() else math.nan
            braked = ~diverged & held(runs)
            counts = (len(runs), int(diverged.sum()), int((~diverged & (runs["still_moving"] > 0)).sum()), int(braked.sum()))
            known = np.where(braked, math.nan, runouts)
            rows.append((case, intensity, *counts, *(width_within(known, share) for share in SHARES), widest))
    return pd.DataFrame(rows, columns=names(width_columns("1")))
