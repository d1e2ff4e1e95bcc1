"""Critical intensities: the bracket of each, from the points of a search, beside the pseudo-static and the sliding block's.

What counts is whether a run is of the class or a worse one.  The bracket lies between the first intensity that reached the class
and the last one below that did not; its middle is the critical intensity, half its width the error of resolution.  A diverged run is
neither: it never ends a bracket, which extends to the next run that has a class, and it is counted.  Nor is one whose debris is braked
before the length or place: with more rows of particles it might come there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sph.experiments.trigger.boundaries import block_displacement, shown
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.hazard import INTENSITIES
from sph.experiments.trigger.points import Key, columns_in, label_columns, names
from sph.measures.metrics import METRIC_BY_NAME, UNDETERMINED, MetricSettings
from sph.scene.configuration import merge
from sph.scene.schema import Scene
from sph.stability.extrapolation import MIN_RATIO, RATIO, to_zero
from sph.stability.search import Search
from sph.storage.trajectory import Variable
from sph.study.baseline import newmark_factor
from sph.study.dimensions import Dimension, value_of
from sph.study.tables import MAX_SLOPES, count_column, number_column, read_csv, text_column
from sph.study.verdicts import FAILS, HOLDS

ONE = Searched((Dimension("amplitude", "m/s2", "", False),), "amplitude")
"""Stands for any dimensions where the names and kinds of the other columns are asked for."""
BRACKETED, AT_LOWEST, NEVER, UNDECIDED = "bracketed", "reached at the lowest", "not reached at the highest", "all diverged"
BRAKED = "braked"
"""Outcomes of a search."""


def bracket_columns(units: str) -> tuple[Variable, ...]:
    """The columns of a bracket, with the unit of the intensity."""
    return (
        text_column(
            "outcome",
            f"{BRACKETED}; {AT_LOWEST} or {NEVER} intensity whose run has a class, then the only end; {UNDECIDED}: no run has a class; "
            f"{BRAKED}: debris that does not reach the length or place is braked and might, so that at most an upper end is known",
        ),
        number_column("critical_intensity", units, "middle of the bracket; NaN without one"),
        number_column("resolution_error", units, "half the width of the bracket; NaN without one"),
        number_column(
            "lower", units, "largest intensity below the upper end at which the class is not reached; NaN if it is reached at the lowest"
        ),
        number_column("upper", units, "smallest intensity at which the class is reached; NaN if it never is"),
        count_column("diverged_inside", "diverged runs between the two, which make the bracket wider than the tolerance"),
        count_column(
            "changes",
            "changes between not reached and reached along the intensities that were run; more than 1: not monotone in the intensity",
        ),
        number_column("lower_still_moving", "1", "1 if the run at the lower end is still moving at its end: it may reach the class later"),
        count_column("runs", "runs at these values"),
        count_column("diverged", "diverged runs among them"),
        count_column("braked", "those whose debris is braked before the length or place, which are not known to stop there; 0 for a class"),
        number_column("wall_time", "s", "computing time of these runs, shared pre-failure runs included in each"),
    )


def critical_columns(searched: Searched) -> tuple[Variable, ...]:
    """The columns of the table of critical intensities."""
    units = searched.intensity.variable(listed=False).units
    return (
        *label_columns(searched.others),
        text_column("collapse_class", "what has to be reached at the critical intensity: the class or a worse one, or the length or place"),
        text_column("intensity", "the dimension that is searched"),
        *bracket_columns(units),
        number_column(
            "extrapolated_intensity",
            units,
            "critical intensity at spacing 0, extrapolated as by sph fos from this case and another that differs only in a coarser "
            "spacing; NaN without such a case, without a bracket of either, and where softening has no width (coupling.softening)",
        ),
        number_column(
            "extrapolation_error", units, "estimate of its error: half the step to it, and the brackets as magnified by the extrapolation"
        ),
        number_column(
            "yield_acceleration",
            "m s-2",
            "pseudo-static estimate: constant acceleration at which the slope fails; NaN where the study's searches are "
            f"not full, where the case has more than {MAX_SLOPES} slopes, or where the search found none",
        ),
        number_column(
            "newmark_intensity",
            units,
            "intensity of the same motion at which a rigid block with that yield acceleration slips by the displacement at which the class "
            "begins (Newmark 1965); NaN for a run-out, which a block does not have",
        ),
    )


def bracket(points: pd.DataFrame, wanted: str, intensity: str = "amplitude") -> pd.Series:
    """What points that differ in one dimension, the intensity, alone say about one class, by the names of ``bracket_columns``."""
    line = points.assign(value=points[intensity].astype(float)).sort_values("value")
    line["reached"] = [shown(run, wanted) for run in line.to_dict("records")]
    decided = line[line["reached"].notna()]
    above, standing = (decided[decided["reached"] == verdict] for verdict in (True, False))
    upper = float(above["value"].min())
    below = standing[~(standing["value"] > upper)].tail(1)
    lower, moving = (float(below[name].sum(min_count=1)) for name in ("value", "still_moving"))
    diverged = line["collapse_class"] == UNDETERMINED
    braked = line["reached"].isna() & ~diverged
    unknown = BRAKED if (braked & ~line["value"].gt(upper)).any() else UNDECIDED if decided.empty else AT_LOWEST
    outcome = unknown if math.isnan(lower) else NEVER if math.isnan(upper) else BRACKETED
    inside = line["value"].gt(lower) & line["value"].lt(upper)
    changes = sum(one != other for one, other in itertools.pairwise(decided["reached"]))
    values = (
        outcome, 0.5 * (lower + upper), 0.5 * (upper - lower), lower, upper, int((inside & diverged).sum()), changes,
        moving, len(line), int(diverged.sum()), int(braked.sum()), float(line["wall_time"].sum()),
    )  # fmt: skip
    return pd.Series(dict(zip(names(bracket_columns("1")), values, strict=True)), dtype=object)


def coarser_cases(scenes: Mapping[str, Scene]) -> dict[str, tuple[str, float]]:
    """For each case the one that differs in a coarser spacing alone, and the ratio of the two: of several that nearest to ``RATIO``.

    None where soil fails over no length: its level falls with the spacing without an end.
    """
    spacings = {case: scene.numerics.spacing for case, scene in scenes.items()}
    alike = {case: merge(scene.model_dump(), {"numerics": {"spacing": None}}) for case, scene in scenes.items()}
    nearest_coarser = {}
    for case, spacing in spacings.items():
        ratios = {other: spacings[other] / spacing for other in scenes if alike[other] == alike[case] and scenes[case].coupling.softening}
        coarser = [other for other, ratio in ratios.items() if ratio >= MIN_RATIO]
        if coarser:
            nearest = min(coarser, key=lambda other: abs(ratios[other] - RATIO))
            nearest_coarser[case] = nearest, ratios[nearest]
    return nearest_coarser


def block_estimates(
    scenes: Mapping[Key, Scene],
    yields: Mapping[Key, float],
    classes: Sequence[str],
    settings: MetricSettings,
    searched: Searched,
    highest: float,
) -> dict[Key, dict[str, dict[str, float]]]:
    """The last two columns of the table, by case and values of the other dimensions and by class.

    ``scenes`` are shaken at the ``highest`` intensity, each by the motion that its values give; ``yields`` are the yield accelerations
    (m/s2) of their slopes, as far as they were searched.
    """
    power, estimates = INTENSITIES[searched.intensity_name].power, dict[Key, dict[str, dict[str, float]]]()
    for at, scene in scenes.items():
        yield_acceleration = yields.get(at, math.nan)
        factors = {name: newmark_factor(scene, yield_acceleration, block_displacement(name, scene, settings)) for name in classes}
        estimates[at] = {
            name: {"yield_acceleration": yield_acceleration, "newmark_intensity": highest * factor ** (1.0 / power)}
            for name, factor in factors.items()
        }
    return estimates


def critical_table(
    points: pd.DataFrame,
    classes: Sequence[str],
    estimates: Mapping[Key, Mapping[str, Mapping[str, float]]],
    searched: Searched,
    coarser: Mapping[str, tuple[str, float]] | None = None,
) -> pd.DataFrame:
    """One row per case, value of the other dimensions and class; ``estimates`` hold the last two columns, as by ``block_estimates``.

    ``coarser`` are the cases to extrapolate from, as by ``coarser_cases``.
    """
    at = names(label_columns(searched.others))
    brackets = {
        (*map(str, values), name): bracket(line, name, searched.intensity_name)
        for values, line in points.groupby(at, sort=False)
        for name in classes
    }

    def at_zero(case: str, others: tuple[str, ...]) -> dict[str, float]:
        other, ratio = (coarser or {}).get(case, (case, math.nan))
        coarse, fine = (Search(each.lower, each.upper, ()) for each in (brackets[other, *others], brackets[case, *others]))
        value, error, _ = to_zero(coarse, fine, ratio)
        return {"extrapolated_intensity": max(value, 0.0), "extrapolation_error": error}

    rows = [
        {
            **dict(zip(at, (case, *values), strict=True)),
            "collapse_class": name,
            "intensity": searched.intensity_name,
            **bracketed,
            **at_zero(case, (*values, name)),
            **estimates[case, *values][name],
        }
        for (case, *values, name), bracketed in brackets.items()
    ]
    return pd.DataFrame(rows, columns=names(critical_columns(searched)))


def read_critical(path: Path | str) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is not one."""
    return read_csv(path, columns_in(path, critical_columns(ONE)), "critical intensities")


