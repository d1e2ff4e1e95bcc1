"""The first screen of the page: whether the slope stands, at which shaking it fails and how far, and what limits the trust in that."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.experiments.trade.advice import expected_sentence
from sph.experiments.trigger.critical import BRACKETED, read_critical
from sph.measures.metrics import CLASSES, ENERGY_LIMIT, STABLE
from sph.measures.sides import BACK
from sph.page.tables import AT_LEAST, MOST_VALUES, NOTHING, Table, metres
from sph.scene.schema import Scene
from sph.scene.units import beside_g, in_both
from sph.storage import trajectory
from sph.storage.trajectory import Status
from sph.study.after_run import is_bounded, is_open
from sph.study.dimensions import Dimension, dimension, shown_unit
from sph.study.equilibrium import weakest_words
from sph.study.finding import Finding, Severity
from sph.study.preflight import Row, read_preflight
from sph.study.searches import SAFETY, SLOPE_LIMITS, YIELD, found_words
from sph.study.tables import EXPECTED

FINDINGS = "{fidelity}/preflight.csv"
"""What was found in the scenes before their runs: errors and warnings are told."""
SEARCHES = "{fidelity}/stages/{limit}*.nc"
"""The searches for a limit of the slopes, where they were made."""
CRITICAL = "*/trigger/trigger.csv"
"""The search for the critical intensities, where it was made."""
AMPLITUDE = "amplitude"
"""The dimension of the shaking."""


class Answer(NamedTuple):
    """What the first screen says."""

    facts: list[tuple[str, str, str]]  # name, what is known of it, and how it can be known
    levels: Table
    warnings: list[str]


def answer(
    table: pd.DataFrame,
    dimensions: Sequence[Dimension],
    scene: Scene,
    probe: str,
    found: Callable[[str], Sequence[str]],
) -> Answer:
    """The answer of a study from its table, the scene of a run and the files ``found`` for a pattern; ValueError names a damaged file."""
    rows = [row for file in found(FINDINGS) for row in read_preflight(file)]
    findings = [row.finding for row in rows]
    factor, how = limit(findings, "factor-of-safety", found(_files(SAFETY)), "sph fos")
    by_slices = weakest_words(findings)
    facts = [
        ("Without shaking", *unshaken(table, rows)),
        ("Factor of safety", f"{factor} by particles; {by_slices}" if by_slices else factor, how),
        ("Yield acceleration", *limit(findings, "yield-acceleration", found(_files(YIELD)), "sph yield-acceleration")),
        ("Shaking at which it fails", searched(scene, found(CRITICAL)) or going(table, dimensions), ""),
    ]
    return Answer(
        [(name, _raised(words), _raised(how)) for name, words, how in facts],
        levels(table, dimensions, probe),
        list(map(_raised, _warnings(table, scene, probe, rows))),
    )


def _raised(words: str) -> str:
    return words.replace("m/s2", shown_unit("m/s2"))


def unshaken(table: pd.DataFrame, rows: Sequence[Row]) -> tuple[str, str]:
    """Whether the slopes stand without shaking by the static tests before the runs, and whether soil softened in the runs before it."""
    runs = len(table)
    fail = sum(row.runs for row in rows if row.finding.code == "fails-unshaken")
    soften = int((table["status"] == Status.FAILED_UNSHAKEN).sum())
    if fail:
        return f"does not stand in {fail} of {runs} runs", "by a static test"
    tested = any(row.finding.code == "stands-unshaken" for row in rows)
    narrow = sum(row.runs for row in rows if row.finding.code == "factor-of-safety" and row.finding.severity == Severity.WARNING)
    if soften:
        how = "its soil is at its strength under gravity, and loses it before the shaking"
        return f"fails in {soften} of {runs} runs", f"{how}; at its peak strength it stands" if tested else how
    if narrow:
        return (
            f"not certain in {narrow} of {runs} runs",
            "by a static test it stands, but its factor of safety is not above 1 by more than its error",
        )
    return ("stands", "by a static test") if tested else ("not tested", "sph check --stability")


def _files(limit: str) -> str:
    return SEARCHES.replace("{limit}", limit)


def limit(findings: Sequence[Finding], code: str, files: Sequence[str], closely: str) -> tuple[str, str]:
    """A limit with its error, least to most over the slopes, and how it was found: by the searches in ``files``, of which Newmark's blocks
    have theirs, or where there are none by the quick ones before the runs; ``closely`` is the command that searches more closely."""
    if files:
        return _of_files(files)
    found = sorted((each.measured.partition(", ") for each in findings if each.code == code), key=lambda parts: float(parts[0].split()[0]))
    if not found:
        return "not searched", closely
    (least, _, how), (most, *_) = found[0], found[-1]
    slopes = f" of {len(found)} slopes" if len(found) > 1 else ""
    return " to ".join(dict.fromkeys((least, most))), f"static, a quick search{slopes} before the runs, {how}; more closely: {closely}"


def _of_files(files: Sequence[str]) -> tuple[str, str]:
    searches = sorted((trajectory.read(file).attrs for file in files), key=lambda facts: float(facts["value"]))
    found = [found_words(facts) for facts in searches if not facts["reason"]]
    reasons = list(dict.fromkeys(found_words(facts)[0] for facts in searches if facts["reason"]))
    several = any(Path(file).stem not in SLOPE_LIMITS for file in files)  # of a study of several slopes, each named
    count = "" if not several else " of one slope" if len(found) == 1 else f" of {len(found)} slopes"
    words = [" to ".join(dict.fromkeys((found[0][0], found[-1][0]))) + count] if found else []
    return "; ".join(words + reasons), ", ".join(["static", *dict.fromkeys(how for _, how in found)])


def searched(scene: Scene, files: Sequence[str]) -> str:
    """The intensities of the shaking at which the slopes of a search begin to go, in words; nothing without a search that found one."""
    for file in files:
        rows = read_critical(file)
        first = rows[(rows["collapse_class"] == min(rows["collapse_class"], key=CLASSES.index)) & (rows["outcome"] == BRACKETED)]
        if len(first):
            intensity = dimension(first["intensity"].iloc[0], ["1"], scene)
            name, low, high = first["collapse_class"].iloc[0], first["critical_intensity"].min(), first["critical_intensity"].max()
            named = "" if intensity.name == AMPLITUDE else f"{intensity.symbol} "
            if intensity.unit == "m/s2":
                span = _span(low, high, in_both)
            else:
                span = f"{_span(low, high, '{:.3g}'.format)} {intensity.shown_unit}".rstrip()
            return f"{named}{span} (searched; class {name} or worse)"
    return ""


def going(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> str:
    """The amplitudes between which the weakest of the slopes leaves the class 'stable', by the runs whose soil does not fail before."""
    if AMPLITUDE not in table:
        return "one shaking only"
    table = table[table["status"] != Status.FAILED_UNSHAKEN]
    if table.empty:
        return "no answer: every run fails without shaking"
    shaking = table[AMPLITUDE].astype(float)
    gone = shaking[table["collapse_class"].isin(CLASSES[1:])].min()
    below = shaking[shaking < shaking[table["collapse_class"] != STABLE].min()].max()  # a run that diverged is not known to stand
    of = " in the weakest case" if len(dimensions) > 1 else ""
    if math.isnan(gone):
        return f"not up to {in_both(shaking.max())}: no run leaves the class {STABLE}"
    return f"at most {in_both(gone)}{of}" if math.isnan(below) else f"between {in_both(below)} and {in_both(gone)}{of}"


def levels(table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str) -> Table:
    """Class, displacement, run-out and the slip of the sliding block, least to most over the other dimensions: a row an amplitude."""
    written = list(dict.fromkeys(table[AMPLITUDE])) if AMPLITUDE in table else []
    groups = [(value, table[table[AMPLITUDE] == value]) for value in sorted(written, key=float)]
    if not 0 < len(groups) <= MOST_VALUES:
        groups = [("all" if groups else "of the scene", table)]
    rows = []
    for value, runs in groups:
        reached = [name for name in CLASSES if (runs["collapse_class"] == name).any()] or [NOTHING]
        lengths = [runs[name].dropna() for name in ("displacement_magnitude", "runout", "newmark_displacement")]
        spans = [_span(each.min(), each.max(), metres) if len(each) else NOTHING for each in lengths]
        if runs["reached_side"].map(is_bounded).any():
            spans[:2] = [AT_LEAST + span for span in spans[:2]]
        rows.append((beside_g(value), " to ".join(dict.fromkeys((reached[0], reached[-1]))), *spans))
    head = ("shaking (m/s²)", "class", f"displacement of {probe} (m)", "run-out (m)", "Newmark block (m)")
    notes = ["Least to most over the other dimensions of the study."] if len(table) > len(groups) else []
    if table["reached_side"].map(is_bounded).any():
        notes.append(f"{AT_LEAST.strip()}: in a run the debris met the box, and would have gone further.")
    if table["newmark_displacement"].notna().any():
        notes.append("The Newmark block has the yield acceleration above.")
    return Table("By the amplitude of shaking", head, rows, " ".join(notes))


def _span(low: float, high: float, words: Callable[[float], str]) -> str:
    return " to ".join(dict.fromkeys((words(low), words(high))))


def _warnings(table: pd.DataFrame, scene: Scene, probe: str, rows: Sequence[Row]) -> list[str]:
    runs, found = len(table), list[str]()

    def say(count: Any, text: str) -> None:
        if count:
            found.append(f"{int(count)} of {runs} runs {text}")

    say(
        (table["status"] == Status.FAILED_UNSHAKEN).sum(),
        "have soil that fails under gravity alone and softens before the shaking: their numbers are not the earthquake's alone.",
    )
    say(table["diverged"].sum(), "diverged: the guard stopped them, and they have no numbers.")
    say(((table["still_moving"] > 0) & (table["diverged"] == 0)).sum(), "still move at their end: displacement and run-out are not final.")
    say(
        table["reached_side"].map(is_bounded).sum(),
        "have debris that reached the end of the box or went over it: displacement and run-out are lower bounds; lengthen the apron.",
    )
    say(
        table["reached_side"].str.contains(BACK).sum(),
        "have failed soil at the end of the box behind the crest: the box bounds the failure; lengthen the crest.",
    )
    say(
        table["energy_error"].map(is_open).sum(),
        f"have made or lost more than {100.0 * ENERGY_LIMIT:g} % of their energy: their numbers are not to be trusted; take a smaller "
        "time step or spacing.",
    )
    say(
        (table["displacement_magnitude"] < scene.numerics.spacing).sum(),
        f"move {probe} by less than one particle spacing ({scene.numerics.spacing:g} m), of which the expected error says nothing.",
    )
    found += [f"{row.runs} of {runs} runs: {row.finding.sentence()}" for row in rows if row.finding.counts]
    same = len(table[[row.name for row in EXPECTED]].drop_duplicates()) == 1
    return [*found, f"Expected error: {expected_sentence(scene) if same else 'differs, see all runs'}."]
