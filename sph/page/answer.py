"""The first screen of the page: whether the slope stands, at what shaking it fails, how far it moves, and what limits trust in that."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.checks.after_run import BRAKED, is_bounded, is_braked, is_open, lower_bounds
from sph.checks.finding import Finding, Severity
from sph.checks.messages import braked_words, factor_words, limit_how, limit_words, search_words, sentence, yield_words
from sph.experiments.trigger.annual import annual_columns
from sph.experiments.trigger.boundaries import in_words
from sph.experiments.trigger.critical import BRACKETED, read_critical
from sph.experiments.trigger.exceedance import SHARES, width_within
from sph.experiments.variants.advice import expected_sentence
from sph.experiments.variants.second_spacing import CONVERGED, NOT_CONVERGED, read_spacing
from sph.figures.style import AT_LEAST, NOTHING, metres
from sph.measures.metrics import AREA_THRESHOLDS, CLASSES, ENERGY_LIMIT, STABLE
from sph.measures.places import ARRIVAL, GROUND, PASSED, PEAK_DEPTH, PEAK_SPEED, PRESSURE, REACHED, column_of, places_in
from sph.measures.sides import BACK
from sph.page.alternatives import compared, verdict
from sph.page.tables import MAX_VALUES, Table, filled
from sph.scene.gravity import UNSHAKEN
from sph.scene.schema import Scene
from sph.scene.units import beside_g, in_both
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.dimensions import ALTERNATIVE, BASE, CASE, Dimension, dimension, shown_unit, title_of
from sph.study.preflight import Row, read_preflight
from sph.study.runs import OF_MEAN, SAFETY, SLOPE_LIMITS, YIELD
from sph.study.tables import EXPECTED, read_csv
from sph.study.verdicts import tally

FINDINGS = "{fidelity}/preflight.csv"
"""What was found in the scenes before their runs: errors and warnings are told."""
SEARCHES = "{fidelity}/stages/{limit}*.nc"
"""The searches for a limit of the slopes, where they were made."""
CRITICAL = "*/trigger/trigger.csv"
"""The search for the critical intensities, where it was made."""
ANNUAL = "*/trigger/fragility_annual.csv"
"""How often a year, where a hazard curve was given."""
CLAIMS, TRIGGER_CLAIM = "{fidelity}/claims.csv", "*/trigger/claim.csv"
"""The claims of a paper as the study decides them, and the one that a search decides, of the study of such claims."""
SPACINGS = "{fidelity}/spacing.csv"
"""The runs at a second spacing, where the study names one."""
NOT_TESTED, NOT_SEARCHED = "not tested", "not searched"
"""What is said of a limit that was not asked for, which a client is not told."""
FEWEST = 4
"""Fewest runs an amplitude whose widths are worth a row."""
AMPLITUDE = "amplitude"
"""The dimension of the shaking."""


class Answer(NamedTuple):
    """What the first screen says."""

    lead: Sequence[str]  # what happens in the strongest shaking, at each place then and in each alternative
    facts: list[tuple[str, str, str]]  # name, what is known of it, and how it can be known
    tables: list[Table]
    alarms: list[str]  # what the spacing decides
    warnings: list[str]  # what limits trust in the results, errors of the scenes first
    expected: str  # the error to expect of the numerics


def answer(
    table: pd.DataFrame,
    dimensions: Sequence[Dimension],
    scene: Scene,
    probe: str,
    found: Callable[[str], Sequence[str]],
    client: bool = False,
    missing: int = 0,
) -> Answer:
    """The answer of a study from its table, the scene of a run and the files ``found`` for a pattern; ValueError names a damaged file.

    That for a ``client`` names no commands and keys.  Of runs that are still ``missing`` in the table nothing is said.
    """
    size = len(table) + missing
    rows = [row for file in found(FINDINGS) for row in read_preflight(file)]
    findings = [row.finding for row in rows]
    why = held_back(table, rows)
    own = as_it_is(table)
    less = f"it may fail at less: {why}" if why else ""
    factor, how = limit(findings, "factor-of-safety", found(_files(SAFETY)), "" if client else "sph fos")
    critical, statically = limit(findings, "yield-acceleration", found(_files(YIELD)), "" if client else "sph yield-acceleration")
    by_slices = min((of.numbers for of in findings if of.code == "limit-equilibrium"), key=lambda of: of["spencer"], default=None)
    facts = [
        *claims(found(CLAIMS), found(TRIGGER_CLAIM)),
        ("Without shaking", *unshaken(table, rows, missing)),
        ("Factor of safety", f"{factor} by SPH; {factor_words(by_slices)}" if by_slices else factor, how),
        *at_residual(rows),
        ("Yield acceleration", f"{critical} by SPH; {yield_words(by_slices)}" if by_slices else critical, statically),
        ("Shaking at which it fails", searched(scene, found(CRITICAL)) or going(own, dimensions, missing), less),
        *answer_spacing(found(SPACINGS)),
        *(at_places(own, why, missing) if len(strongest(own)) < len(own) else ()),  # else the lead says it
        *yearly(found(ANNUAL), falling(table, rows) > 0),
    ]
    first, *places = lead(table, rows, why, missing)
    beside = verdict(strongest(table), dimensions)
    return Answer(
        [_raised(words) for words in (first, beside, *places) if words],
        [(name, _raised(words), _raised(how)) for name, words, how in facts if not (client and words in (NOT_TESTED, NOT_SEARCHED))],
        [filled(each) for each in (*compared(table, dimensions, probe), levels(own, dimensions, probe, why), *widths(own))],
        drifts(found(SPACINGS), probe, _points(table, dimensions)),
        list(map(_raised, _warnings(table, scene, probe, rows, client, size))),
        expected_sentence(scene, not client).split(", since" if client else "\n")[0]
        if len(table[[row.name for row in EXPECTED]].dropna(how="all").drop_duplicates()) <= 1
        else "differs, see all runs",
    )


def lead(table: pd.DataFrame, rows: Sequence[Row], why: str = "", missing: int = 0) -> list[str]:
    """Whether the slopes stand without shaking, and in the strongest shaking of the study how many runs fail and how far the debris goes;
    behind that what it does at each place.  Where runs are ``missing`` it begins with that."""
    said, size = list[str](), len(table) + missing
    if missing:
        said.append(f"So far {len(table)} of {_runs(size)} are done, and what is said here is of these alone")
    if falls := falling(table, rows):
        said.append(f"The slope does not stand without shaking{'' if falls == size else f' in {falls} of {size} runs'}")
    others = strongest(table)
    level = f"At {in_both(float(others[AMPLITUDE].iloc[0]))}" if AMPLITUDE in table else "In this study"
    if (runs := as_it_is(others)) is not others:
        level = f"As it is, {level[0].lower()}{level[1:]}"
    elif ALTERNATIVE in runs and not (runs[ALTERNATIVE] == BASE).any():  # those of the scene as it is are still to come
        level = f"With {' or '.join(map(str, runs[ALTERNATIVE].unique()))}, {level[0].lower()}{level[1:]}"
    known = runs[runs["diverged"] == 0]
    fail, collapse = (int(known["collapse_class"].isin(classes).sum()) for classes in (CLASSES[1:], CLASSES[-1:]))
    if known.empty:
        words = [f"{level} every run diverged: there is no result"]
    elif not fail:
        words = [f"{level} no run fails" + f", but soil that would move is braked: {why}" * bool(why)]
    else:
        if len(known) == 1:
            words = [f"{level} the slope {'collapses' if collapse else 'fails'}"]
        else:
            words = [f"{level} {fail} of {len(known)} runs fail" + f", {collapse} of them by collapse" * bool(collapse)]
        words += [f"{len(runs) - len(known)} diverged"] * bool(len(known) < len(runs))
        moving = int((known["still_moving"] > 0).sum())
        if (farthest := known["runout"].max()) > 0.0:
            words.append(f"debris runs {_bound(known)} {metres(farthest)} m beyond the toe")
        if moving:
            words.append(f"soil still moves at the end of {_runs(moving)}" if len(known) > 1 else "soil still moves at the end")
    places = places_in(table.columns) if len(known) else ()
    more = [f"{place}: {'; '.join(filter(None, at_place(known, place, missing=missing)))}" for place in places]
    return [f"{words}." for words in (". ".join([*said, "; ".join(words)]), *more)]


def strongest(table: pd.DataFrame) -> pd.DataFrame:
    """The runs in the strongest shaking; all where it is one."""
    return table[table[AMPLITUDE] == max(table[AMPLITUDE], key=float)] if AMPLITUDE in table else table


def as_it_is(table: pd.DataFrame) -> pd.DataFrame:
    """The runs of the scene as it is, of a study with alternatives; all where there are none of them, or no alternatives."""
    own = table[table[ALTERNATIVE] == BASE] if ALTERNATIVE in table else table
    return own if 0 < len(own) < len(table) else table


def _bound(known: pd.DataFrame) -> str:
    """Whether the largest run-out of some runs is that, or more was to come."""
    return "at least" if (known["still_moving"] > 0).any() or lower_bounds(known).any() else "up to"


def falling(table: pd.DataFrame, rows: Sequence[Row]) -> int:
    """The number of runs whose slope does not stand without shaking: by the static test before them, or else in the run itself."""
    failed = int((table["status"] == Status.FAILED_UNSHAKEN).sum())
    return sum(row.runs for row in rows if row.finding.code == "fails-unshaken") or failed


def _points(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> dict[str, str]:
    """The runs of a grid in words, by name; a case of a list keeps its name."""
    points = table.to_dict("records") if CASE not in table else []
    return {str(run): title_of(dimensions, point) for run, point in zip(table.index, points, strict=False)}  # type: ignore[arg-type]


def _raised(words: str) -> str:
    return words.replace("m/s2", shown_unit("m/s2"))


def held_back(table: pd.DataFrame, rows: Sequence[Row]) -> str:
    """How many rows of particles the weak soil has that stronger ground brakes, in words; nothing where it does so in no run."""
    if not table["findings"].map(is_braked).any():
        return ""
    return " and ".join(braked_words(row.finding) for row in rows if row.finding.code in BRAKED) or "few rows of particles in weak soil"


def unshaken(table: pd.DataFrame, rows: Sequence[Row], missing: int = 0) -> tuple[str, str]:
    """Whether the slopes of the runs, of those that are ``missing`` too, stand without shaking by the static tests before the runs, and
    whether soil softened in the runs before it."""
    runs, size = len(table), len(table) + missing
    fail = sum(row.runs for row in rows if row.finding.code == "fails-unshaken")
    soften = int((table["status"] == Status.FAILED_UNSHAKEN).sum())
    if fail:
        return f"does not stand in {fail} of {size} runs", "by a static test"
    tested = any(row.finding.code == "stands-unshaken" for row in rows)
    narrow = sum(row.runs for row in rows if row.finding.code == "factor-of-safety" and row.finding.severity == Severity.WARNING)
    if soften:
        how = f"soil reaches its strength under gravity and softens before the shaking exceeds {UNSHAKEN:g} g"
        return f"fails in {soften} of {runs} runs", f"{how}; the slope stands at peak strength" if tested else how
    if narrow:
        return (
            f"not certain in {narrow} of {size} runs",
            "it stands in a static test, but its factor of safety does not exceed 1 by more than its error",
        )
    return ("stands", "by a static test") if tested else (NOT_TESTED, "sph check --stability")


def at_residual(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    """The factors of safety at the strength that failed soil keeps, and what it means where that is below 1 and the slope stands now."""
    found = [row.finding.numbers for row in rows if row.finding.code == "limit-equilibrium-residual"]
    falls, stands = (sum(row.runs for row in rows if row.finding.code == code) for code in ("fails-at-residual", "stands-at-residual"))
    by_particles = f"in SPH it stands in {stands} of {falls + stands} runs" if falls + stands else ""
    if not found and not by_particles:
        return []
    factors = sorted(of["spencer"] for of in found)
    by_slices = factor_words(found[0]) if len(found) == 1 else f"Spencer {factors[0]:.2f} to {factors[-1]:.2f}" if found else ""
    keeps = "once soil is shaken beyond its peak strength it keeps flowing, whatever the factor at peak strength (progressive failure)"
    meant = keeps if falls else ""
    return [("Factor of safety at residual strength", "; ".join(filter(None, (by_slices, by_particles))), meant)]


def _files(limit: str) -> str:
    return SEARCHES.replace("{limit}", limit)


def limit(findings: Sequence[Finding], code: str, files: Sequence[str], closely: str) -> tuple[str, str]:
    """A limit with its error, least to most over the slopes, and how it was found: by the searches in ``files``, of which Newmark's blocks
    have theirs, or where there are none by the quick ones before the runs; ``closely`` is the command that searches more closely, if it is
    to be named."""
    if files:
        return _of_files(files)
    found = sorted((each for each in findings if each.code == code), key=lambda each: float(each.numbers["value"]))
    if not found:
        unknown = [str(each.numbers["reason"]) for each in findings if (each.code, each.subject) == ("stability-unknown", code)]
        if unknown:
            return "not known", unknown[0] if closely else re.sub(r"^[a-z_.]+: ", "", unknown[0])
        return NOT_SEARCHED, closely
    slopes = f" of {len(found)} slopes" if len(found) > 1 else ""
    how = f"static, a quick search{slopes} before the runs, {limit_how(found[0])}"
    return " to ".join(dict.fromkeys(map(limit_words, (found[0], found[-1])))), how + f"; more closely: {closely}" * bool(closely)


def _of_files(files: Sequence[str]) -> tuple[str, str]:
    searches = sorted((trajectory.read(file).attrs for file in files), key=lambda facts: float(facts["value"]))
    found = [search_words(facts) for facts in searches if not facts["reason"]]
    reasons = list(dict.fromkeys(search_words(facts)[0] for facts in searches if facts["reason"]))
    several = any(Path(file).stem not in SLOPE_LIMITS for file in files)  # of a study of several slopes, each named
    one = " of the mean soil" if all(OF_MEAN in Path(file).stem for file in files) else " of one slope"
    count = "" if not several else one if len(found) == 1 else f" of {len(found)} slopes"
    words = [" to ".join(dict.fromkeys((found[0][0], found[-1][0]))) + count] if found else []
    return "; ".join(words + reasons), ", ".join(["static", *dict.fromkeys(how for _, how in found)])


def searched(scene: Scene, files: Sequence[str]) -> str:
    """The intensities of the shaking at which the slopes of a search begin to fail, in words; nothing without a search that found one."""
    for file in files:
        rows = read_critical(file)
        order = [*CLASSES, *rows["collapse_class"]]
        first = rows[(rows["collapse_class"] == min(rows["collapse_class"], key=order.index)) & (rows["outcome"] == BRACKETED)]
        if len(first):
            intensity = dimension(first["intensity"].iloc[0], ["1"], scene)
            name, low, high = first["collapse_class"].iloc[0], first["critical_intensity"].min(), first["critical_intensity"].max()
            named = "" if intensity.name == AMPLITUDE else f"{intensity.symbol} "
            if intensity.unit == "m/s2":
                span = _span(low, high, in_both)
            else:
                span = f"{_span(low, high, '{:.3g}'.format)} {intensity.shown_unit}".rstrip()
            return f"{named}{span} (searched; {in_words(name)})"
    return ""


def going(table: pd.DataFrame, dimensions: Sequence[Dimension], missing: int = 0) -> str:
    """The amplitudes between which the weakest of the slopes leaves the class 'stable', by the runs whose soil does not fail before; at
    most the higher one where runs are ``missing``, which may fail at less."""
    if AMPLITUDE not in table:
        return "only one level of shaking was run"
    table = table[table["status"] != Status.FAILED_UNSHAKEN]
    if table.empty:
        return "no answer: every run fails without shaking"
    shaking = table[AMPLITUDE].astype(float)
    gone = shaking[table["collapse_class"].isin(CLASSES[1:])].min()
    below = shaking[shaking < shaking[table["collapse_class"] != STABLE].min()].max()  # a run that diverged is not known to stand
    of = " in the weakest case" if len(dimensions) > 1 else ""
    if math.isnan(gone):
        return f"no failure found{' so far' * bool(missing)} up to {in_both(shaking.max())}: no run goes beyond the class {STABLE}"
    return f"at most {in_both(gone)}{of}" if missing or math.isnan(below) else f"between {in_both(below)} and {in_both(gone)}{of}"


def claims(files: Sequence[str], searched: Sequence[str]) -> list[tuple[str, str, str]]:
    """How many claims of the paper hold; one that runs alone leave open has the verdict of the first case ``searched``."""
    facts = []
    for file in files:
        verdicts = _verdicts(file)
        for decided in searched[:1]:
            verdicts |= _verdicts(decided)
        facts.append(("The paper's claims", *tally(verdicts)))
    return facts


def _verdicts(file: str) -> dict[int, str]:
    """The verdicts of a table of claims by their numbers, of the first of several cases; ValueError names a file that is none."""
    try:
        rows = pd.read_csv(file, keep_default_na=False)[["claim", "verdict"]].astype({"claim": int, "verdict": str})
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"{file}: cannot be read as a table: {error}; delete it and repeat the command that wrote it") from error
    first = rows.drop_duplicates("claim")
    return dict(zip(first["claim"].tolist(), first["verdict"].tolist(), strict=True))


def answer_spacing(files: Sequence[str]) -> list[tuple[str, str, str]]:
    """In how many runs a second spacing changes nothing that counts."""
    facts = []
    for file in files:
        rows = read_spacing(file)
        runs = [set(of["verdict"]) == {CONVERGED} for _, of in rows.groupby("run")]
        at = " and ".join(f"{rows[name].iloc[0]:.3g} m" for name in ("spacing", "second_spacing"))
        facts.append(("Spacing", f"{CONVERGED} in {sum(runs)} of {len(runs)} runs", f"all runs with particles of {at}"))
    return facts


def drifts(files: Sequence[str], probe: str, points: Mapping[str, str]) -> list[str]:
    """The largest change of displacement and run-out by a second spacing, where that is not converged, and the runs in which it decides
    whether the debris reaches a place; ``points`` are the words for runs, others keep their names."""
    found = []
    for file in files:
        rows = read_spacing(file)
        rows["run"] = [points.get(run, run) for run in rows["run"]]
        drifting = rows[rows["verdict"] == NOT_CONVERGED]
        for quantity, what in (("displacement_magnitude", f"displacement of {probe}"), ("runout", "run-out")):
            of = drifting[drifting["quantity"] == quantity]
            if of.empty:
                continue
            worst = max(of.to_dict("records"), key=lambda row: abs(row["value"] - row["second_value"]))
            both = sorted(((worst[f"{which}spacing"], worst[f"{which}value"]) for which in ("", "second_")), reverse=True)
            said = ", ".join(f"{metres(value)} m at {spacing:.3g} m" for spacing, value in both)
            towards = "" if math.isnan(worst["extrapolated"]) else f"; extrapolated to spacing 0: {metres(worst['extrapolated'])} m"
            count = rows.loc[rows["quantity"] == quantity, "run"].nunique()
            found.append(f"Not converged: {what} in {len(of)} of {count} runs, most at {worst['run']}: {said}{towards}.")
        for place in places_in(rows["quantity"].unique()):
            past = rows[rows["quantity"] == column_of(place, PASSED)]
            known = [(run, values) for run, *values in past[["run", "value", "second_value", "extrapolated"]].itertuples(index=False)]
            open_runs = [run for run, values in known if len({value >= 0.0 for value in values if not math.isnan(value)}) > 1]
            if open_runs:
                found.append(
                    f"Not converged: whether debris reaches {place} depends on the spacing at {'; '.join(open_runs[:3])}"
                    f"{f' and {len(open_runs) - 3} more runs' if len(open_runs) > 3 else ''}."
                )
    return found


def at_places(table: pd.DataFrame, why: str = "", missing: int = 0) -> list[tuple[str, str, str]]:
    """What the debris does at each place."""
    return [(f"At {place}", *at_place(table, place, why, missing)) for place in places_in(table.columns)]


def at_place(table: pd.DataFrame, place: str, why: str = "", missing: int = 0) -> tuple[str, str]:
    """In how many runs the debris reaches a place, how deep, how fast and with what pressure, and when; how far short of it the debris
    stops, and how far the ground of the place itself moves.

    While debris moves nothing is known of how far it goes, nor where it was braked, for ``held_back`` says ``why``; nor of runs that are
    ``missing``."""
    of = {quantity: table[column_of(place, quantity)] for quantity in (REACHED, PASSED, ARRIVAL, PEAK_DEPTH, PEAK_SPEED, PRESSURE, GROUND)}
    known, there = of[REACHED].notna(), of[REACHED] > 0.0
    short = known & ~there
    braked = short & table["findings"].map(is_braked)
    moving = short & ~braked & (table["still_moving"] > 0)
    still = short & ~braked & ~moving
    words, how = list[str](), list[str]()
    if there.any():
        first = (of[ARRIVAL] - table["shaking_start"]).min()
        begins = f", first {first:.3g} s after the shaking begins" * (not math.isnan(first))
        words.append(f"reached in {there.sum()} of {_runs(known.sum())}{begins}, up to {metres(of[PEAK_DEPTH][there].max())} m deep")
        speed, pressure = (f"{float(f'{most:.2g}'):g}" for most in (of[PEAK_SPEED][there].max(), 1e-3 * of[PRESSURE][there].max()))
        words.append(f"{speed} m/s and {pressure} kPa at most")
    elif still.any() or not (known.any() or missing):
        words.append(f"not reached in {_runs(still.sum())}")
    words += [f"not yet in {_runs(moving.sum())}, whose debris still moves at the end"] * bool(moving.any())
    words += [f"unknown in {_runs(braked.sum())}, whose debris is braked" + f": {why}" * bool(why)] * bool(braked.any())
    words += [f"unknown in {_runs(missing)} still to come"] * bool(missing)
    words += [f"its ground moves by up to {metres(of[GROUND].max())} m"] * bool(of[GROUND].max() >= min(AREA_THRESHOLDS.values()))
    gap = -float(of[PASSED][short].max())
    if not there.any() and gap > 0.0:
        if (table["still_moving"][short] > 0).any():
            how.append(f"the debris is at least {metres(gap)} m short of it then; run them for longer")
        else:
            stops = f"the debris stops at least {metres(gap)} m short of it"
            how.append(f"the braked debris comes to {metres(gap)} m of it" if braked.any() else stops)
    return "; ".join(words), "; ".join(how)


def _runs(count: float) -> str:
    return f"{count:.0f} run" if count == 1 else f"{count:.0f} runs"


def yearly(files: Sequence[str], falls: bool = False) -> list[tuple[str, str, str]]:
    """How often a year each class or place is reached, by the annual frequencies of a search; of a slope that ``falls`` without shaking
    there is none."""
    if files and falls:
        return [("How often", "no frequency: the slope does not stand without shaking", "")]
    found = []
    for file in files:
        for row in read_csv(file, annual_columns("1"), "annual frequencies").to_dict("records"):
            fitted = not math.isnan(row["frequency"])
            ends = ("frequency_lower", "frequency_upper") if fitted else ("frequency_least", "frequency_most")
            span = f"{row[ends[0]]:.2g} to {row[ends[1]]:.2g}"
            words = f"{row['frequency']:.2g} times a year ({span})" if fitted else f"{span} times a year"
            beyond = f"; shaking beyond the curve adds at most {row['beyond_last']:.2g}"
            how = f"fragility integrated over the hazard curve{beyond}" if fitted else "bounds from the brackets, over the hazard curve"
            found.append((f"How often: {in_words(row['collapse_class'])}", words, how))
    return found


def widths(table: pd.DataFrame) -> list[Table]:
    """Widths that most of the runs do not pass, a row per amplitude; none for a study without places, and for too few runs an amplitude."""
    if not places_in(table.columns) or max(len(runs) for _, runs in _groups(table)) < FEWEST:
        return []
    rows = []
    for value, runs in _groups(table):
        runouts = runs["runout"].to_numpy(float)
        bounded = bool(lower_bounds(runs).any())
        rows.append((beside_g(value), str(len(runs)), *(metres(width_within(runouts, share), bounded) for share in SHARES)))
    head = ("shaking (m/s²)", "runs", *(f"{share:.0%} (m)" for share in SHARES))
    errors = table["expected_runout_error"].dropna()
    error = f"the spacing adds an error of up to {errors.max():.0%}" if len(errors) else "the error due to the spacing is unknown"
    note = f"All runs of the study count equally, with the soils, motions and levels chosen; {error}."
    return [Table("Run-out from the toe not exceeded by this share of the runs", head, rows, note)]


def _groups(table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """The runs of a study by the amplitude of shaking, if it has one and not too many."""
    written = list(dict.fromkeys(table[AMPLITUDE])) if AMPLITUDE in table else []
    groups = [(str(value), table[table[AMPLITUDE] == value]) for value in sorted(written, key=float)]
    return groups if 0 < len(groups) <= MAX_VALUES else [("all" if groups else "of the scene", table)]


def levels(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str, why: str = "") -> Table:
    """Class, displacement, run-out and the slip of the sliding block, least to most over the other dimensions: a row per amplitude."""
    groups = _groups(table)
    rows = []
    for value, runs in groups:
        reached = [name for name in CLASSES if (runs["collapse_class"] == name).any()] or [NOTHING]
        met = lower_bounds(runs)
        columns = (("displacement_magnitude", met), ("runout", met), ("newmark_displacement", met & False))
        spans = [_lengths(runs[name], bounds) for name, bounds in columns]
        rows.append((beside_g(value), " to ".join(dict.fromkeys((reached[0], reached[-1]))), *spans))
    head = ("shaking (m/s²)", "class", f"displacement of {probe} (m)", "run-out (m)", "Newmark block (m)")
    notes = ["Smallest to largest value over the other dimensions of the study."] if len(table) > len(groups) else []
    if table["reached_side"].map(is_bounded).any():
        notes.append(f"{AT_LEAST.strip()}: in at least one run debris reached an end of the box and would have gone further.")
    if why:
        notes.append(f"{AT_LEAST.strip()}: debris is braked, so the value is too small: {why}.")
    notes += _compared(table)
    if table["newmark_displacement"].notna().any():
        soft = table["findings"].str.contains("block-not-rigid").any()
        rigid = "; where the slope is not rigid, the slip of the block is not an upper bound" if soft else ""
        notes.append(f"The Newmark block is rigid and uses the yield acceleration above{rigid}.")
    return Table("By the amplitude of shaking", head, rows, " ".join(notes))


def _compared(table: pd.DataFrame) -> list[str]:
    """How far a sliding point and slides of the field go, beside the run-outs, in a sentence; none where no debris passes the toe."""
    table = table[table["runout"] > 0.0]
    if table.empty:
        return []
    energy, field = (_lengths(table[name], lower_bounds(table) & False) for name in ("energy_line_runout", "corominas_runout"))
    if field == NOTHING:
        return []
    point = f"{energy} m by the energy line (residual friction, less by water pressure)" if energy != NOTHING else ""
    return [f"To compare with run-outs: {', '.join(filter(None, (point, f'{field} m by Corominas (debris slides)')))}."]


def _lengths(values: pd.Series, bounds: pd.Series) -> str:
    """The smallest to the largest of some lengths in m, some of which are lower bounds."""
    values = values.dropna()
    if values.empty:
        return NOTHING
    low, high = values.min(), values.max()
    ends = ((low, bounds[values.index][values == low].all()), (high, bounds.any()))
    return " to ".join(dict.fromkeys(metres(end, bool(bound)) for end, bound in ends))


def _span(low: float, high: float, words: Callable[[float], str]) -> str:
    return " to ".join(dict.fromkeys((words(low), words(high))))


def _warnings(table: pd.DataFrame, scene: Scene, probe: str, rows: Sequence[Row], client: bool, size: int) -> list[str]:
    runs = len(table)
    errors, warnings = (
        [f"{row.runs} of {size} runs: {sentence(row.finding, not client)}" for row in rows if row.finding.severity == severity]
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
    say(
        ((table["still_moving"] > 0) & (table["diverged"] == 0)).sum(),
        "are still moving at the end: displacement and run-out are not final.",
    )
    say(
        table["reached_side"].map(is_bounded).sum(),
        "have debris that reached the end of the box or went over it: displacement and run-out are lower bounds; lengthen the apron.",
    )
    say(
        table["findings"].map(is_braked).sum(),
        "have debris that is braked: displacement and run-out are lower bounds, and the slope may fail at less.",
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
