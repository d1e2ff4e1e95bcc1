"""What the debris does at each place in the strongest shaking of a study, and in a weaker one that is worse, for each alternative."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from sph.checks.after_run import has_debris, held, near_miss
from sph.figures.style import LEAST, NOTHING, metres
from sph.measures.metrics import AREA_THRESHOLDS
from sph.measures.places import ARRIVAL, GROUND, PASSED, PEAK_DEPTH, PEAK_SPEED, PRESSURE, REACHED, column_of, places_in
from sph.page.second_spacing import WHERE_SPACING_DECIDES, differs, weakest_words
from sph.page.tables import Table, filled, moves_on
from sph.scene.gravity import GRAVITY
from sph.scene.units import in_both
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, AS_IT_IS, BASE

HEAD = (
    "place",
    ALTERNATIVE,
    "shaking",
    "reached in runs",
    "reached from",
    "first after (s of shaking)",
    "depth up to (m)",
    "fastest particle (m/s)",
    "impact pressure (kPa)",
    "its ground moves (m)",
    "where it is not reached",
)
"""What a row says."""
WORSE = 1.1
"""Over the largest value in the strongest shaking, from which on that in weaker shaking is worth a row."""


def at_places(table: pd.DataFrame, why: str = "", contradicted: bool = False) -> list[Table]:
    """What the debris does at each place in the strongest shaking of the runs of a study, and in weaker shaking in which something is
    worse; no table without places.

    While debris moves nothing is known of how far it goes, nor where it was braked, for ``held_back`` says ``why``, nor as long as runs
    stand that should fail, where the scene as it is is ``contradicted``.
    """
    places = places_in(table.columns)
    known = table[table["diverged"] == 0]
    if not places or known.empty:
        return []
    strongest = known[known[AMPLITUDE] == max(known[AMPLITUDE], key=float)] if AMPLITUDE in known else known
    names = known[ALTERNATIVE].astype(str) if ALTERNATIVE in known else pd.Series(BASE, known.index)
    rows = []
    for place in places:
        for name in dict.fromkeys(names):
            runs = strongest[names[strongest.index] == name]
            called = AS_IT_IS if name == BASE else name
            first = _reached_from(known[names == name], place) if len(strongest) < len(known) else NOTHING
            unsure = contradicted and name == BASE
            weaker = known[(names == name) & ~known.index.isin(strongest.index)]
            for of in (runs, *_worse(runs, weaker, place)):
                *cells, short = _at(of, place, first, unsure)
                short += "" if unsure or of is not runs else _nearer(runs, weaker, place)
                rows.append((place.replace("_", " "), called if ALTERNATIVE in known else NOTHING, _level(of) or NOTHING, *cells, short))
    at, level = "", _level(strongest)
    if len({row[2] for row in rows}) == 1:  # the caption says it
        at, rows = f" at {level}" * bool(level), [(*row[:2], NOTHING, *row[3:]) for row in rows]
    reached = (known[[column_of(place, REACHED) for place in places]] > 0.0).any(axis=None)
    notes = ["Impact pressure: mean over the depth of the debris."] * bool(reached)
    if held(strongest).any():
        notes.append("Weak soil that is held back might go farther with more rows of particles" + f": {why}" * bool(why) + ".")
    if len(moving := strongest[strongest["at_rest"] == 0]):
        notes.append(f"Debris that still moves: {moves_on(moving)}.")
    return [filled(Table(f"Debris at the places{at}", HEAD, rows, " ".join(notes)))]


def at_a_glance(table: pd.DataFrame, contradicted: bool = False) -> Table | None:
    """From which shaking debris reaches each place, and the largest depth, speed and pressure of all runs, without those of which the
    spacing decides if they stand, for each alternative; None without places.  ``contradicted`` as in ``at_places``."""
    places = places_in(table.columns)
    known = table[(table["diverged"] == 0) & ~differs(table)]
    if not places or known.empty:
        return None
    names = known[ALTERNATIVE].astype(str) if ALTERNATIVE in known else pd.Series(BASE, known.index)
    own = list(dict.fromkeys(names))
    rows = [
        (place.replace("_", " "), *(_glance(known[names == name], place, contradicted and name == BASE) for name in own))
        for place in places
    ]
    columns = [AS_IT_IS if name == BASE else name for name in own] if len(own) > 1 else ["debris"]
    caption = "Debris at the places: the weakest shaking that brings any, the most of all runs, and how far the ground there moves"
    return Table(caption, ("place", *columns), rows)


def _glance(runs: pd.DataFrame, place: str, contradicted: bool) -> str:
    """What debris does at a place in runs of one alternative."""
    there = runs[column_of(place, REACHED)] > 0.0
    if not there.any():
        strongest = runs[runs[AMPLITUDE] == max(runs[AMPLITUDE], key=float)] if AMPLITUDE in runs else runs
        short = _at(strongest, place, NOTHING, contradicted)[-1]
        return short if short.startswith(("unknown", "not known", "may be")) else f"not reached: {short}"
    least = f"from {runs[AMPLITUDE][there].astype(float).min() / GRAVITY:.3g} g: " if AMPLITUDE in runs else ""
    _, _, _, depth, speed, pressure, moves, _ = _at(runs, place, "", contradicted=False)
    return f"{least}{depth} m deep, {speed} m/s, {pressure} kPa" + f"; moves {moves} m" * (moves != NOTHING)


def _worse(runs: pd.DataFrame, weaker: pd.DataFrame, place: str) -> list[pd.DataFrame]:
    """Runs of the levels of ``weaker`` shaking in which a value at a place is largest, and counts."""
    if weaker.empty:
        return []
    counts = (weaker[column_of(place, REACHED)] > 0.0) | (weaker[column_of(place, GROUND)] >= min(AREA_THRESHOLDS.values()))
    levels = set[Any]()
    for column in (column_of(place, quantity) for quantity in (PEAK_DEPTH, PEAK_SPEED, PRESSURE, GROUND)):
        run = max(weaker[counts & (weaker[column] > 0.0)].to_dict("records"), key=lambda run: run[column], default=None)
        if run and not run[column] < WORSE * runs[column].max():
            levels.add(run[AMPLITUDE])
    return [of for level, of in weaker.groupby(AMPLITUDE, sort=False) if level in levels]


def _level(runs: pd.DataFrame) -> str:
    """The amplitude of the shaking of some runs, and whether the spacing decides if they stand; nothing where there is none."""
    if AMPLITUDE not in runs or runs.empty:
        return ""
    return in_both(float(runs[AMPLITUDE].iloc[0])) + WHERE_SPACING_DECIDES * bool(differs(runs).any())


def _reached_from(runs: pd.DataFrame, place: str) -> str:
    """The least amplitude of a run whose debris reaches a place, and a lower one of runs of which the spacing decides if they stand."""
    return weakest_words(runs[runs[column_of(place, REACHED)] > 0.0]) or NOTHING


def _at(runs: pd.DataFrame, place: str, reached_from: str, contradicted: bool) -> Sequence[str]:
    """The cells of a place from how many runs reach it on."""
    of = {quantity: runs[column_of(place, quantity)] for quantity in (REACHED, PASSED, ARRIVAL, PEAK_DEPTH, PEAK_SPEED, PRESSURE, GROUND)}
    there = of[REACHED] > 0.0
    reached = f"{there.sum()} of {of[REACHED].notna().sum()}"
    values = [NOTHING] * 4
    if there.any():
        first = float((of[ARRIVAL] - runs["shaking_start"])[there].min())
        speed, pressure = (f"{float(f'{most:.2g}'):g}" for most in (of[PEAK_SPEED][there].max(), 1e-3 * of[PRESSURE][there].max()))
        begins = NOTHING if first != first else "before it" if first < 0.0 else f"{first:.3g}"
        values = [begins, metres(float(of[PEAK_DEPTH][there].max())), speed, pressure]
    ground = float(of[GROUND].max())
    moves = metres(ground) if ground >= min(AREA_THRESHOLDS.values()) else NOTHING
    return (reached, reached_from, *values, moves, "not known: runs stand that should fail" if contradicted else _short(runs, place, there))


def _short(runs: pd.DataFrame, place: str, there: pd.Series) -> str:
    """How far short of a place the debris stops that goes farthest of runs that do not reach it, and how certain that is: unknown where
    some are held back or still move, and then what those at rest do only if they come nearer."""
    short = runs[~there & runs[column_of(place, REACHED)].notna()]
    if short.empty:
        return NOTHING
    braked = held(short)
    moving = ~braked & (short["at_rest"] == 0)
    unsure = braked | moving
    if not unsure.any():
        return _at_rest(short, place)
    reason = " and ".join([*["held back"] * bool(braked.any()), *["still moving"] * bool(moving.any())])
    count = f" in {unsure.sum()} of {len(short)} runs" if len(short) > 1 else ""
    away = _away(_farthest(short[unsure], place), place)
    said = f"unknown{count}, {reason}{f'; {away} at the end' if away else ''}"
    passed = short[column_of(place, PASSED)]
    nearer = bool(passed[~unsure].max() > passed[unsure].max())  # not where all are unsure: NaN
    return f"{said}; of those at rest: {_at_rest(short[~unsure], place)}" if nearer else said


def _nearer(runs: pd.DataFrame, weaker: pd.DataFrame, place: str) -> str:
    """How far short of a place the debris is in ``weaker`` shaking, where it comes nearer than in that of ``runs``; nothing where it
    reaches the place in one of them."""
    passed, reached = column_of(place, PASSED), column_of(place, REACHED)
    if (pd.concat([runs, weaker])[reached] > 0.0).any() or not weaker[passed].max() > runs[passed].max() + LEAST:
        return ""
    level = _farthest(weaker, place)[AMPLITUDE]
    same = weaker[weaker[AMPLITUDE] == level]
    return f"; at {in_both(float(level))}: {_short(same, place, same[reached] > 0.0)}"


def _farthest(runs: pd.DataFrame, place: str) -> dict[Any, Any]:
    """The run whose debris comes nearest to a place."""
    return runs.sort_values(column_of(place, PASSED), na_position="first").to_dict("records")[-1]


def _away(run: Mapping[Any, Any], place: str) -> str:
    """How far short of a place the debris of a run is; nothing where none comes down or its depth does not count."""
    gap = -float(run[column_of(place, PASSED)])
    return f"{metres(gap)} m short" if gap > 0.0 and has_debris(run) else ""


def _at_rest(runs: pd.DataFrame, place: str) -> str:
    """How far short of a place debris at rest is that goes farthest."""
    farthest = _farthest(runs, place)
    gap, away = -float(farthest[column_of(place, PASSED)]), _away(farthest, place)
    if math.isnan(gap):
        return "no debris comes from above it"
    if error := near_miss(farthest, place):
        return f"may be reached: stops {away}, within its error of {100.0 * error:.0f} %"
    if not any(map(has_debris, runs.to_dict("records"))):
        return f"no soil that fails comes within {metres(gap)} m" if gap > 0.0 else "no soil that fails comes near"
    return f"stops {away}" if away else "no depth that counts"
