"""The alternatives of a study beside the scene as it is: a row each, near the top of the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.after_run import in_motion, is_at_least, is_bounded, is_held, near_miss
from sph.checks.finding import Finding
from sph.checks.messages import listed, sentence
from sph.figures.style import AT_LEAST, NOTHING, metres
from sph.measures.metrics import CLASSES
from sph.measures.places import ARRIVAL, PEAK_DEPTH, REACHED, column_of, places_in
from sph.page.tables import Table
from sph.scene.units import in_both
from sph.storage.trajectory import Status
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, AS_IT_IS, BASE, Dimension, title_of
from sph.study.preflight import Row

MORE = " farther"
CLOSE = "debris stops short by less than the error of a run-out"
"""Why it is not known whether an alternative keeps debris from a place that none of its runs reaches."""
NOTICED = 0.5
"""Percent of the displacement below which nothing is saved."""


Slices = Mapping[str, tuple[str, str]]
"""Factors of safety and yield acceleration by limit equilibrium in words, by the alternative."""


def slices_of(table: pd.DataFrame, rows: Sequence[Row]) -> Slices:
    """What limit equilibrium found before the runs, of the first slope of each alternative."""
    found = dict[str, tuple[str, str]]()
    for row in rows if ALTERNATIVE in table else ():
        of = row.finding.numbers
        if row.finding.code == "limit-equilibrium" and row.worst_run in table.index:
            bishop = f"{of['bishop']:.2f}" if "bishop" in of else NOTHING
            critical = in_both(of["critical"]) if "critical" in of else in_both(0.0) if of["spencer"] <= 1.0 else NOTHING
            found.setdefault(str(table.loc[row.worst_run, ALTERNATIVE]), (f"{bishop}, {of['spencer']:.2f}", critical))
    return found


def compared(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str, slices: Slices | None = None) -> list[Table]:
    """What happens in each alternative, and what it saves of the displacement; no table of a study without alternatives.

    An alternative is compared with the scene as it is in the same runs, and what it saves is told of the run in which the scene as it is
    moves farthest.  Each has its own limits by ``slices``, where these are known of any.
    """
    if ALTERNATIVE not in table or BASE not in set(table[ALTERNATIVE]):
        return []
    others = [dimension for dimension in dimensions if dimension.name != ALTERNATIVE]
    known = table[table["diverged"] == 0]
    groups = {str(name): runs for name, runs in known.groupby(ALTERNATIVE, sort=False)}
    if BASE not in groups:
        return []
    base = groups[BASE]
    worst: dict[Any, Any] = max(base.to_dict("records"), key=lambda run: run["displacement_magnitude"])
    at = {dimension.name: worst[dimension.name] for dimension in others}
    places = places_in(table.columns)
    rows = []
    for name in dict.fromkeys(map(str, table[ALTERNATIVE])):
        runs, called = groups.get(name), AS_IT_IS if name == BASE else name
        if runs is None:
            rows.append((called, "diverged", *[NOTHING] * (6 + 3 * len(places) + 2 * bool(slices))))
            continue
        own = next((run for run in runs.to_dict("records") if all(run[key] == value for key, value in at.items())), None)
        rows.append(
            (
                called,
                max(runs["collapse_class"], key=CLASSES.index),
                f"{int((runs['collapse_class'] != CLASSES[0]).sum())} of {len(runs)}",
                _fails_from(runs),
                _acceleration(runs),
                _length(own, "displacement_magnitude"),
                _length(own, "runout"),
                NOTHING if name == BASE or own is None else saved(worst, own).words,
                *(cell for place in places for cell in _at(runs, place)),
                *((slices.get(name, (NOTHING, NOTHING))) if slices else ()),
            )
        )
    head = (
        ALTERNATIVE,
        "worst class",
        "runs that fail",
        "fails from (of those run)",
        "yield acceleration (SPH)",
        f"displacement of {probe} (m)",
        "run-out from its own toe (m)",
        "saves of the displacement",
        *(f"{place}: {what}" for place in places for what in ("runs that reach it", "first after (s of shaking)", "largest depth (m)")),
        *(("factor of safety (Bishop, Spencer)", "yield acceleration (Spencer)") if slices else ()),
    )
    said = title_of(others, {key: str(value) for key, value in at.items()})
    note = f"Displacement, run-out and what is saved: {said}, where the scene as it is moves farthest." if others else ""
    return [Table("Alternatives, beside the scene as it is", head, rows, note)]


def verdict(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> str:
    """Which alternatives prevent the failure and keep debris from places that it reaches, and what the others save of the displacement,
    in a sentence; nothing without runs to compare.  ``table`` has runs of one level of shaking."""
    if ALTERNATIVE not in table:
        return ""
    known = table[table["diverged"] == 0]
    runs = {str(name): of.to_dict("records") for name, of in known.groupby(ALTERNATIVE, sort=False)}
    base = runs.pop(BASE, [])
    if not base or not runs:
        return ""
    asked, left = list[tuple[Mapping[str, bool | str], str, str]](), [*runs]  # left: alternatives that fail
    if any(map(_fails, base)):
        outcomes = {name: _avoided(of, _fails) for name, of in runs.items()}
        left = [name for name, outcome in outcomes.items() if outcome is False]
        asked.append((outcomes, "prevent", "the failure in these runs"))
    kept: dict[tuple[bool | str, ...], list[str]] = {}  # places by what the alternatives do for them
    for place in places_in(known.columns):

        def reaches(run: Mapping[Any, Any], reached: str = column_of(place, REACHED)) -> bool:
            return bool(run[reached] > 0.0)

        if any(map(reaches, base)):
            close = partial(near_miss, place=place)
            kept.setdefault(tuple(_avoided(of, reaches, close) for of in runs.values()), []).append(place.replace("_", " "))
    asked += [(dict(zip(runs, of, strict=True)), "keep", f"debris from {listed(places)}") for of, places in kept.items()]
    said = [words for each in asked if (words := _which(*each))] + _unknown(asked)
    worst = max(base, key=lambda run: run["displacement_magnitude"])
    same = [each.name for each in dimensions if each.name != ALTERNATIVE]
    pairs = [(name, run) for name in left for run in runs[name] if all(run[key] == worst[key] for key in same)]
    savings = {name: saved(worst, run) for name, run in pairs}
    known_savings = [_saves(name, saving.words) for name, saving in savings.items() if saving.known]
    if known_savings:
        several = [each for each in dimensions if each.name != ALTERNATIVE and len({run[each.name] for run in base}) > 1]
        point = {each.name: str(worst[each.name]) for each in several}
        at = f" in the run that moves farthest as it is ({title_of(several, point)})," if several else ""
        said.append(f"of the displacement{at} {listed(known_savings)}")
    said += [f"what {name} saves is {saving.words}" for name, saving in savings.items() if not saving.known]
    words = "; ".join(said)
    return f"{words[0].upper()}{words[1:]}." if words else ""


def doubts(table: pd.DataFrame, rows: Sequence[Row]) -> str:
    """The errors and warnings that the scenes of alternatives have and the scene as it is has not, each once, in a sentence."""
    if ALTERNATIVE not in table:
        return ""
    of = table[ALTERNATIVE].astype(str)
    doubted: dict[tuple[str, str], tuple[Finding, list[str]]] = {}
    for finding, runs, name in ((row.finding, row.runs, str(of.get(row.worst_run, BASE))) for row in rows if row.finding.counts):
        if name != BASE and runs <= (of == name).sum():
            doubted.setdefault((finding.code, finding.subject), (finding, []))[1].append(name)
    parts = [
        f"{listed(names)} are in doubt, with the numbers of {names[0]}: {sentence(each, keys=False)}"
        if names[1:]
        else f"{names[0]} is in doubt: {sentence(each, keys=False)}"
        for each, names in doubted.values()
    ]
    return f"But {'; '.join(parts)}." if parts else ""


def _fails(run: Mapping[Any, Any]) -> bool:
    return bool(run["collapse_class"] != CLASSES[0])


def _avoided(
    runs: Sequence[Mapping[Any, Any]],
    harm: Callable[[Mapping[Any, Any]], bool],
    close: Callable[[Mapping[Any, Any]], float] = lambda run: 0.0,
) -> bool | str:
    """Whether no run does ``harm``; the reason why it is not known where one that has not goes on, or comes ``close``."""
    if any(map(harm, runs)):
        return False
    return next((_why(run) for run in runs if is_at_least(run)), CLOSE if any(map(close, runs)) else True)


def _which(outcomes: Mapping[str, bool | str], verb: str, what: str) -> str:
    """Which alternatives do something and which do not, by their outcomes; nothing where it is not known of any."""
    able, unable = ([name for name, outcome in outcomes.items() if outcome is wanted] for wanted in (True, False))
    parts = [f"{listed(able)} {verb}{'s' * (len(able) == 1)} {what}"] if able else []
    if able and unable:
        parts.append(f"{listed(unable)} {'does' if len(unable) == 1 else 'do'} not")
    elif len(unable) == 1:
        parts.append(f"{unable[0]} does not {verb} {what}")
    elif unable:
        none, last = ("neither", "nor") if len(unable) == 2 else ("none of", "and")
        parts.append(f"{none} {listed(unable, last)} {verb}s {what}")
    return ", ".join(parts)


def _unknown(asked: Iterable[tuple[Mapping[str, bool | str], str, str]]) -> list[str]:
    """Of which alternatives it is not known what they do, with the reasons."""
    reasons: dict[str, list[str]] = {}
    for outcomes, verb, what in asked:
        for why in dict.fromkeys(outcome for outcome in outcomes.values() if isinstance(outcome, str)):
            names = [name for name, outcome in outcomes.items() if outcome == why]
            reasons.setdefault(why, []).append(f"{listed(names)} {verb}{'s' * (len(names) == 1)} {what}")
    return [f"whether {' or '.join(words)} is unknown, since {why}" for why, words in reasons.items()]


def _saves(name: str, words: str) -> str:
    """What an alternative saves of the displacement, by the ``words`` of ``saved``."""
    return f"{name} {'moves' if words.endswith(MORE) else 'saves'} {words.replace(AT_LEAST, 'at least ')}"


class Saving(NamedTuple):
    """What an alternative saves of the displacement."""

    words: str
    known: bool = True  # or the words say why not


def saved(base: Mapping[Any, Any], own: Mapping[Any, Any]) -> Saving:
    """How much less an alternative moves than the scene as it is, in m and percent; where one of them is a lower bound, what is known."""
    less = float(base["displacement_magnitude"] - own["displacement_magnitude"])
    share = 100.0 * less / float(base["displacement_magnitude"]) if base["displacement_magnitude"] > 0.0 else 0.0
    words = f"{metres(abs(less))} m ({abs(share):.0f} %)" + MORE * (less < 0.0)
    bounds = is_at_least(base), is_at_least(own)
    if all(bounds):
        reasons = _why(base), _why(own)
        why = f"in both {reasons[0]}" if reasons[0] == reasons[1] else f"as it is {reasons[0]}, and with it {reasons[1]}"
        return Saving(f"unknown: {why}", known=False)
    if any(bounds):
        return Saving(f"at most {words}" if bounds[1] == (less >= 0.0) else f"{AT_LEAST}{words}")
    return Saving(words if abs(share) >= NOTICED else "nothing")


def _why(run: Mapping[Any, Any]) -> str:
    """Why displacement and run-out of a run are lower bounds, and what to do about it."""
    time = run["time_to_rest"]
    longer = "longer, it does not slow down yet" if math.isnan(time) else f"some {time:.2g} s more"
    reasons = (
        (is_held(run), "weak soil is held back (take a smaller spacing, for more rows of particles in it)"),
        (is_bounded(run["reached_side"]), "debris leaves the box (lengthen the apron)"),
        (in_motion(run), f"soil still moves at the end (run it for {longer})"),
    )
    return next(words for holds, words in reasons if holds)


def _length(run: Mapping[Any, Any] | None, name: str) -> str:
    return NOTHING if run is None else metres(float(run[name]), is_at_least(run))


def _at(runs: pd.DataFrame, place: str) -> tuple[str, str, str]:
    """In how many of the runs debris reaches a place, when it first does after the shaking begins, and its largest depth there; at least,
    where it goes on in a run that has not reached it, or whose depth may grow."""
    reached = runs[column_of(place, REACHED)]
    known, there = runs[reached.notna()].to_dict("records"), runs[reached > 0.0]
    on_its_way = any(is_at_least(run) for run in known if run[column_of(place, REACHED)] == 0.0)
    count = f"{AT_LEAST * on_its_way}{len(there)} of {len(known)}"
    if there.empty:
        return count, NOTHING, NOTHING
    shaken = there[there["status"] != Status.FAILED_UNSHAKEN]  # debris of the others may come before the shaking
    first = float((shaken[column_of(place, ARRIVAL)] - shaken["shaking_start"]).min())
    bounded = any(is_at_least(run) for run in known)
    return count, f"{first:.3g}" if first == first else NOTHING, metres(float(there[column_of(place, PEAK_DEPTH)].max()), bounded)


def _fails_from(runs: pd.DataFrame) -> str:
    """The smallest amplitude of a run that fails."""
    if AMPLITUDE not in runs:
        return NOTHING
    failing = runs.loc[runs["collapse_class"] != CLASSES[0], AMPLITUDE].astype(float)
    return in_both(failing.min()) if len(failing) else f"not up to {in_both(runs[AMPLITUDE].astype(float).max())}"


def _acceleration(runs: pd.DataFrame) -> str:
    found = sorted(set(runs["yield_acceleration"].dropna()))
    return " to ".join(in_both(value) for value in dict.fromkeys((found[0], found[-1]))) if found else NOTHING
