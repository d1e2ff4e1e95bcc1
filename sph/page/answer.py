"""The first screen of the page: whether the slope stands, at what shaking it fails, how far it moves, and what limits trust in that."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.after_run import BRAKED, LATE, at_least, has_thin_debris, held, is_at_least, is_bounded, is_braked, is_open, near_miss
from sph.checks.cover_rows import SCATTER
from sph.checks.messages import Severity, block_words, braked_words, factor_words, listed, sentence, surer, yield_words
from sph.experiments.variants.advice import expected_words
from sph.figures.style import metres
from sph.measures.metrics import AREA_THRESHOLDS, CLASSES, ENERGY_LIMIT
from sph.measures.places import GROUND, PASSED, REACHED, column_of, places_in
from sph.measures.sides import BACK
from sph.page.alternatives import compared, doubts, holding, of_alternative, slices_of, verdict
from sph.page.facts import (
    NOT_KNOWN,
    NOT_SEARCHED,
    NOT_TESTED,
    at_residual,
    claims,
    fails_below,
    fails_in_weakest,
    few_rows,
    going,
    limit,
    runs_said,
    searched,
    unshaken,
    when,
    yearly,
)
from sph.page.levels import levels, widths
from sph.page.matrix import TO_COME
from sph.page.places import at_a_glance, at_places
from sph.page.second_spacing import answer_spacing, at_spacings, differs, drifts
from sph.page.tables import Table, filled, moves_on, turned
from sph.scene.gravity import UNSHAKEN
from sph.scene.schema import Scene
from sph.scene.scheme import SOFTENING
from sph.scene.units import in_both
from sph.stability.record import SAFETY, SEARCHES, YIELD
from sph.storage.trajectory import Status
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, BASE, CASE, SAME_LEVEL, SPACING, Dimension, shown_unit, title_of
from sph.study.preflight import Row, read_preflight
from sph.study.tables import EXPECTED

FINDINGS, CHECKED = "{fidelity}/preflight.csv", "{fidelity}/checked.csv"
"""What was found in the scenes before their runs: errors and warnings are told; and what is known of that before the searches."""
SEARCH_FILES = "{fidelity}/stages/{limit}*.nc"
"""The searches for a limit of the slopes, where they were made."""
CRITICAL = "*/trigger/trigger.csv"
"""The search for the critical intensities, where it was made."""
ANNUAL = "*/trigger/fragility_annual.csv"
"""How often a year, where a hazard curve was given."""
CLAIMS, TRIGGER_CLAIM = "{fidelity}/claims.csv", "*/trigger/claim.csv"
"""The claims of a paper as the study decides them, and the one that a search decides, of the study of such claims."""
AWAY, FALLS = "block-runs-away", "fails-unshaken"
"""The findings that a slope fails: by limit equilibrium in the shaking of a run, and by a static test without shaking."""
STANDS = "stands-unshaken"
"""The finding of a static test before the runs."""
SPACINGS = "{fidelity}/spacing.csv"
"""The runs at a second spacing, where the study names one."""

FARTHER_IN_WEAKER = 1.01
"""Run-out in weaker shaking, over that in the strongest, from which on it is told."""


SPREADS = "less than the yield acceleration: soil that reaches its peak strength somewhere loses it, and the failure spreads"
"""Why a slope may fail in weaker shaking than that."""
SENSELESS = 10.0
"""Run-out of others over that of the debris from which on it tells nothing, as an energy line with hardly any friction."""


class Answer(NamedTuple):
    """What the first screen says."""

    lead: Sequence[str]  # what happens in the strongest shaking, and in the alternatives then
    glance: Table | None  # what debris does at each place, in a row
    places: list[Table]  # and in full, in the strongest shaking and in weaker shaking that is worse
    facts: list[tuple[str, str, str]]  # name, what is known of it, and how it can be known: those that come first
    more: list[tuple[str, str, str]]  # and further ones
    tables: list[Table]
    alarms: list[str]  # what the spacing decides
    warnings: list[str]  # what limits trust in the results, errors of the scenes first
    surer: str  # what would make the results surer
    expected: str  # the error to expect of the numerics
    why_unknown: str  # why it is not known, and what to do


def answer(
    table: pd.DataFrame,
    dimensions: Sequence[Dimension],
    scene: Scene,
    probe: str,
    found: Callable[[str], Sequence[str]],
    client: bool = False,
    missing: int = 0,
    to_come: Collection[str] = (),
    assumed: Collection[str] = (),
    alternatives: Mapping[str, Mapping[str, Any]] | None = None,
    again: pd.DataFrame | None = None,
    design: float | None = None,
) -> Answer:
    """The answer of a study from its table, the scene of a run and the files ``found`` for a pattern; ValueError names a damaged file.

    That for a ``client`` names no commands and keys, neither of the scene's that are ``assumed`` nor of ``alternatives``.  Of runs that are
    still ``missing`` in the table nothing is said; ``to_come`` are the codes of findings that are still searched; ``again`` is the table of
    the runs at a second spacing, ``design`` the amplitude (m/s2) that is answered first.
    """
    size = len(table) + missing
    rows = [row for file in found(FINDINGS) or found(CHECKED) for row in read_preflight(file)]
    own, first = as_it_is(table), up_to(table, design)
    findings = [row.finding for row in [row for row in rows if row.worst_run in own.index] or rows]  # not those of alternatives
    why = held_back(table, rows)
    weaker = "it fails in the weakest shaking that was run" + "; add weaker levels to the study's amplitude" * (not client)
    less = f"it may fail at less: {why}" if why else weaker if fails_in_weakest(own) else ""

    def sought(limit_of: str, command: str) -> tuple[str, str]:
        code = SEARCHES[limit_of].code
        files = [file for file in found(_files(limit_of)) if f"{ALTERNATIVE}-" not in Path(file).stem]  # those of the scene as it is
        return _unless(to_come, code, limit(findings, code, files, "" if client else command))

    factor, how = sought(SAFETY, "sph fos")
    how += few_rows(findings)
    critical, statically = sought(YIELD, "sph yield-acceleration")
    by_slices = min((of.numbers for of in findings if of.code == "limit-equilibrium"), key=lambda of: of["spencer"], default=None)
    least = min((of.numbers["value"] for of in findings if of.code == SEARCHES[SAFETY].code), default=math.nan)
    yields = own["yield_acceleration"].min()
    of_search = searched(scene, found(CRITICAL))
    least_yield = min(filter(None, (by_slices.get("critical") if by_slices else None, None if math.isnan(yields) else yields)), default=0.0)
    if not of_search and fails_below(own, least_yield):
        less = "; ".join(filter(None, (SPREADS, less)))
    if not of_search and AMPLITUDE in own and SPACING not in own:
        less = "; ".join(filter(None, (at_spacings(own, again, probe, scene.numerics.spacing), less)))
    limits, unknown = [("Factor of safety", factor, how), ("Yield acceleration", critical, statically)], list[tuple[str, str, str]]()
    if by_slices:
        unknown = [(f"{name} by SPH", value, reason) for name, value, reason in limits if value == NOT_KNOWN]
        slices = (factor_words(by_slices), least, by_slices["spencer"]), (yield_words(by_slices), yields, by_slices.get("critical", 0.0))
        limits = [_by_both(*by_sph, *of) for by_sph, of in zip(limits, slices, strict=True)]
    facts = [
        *claims(found(CLAIMS), found(TRIGGER_CLAIM)),
        *yearly(found(ANNUAL), falling(table, rows) > 0),
        ("Shaking at which it fails", of_search or going(own, dimensions, missing), less),
        ("Without shaking", *_unless(to_come, STANDS, unshaken(table, rows, missing, by_slices["spencer"] if by_slices else math.inf))),
        *limits,
    ]
    more = [*when(strongest(as_it_is(first)), probe), *at_residual(rows), *unknown, *answer_spacing(again, size, why)]
    doubted = contradicted(as_it_is(strongest(first)), rows)
    errors = table.loc[table["diverged"] == 0, [row.name for row in EXPECTED]]
    alike = len(errors.drop_duplicates()) <= 1
    expected, why_unknown = (
        expected_words(scene) if alike else (f"known for {len(errors.dropna(how='all'))} of {len(errors)} runs, see all runs", "")
    )
    alarms = drifts(again, probe, _points(table, dimensions))
    beside = "" if doubted else " ".join(filter(None, (verdict(strongest(first), doubts(table, rows)), holding(first))))
    beyond = lead(table, []) if len(first) < len(table) else ""
    return Answer(
        [_raised(words) for words in (lead(first, rows, why, missing, len(table)), beside, beyond) if words],
        at_a_glance(table, bool(doubted)),
        [_table_raised(each) for each in at_places(first, why, bool(doubted))],
        [(name, _raised(words), _raised(how)) for name, words, how in facts if not (client and words in (NOT_TESTED, NOT_SEARCHED))],
        [(name, _raised(words), _raised(how)) for name, words, how in more],
        [
            turned(_table_raised(filled(each)))
            for each in compared(table, dimensions, probe, slices_of(table, rows), {} if client else alternatives)
        ]
        + [filled(each) for each in (levels(own, dimensions, probe, why), *widths(own))],
        alarms,
        list(map(_raised, _warnings(table, scene, probe, rows, client, size))),
        surer_with(table, rows, again is not None or not why_unknown, bool(alarms), scene.early_stop is not None, SOFTENING in assumed),
        expected,
        why_unknown,
    )


def _by_both(name: str, by_sph: str, how: str, by_slices: str, value: float, spencer: float) -> tuple[str, str, str]:
    """A limit by both methods, that first which is known and lies lower, by its ``value`` by SPH, NaN without one, and Spencer's; by slices
    alone where a search found none by SPH."""
    if by_sph == NOT_KNOWN:
        return name, by_slices, ""
    return name, f"{by_sph} by SPH; {by_slices}" if value <= spencer else f"{by_slices}; {by_sph} by SPH", how


def _unless(to_come: Collection[str], code: str, said: tuple[str, str]) -> tuple[str, str]:
    """What is said of a limit, unless it is not known and still searched."""
    return (TO_COME, "") if code in to_come and said[0] in (NOT_TESTED, NOT_SEARCHED) else said


def lead(table: pd.DataFrame, rows: Sequence[Row], why: str = "", missing: int = 0, done: int = 0) -> str:
    """Whether the slopes stand without shaking, and in the strongest shaking of the study how many runs fail and how far the debris goes.
    Where runs are ``missing`` it begins with that; ``done`` are those of the whole study, if these are fewer."""
    done = done or len(table)
    said, size = list[str](), done + missing
    if missing:
        said.append(f"So far {done} of {runs_said(size)} are done, and what is said here is of these alone")
    if falls := falling(table, rows):
        codes = {row.finding.code for row in rows}
        counted = size if FALLS in codes else done
        where = "" if falls == counted else f" in {falls} of {counted} runs"
        if STANDS in codes and FALLS not in codes:
            softens = f"soil yields and softens before the shaking{where}, so the earthquake is not the only cause"
            said.append(f"The slope stands at peak strength, but {softens}")
        else:
            said.append(f"The slope does not stand without shaking{where}")
    others = strongest(table)
    level = f"At {in_both(float(others[AMPLITUDE].iloc[0]))}" if AMPLITUDE in table else "In this study"
    if (runs := as_it_is(others)) is not others:
        level = f"As it is, {level[0].lower()}{level[1:]}"
    elif ALTERNATIVE in runs and not (runs[ALTERNATIVE] == BASE).any():  # those of the scene as it is are still to come
        level = f"With {' or '.join(map(str, runs[ALTERNATIVE].unique()))}, {level[0].lower()}{level[1:]}"
    known = runs[runs["diverged"] == 0]
    should = contradicted(runs, rows)
    fail, collapse = (int(known["collapse_class"].isin(classes).sum()) for classes in (CLASSES[1:], CLASSES[-1:]))
    if known.empty:
        words = [f"{level} every run diverged: there is no result"]
    elif not fail:
        words = [f"{level} no run fails" + f", but weak soil is held back and might fail with more rows: {why}" * bool(why)]
        if should:
            words.append(
                f"by limit equilibrium it should fail: {block_words(should[0].finding.numbers)}. Run it with more rows of particles"
            )
    else:
        if len(known) == 1:
            words = [f"{level} the slope {'collapses' if collapse else 'fails'}"]
        else:
            words = [f"{level} {fail} of {len(known)} runs {'collapse' if fail == collapse else 'fail'}{'s' * (fail == 1)}"]
            words[0] += f", {collapse} of them by collapse" * (0 < collapse < fail)
        if decided := int((differs(known) & (known["collapse_class"] != CLASSES[0])).sum()):
            words[0] += f", {decided} of them" * (len(known) > 1) + " at one of two spacings alone"
        words += [f"{len(runs) - len(known)} diverged"] * bool(len(known) < len(runs))
        moving, weaker = known[known["at_rest"] == 0], _weaker(table, known)
        if (farthest := known["runout"].max()) > 0.0:
            words.append(
                f"debris runs {_bound(known)} {metres(farthest)} m beyond the toe{_beside_others(known)}{_farther_in_weaker(weaker, known)}"
            )
        words += _of_places(known, weaker)
        if len(moving):
            of = f" of {runs_said(len(moving))}" * (len(known) > 1)
            words.append(f"soil still moves at the end{of}, {moves_on(moving)}")
    return f"{'. '.join([*said, '; '.join(words)])}."


def _of_places(known: pd.DataFrame, weaker: pd.DataFrame) -> list[str]:
    """The places that debris reaches in some of these runs, or in ``weaker`` shaking alone, or that it certainly does not, and those whose
    ground moves with the slope."""
    places, runs = places_in(known.columns), known.to_dict("records")
    reached = [name for name in places if (known[column_of(name, REACHED)] > 0.0).any()]
    also = [name for name in places if name not in reached and (weaker[column_of(name, REACHED)] > 0.0).any()]
    moves = {name: float(known[column_of(name, GROUND)].max()) for name in places}
    moved = [f"{metres(by)} m at {name}" for name, by in moves.items() if by >= min(AREA_THRESHOLDS.values())]
    said = [f"it reaches {listed(reached)}"] if reached else []
    below = [name for name in places if known[column_of(name, PASSED)].notna().any()]  # to which debris could come
    said += [f"in weaker shaking it reaches {listed(also)}{' as well' * bool(reached)}"] if also else []
    if below and not said and not any(is_at_least(run) or near_miss(run, place) for run in runs for place in below):
        said = [f"it does not reach {listed(below, 'or')}"]
    said += [f"the ground moves {listed(moved)}"] if moved else []
    return [words.replace("_", " ") for words in said]


def surer_with(
    table: pd.DataFrame, rows: Sequence[Row], checked: bool, differs: bool = False, ended: bool = False, assumed: bool = False
) -> str:
    """What would make the results surer, the most effective three: shear tests where the loss of strength is ``assumed``, a finer spacing
    where what was checked ``differs`` or debris is thin, longer runs, without an early stop where runs are ``ended`` by it, a second
    spacing where the error of the spacing is not ``checked``, and what the warnings ask for, by their rank; nothing where none does."""
    moving = ((table["at_rest"] == 0) & (table["diverged"] == 0)).any()
    said = (
        ["shear tests of the slip at which strength is lost"] * assumed
        + ["a finer spacing"] * bool(differs or has_thin_debris(table).any())
        + ["longer runs" + " without an early stop" * ended] * bool(moving)
    )
    said += ["runs at a second spacing"] * (not checked)
    warnings = sorted((row.finding for row in rows if row.finding.counts), key=lambda each: each.rank)
    return ", ".join(list(dict.fromkeys(filter(None, (*said, *map(surer, warnings)))))[:3])


def contradicted(runs: pd.DataFrame, rows: Sequence[Row]) -> list[Row]:
    """The findings of limit equilibrium by which some of the runs should fail, where none does."""
    stands = not runs.loc[runs["diverged"] == 0, "collapse_class"].isin(CLASSES[1:]).any()
    return [row for row in rows if stands and row.finding.code == AWAY and row.worst_run in runs.index]


def strongest(table: pd.DataFrame) -> pd.DataFrame:
    """The runs in the strongest shaking; all where it is one."""
    return table[table[AMPLITUDE] == max(table[AMPLITUDE], key=float)] if AMPLITUDE in table else table


def up_to(table: pd.DataFrame, design: float | None) -> pd.DataFrame:
    """The runs in shaking up to an amplitude, m/s2, which is then the strongest; all without one, and where none of it is done."""
    if design is None or AMPLITUDE not in table:
        return table
    weaker = table[table[AMPLITUDE].astype(float) <= design * (1.0 + SAME_LEVEL)]
    return table if weaker.empty else weaker


def as_it_is(table: pd.DataFrame) -> pd.DataFrame:
    """The runs of the scene as it is, of a study with alternatives; all where there are none of them, or no alternatives."""
    own = table[table[ALTERNATIVE] == BASE] if ALTERNATIVE in table else table
    return own if 0 < len(own) < len(table) else table


def _bound(known: pd.DataFrame) -> str:
    """Whether the largest run-out of some runs is that, or more was to come."""
    return "at least" if at_least(known).any() else "up to"


def _beside_others(known: pd.DataFrame) -> str:
    """How far a sliding point and slides of the field would go where the debris goes farthest, in brackets."""
    farthest = max(known[known["runout"] > 0.0].to_dict("records"), key=lambda run: run["runout"])
    others = {"energy line": farthest["energy_line_runout"], "mean of past slides": farthest["corominas_runout"]}
    words = ", ".join(f"{name} {metres(goes)} m" for name, goes in others.items() if 0.0 < goes < SENSELESS * farthest["runout"])
    return f" ({words})" * bool(words)


def _weaker(table: pd.DataFrame, known: pd.DataFrame) -> pd.DataFrame:
    """Runs of the scene as it is in weaker shaking than that of the runs ``known``, without those of which the spacing decides if they
    stand."""
    own = as_it_is(table)
    return own[(own["diverged"] == 0) & ~own.index.isin(known.index) & ~differs(own)] if AMPLITUDE in own else own[:0]


def _farther_in_weaker(weaker: pd.DataFrame, known: pd.DataFrame) -> str:
    """How far debris goes in ``weaker`` shaking, where that is farther than in that of the runs ``known``."""
    if weaker.empty or weaker["runout"].max() < FARTHER_IN_WEAKER * known["runout"].max():
        return ""
    run = max(weaker.to_dict("records"), key=lambda run: run["runout"])
    return f", and {metres(run['runout'], is_at_least(run))} m at {in_both(float(run[AMPLITUDE]))}"


def falling(table: pd.DataFrame, rows: Sequence[Row]) -> int:
    """The number of runs whose slope does not stand without shaking: by the static test before them, or else in the run itself."""
    failed = int((table["status"] == Status.FAILED_UNSHAKEN).sum())
    return sum(row.runs for row in rows if row.finding.code == FALLS) or failed


def _points(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> dict[str, str]:
    """The runs of a grid in words, by name; a case of a list keeps its name."""
    points = table.to_dict("records") if CASE not in table else []
    return {str(run): title_of(dimensions, point) for run, point in zip(table.index, points, strict=False)}  # type: ignore[arg-type]


def _raised(words: str) -> str:
    return words.replace("m/s2", shown_unit("m/s2"))


def _table_raised(table: Table) -> Table:
    return table._replace(caption=_raised(table.caption), rows=[[_raised(cell) for cell in row] for row in table.rows])


def held_back(table: pd.DataFrame, rows: Sequence[Row]) -> str:
    """How many rows of particles the weak soil has that stronger ground brakes, in words, of the scene as it is rather than of
    alternatives; nothing where it does so in no run."""
    if not held(table).any():
        return ""
    rows = [row for row in rows if row.worst_run in as_it_is(table).index] or rows
    return (
        " and ".join(braked_words(row.finding) for row in rows if row.finding.code in (*BRAKED, LATE))
        or "few rows of particles in weak soil"
    )


def _files(limit: str) -> str:
    return SEARCH_FILES.replace("{limit}", limit)


def _warnings(table: pd.DataFrame, scene: Scene, probe: str, rows: Sequence[Row], client: bool, size: int) -> list[str]:
    runs = len(table)
    told = [(doubt.finding, doubt.of) for doubt in doubts(table, rows)]
    told += [(row.finding, f"{row.runs} of {size} runs") for row in rows if not of_alternative(table, row)]
    errors, warnings = (
        [f"{who}: {sentence(each, not client)}" for each, who in told if each.severity == severity]
        for severity in (Severity.ERROR, Severity.WARNING)
    )
    found = list[str]()

    def say(count: Any, text: str) -> None:
        if count:
            found.append(f"{int(count)} of {runs} runs {text}")

    say(
        (table["status"] == Status.FAILED_UNSHAKEN).sum(),
        f"have soil that fails under gravity alone and softens before the shaking exceeds {UNSHAKEN:g} g: their results are not due to the "
        "earthquake alone.",
    )
    say(table["diverged"].sum(), "diverged: the guard stopped them, and they have no results.")
    if len(moving := table[(table["at_rest"] == 0) & (table["diverged"] == 0)]):
        say(len(moving), f"are still moving at the end, {moves_on(moving)}: displacement and run-out are not final.")
    say(
        table["reached_side"].map(is_bounded).sum(),
        "have debris that reached the end of the box or went over it: displacement and run-out are lower bounds; lengthen the apron.",
    )
    braked = table["findings"].map(is_braked)
    say(braked.sum(), "have weak soil that is braked: displacement and run-out are lower bounds, and the slope may fail at less.")
    say((held(table) & ~braked).sum(), "stand with few rows of particles in weak soil, with which it fails too late: they may fail.")
    say(
        has_thin_debris(table).sum(),
        "have debris of few particles' thickness in front of the toe: their run-out is not reliable, or known to some "
        f"{100.0 * SCATTER:.0f} % at best; use a smaller spacing.",
    )
    say(
        table["reached_side"].str.contains(BACK).sum(),
        "have failed soil at the end of the box behind the crest: the box limits the failure; lengthen the crest.",
    )
    say(
        table["energy_error"].map(is_open).sum(),
        f"have an energy error of more than {100.0 * ENERGY_LIMIT:g} %: their results are not reliable; use a smaller time step "
        "or spacing.",
    )
    say(
        (table["displacement_magnitude"] < scene.numerics.spacing).sum(),
        f"move {probe} by less than a spacing ({scene.numerics.spacing:.4g} m): the expected error does not apply.",
    )
    return [*errors, *found, *warnings]
