"""Critical amplitudes: the bracket of each, from the points of a search, beside the pseudo-static and the sliding block's.

What counts is whether a run is of the class or a worse one.  The bracket lies between the first amplitude that reached the class
and the last one below that did not; its middle is the critical amplitude, half its width the error of resolution.  A diverged run is
neither: it never ends a bracket, which extends to the next run that has a class, and it is counted.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.experiments.trigger.design import reached
from sph.experiments.trigger.points import POINT, WANTED, names
from sph.measures.metrics import METRIC_BY_NAME, UNDETERMINED
from sph.storage.trajectory import Variable
from sph.study.tables import ROW, count_column, number_column, read_csv, text_column
from sph.study.verdicts import FAILS, HOLDS

BRACKETED, AT_LOWEST, NEVER, UNDECIDED = "bracketed", "reached at the lowest", "not reached at the highest", "all diverged"
"""Outcomes of a search."""

BRACKET: tuple[Variable, ...] = (
    text_column(
        "outcome",
        f"{BRACKETED}; {AT_LOWEST} or {NEVER} amplitude whose run has a class, then the only end; {UNDECIDED}: no run has a class",
    ),
    number_column("critical_amplitude", "m s-2", "middle of the bracket; NaN without one"),
    number_column("resolution_error", "m s-2", "half the width of the bracket; NaN without one"),
    number_column(
        "lower", "m s-2", "largest amplitude below the upper end at which the class is not reached; NaN if it is reached at the lowest"
    ),
    number_column("upper", "m s-2", "smallest amplitude at which the class is reached; NaN if it never is"),
    count_column("diverged_inside", "diverged runs between the two: the bracket is so much wider than the tolerance"),
    count_column(
        "changes", "changes between not reached and reached along the amplitudes that were run; more than 1: not monotone in amplitude"
    ),
    number_column("last_not_reached", "m s-2", "largest amplitude at which the class is not reached; above the upper end: not monotone"),
    number_column("lower_still_moving", "1", "1 if the run at the lower end is still moving at its end: it may reach the class later"),
    number_column(
        "lower_failed_fraction", "1", "failed part of the soil at the lower end; 0: the class comes with the first failure of all"
    ),
    count_column("runs", "runs at this S_R and gamma"),
    count_column("diverged", "diverged runs among them"),
    number_column("wall_time", "s", "computing time of these runs, shared pre-failure runs included in each"),
)
CRITICAL: tuple[Variable, ...] = (
    *WANTED[:3],
    text_column("collapse_class", "the class, or a worse one, whose critical amplitude is searched"),
    *BRACKET,
    number_column("yield_acceleration", "m s-2", "pseudo-static estimate: constant acceleration at which the slope of the case fails"),
    number_column(
        "newmark_amplitude",
        "m s-2",
        "amplitude of the same motion at which a rigid block with that yield acceleration slips by the displacement at which the class "
        "begins (Newmark 1965)",
    ),
)
"""The columns."""


class Bracket(NamedTuple):
    """What the runs at one S_R and gamma say about one class; see ``BRACKET``."""

    outcome: str
    critical_amplitude: float
    resolution_error: float
    lower: float
    upper: float
    diverged_inside: int
    changes: int
    last_not_reached: float
    lower_still_moving: float
    lower_failed_fraction: float
    runs: int
    diverged: int
    wall_time: float


def bracket(points: pd.DataFrame, wanted: str) -> Bracket:
    """The bracket of a class from the points at one S_R and gamma."""
    line = points.assign(value=points["amplitude"].astype(float)).sort_values("value")
    line["reached"] = [reached(name, wanted) for name in line["collapse_class"]]
    decided = line[line["reached"].notna()]
    above, standing = (decided[decided["reached"] == verdict] for verdict in (True, False))
    upper = float(above["value"].min())
    below = standing[~(standing["value"] > upper)].tail(1)
    lower, moving, failed = (float(below[name].sum(min_count=1)) for name in ("value", "still_moving", "failed_fraction"))
    outcome = UNDECIDED if decided.empty else NEVER if math.isnan(upper) else AT_LOWEST if math.isnan(lower) else BRACKETED
    inside = line["value"].gt(lower) & line["value"].lt(upper)
    return Bracket(
        outcome,
        critical_amplitude=0.5 * (lower + upper),
        resolution_error=0.5 * (upper - lower),
        lower=lower,
        upper=upper,
        diverged_inside=int(inside.sum()),
        changes=sum(one != other for one, other in itertools.pairwise(decided["reached"])),
        last_not_reached=float(standing["value"].max()),
        lower_still_moving=moving,
        lower_failed_fraction=failed,
        runs=len(line),
        diverged=len(line) - len(decided),
        wall_time=float(line["wall_time"].sum()),
    )


def critical_table(
    points: pd.DataFrame, classes: Sequence[str], estimates: Mapping[str, Mapping[str, Mapping[str, float]]]
) -> pd.DataFrame:
    """One row a case, S_R, gamma and class; ``estimates`` hold the last two columns by case and class."""
    rows = [
        {
            **dict(zip(names(WANTED[:3]), at, strict=True)),
            "collapse_class": name,
            **bracket(line, name)._asdict(),
            **estimates[str(at[0])][name],
        }
        for at, line in points.groupby(names(WANTED[:3]), sort=False)
        for name in classes
    ]
    return pd.DataFrame(rows, columns=names(CRITICAL))


def read_critical(path: Path | str) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is none."""
    return read_csv(path, CRITICAL, "critical amplitudes")


