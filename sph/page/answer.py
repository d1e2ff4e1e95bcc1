"""The first screen of the page: whether the slope stands, at which shaking it goes and how far, and what limits the trust in that."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import pandas as pd

from sph.experiments.cost_accuracy.advice import expected_sentence
from sph.experiments.trigger.critical import BRACKETED, read_critical
from sph.measures.metrics import CLASSES, STABLE
from sph.page.tables import MOST_VALUES, NOTHING, Table, metres
from sph.scene.schema import Scene
from sph.storage import trajectory
from sph.study.dimensions import Dimension, dimension
from sph.study.findings import in_both
from sph.study.preflight import read_preflight
from sph.study.tables import EXPECTED

FINDINGS = "{fidelity}/preflight.csv"
"""What was found in the scenes before their runs: errors and warnings are told."""
SAFETY = "{fidelity}/stages/factor_of_safety.nc"
"""The search for the factor of safety, where it was made."""
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
    safety_target: str,
) -> Answer:
    """The answer of a study from its table, the scene of a run and the files ``found`` for a pattern; ValueError names a damaged file.

    ``safety_target`` makes the factor of safety of a study of one slope.
    """
    unshaken, runs = int((table["failed_unshaken"] > 0).sum()), len(table)
    yields = table["yield_acceleration"].dropna().unique()
    yield_words = ("not searched", "sph yield-acceleration, for each slope of the study")
    if len(yields) == 1:
        yield_words = in_both(yields[0]).replace("m/s2", "m/s²"), "pseudo-static, at the spacing of the runs"
    facts = [
        ("Without shaking", "stands" if not unshaken else f"does not stand in {unshaken} of {runs} runs", ""),
        ("Factor of safety", *safety(found(SAFETY), found(FINDINGS), len(yields) == 1, safety_target)),
        ("Yield acceleration", *yield_words),
        ("Shaking at which it goes", searched(scene, found(CRITICAL)) or going(table, dimensions), ""),
    ]
    return Answer(facts, levels(table, dimensions, probe), _warnings(table, scene, found(FINDINGS)))


def safety(files: Sequence[str], findings: Sequence[str], one_slope: bool, target: str) -> tuple[str, str]:
    """The factor of safety of the study's slope, or how to have it."""
    for file in files:
        facts = trajectory.read(file).attrs
        if facts["reason"]:
            return "not found", str(facts["reason"])
        return f"{float(facts['value']):.2f}", "static, by reduced strength, at the spacing of the runs"
    for finding in (row.finding for file in findings for row in read_preflight(file)):
        if finding.code == "factor-of-safety" and one_slope:
            value, _, how = finding.measured.partition(", ")
            return value, f"static, a quick search before the runs, {how}; more closely: snakemake --cores 2 {target}"
    return "not searched", f"snakemake --cores 2 {target}" if one_slope else "sph fos, for each slope of the study"


def searched(scene: Scene, files: Sequence[str]) -> str:
    """The intensities of the shaking at which the slopes of a search begin to go, in words; nothing without a search that found one."""
    for file in files:
        rows = read_critical(file)
        first = rows[(rows["collapse_class"] == min(rows["collapse_class"], key=CLASSES.index)) & (rows["outcome"] == BRACKETED)]
        if len(first):
            intensity = dimension(first["intensity"].iloc[0], ["1"], scene)
            name, low, high = first["collapse_class"].iloc[0], first["critical_intensity"].min(), first["critical_intensity"].max()
            named = "" if intensity.name == AMPLITUDE else f"{intensity.symbol} "
            return f"{named}{_span(low, high, lambda value: f'{value:.3g}')} {intensity.shown_unit} (searched; class {name} or worse)"
    return ""


def going(table: pd.DataFrame, dimensions: Sequence[Dimension]) -> str:
    """The amplitudes between which the weakest of the slopes leaves the class 'stable', by the runs of the study."""
    if AMPLITUDE not in table:
        return "one shaking only"
    shaking = table[AMPLITUDE].astype(float)
    gone = shaking[table["collapse_class"].isin(CLASSES[1:])].min()
    below = shaking[shaking < shaking[table["collapse_class"] != STABLE].min()].max()  # a run that diverged is not known to stand
    of = " in the weakest case" if len(dimensions) > 1 else ""
    if math.isnan(gone):
        return f"not up to {shaking.max():g} m/s²: no run leaves the class {STABLE}"
    return f"at most {gone:g} m/s²{of}" if math.isnan(below) else f"between {below:g} and {gone:g} m/s²{of}"


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
        rows.append((value, " to ".join(dict.fromkeys((reached[0], reached[-1]))), *spans))
    head = ("shaking (m/s²)", "class", f"displacement of {probe} (m)", "run-out (m)", "Newmark block (m)")
    note = "Least to most over the other dimensions of the study." if len(table) > len(groups) else ""
    return Table("By the amplitude of shaking", head, rows, note)


def _span(low: float, high: float, words: Callable[[float], str]) -> str:
    return " to ".join(dict.fromkeys((words(low), words(high))))


def _warnings(table: pd.DataFrame, scene: Scene, files: Sequence[str]) -> list[str]:
    runs, found = len(table), list[str]()

    def say(count: Any, text: str) -> None:
        if count:
            found.append(f"{int(count)} of {runs} runs {text}")

    say(
        (table["failed_unshaken"] > 0).sum(),
        "fail under gravity alone: that slope does not stand without shaking, and its numbers are not the earthquake's alone.",
    )
    say(table["diverged"].sum(), "diverged: the guard stopped them, and they have no numbers.")
    say(((table["still_moving"] > 0) & (table["diverged"] == 0)).sum(), "still move at their end: displacement and run-out are not final.")
    for file in files:
        found += [f"{row.runs} of {runs} runs: {row.finding.sentence()}" for row in read_preflight(file) if row.finding.counts]
    same = len(table[[row.name for row in EXPECTED]].drop_duplicates()) == 1
    return [*found, f"Expected error: {expected_sentence(scene) if same else 'differs, see all runs'}."]
