"""The preflight: what is found of a scene, or of all scenes of a study, before any run of them.

``sph.study.findings`` needs no run.  Here are the static questions (``sph.stability``): whether the slope stands unshaken at its peak
strength and at the strength that failed soil keeps, its factor of safety and its yield acceleration.  ``sph check --stability`` asks
them of a scene at two spacings and extrapolates; the first job of a study asks them at one, twice as coarse, which takes an
eighth of the time of the scene's own and makes slopes too strong by some per cent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.scene.schema import Scene
from sph.stability.extrapolation import RATIO, extrapolated, two_spacings
from sph.stability.safety import DEFAULT_RULE, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial
from sph.stability.standing import coarsest_spacing, divided_strength, stand, static_scene, weakened
from sph.storage.trajectory import Variable
from sph.study.cost import cost
from sph.study.findings import CODES, Finding, Severity, finding, findings, in_both
from sph.study.tables import count_column, read_csv, text_column, write_csv

EXTRAPOLATED_TOLERANCE, TOLERANCE = 0.01, 0.05
"""Relative width of the brackets in which searches end, where the extrapolation magnifies it and at one spacing."""
MARGIN = 1.1
"""Factor of safety below which the error of a search may hide that the slope does not stand."""
LONGEST = 60.0
"""Computing time on the reference machine after which no further slope or strength of a study is tested for standing, s."""
MOST_SCENES = 200
"""Most scenes of a study that are looked at, evenly through it."""
PREFLIGHT: tuple[Variable, ...] = (
    text_column("severity", f"how much it matters: {', '.join(Severity)}"),
    text_column("code", "what kind of finding it is"),
    count_column("runs", "how many of the runs looked at it concerns"),
    text_column("first_run", "the first of them; what was measured is of this one"),
    text_column("what", "the finding in words"),
    text_column("measured", "what was measured"),
    text_column("wanted", "what is wanted; empty for a note that asks for nothing"),
    text_column("key", "the key to change; empty where nothing need be"),
)
"""The columns of ``preflight.csv``."""

QUESTIONS: dict[str, tuple[str, Callable[..., Search], Callable[[float], str]]] = {
    "factor-of-safety": ("static factor of safety", factor_of_safety, "{:.2f}".format),
    "yield-acceleration": ("yield acceleration, pseudo-static", yield_acceleration, in_both),
}
"""Words, search and text of the limits, by the code of their finding."""


class Row(NamedTuple):
    """A finding of a study."""

    finding: Finding
    runs: int  # that it concerns
    first_run: str


def stability(scene: Scene) -> list[Finding]:
    """What static tests of a scene say; factor of safety and yield acceleration extrapolated from its spacing and twice that.

    Some thirty runs, of seconds to minutes each; two where the slope does not stand.  ValueError where the scene has no slope
    or is too coarse for the tests.
    """
    static = static_scene(scene, DEFAULT_RULE)
    peak = _at_peak(static)
    if not peak.stands:
        return [_of_peak(peak)]

    def limit(code: str) -> Finding:
        label, find, text = QUESTIONS[code]
        try:
            found = extrapolated(find, scene, two_spacings(scene, DEFAULT_RULE), EXTRAPOLATED_TOLERANCE, DEFAULT_RULE)
        except ValueError as error:
            return finding("stability-unknown", label, f"not found: {error}")
        return _of_limit(code, f"{text(found.value)}, give or take {text(found.error)}", found.value)

    return [_of_peak(peak), _of_residual(_at_residual(static), scene.coupling.S_R), *map(limit, QUESTIONS)]


def _at_peak(static: Scene) -> Trial:
    return stand(divided_strength(static, 1.0), DEFAULT_RULE, 1.0)


def _at_residual(static: Scene) -> Trial:
    return stand(weakened(static, static.coupling.S_R), DEFAULT_RULE, static.coupling.S_R)


def _of_peak(trial: Trial) -> Finding:
    if trial.stands:
        return finding("stands-unshaken", "the slope unshaken, at its peak strength", "stands")
    return finding(
        "fails-unshaken",
        "the slope does not stand unshaken, so that its failure is not that of an earthquake",
        f"fails at its peak strength, {trial.displaced_area:.3g} m2 displaced ({trial.status})",
        "to stand",
        "soil.cohesion and soil.friction_angle, or the geometry",
    )


def _of_residual(trial: Trial, strength_ratio: float) -> Finding:
    what = f"the slope unshaken, at its residual strength (S_R {strength_ratio:g})"
    if trial.stands:
        return finding("stands-at-residual", what, "stands: what fails comes to rest")
    return finding("fails-at-residual", what, "does not stand: soil that fails runs down until the slope is flatter")


def _of_limit(code: str, text: str, value: float) -> Finding:
    weak = code == "factor-of-safety" and value < MARGIN
    return finding(
        code,
        QUESTIONS[code][0],
        text,
        f"at least {MARGIN:g}, since the search has an error" if weak else "",
        "soil.cohesion and soil.friction_angle, or the geometry" if weak else "",
        Severity.WARNING if weak else None,
    )


def coarser(scene: Scene) -> Scene:
    """A scene at the spacing of a study's static tests: twice its own, or the coarsest that the failure rule allows."""
    own = scene.numerics.spacing
    spacing = max(min(RATIO * own, coarsest_spacing(scene, DEFAULT_RULE)), own)
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"spacing": spacing})})