# ---------------------------------------------------------------- another fidelity

PAIR = ("collapse_class", "displacement_magnitude", "runout")
ENDS: tuple[Variable, ...] = (
    *WANTED[:3],
    text_column("wanted_class", "the class whose bracket is confirmed"),
    text_column("end", "end of the bracket: lower or upper"),
    WANTED[3],
)
"""The columns of an end before it is run again."""
CONFIRM: tuple[Variable, ...] = (
    *ENDS,
    *(METRIC_BY_NAME[name]._replace(dims=ROW) for name in PAIR),
    *(
        METRIC_BY_NAME[name]._replace(name=f"confirming_{name}", dims=ROW, text=f"{name} at the confirming fidelity")
        for name in ("status", *PAIR)
    ),
    *(
        number_column(f"{name}_difference", METRIC_BY_NAME[name].units, f"confirming {name} minus that of the search; NaN if one diverged")
        for name in PAIR[1:]
    ),
    text_column("verdict", "holds: on this side of the class at both fidelities; fails: on the other side; undetermined: a run diverged"),
)
"""The columns."""


def bracket_ends(
    table: pd.DataFrame, points: pd.DataFrame, wanted: str, cases: Sequence[str], S_R: Sequence[str], gamma: Sequence[str]
) -> pd.DataFrame:
    """The ends that exist of the brackets of a class, for chosen cases and numbers, with the columns ``ENDS``."""
    chosen = {(case, float(one), float(other)) for case in cases for one in S_R for other in gamma}
    labels = {float(label): label for label in points["amplitude"]}
    rows = [
        {**row, "wanted_class": wanted, "end": end, "amplitude": labels[row[end]]}
        for row in table[table["collapse_class"] == wanted].to_dict("records")
        for end in ("lower", "upper")
        if (row["case"], float(row["S_R"]), float(row["gamma"])) in chosen and not math.isnan(row[end])
    ]
    return pd.DataFrame(rows, columns=names(ENDS))


def confirm_table(ends: pd.DataFrame, points: pd.DataFrame, confirming: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """One row an end, from the points of the search and the metrics of the confirming runs in the ends' order."""
    by_point = points.set_index(POINT)
    rows = []
    for end, other in zip(ends.to_dict("records"), confirming, strict=True):
        own = by_point.loc[tuple(end[name] for name in POINT)]
        sides = {reached(str(name), end["wanted_class"]) for name in (own["collapse_class"], other["collapse_class"])}
        rows.append(
            end
            | {name: own[name] for name in PAIR}
            | {f"confirming_{name}": other[name] for name in ("status", *PAIR)}
            | {f"{name}_difference": other[name] - own[name] for name in PAIR[1:]}
            | {"verdict": UNDETERMINED if None in sides else HOLDS if len(sides) == 1 else FAILS}
        )
    return pd.DataFrame(rows, columns=names(CONFIRM))


def read_ends(path: Path | str) -> pd.DataFrame:
    """Table of ends to be run again, from its CSV; ValueError names a file that is none."""
    return read_csv(path, ENDS, "ends of brackets")
