"""The preflight: findings on all scenes of a study.

Those that need no simulation come before any job.  Static tests (``sph.checks.stability``) and searches for limits of the slopes go beside
the runs, the tests first, so that an error stops a study early.  Both have coarser spacings than ``sph check --stability``, which cost a
fraction of that and leave a larger error.
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from sph.checks import equilibrium
from sph.checks.cover_rows import covers
from sph.checks.finding import Finding, finding
from sph.checks.layers import layers_of, unbroken
from sph.checks.messages import OR, Severity, line, record
from sph.checks.motion import other_direction
from sph.checks.scene import findings
from sph.checks.stability import QUESTIONS, Peak, at_peak, of_limit, of_standing, settled
from sph.scene.schema import Scene
from sph.scene.strict_json import parse_json, to_json
from sph.solver.particles import place_particles
from sph.stability.extrapolation import RATIO, UNASKED_RATIO, at_spacing, unasked_spacings
from sph.stability.record import SEARCHES, YIELD
from sph.stability.safety import DEFAULT_RULE
from sph.stability.standing import divided_strength, dividing, slope_height, static_scene, weakened
from sph.storage.trajectory import Variable
from sph.study.cost import cost
from sph.study.plan import Plan
from sph.study.runs import PlannedRun
from sph.study.tables import MAX_SLOPES, count_column, number_column, read_csv, text_column, write_csv

QUICK_TOLERANCE = 0.03
"""Relative width of the brackets in which the searches of a study end."""
DEARER = 3.0
"""Times as long as with the ``quick_spacings`` that a search may take where these do not resolve a layer."""
COVER_ROWS = 3
"""Rows of particles that weak soil on stronger ground needs at both spacings of a search: with fewer the factor of safety does not fall in
proportion to the spacing (2.3, 1.7 and 1.4 with 1.4, 2.1 and 2.6 rows where Spencer's is 1.09), and extrapolates to anything."""
QUICK_ROWS = 2
"""Rows of particles across the thinnest layer at the finer of these spacings, where the scene's own has as many."""
LONGEST = 60.0
"""Computing time on the reference machine after which no further slope or strength of a study is tested for standing, s."""
MAX_SCENES = 200
"""Most scenes of a study that are looked at, evenly through it."""
OWN_SECONDS = 12.0
"""Computing time on the reference machine up to which a study tests whether a slope stands at the spacing of its runs, s."""
QUICK_TRIALS = (9, 6)
"""Static tests of a search to ``QUICK_TOLERANCE``, at the coarse and at the fine spacing (measured: 5 to 11 and 3 to 6)."""
QUICK_SENSITIVITY = 6
"""Static tests at the coarse spacing by which the sensitivity of the yield acceleration is found, to the same tolerance."""
PREFLIGHT: tuple[Variable, ...] = (
    text_column("severity", f"how much it matters: {', '.join(Severity)}"),
    text_column("code", "what kind of finding it is"),
    count_column("runs", "number of the checked runs that have it"),
    text_column("worst_run", "the run in which it is worst, the first if there are several; the measured value is from this run"),
    text_column("what", "the finding in words"),
    text_column("measured", "measured value"),
    text_column("wanted", "required value; empty for a note that asks for nothing"),
    text_column("key", "keys of which one is to change, with 'or' between them; empty if nothing needs to be changed"),
    text_column("subject", "layer, variable or component that it concerns, where a scene may have several"),
    number_column(
        "off_by",
        "1",
        "distance between the measured and the required value over the larger of the two; 1 where it is not a matter of degree",
    ),
    text_column("numbers", "its numbers by name, as JSON: in SI units, angles in radians, or the unit that the name says"),
)
"""The columns of ``preflight.csv``."""


class Row(NamedTuple):
    """A finding of a study."""

    finding: Finding
    runs: int  # that it concerns
    worst_run: str


def looked_at(plan: Plan) -> dict[str, PlannedRun]:
    """The runs of a study whose scenes are checked, by name."""
    return {name: plan.shared.runs[name] for name in plan.study.shown_runs(MAX_SCENES)}


def quick_spacings(scene: Scene) -> tuple[float, float]:
    """Coarse and fine spacing (m) of a study's static tests: twice the scene's own and up to twice that.

    The failure rule limits the coarse one; the fine one is then at most two thirds of it, and half of the thinnest layer but no finer
    than the scene's own.  Both divide the slope's height.
    """
    own = scene.numerics.spacing
    coarse, fine = unasked_spacings(scene, RATIO * own, DEFAULT_RULE)
    thinnest = min(layer.thickness for layer in layers_of(scene, place_particles(scene)) if layer.particles) * own
    return coarse, min(fine, dividing(max(own, thinnest / QUICK_ROWS), slope_height(scene)))


def search_spacings(scene: Scene) -> tuple[float, float]:
    """Those of a study's searches: the coarsest, no coarser than these, that break no layer which is whole in the scene and give weak soil
    on stronger ground ``COVER_ROWS`` rows.  ValueError where a search then takes more than ``DEARER`` times as long as with these."""
    quick = quick_spacings(scene)
    most = min((cover.thickness for cover in covers(scene) if not cover.seamed), default=math.inf) / COVER_ROWS
    coarse = unbroken(scene, min(quick[0], most))
    spacings = coarse, unbroken(scene, min(quick[1], coarse / UNASKED_RATIO))
    if spacings != quick and (times := _seconds(scene, QUICK_TRIALS, spacings) / _seconds(scene, QUICK_TRIALS, quick)) > DEARER:
        raise ValueError(
            f"numerics.spacing: a search that gives thin soil its rows of particles, with {spacings[0]:.3g} and {spacings[1]:.3g} m, takes "
            f"{times:.2g} times as long as one with {quick[0]:.3g} and {quick[1]:.3g} m; at most {DEARER:g} times are allowed"
        )
    return spacings


def standing_scene(scene: Scene) -> Scene:
    """A scene at the spacing at which a study tests whether its slopes stand: its own where a test takes at most ``OWN_SECONDS``, or else
    the fine one of ``quick_spacings``."""
    with suppress(ValueError):  # too coarse for a test
        if cost(static_scene(scene, DEFAULT_RULE)).seconds <= OWN_SECONDS:
            return scene
    return at_spacing(scene, quick_spacings(scene)[1])


class Slopes(NamedTuple):
    """The different static tests of a study."""

    runs: dict[tuple[str, str], list[str]]  # by the test at peak and at residual strength
    statics: dict[str, Scene]  # by run
    quick: dict[str, Scene]  # the scene at the spacing of these, by run
    untested: dict[Finding, list[str]]  # why runs have none


def _slopes(scenes: Mapping[str, Scene]) -> Slopes:
    slopes = Slopes({}, {}, {}, {})
    for name, scene in scenes.items():
        try:
            quick = standing_scene(scene)
            static = static_scene(quick, DEFAULT_RULE)
        except ValueError as error:
            slopes.untested.setdefault(finding("stability-unknown", subject="stability", reason=str(error)), []).append(name)
            continue
        slopes.statics[name], slopes.quick[name] = static, quick
        residual = weakened(static, static.coupling.S_R)
        at_peak = divided_strength(static_scene(quick, DEFAULT_RULE, own_stiffness=True), 1.0)
        same: dict[str, Any] = {"name": True, "title": True, "probes": True, "coupling": {"S_R"}}
        slopes.runs.setdefault((at_peak.model_dump_json(exclude=same), residual.model_dump_json(exclude=same)), []).append(name)
    return slopes


def preflight_searches(plan: Plan) -> tuple[str, ...] | None:
    """Limits that the preflight of a study searches, by its key ``searches``; None: its slopes are not tested either.

    Not the yield acceleration where it is searched elsewhere, for the sliding block.
    """
    asked = plan.study.searches
    quick = asked == "quick" or bool(plan.searches)
    return None if asked == "none" else tuple(code for code in QUESTIONS if not (quick and code == SEARCHES[YIELD].code))


def preflight_seconds(scenes: Mapping[str, Scene], searches: Sequence[str] | None = tuple(QUESTIONS)) -> tuple[float, float]:
    """Computing time on the reference machine of ``study_stability`` and of ``study_limits``, s, where all slopes stand; 0 without them."""
    if searches is None:
        return 0.0, 0.0
    runs, statics, quick, _ = _slopes(scenes)
    tests, limits, slopes = 0.0, 0.0, set[str]()
    coarse, fine = (len(searches) * trials for trials in QUICK_TRIALS)
    coarse += QUICK_SENSITIVITY * (SEARCHES[YIELD].code in searches)
    for (peak_key, _), names in runs.items():
        first = peak_key not in slopes
        if tests <= LONGEST:
            tests += cost(statics[names[0]]).seconds * (1 + first) + first * cost(settled(quick[names[0]])).seconds
        if first and limits <= LONGEST:
            limits += search_seconds(scenes[names[0]], (coarse, fine))
        slopes.add(peak_key)
    return tests, limits


@functools.lru_cache(maxsize=4)
def plan_seconds(plan: Plan) -> tuple[float, float]:
    """The same of the runs of a study that are checked."""
    checked = {name: plan.built(**plan.study.runs[name]) for name in plan.study.shown_runs(MAX_SCENES)}
    return preflight_seconds(checked, preflight_searches(plan))


def search_seconds(scene: Scene, trials: Sequence[float]) -> float:
    """Computing time on the reference machine of numbers of static tests of a scene at the ``search_spacings``, s; 0 without a search."""
    try:
        return _seconds(scene, trials, search_spacings(scene))
    except ValueError:
        return 0.0


def _seconds(scene: Scene, trials: Sequence[float], spacings: Sequence[float]) -> float:
    return sum(
        number * cost(static_scene(at_spacing(scene, spacing), DEFAULT_RULE)).seconds
        for number, spacing in zip(trials, spacings, strict=True)
    )


def study_stability(scenes: Mapping[str, Scene], say: Callable[[str], None] = print) -> list[Row]:
    """What static tests of the scenes of a study say, by the names of its runs.

    Each slope is tested once at its peak strength, and at every residual strength of its runs, until that has taken ``LONGEST``.  The
    strength with which one would not soften is sought until that has taken as long.
    """
    runs, statics, quick, by_finding = _slopes(scenes)
    peaks: dict[str, Peak] = {}
    spent, sought, left = 0.0, 0.0, list[str]()
    for (peak_key, _), names in runs.items():
        static = statics[names[0]]
        if spent > LONGEST:
            left += names
            continue
        one = cost(static).seconds
        if peak_key not in peaks:
            peaks[peak_key] = at_peak(quick[names[0]])
            spent += one + cost(settled(quick[names[0]])).seconds
        peak = peaks[peak_key]
        scene = scenes[names[0]]
        for each in of_standing(peak, scene, static, quick[names[0]], sought <= LONGEST):
            if each not in by_finding:
                say(f"{names[0]}: {line(each)}")
            by_finding.setdefault(each, []).extend(names)
            if tests := each.numbers.get("static_tests"):
                sought += tests * one + each.numbers["gravity_tests"] * cost(settled(quick[names[0]])).seconds
        spent += one * (1 + 2 * (bool(peak.begun) and not peak.too_much)) * peak.trial.stands
    if left:
        by_finding[finding("stability-unknown", subject="stability of further slopes")] = left
    return _rows(by_finding)


def study_equilibrium(scenes: Mapping[str, Scene], tested: Sequence[Row], say: Callable[[str], None] = print) -> list[Row]:
    """What limit equilibrium says of the slopes of a study that do not fall as ``tested`` by ``study_stability``, of the first
    ``MAX_SLOPES`` of them, and what a sliding block with its yield acceleration does in the motions of their runs."""
    by_finding: dict[Finding, list[str]] = {}
    for groups in _standing(scenes, tested)[:MAX_SLOPES]:
        names = [name for group in groups for name in group]
        told = equilibrium.of_equilibrium(scenes[names[0]])
        for each in told:
            say(f"{names[0]}: {line(each)}")
            by_finding.setdefault(each, []).extend(names)
        strength = next((each.numbers["critical"] for each in told if "critical" in each.numbers), 0.0)
        turned = other_direction({name: scenes[name] for name in names}, strength)
        for met in (turned, *(equilibrium.runs_away({name: scenes[name] for name in group}, strength) for group in groups)):
            if met:  # one finding, of the run in which it matters most
                worst, first = min(met.items(), key=lambda each: each[1].rank)
                say(f"{worst}: {line(first)}")
                by_finding.setdefault(first, []).extend([worst, *(name for name in met if name != worst)])
    return _rows(by_finding)


def study_limits(
    scenes: Mapping[str, Scene], tested: Sequence[Row], say: Callable[[str], None] = print, searches: Sequence[str] = tuple(QUESTIONS)
) -> list[Row]:
    """The limits of the slopes of a study that do not fall as ``tested`` by ``study_stability``, by ``searches`` of ``QUESTIONS``: of the
    first slope, and of others until that has taken ``LONGEST``; and which of them limit equilibrium contradicts."""
    by_finding: dict[Finding, list[str]] = {}
    spent, unsearched = 0.0, list[str]()
    for groups in _standing(scenes, tested) if searches else ():
        names = [name for group in groups for name in group]
        scene = scenes[names[0]]
        if spent > LONGEST:
            unsearched += names
            continue
        try:
            spacings = search_spacings(scene)
            limits = [of_limit(code, scene, QUICK_TOLERANCE, spacings) for code in searches]
        except ValueError as error:
            limits = [finding("stability-unknown", subject=code, reason=str(error)) for code in searches]
        for limit in limits:
            tests = (limit.numbers.get(name, most) for name, most in zip(("coarse_tests", "fine_tests"), QUICK_TRIALS, strict=True))
            spent += search_seconds(scene, list(tests))
        for each in (*limits, *equilibrium.that_differ(scene, [limit for limit in limits if "value" in limit.numbers])):
            say(f"{names[0]}: {line(each)}")
            by_finding.setdefault(each, []).extend(names)
    if unsearched:
        by_finding[finding("stability-unknown", subject="limits of further slopes")] = unsearched
    return _rows(by_finding)


def _standing(scenes: Mapping[str, Scene], tested: Sequence[Row]) -> list[list[list[str]]]:
    """The runs of each slope that does not fall as ``tested``, by residual strength."""
    slopes: dict[str, list[list[str]]] = {}
    for (peak_key, _), names in _slopes(scenes).runs.items():
        slopes.setdefault(peak_key, []).append(names)
    falling = {row.worst_run for row in tested if row.finding.code == "fails-unshaken"}
    return [groups for groups in slopes.values() if groups[0][0] not in falling]


def _rows(by_finding: Mapping[Finding, Sequence[str]]) -> list[Row]:
    return [Row(each, len(names), names[0]) for each, names in by_finding.items()]


def study_findings(scenes: Mapping[str, Scene]) -> list[Row]:
    """Findings on the scenes of a study that need no run, the most harmful first.

    Each code, key and subject once, in the words of the run in which it is worst.
    """
    by_kind: dict[tuple[str, tuple[str, ...], str], dict[str, Finding]] = {}
    of_all = _of_own_ratios(list(scenes.values()))
    for name, scene in scenes.items():
        for each in findings(scene) + of_all:
            runs = by_kind.setdefault((each.code, each.keys, each.subject), {})
            runs[name] = min(runs.get(name, each), each, key=lambda one: one.rank)
    rows = []
    for runs in by_kind.values():
        worst = min(runs, key=lambda name: runs[name].rank)
        rows.append(Row(runs[worst], len(runs), worst))
    return sorted(rows, key=lambda row: row.finding.rank)


def _of_own_ratios(scenes: Sequence[Scene]) -> list[Finding]:
    """A warning where the scenes differ in an S_R or gamma that does not reach layers with one of their own, and where they differ in an
    S_R that no soil feels, since residual strengths are written of all that it reaches."""
    warnings = []
    for key in ("S_R", "gamma"):
        kept = [name for name, layer in scenes[0].layers.items() if getattr(layer, key) is not None] if scenes else []
        if kept and len({getattr(scene.coupling, key) for scene in scenes}) > 1:
            warnings.append(finding("own-strength-ratio", f"layers.{kept[0]}.{key}", subject=key, layers=", ".join(kept)))
    own = [(None, *(layer.S_R for layer in scene.layers.values())) for scene in scenes]
    reached = [
        of.uses_S_R
        for scene, ratios in zip(scenes, own, strict=True)
        for of, ratio in zip(scene.materials, ratios, strict=True)
        if ratio is None
    ]
    if len({scene.coupling.S_R for scene in scenes}) > 1 and not any(reached):
        keys = ("soil.residual_cohesion", "soil.residual_friction_angle")
        warnings.append(finding("own-strength-ratio", *keys, subject="S_R", layers=""))
    return warnings


def tell(rows: Iterable[Row]) -> None:
    """Show what is more than a note where the study was started."""
    for row in rows:
        if row.finding.counts:
            print(f"{row.worst_run}: {line(row.finding)}", file=sys.stderr, flush=True)


def look_first(scenes: Mapping[str, Scene], stops: bool) -> None:
    """Tell what is found in the scenes of a study, by run, before any job of it; errors raise ValueError if it ``stops`` for them."""
    rows = study_findings(scenes)
    tell(rows)
    if stops:
        stop_for_errors(rows)


def stop_for_errors(rows: Iterable[Row]) -> None:
    """ValueError with the errors among findings and the remedies, if there are any."""
    errors = [row for row in rows if row.finding.severity == Severity.ERROR]
    if errors:
        told = [f"{row.worst_run}{f' and {row.runs - 1} more' if row.runs > 1 else ''}: {line(row.finding)}" for row in errors]
        raise ValueError(
            "\n".join(told) + "\nno further run is started, since results would not be those that you want: mend this, or write "
            "on_error: go_on in the study (--config on_error=go_on) to run it as it is; finished runs stay as they are"
        )


def write_preflight(path: Path | str, rows: Sequence[Row]) -> None:
    """Write ``preflight.csv``, or the part of it that is known before the searches, the most harmful finding first."""
    order = sorted(rows, key=lambda row: row.finding.rank)
    lines = [
        record(row.finding) | {"runs": row.runs, "worst_run": row.worst_run, "numbers": to_json(dict(row.finding.numbers))} for row in order
    ]
    write_csv(pd.DataFrame(lines, columns=[column.name for column in PREFLIGHT]), path)


def read_preflight(path: Path | str) -> list[Row]:
    """The rows of ``preflight.csv``; ValueError names a file that is not one."""
    table = read_csv(path, PREFLIGHT, "the preflight")
    return [
        Row(
            Finding(row["code"], tuple(filter(None, row["key"].split(OR))), row["subject"], parse_json(row["numbers"])),
            int(row["runs"]),
            str(row["worst_run"]),
        )
        for row in table.to_dict("records")
    ]