# ---------------------------------------------------------------- another fidelity

PAIR = ("collapse_class", "displacement_magnitude", "runout")


def end_columns(searched: Searched) -> tuple[Variable, ...]:
    """The columns of an end of a bracket before it is run again."""
    return (
        *label_columns(searched.all),
        text_column("wanted_class", "the class whose bracket is confirmed"),
        text_column("end", "end of the bracket: lower or upper"),
    )


def confirm_columns(searched: Searched) -> tuple[Variable, ...]:
    """The columns of an end of a bracket that was run again."""
    return (
        *end_columns(searched),
        *(METRIC_BY_NAME[name] for name in PAIR),
        *(
            METRIC_BY_NAME[name]._replace(name=f"confirming_{name}", text=f"{name} at the confirming fidelity")
            for name in ("status", *PAIR)
        ),
        *(
            number_column(
                f"{name}_difference", METRIC_BY_NAME[name].units, f"confirming {name} minus that of the search; NaN if one diverged"
            )
            for name in PAIR[1:]
        ),
        text_column(
            "verdict",
            "holds: on this side of the class at both fidelities; fails: on the other side; undetermined: a run diverged, or its debris is "
            "braked before the length or place",
        ),
    )


def bracket_ends(
    table: pd.DataFrame, points: pd.DataFrame, wanted: str, cases: Sequence[str], at: Mapping[str, Sequence[str]], searched: Searched
) -> pd.DataFrame:
    """The ends that exist of the brackets of a class, for chosen cases and values of the other dimensions."""
    chosen = {name: {value_of(value) for value in values} for name, values in at.items()}
    labels = {float(label): label for label in points[searched.intensity_name]}
    rows = [
        {**row, "wanted_class": wanted, "end": end, searched.intensity_name: labels[row[end]]}
        for row in table[table["collapse_class"] == wanted].to_dict("records")
        for end in ("lower", "upper")
        if row["case"] in cases and all(value_of(row[name]) in values for name, values in chosen.items()) and not math.isnan(row[end])
    ]
    return pd.DataFrame(rows, columns=names(end_columns(searched)))


def confirm_table(ends: pd.DataFrame, points: pd.DataFrame, confirming: Sequence[Mapping[str, Any]], searched: Searched) -> pd.DataFrame:
    """One row per end, from the points of the search and the metrics of the confirming runs in the ends' order."""
    at = names(label_columns(searched.all))
    by_point = points.set_index(at)
    rows = []
    for end, other in zip(ends.to_dict("records"), confirming, strict=True):
        own = by_point.loc[tuple(end[name] for name in at)]
        sides = {shown(run, end["wanted_class"]) for run in (own, other)}
        rows.append(
            end
            | {name: own[name] for name in PAIR}
            | {f"confirming_{name}": other[name] for name in ("status", *PAIR)}
            | {f"{name}_difference": other[name] - own[name] for name in PAIR[1:]}
            | {"verdict": UNDETERMINED if None in sides else HOLDS if len(sides) == 1 else FAILS}
        )
    return pd.DataFrame(rows, columns=names(confirm_columns(searched)))


def read_ends(path: Path | str) -> pd.DataFrame:
    """Table of ends to be run again, from its CSV; ValueError names a file that is not one."""
    return read_csv(path, columns_in(path, end_columns(Searched((), ""))), "ends of brackets")
