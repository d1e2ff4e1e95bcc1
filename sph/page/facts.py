"""The facts of the first screen, one by one: limits of the slopes, shaking at which they fail, frequencies."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from sph.checks.cover_rows import factor_with, is_late
from sph.checks.finding import Finding
from sph.checks.messages import Severity, factor_words, limit_how, limit_words, search_words
from sph.experiments.trigger.annual import annual_columns
from sph.experiments.trigger.boundaries import in_words
from sph.experiments.trigger.critical import BRACKETED, read_critical
from sph.measures.metrics import CLASSES, STABLE
from sph.page.second_spacing import differs, second_class
from sph.scene.gravity import UNSHAKEN
from sph.scene.schema import Scene
from sph.scene.units import in_both
from sph.stability.record import SLOPE_LIMITS
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.dimensions import AMPLITUDE, Dimension, dimension
from sph.study.preflight import Row
from sph.study.runs import OF_MEAN
from sph.study.tables import read_csv
from sph.study.verdicts import tally

NOT_TESTED, NOT_SEARCHED = "not tested", "not searched"
"""What is said of a limit that was not asked for, which a client is not told."""
NOT_KNOWN = "not known"
"""What is said of a limit that a search did not find."""


def unshaken(table: pd.DataFrame, rows: Sequence[Row], missing: int = 0, spencer: float = math.inf) -> tuple[str, str]:
    """Whether the slopes of the runs, of those that are ``missing`` too, stand without shaking by the static tests before the runs and by
    the least factor of safety of ``spencer``, and whether soil softened in the runs before it."""
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
    if tested and spencer < 1.0:
        return "not certain", f"it stands in a static test, but by Spencer's method its factor of safety is {spencer:.2f}"
    return ("stands", "by a static test") if tested else (NOT_TESTED, "sph check --stability")


def at_residual(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    """The factors of safety at the strength that failed soil keeps, and what it means where that is below 1 and the slope stands now."""
    found = [row.finding.numbers for row in rows if row.finding.code == "limit-equilibrium-residual"]
    falls, stands = (sum(row.runs for row in rows if row.finding.code == code) for code in ("fails-at-residual", "stands-at-residual"))
    by_particles = f"by a static test of SPH the slope would stand in {stands} of {falls + stands} runs" if falls + stands else ""
    if not found and not by_particles:
        return []
    factors = sorted(of["spencer"] for of in found)
    by_slices = factor_words(found[0]) if len(found) == 1 else f"Spencer {_span(factors[0], factors[-1], '{:.2f}'.format)}" if found else ""
    keeps = "once soil is shaken beyond its peak strength it keeps flowing, whatever the factor at peak strength (progressive failure)"
    meant = keeps if falls else ""
    return [("Factor of safety at residual strength", "; ".join(filter(None, (by_slices, by_particles))), meant)]


def limit(findings: Sequence[Finding], code: str, files: Sequence[str], closely: str) -> tuple[str, str]:
    """A limit with its error, least to most over the slopes, and how it was found: by the searches in ``files``, of which Newmark's blocks
    have theirs, or by the quick ones before the runs, beside which stand those in files where they are of fewer slopes; ``closely`` is the
    command that searches more closely, if it is to be named."""
    found = sorted((each for each in findings if each.code == code), key=lambda each: float(each.numbers["value"]))
    if files and len(files) >= len(found):
        return _of_files(files, bool(closely))
    if not found:
        unknown = [str(each.numbers["reason"]) for each in findings if (each.code, each.subject) == ("stability-unknown", code)]
        if unknown:
            return NOT_KNOWN, unknown[0] if closely else re.sub(r"^[a-z_.]+: ", "", unknown[0])
        return NOT_SEARCHED, closely
    slopes = f" of {len(found)} slopes" if len(found) > 1 else ""
    how = f"static, a quick search{slopes} before the runs, {limit_how(found[0].numbers)}"
    words = " to ".join(dict.fromkeys(map(limit_words, (found[0], found[-1]))))
    if files:
        words += f"; more closely {_of_files(files, bool(closely))[0]}"
    return words, how + f"; more closely: {closely}" * bool(closely)


def few_rows(findings: Sequence[Finding]) -> str:
    """How many rows of particles weak soil on stronger ground has in the quick search for the factor of safety, where they are too few."""
    fine = [of.numbers["fine"] for of in findings if of.code == "factor-of-safety"]
    thickness = {
        of.subject: of.numbers["thickness"]
        for of in findings
        if of.numbers.get("factor", 2.0) > 1.0 and of.code in ("cover-rows", "cover-late", "weak-on-strong")
    }
    few = [(deep / min(fine), name) for name, deep in thickness.items() if fine]
    return "".join(
        f"; with {rows:.2g} rows of particles in {name} at most, which make it up to {factor_with(rows) - 1.0:.0%} too high"
        for rows, name in few
        if is_late(factor_with(rows))
    )


def _of_files(files: Sequence[str], named: bool) -> tuple[str, str]:
    """The same by the searches in some files; one of several slopes is ``named`` as its file is, or not."""
    searches = sorted((trajectory.read(file).attrs for file in files), key=lambda facts: float(facts["value"]))
    found = [search_words(facts) for facts in searches if not facts["reason"]]
    reasons = list(dict.fromkeys(search_words(facts)[0] for facts in searches if facts["reason"]))
    several = any(Path(file).stem not in SLOPE_LIMITS for file in files)  # of a study of several slopes, each named
    slope = re.sub("|".join(f"^{limit}_?" for limit in SLOPE_LIMITS), "", Path(files[0]).stem) if named and len(files) == 1 else ""
    one = " of the mean soil" if all(OF_MEAN in Path(file).stem for file in files) else f" of {slope or 'one slope'}"
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
    most the higher one where runs are ``missing``, which may fail at less.  Where some were made at a second spacing, too, a run counts as
    one that fails if it does so at both, and as one that stands if it is not known to fail at any.
    """
    if AMPLITUDE not in table:
        return "only one level of shaking was run"
    table = table[table["status"] != Status.FAILED_UNSHAKEN]
    if table.empty:
        return "no answer: every run fails without shaking"
    shaking, differ = table[AMPLITUDE].astype(float), differs(table)
    stands = (table["collapse_class"] == STABLE) & ~differ  # a run that diverged is not known to stand
    fails = table["collapse_class"].isin(CLASSES[1:]) & ~differ
    both = fails & second_class(table).isin(CLASSES[1:])
    fails = both if both.any() or differ.any() else fails  # where none was repeated, or all of those diverged, one spacing is all there is
    below, gone = shaking[shaking < shaking[~stands].min()].max(), shaking[fails].min()
    of = " in the weakest case" if len(dimensions) > 1 else ""
    if math.isnan(gone) and differ.any():
        return f"not known: at {in_both(shaking[differ].min())} it depends on the spacing"
    if math.isnan(gone):
        return f"no failure found{' so far' * bool(missing)} up to {in_both(shaking.max())}: no run goes beyond the class {STABLE}"
    return f"at most {in_both(gone)}{of}" if missing or math.isnan(below) else f"between {in_both(below)} and {in_both(gone)}{of}"