def study_stability(scenes: Mapping[str, Scene], searches: Sequence[str], say: Callable[[str], None] = print) -> list[Row]:
    """What static tests of the scenes of a study say, by the names of its runs; ``searches`` of ``QUESTIONS`` are made of the first.

    Each slope is tested once at its peak strength, and at every residual strength of its runs, until that has taken ``LONGEST``.
    """
    runs: dict[tuple[str, str], list[str]] = {}
    statics: dict[str, Scene] = {}
    found: dict[Finding, list[str]] = {}
    for name, scene in scenes.items():
        try:
            static = static_scene(coarser(scene), DEFAULT_RULE)
        except ValueError as error:
            found.setdefault(finding("stability-unknown", "the stability of the slope", f"not tested: {error}"), []).append(name)
            continue
        statics[name] = static
        residual = weakened(static, static.coupling.S_R)
        peak = divided_strength(static, 1.0)
        same: dict[str, Any] = {"name": True, "title": True, "probes": True, "coupling": {"S_R"}}
        runs.setdefault((peak.model_dump_json(exclude=same), residual.model_dump_json(exclude=same)), []).append(name)
    peaks: dict[str, Trial] = {}
    spent, left = 0.0, list[str]()
    for (peak_key, _), names in runs.items():
        static = statics[names[0]]
        if spent > LONGEST:
            left += names
            continue
        one = cost(static).seconds
        if peak_key not in peaks:
            peaks[peak_key] = _at_peak(static)
            spent += one
            say(f"{names[0]}: {_of_peak(peaks[peak_key]).line()}")
        found.setdefault(_of_peak(peaks[peak_key]), []).extend(names)
        if peaks[peak_key].stands:
            residual_finding = _of_residual(_at_residual(static), static.coupling.S_R)
            spent += one
            say(f"{names[0]}: {residual_finding.line()}")
            found.setdefault(residual_finding, []).extend(names)
    if left:
        found[finding("stability-unknown", "the stability of further slopes of the study", "not tested, to save time")] = left
    first = next(iter(statics), None)
    base = peaks[next(iter(runs))[0]] if first else None
    if first and base and base.stands:
        for code in searches:
            label, find, text = QUESTIONS[code]
            known = {1.0: base} if code == "factor-of-safety" else {}
            scene = coarser(scenes[first])
            try:
                value = find(scene, TOLERANCE, known=known).value
                limit = _of_limit(code, f"{text(value)}, at a spacing of {scene.numerics.spacing:g} m to {TOLERANCE:.0%}", value)
            except ValueError as error:
                limit = finding("stability-unknown", label, f"not found: {error}")
            say(f"{first}: {limit.line()}")
            found.setdefault(limit, []).append(first)
    return [Row(each, len(names), names[0]) for each, names in found.items()]


def study_findings(scenes: Mapping[str, Scene]) -> list[Row]:
    """What is found of the scenes of a study without a run: each code and key once, in the words of the first run that has it."""
    found: dict[tuple[str, str], list[str]] = {}
    words: dict[tuple[str, str], Finding] = {}
    for name, scene in scenes.items():
        for each in findings(scene):
            words.setdefault((each.code, each.key), each)
            found.setdefault((each.code, each.key), []).append(name)
    return [Row(words[at], len(dict.fromkeys(names)), names[0]) for at, names in found.items()]


def write_preflight(path: Path | str, rows: Sequence[Row]) -> None:
    """Write ``preflight.csv``: errors first, then warnings and notes, in the order of ``CODES``."""
    grave, known = list(Severity), list(CODES)
    order = sorted(rows, key=lambda row: (grave.index(Severity(row.finding.severity)), known.index(row.finding.code)))
    lines = [row.finding._asdict() | {"runs": row.runs, "first_run": row.first_run} for row in order]
    write_csv(pd.DataFrame(lines, columns=[column.name for column in PREFLIGHT]), path)


def read_preflight(path: Path | str) -> list[Row]:
    """The rows of ``preflight.csv``; ValueError names a file that is none."""
    table = read_csv(path, PREFLIGHT, "the preflight")
    return [
        Row(Finding(*(str(row[name]) for name in Finding._fields)), int(row["runs"]), str(row["first_run"]))
        for row in table.to_dict("records")
    ]
