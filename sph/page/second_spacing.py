"""What the page says of runs that were made at a second spacing, too."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import pandas as pd

from sph.checks.messages import listed
from sph.experiments.variants.second_spacing import CONVERGED, LENGTHS, NOT_CONVERGED
from sph.figures.style import metres
from sph.measures.metrics import CLASSES, STABLE, UNDETERMINED
from sph.measures.places import PASSED, column_of, places_in
from sph.scene.units import in_both
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, BASE

SECOND_CLASS = "second_class"
"""Column of the class at the second spacing, empty for a run that was not repeated."""
OPEN = "open"
"""What it says of a run of which that is not known, though the spacing may decide."""
WHERE_SPACING_DECIDES = ", where the spacing decides"
"""Said of the shaking of a run that stands at one of two spacings and fails at the other."""


def with_second_class(table: pd.DataFrame, again: pd.DataFrame | None, axes: Sequence[str]) -> pd.DataFrame:
    """The table of a study over ``axes``, by the names of its runs, with what these were ``again`` at the second spacing.

    Of an alternative that fails, and was not repeated, that is ``OPEN`` where the spacing decides if the scene as it is does in that run.
    """
    classes = {} if again is None else dict(zip(again["run"], again[SECOND_CLASS], strict=True))
    table = table.assign(**{SECOND_CLASS: [classes.get(run, "") for run in table.index]})
    if ALTERNATIVE in axes:
        others = pd.MultiIndex.from_frame(table[[ALTERNATIVE, *(axis for axis in axes if axis != ALTERNATIVE)]]).droplevel(0)
        unsure = others.isin(others[differs(table) & (table[ALTERNATIVE] == BASE)])
        table.loc[unsure & (table[SECOND_CLASS] == "") & table["collapse_class"].isin(CLASSES[1:]), SECOND_CLASS] = OPEN
    return table


def second_class(table: pd.DataFrame) -> pd.Series:
    """The class of runs at the second spacing; empty where it is not known."""
    return table[SECOND_CLASS] if SECOND_CLASS in table else pd.Series("", table.index)


def differs(table: pd.DataFrame) -> pd.Series:
    """Whether the spacing decides if runs stand: at one of two it does and at the other it fails."""
    own, again = table["collapse_class"], second_class(table)
    known = (own != UNDETERMINED) & ~again.isin(["", UNDETERMINED])
    return known & ((own == STABLE) != (again == STABLE)) | (again == OPEN)


def weakest_words(runs: pd.DataFrame) -> str:
    """The least amplitude of some runs, and a lower one of those of which the spacing decides if they stand; nothing of none."""
    shaking = runs[AMPLITUDE].astype(float)
    least, sure = shaking.min(), shaking[~differs(runs)].min()
    said = [in_both(sure)] * (not math.isnan(sure)) + [in_both(least) + WHERE_SPACING_DECIDES] * (len(runs) > 0 and not least >= sure)
    return "; ".join(said)


def at_spacings(table: pd.DataFrame, again: pd.DataFrame | None, probe: str, spacing: float) -> str:
    """With what particles it was found in what shaking the slope fails, or, of the weakest shaking in which that depends on the spacing,
    what both say."""
    if again is None or (again[SECOND_CLASS] == UNDETERMINED).all():  # none, or all diverged
        return f"with particles of {spacing:.3g} m alone"
    differ = table[differs(table)]
    if differ.empty:
        return f"with particles of {again['spacing'].iloc[0]:.3g} m and of {again['second_spacing'].iloc[0]:.3g} m"
    run = str(differ[AMPLITUDE].astype(float).idxmin())
    row = again[(again["run"] == run) & (again["quantity"] == LENGTHS[0])].iloc[0]
    said = " and ".join(f"{metres(row[f'{of}value'])} m with particles of {row[f'{of}spacing']:.3g} m" for of in ("", "second_"))
    return f"at {in_both(float(differ[AMPLITUDE][run]))} it depends on the spacing: {probe} moves {said}"


def answer_spacing(again: pd.DataFrame | None, runs: int, why: str = "") -> list[tuple[str, str, str]]:
    """In how many of the runs ``again`` at a second spacing that changes nothing that counts, which shows little where both have few rows
    of particles: ``why``; the study has so many ``runs``."""
    if again is None or again.empty:
        return []
    agree = [set(of["verdict"]) == {CONVERGED} for _, of in again.groupby("run")]
    at = " and ".join(f"{again[name].iloc[0]:.3g} m" for name in ("spacing", "second_spacing"))
    few = f"; it does not show what more rows would change: {why}" * bool(why)
    words = f"{CONVERGED}, or differs by less than counts as motion, in {sum(agree)} of {len(agree)} runs"
    of = "all runs" if len(agree) >= runs else "the runs that decide in what shaking it fails,"
    return [("Spacing", words, f"{of} with particles of {at}{few}")]


def drifts(again: pd.DataFrame | None, probe: str, points: Mapping[str, str]) -> list[str]:
    """The runs of which a second spacing changes displacement or run-out most, where that is not converged, with what it changes in them,
    and further runs in which it decides whether debris reaches a place; ``points`` are the words for runs, others keep their names."""
    if again is None or again.empty:
        return []
    rows, told, counts = again.assign(run=[points.get(run, run) for run in again["run"]]), dict[str, list[str]](), list[str]()
    for quantity, name, moves in (
        ("displacement_magnitude", f"displacement of {probe}", f"{probe} moves"),
        ("runout", "run-out", "debris runs"),
    ):
        of = rows[rows["quantity"] == quantity]
        drifting = of[of["verdict"] == NOT_CONVERGED]
        if drifting.empty:
            continue
        worst = max(drifting.to_dict("records"), key=lambda row: abs(row["value"] - row["second_value"]))
        said = f"{moves} {metres(worst['value'])} m and {metres(worst['second_value'])} m"
        towards = "" if math.isnan(worst["extrapolated"]) else f" (extrapolated to spacing 0: {metres(worst['extrapolated'])} m)"
        told.setdefault(worst["run"], []).append(said + towards)
        counts.append(f"{name} in {len(drifting)} of {of['run'].nunique()} runs")
    unsure = dict[str, list[str]]()
    for place in places_in(rows["quantity"].unique()):
        past = rows[rows["quantity"] == column_of(place, PASSED)]
        for run, *values in past[["run", "value", "second_value"]].itertuples(index=False):
            if len({value >= 0.0 for value in values if not math.isnan(value)}) > 1:
                unsure.setdefault(run, []).append(place.replace("_", " "))
    at = " and of ".join(f"{again[name].iloc[0]:.3g} m" for name in ("spacing", "second_spacing"))
    for run, changes in told.items():
        changes += [f"it reaches {listed(unsure.pop(run), 'or')} or not"] if run in unsure else []
    runs_differ = "; ".join(f"at {run} {', '.join(changes)}" for run, changes in told.items())
    found = [f"Not converged: {' and '.join(counts)}. With particles of {at}: {runs_differ}."] if told else []
    by_places = dict[tuple[str, ...], list[str]]()
    for run, places in unsure.items():
        by_places.setdefault(tuple(places), []).append(run)
    found += [
        f"Not converged: whether debris reaches {listed(places, 'or')} depends on the spacing at {'; '.join(runs[:3])}"
        f"{f' and {len(runs) - 3} more runs' if len(runs) > 3 else ''}."
        for places, runs in by_places.items()
    ]
    return found