def fails_below(table: pd.DataFrame, critical: float) -> bool:
    """Whether a slope fails in shaking weaker than a yield acceleration, m/s2, whatever the spacing."""
    if AMPLITUDE not in table:
        return False
    fails = table["collapse_class"].isin(CLASSES[1:]) & (table["status"] != Status.FAILED_UNSHAKEN) & ~differs(table)
    return bool((table.loc[fails, AMPLITUDE].astype(float) < critical).any())


def fails_in_weakest(table: pd.DataFrame) -> bool:
    """Whether a slope fails in the weakest shaking of a study of several, so that weaker shaking would tell more."""
    if AMPLITUDE not in table:
        return False
    weakest = table[table[AMPLITUDE] == min(table[AMPLITUDE], key=float)]
    return bool((weakest["collapse_class"].isin(CLASSES[1:]) & (weakest["status"] != Status.FAILED_UNSHAKEN)).any())


def when(table: pd.DataFrame, probe: str) -> list[tuple[str, str, str]]:
    """When the probe begins to move in those of some runs that fail, least to most, and when the first soil does; nothing where none
    fails."""
    failing = table[table["collapse_class"].isin(CLASSES[1:]) & (table["status"] != Status.FAILED_UNSHAKEN)]
    begins, first = (failing[name] - failing["shaking_start"] for name in ("onset_time", "first_failure_time"))
    if not begins.notna().any():
        return []
    level = f"at {in_both(float(table[AMPLITUDE].iloc[0]))}; " if AMPLITUDE in table else ""
    soil = f"the first soil reaches its strength after {_span(first.min(), first.max(), _seconds)} s"
    moves = f"{probe} begins to move {_span(begins.min(), begins.max(), _seconds)} s after the shaking begins"
    return [("When it fails", moves, level + soil)]


def _seconds(time: float) -> str:
    """A time of a run (s), to a hundredth or as less than that."""
    return f"{time:.2f}" if time >= 0.01 else "less than 0.01"


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


def runs_said(count: float) -> str:
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


def _span(low: float, high: float, words: Callable[[float], str]) -> str:
    return " to ".join(dict.fromkeys((words(low), words(high))))
