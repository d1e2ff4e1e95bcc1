"""The alternatives of a study beside the scene as it is: a row each, near the top of the page."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.after_run import at_least, has_debris, in_motion, is_at_least, is_bounded, is_held, near_miss
from sph.checks.finding import Finding
from sph.checks.messages import listed, within_words
from sph.figures.style import AT_LEAST, LEAST, NOTHING, metres
from sph.measures.metrics import CLASSES
from sph.measures.places import PASSED, REACHED, column_of, places_in
from sph.page.second_spacing import differs, weakest_words
from sph.page.tables import Table
from sph.scene.units import in_both
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, AS_IT_IS, BASE, Dimension, title_of
from sph.study.preflight import Row

MORE = " farther"
LENGTHS = "displacement_magnitude", "runout"
"""What an alternative saves of."""
FARTHER = 1.1
"""Displacement in an alternative, over that of the scene as it is, from which on it is said to be larger."""
NOTICED = 0.5
"""Percent of a length below which nothing is saved."""


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
            within = within_words(of)
            words = f"{bishop}, {of['spencer']:.2f}{within[0]}", f"{critical}{within[1]}"
            found.setdefault(str(table.loc[row.worst_run, ALTERNATIVE]), words)
    return found


def compared(
    table: pd.DataFrame,
    dimensions: Sequence[Dimension],
    probe: str,
    slices: Slices | None = None,
    keys: Mapping[str, Mapping[str, Any]] | None = None,
) -> list[Table]:
    """What happens in each alternative, and what it saves of displacement and run-out; no table of a study without alternatives.

    An alternative is compared with the scene as it is in the same runs, and what it saves is told of the run in which the scene as it is
    moves farthest.  Each has its own limits by ``slices``, where these are known of any, and its scene ``keys`` are named.
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
    rows = []
    for name in dict.fromkeys(map(str, table[ALTERNATIVE])):
        runs, called = groups.get(name), AS_IT_IS if name == BASE else name
        if runs is None:
            rows.append((called, "diverged", *[NOTHING] * (7 + 2 * bool(slices))))
            continue
        own = next((run for run in runs.to_dict("records") if all(run[key] == value for key, value in at.items())), None)
        rows.append(
            (
                called,
                max(runs["collapse_class"], key=CLASSES.index),
                f"{int((runs['collapse_class'] != CLASSES[0]).sum())} of {len(runs)}",
                _fails_from(runs),
                _acceleration(runs),
                *(_length(own, length) for length in LENGTHS),
                *(NOTHING if name == BASE or own is None else saved(worst, own, length) for length in LENGTHS),
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
        "displacement that it saves",
        "reach of the debris that it saves",
        *(("factor of safety (Bishop, Spencer)", "yield acceleration (Spencer)") if slices else ()),
    )
    said = title_of(others, {key: str(value) for key, value in at.items()})
    notes = [f"Displacement, run-out and what is saved: {said}, where the scene as it is moves farthest."] if others else []
    notes += [
        f"With {name} {probe} moves farther than as it is, by more than {100.0 * (FARTHER - 1.0):.0f} %, in {count} of {len(runs)} runs."
        for name, runs in groups.items()
        if (count := _farther(base, runs, [dimension.name for dimension in others]))
    ]
    notes += [f"{name}: {listed(changes)}." for name, of in (keys or {}).items() if (changes := _changes(of))]
    return [Table("Alternatives, beside the scene as it is", head, rows, " ".join(notes))]


def _changes(keys: Mapping[str, Any], path: str = "") -> list[str]:
    """What an alternative changes: every key with its value, or how many it has of a list."""
    said = list[str]()
    for name, value in keys.items():
        if isinstance(value, Mapping):
            said += _changes(value, f"{path}{name}.")
        else:
            words = f"{len(value)} values" if isinstance(value, (list, tuple)) else "none" if value is None else f"{value}"
            said.append(f"`{path}{name}` {words}")
    return said


def _farther(base: pd.DataFrame, runs: pd.DataFrame, keys: Sequence[str]) -> int:
    """In how many runs, by the dimensions ``keys``, the probe moves more than ``FARTHER`` times as far as in those of ``base``, of which no
    lower bound is compared."""
    moved = LENGTHS[0]
    there = {tuple(run[key] for key in keys): run[moved] for run in base.to_dict("records") if not is_at_least(run)}
    pairs = ((run[moved], there.get(tuple(run[key] for key in keys), math.nan)) for run in runs.to_dict("records"))
    return sum(own > max(FARTHER * before, before + LEAST) for own, before in pairs)


def verdict(table: pd.DataFrame, doubted: Sequence[Doubt] = ()) -> str:
    """Which alternatives prevent the failure and keep debris from places that it reaches, and which are ``doubted``, in a sentence;
    nothing without runs to compare.  ``table`` has runs of one level of shaking."""
    if ALTERNATIVE not in table:
        return ""
    known = table[table["diverged"] == 0]
    runs = {str(name): of.to_dict("records") for name, of in known.groupby(ALTERNATIVE, sort=False)}
    base = runs.pop(BASE, [])
    if not base or not runs:
        return ""
    asked = list[tuple[Mapping[str, bool | None], str, str]]()
    if any(map(_fails, base)):
        asked.append(({name: _avoided(of, _fails) for name, of in runs.items()}, "prevent", "the failure in these runs"))
    kept: dict[tuple[bool | None, ...], list[str]] = {}  # places by what the alternatives do for them
    for place in places_in(known.columns):

        def reaches(run: Mapping[Any, Any], reached: str = column_of(place, REACHED)) -> bool:
            return bool(run[reached] > 0.0)

        if any(map(reaches, base)):
            close = partial(near_miss, place=place)
            kept.setdefault(tuple(_avoided(of, reaches, close) for of in runs.values()), []).append(place.replace("_", " "))
    asked += [(dict(zip(runs, of, strict=True)), "keep", f"debris from {listed(places)}") for of, places in kept.items()]
    said = [words for each in asked for words in _which(*each)]
    names = list(dict.fromkeys(name for doubt in doubted for name in doubt.names))
    if said and names:
        said.append(f"{listed(names)} {'is' if len(names) == 1 else 'are'} in doubt, see the warnings")
    words = "; ".join(said)
    return f"{words[0].upper()}{words[1:]}." if words else ""


def holding(table: pd.DataFrame) -> str:
    """Up to which weaker shaking in which the scene as it is fails alternatives hold the slope, in a sentence; nothing where none does."""
    if ALTERNATIVE not in table or AMPLITUDE not in table:
        return ""
    known = table[table["diverged"] == 0]
    levels = sorted(set(known[AMPLITUDE]), key=float)[:-1]
    fails, sure = (known["collapse_class"] != CLASSES[0]) | at_least(known), ~differs(known)
    failing = {
        (str(name), level): bool(of.any()) for (name, level), of in fails.groupby([known[ALTERNATIVE].astype(str), known[AMPLITUDE]])
    }
    lost = {str(level) for level in known.loc[(known[ALTERNATIVE] == BASE) & (known["collapse_class"] != CLASSES[0]) & sure, AMPLITUDE]}
    held = dict[str, list[str]]()
    for name in dict.fromkeys(known[ALTERNATIVE].astype(str)):
        standing = [level for level in levels if str(level) in lost and failing.get((name, level)) is False]
        if name != BASE and standing:
            held.setdefault(in_both(float(standing[-1])), []).append(name)
    said = [f"{listed(names)} {'holds' if len(names) == 1 else 'hold'} it at {level}" for level, names in held.items()]
    return f"The slope fails as it is in weaker shaking too, where {listed(said)}." if said else ""


class Doubt(NamedTuple):
    """A finding that the scenes of alternatives have and the scene as it is has not."""

    finding: Finding  # of the first of them
    names: list[str]  # of the alternatives

    @property
    def of(self) -> str:
        """Whose it is, and whose numbers stand in it."""
        return listed(self.names) + f", with the numbers of {self.names[0]}" * bool(self.names[1:])


def doubts(table: pd.DataFrame, rows: Sequence[Row]) -> list[Doubt]:
    """The errors and warnings that the scenes of alternatives have and the scene as it is has not, each once."""
    found: dict[tuple[str, str], Doubt] = {}
    known = set[tuple[str, str]]()  # of the scene as it is, perhaps with other numbers
    for row in rows:
        kind = row.finding.code, row.finding.subject
        if row.finding.counts and (name := of_alternative(table, row)):
            found.setdefault(kind, Doubt(row.finding, [])).names.append(name)
        elif row.finding.counts:
            known.add(kind)
    return [doubt for kind, doubt in found.items() if kind not in known]


def of_alternative(table: pd.DataFrame, row: Row) -> str:
    """The alternative whose runs alone have a finding; nothing where others have it, too."""
    of = table[ALTERNATIVE].astype(str) if ALTERNATIVE in table else pd.Series(dtype=str)
    name = str(of.get(row.worst_run, BASE))
    return name if name != BASE and row.runs <= (of == name).sum() else ""


def _fails(run: Mapping[Any, Any]) -> bool:
    return bool(run["collapse_class"] != CLASSES[0])


def _avoided(
    runs: Sequence[Mapping[Any, Any]],
    harm: Callable[[Mapping[Any, Any]], bool],
    close: Callable[[Mapping[Any, Any]], float] = lambda run: 0.0,
) -> bool | None:
    """Whether no run does ``harm``; None where it is not known, since one that has not goes on or comes ``close``."""
    if any(map(harm, runs)):
        return False
    return None if any(is_at_least(run) or close(run) for run in runs) else True


def _which(outcomes: Mapping[str, bool | None], verb: str, what: str) -> list[str]:
    """Which alternatives do something and which do not, by their outcomes, and of which it is not known."""
    able, unable, unknown = ([name for name, outcome in outcomes.items() if outcome is wanted] for wanted in (True, False, None))
    parts = [f"{listed(able)} {verb}{'s' * (len(able) == 1)} {what}"] if able else []
    if able and unable:
        parts.append(f"{listed(unable)} {'does' if len(unable) == 1 else 'do'} not")
    elif len(unable) == 1:
        parts.append(f"{unable[0]} does not {verb} {what}")
    elif unable:
        none, last = ("neither", "nor") if len(unable) == 2 else ("none of", "and")
        parts.append(f"{none} {listed(unable, last)} {verb}s {what}")
    open_ones = [f"whether {listed(unknown, 'or')} {verb}s {what} is unknown"] if unknown else []
    return [", ".join(parts)] * bool(parts) + open_ones


def saved(base: Mapping[Any, Any], own: Mapping[Any, Any], length: str = "displacement_magnitude") -> str:
    """How much less an alternative moves or runs out than the scene as it is, in m and percent; where one of them is a lower bound, what
    is known.  Run-outs of debris are compared at the farthest place of the study, since that of a berm begins at its foot."""
    columns = [column_of(place, PASSED) for place in places_in(base)] if length == "runout" and has_debris(own) else []
    columns.sort(key=lambda column: float(base[column]))
    less = next((by for column in columns if not math.isnan(by := float(base[column] - own[column]))), float(base[length] - own[length]))
    share = 100.0 * less / float(base[length]) if base[length] > 0.0 else 0.0
    words = f"{metres(abs(less))} m ({abs(share):.0f} %)" + MORE * (less < 0.0)
    bounds = is_at_least(base), is_at_least(own)
    if all(bounds):
        reasons = _why(base), _why(own)
        return f"unknown: in both {reasons[0]}" if reasons[0] == reasons[1] else f"unknown: as it is {reasons[0]}, and with it {reasons[1]}"
    if any(bounds):
        return f"at most {words}" if bounds[1] == (less >= 0.0) else f"{AT_LEAST}{words}"
    return "none, " * (less < 0.0) + words if abs(share) >= NOTICED else "nothing"


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


def _fails_from(runs: pd.DataFrame) -> str:
    """The smallest amplitude of a run that fails."""
    if AMPLITUDE not in runs:
        return NOTHING
    failing = runs[(runs["collapse_class"] != CLASSES[0]) | differs(runs)]
    return weakest_words(failing) or f"not up to {in_both(runs[AMPLITUDE].astype(float).max())}"


def _acceleration(runs: pd.DataFrame) -> str:
    found = sorted(set(runs["yield_acceleration"].dropna()))
    return " to ".join(in_both(value) for value in dict.fromkeys((found[0], found[-1]))) if found else NOTHING
