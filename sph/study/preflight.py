"""The preflight: findings on a scene, or on all scenes of a study, before any of them is run.

``sph.checks.scene`` needs no run.  Here are the static questions (``sph.stability``): whether the slope stands unshaken at its peak
strength and at the strength that failed soil keeps, its factor of safety and its yield acceleration, each with its error, and what limit
equilibrium says of them (``sph.checks.equilibrium``).  Both are searched at two spacings and extrapolated: at one, slopes come out too
strong.  ``sph check --stability`` takes the scene's own spacing and twice that; the first job of a study takes coarser ones, which cost a
fraction of that and leave a larger error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sph.checks.equilibrium import of_equilibrium, of_residual
from sph.checks.finding import Finding, Severity, finding
from sph.checks.layers import broken_at, layers_of
from sph.checks.scene import findings
from sph.checks.soil import mobilised_strength
from sph.measures.mobilised import mobilised_by_layer
from sph.output.run import Run
from sph.scene.gravity import FAILED_AREA
from sph.scene.schema import Scene
from sph.solver.particles import place_particles
from sph.solver.run import run
from sph.stability.extrapolation import RATIO, Extrapolated, at_spacing, extrapolated, two_spacings, unasked_spacings
from sph.stability.safety import DEFAULT_RULE, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial
from sph.stability.standing import divided_strength, dividing, judged, slope_height, stand, static_scene, weakened
from sph.storage.trajectory import Variable
from sph.study.cost import cost
from sph.study.runs import SAFETY, YIELD
from sph.study.searches import TEXTS
from sph.study.tables import count_column, number_column, read_csv, text_column, write_csv

QUICK_TOLERANCE = 0.03
"""Relative width of the brackets in which the searches of a study end."""
QUICK_ROWS = 2
"""Rows of particles across the thinnest layer at the finer of these spacings, where the scene's own has as many."""
LONGEST = 60.0
"""Computing time on the reference machine after which no further slope or strength of a study is tested for standing, s."""
MOST_SCENES = 200
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
    text_column("key", "key to change; empty if nothing needs to be changed"),
    text_column("subject", "layer, variable or component that it concerns, where a scene may have several"),
    number_column(
        "off_by",
        "1",
        "distance between the measured and the required value over the larger of the two; 1 where it is not a matter of degree",
    ),
)
"""The columns of ``preflight.csv``."""

QUESTIONS: dict[str, tuple[str, Callable[..., Search], Callable[[float, float], str]]] = {
    "factor-of-safety": ("static factor of safety", factor_of_safety, TEXTS[SAFETY]),
    "yield-acceleration": ("yield acceleration, pseudo-static", yield_acceleration, TEXTS[YIELD]),
}
"""Words, search and text (of value and error) of the limits, by the code of their finding."""


class Row(NamedTuple):
    """A finding of a study."""

    finding: Finding
    runs: int  # that it concerns
    worst_run: str


def stability(scene: Scene) -> list[Finding]:
    """What static tests of a scene say; factor of safety and yield acceleration extrapolated from its spacing and twice that.

    Some thirty runs, of seconds to minutes each; two where the slope does not stand.  ValueError where the scene has no slope
    or is too coarse for the tests.
    """
    static = static_scene(scene, DEFAULT_RULE)
    peak = _at_peak(scene)
    if not peak.trial.stands:
        return [_of_peak(peak, scene)]

    factors = list[tuple[float, float]]()

    def limit(code: str) -> Finding:
        label, find, _ = QUESTIONS[code]
        try:
            search = extrapolated(find, scene)
            factors.extend([(search.value, search.error)] if code == "factor-of-safety" else [])
            return _of_limit(code, search)
        except ValueError as error:
            return finding("stability-unknown", label, f"not found: {error}")

    softened = _of_softening(peak, scene, lambda: _softening(scene))
    standing = [_of_peak(peak, scene), *_of_mobilised(peak), *softened, _of_residual(_at_residual(static), scene), *of_residual(scene)]
    coarse: list[Finding] = []
    with suppress(ValueError):  # of spacings too close to each other, which the searches tell
        coarse = broken_at(scene, two_spacings(scene, DEFAULT_RULE))
    limits = [limit(code) for code in QUESTIONS]
    return [*standing, *coarse, *limits, *of_equilibrium(scene, factors)]


class Peak(NamedTuple):
    """The test of a slope at its peak strength."""

    trial: Trial
    spacing: float  # m
    yielded: float = 0.0
    """area of the soil that failed under gravity alone, m2"""
    too_much: bool = False
    """that area is one with which a run has the status ``failed_unshaken``"""
    begun: bool = False
    """soil has failed, in the gravity stage or later, so that it may soften"""
    mobilised: Mapping[str, float] = {}
    """share of its peak strength that each layer uses at the end of the gravity stage"""


def _at_peak(scene: Scene) -> Peak:
    """Whether it stands does not depend on the stiffness; which soil yields under gravity does, where soils differ in it."""
    tested = divided_strength(static_scene(scene, DEFAULT_RULE), 1.0)
    result = run(tested)
    trial = judged(result, tested, DEFAULT_RULE, 1.0)
    settled = _settled(scene)
    settled_run = Run(run(settled).trajectory, settled)
    count = int(np.count_nonzero(settled.gravity.failed(settled_run["t_f"][settled_run.soil])))
    begun = any(np.isfinite(each["t_f"][each.soil]).any() for each in (Run(result.trajectory, tested), settled_run))
    used = mobilised_by_layer(settled_run, settled_run.gravity_frame) if trial.stands else {}
    spacing = tested.numerics.spacing
    return Peak(trial, spacing, count * spacing**2, settled.fails_unshaken(count), begun, used)


def _settled(scene: Scene) -> Scene:
    """The test with the soil's own stiffness, until just after the gravity stage, from whose end on failure counts."""
    static = divided_strength(static_scene(scene, DEFAULT_RULE, own_stiffness=True), 1.0)
    return static.model_copy(update={"duration": static.gravity.duration + static.outputs.frame_interval})


def _at_residual(static: Scene) -> Trial:
    return stand(weakened(static, static.coupling.S_R), DEFAULT_RULE, static.coupling.S_R)


def _softening(scene: Scene) -> Trial:
    """The test with the scene's loss of strength; with its own stiffness, which decides over what length slip develops, unless the soil is
    so soft that its elastic movement alone counts as failure."""

    def trial(softens: bool, own_stiffness: bool) -> Trial:
        return stand(static_scene(scene, DEFAULT_RULE, softens=softens, own_stiffness=own_stiffness), DEFAULT_RULE, 1.0)

    return trial(softens=True, own_stiffness=trial(softens=False, own_stiffness=True).stands)


def _at(spacing: float, scene: Scene) -> str:
    """The spacing of a test in words, with that of the runs where it is another."""
    own = scene.numerics.spacing
    return f"at a spacing of {spacing:.3g} m" + ("" if math.isclose(spacing, own, rel_tol=1e-6) else f", where the runs have {own:.3g} m")


def _of_peak(peak: Peak, scene: Scene) -> Finding:
    if peak.trial.stands:
        return finding("stands-unshaken", "the slope without shaking, at peak strength", f"stands {_at(peak.spacing, scene)}")
    return finding(
        "fails-unshaken",
        "the slope does not stand without shaking, so its failure is not due to the earthquake",
        f"fails at its peak strength, {peak.trial.displaced_area:.3g} m2 displaced ({peak.trial.status}) {_at(peak.spacing, scene)}",
        "to stand",
        "soil.cohesion and soil.friction_angle, or the geometry",
    )


def _of_mobilised(peak: Peak) -> list[Finding]:
    """How much of its peak strength each layer uses before the shaking, the most first."""
    shares = sorted(peak.mobilised.items(), key=lambda pair: -pair[1])
    return [mobilised_strength(name, share, "before the shaking") for name, share in shares]


def _of_softening(peak: Peak, scene: Scene, softening: Callable[[], Trial]) -> list[Finding]:
    """An error where so much soil is at its strength under gravity that runs of the scene have the status ``failed_unshaken``, or where
    the slope fails unshaken as its soil softens.

    Without soil that fails at the peak strength none softens, and the test at that strength is the answer.
    """
    softens = scene.coupling.gamma > 0 or scene.coupling.softens_by_slip or any(layer.gamma for layer in scene.layers.values())
    what = "soil is at its strength under gravity alone and softens before the shaking, so the result is not due to an earthquake"
    key = f"coupling.softening{'' if scene.coupling.softening is None else '.slip_at_peak'}, or soil.cohesion and soil.friction_angle"
    if not softens or not peak.begun:
        return []
    if peak.too_much:
        wanted = f"at most {FAILED_AREA:g} H2 = {FAILED_AREA * slope_height(scene) ** 2:.3g} m2"
        return [finding("softens-unshaken", what, f"{peak.yielded:.3g} m2 {_at(peak.spacing, scene)}", wanted, key)]
    trial = softening()
    if trial.stands:
        return []
    measured = f"{trial.displaced_area:.3g} m2 displaced ({trial.status}) as it softens, {_at(peak.spacing, scene)}"
    what = "without shaking the slope fails as its soil softens, so the result is not due to the earthquake alone"
    return [finding("fails-softened", what, measured, "to stand", key)]


def _of_residual(trial: Trial, scene: Scene) -> Finding:
    own = "".join(f", {name} {layer.S_R:g}" for name, layer in scene.layers.items() if layer.S_R is not None)
    what = f"the slope without shaking, at residual strength (S_R {scene.coupling.S_R:g}{own})"
    if trial.stands:
        return finding("stands-at-residual", what, "stands: soil that fails comes to rest")
    return finding("fails-at-residual", what, "does not stand: soil that fails flows until the slope is flatter")


def _of_limit(code: str, found: Extrapolated) -> Finding:
    label, _, text = QUESTIONS[code]
    weak = code == "factor-of-safety" and found.value - found.error < 1.0
    return finding(
        code,
        label,
        f"{text(found.value, found.error)}, {found.how}",
        "above 1 by more than its error" if weak else "",
        "soil.cohesion and soil.friction_angle, or the geometry" if weak else "",
        Severity.WARNING if weak else None,
    )


def quick_spacings(scene: Scene) -> tuple[float, float]:
    """Coarse and fine spacing (m) of a study's static tests: twice the scene's own and up to twice that.

    The failure rule limits the coarse one; the fine one is then at most two thirds of it, and half of the thinnest layer but no finer
    than the scene's own.  Both divide the slope's height.
    """
    own = scene.numerics.spacing
    coarse, fine = unasked_spacings(scene, RATIO * own, DEFAULT_RULE)
    thinnest = min(layer.thickness for layer in layers_of(scene, place_particles(scene)) if layer.particles) * own
    return coarse, min(fine, dividing(max(own, thinnest / QUICK_ROWS), slope_height(scene)))


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
    found = Slopes({}, {}, {}, {})
    for name, scene in scenes.items():
        try:
            quick = standing_scene(scene)
            static = static_scene(quick, DEFAULT_RULE)
        except ValueError as error:
            found.untested.setdefault(finding("stability-unknown", "the stability of the slope", f"not tested: {error}"), []).append(name)
            continue
        found.statics[name], found.quick[name] = static, quick
        residual = weakened(static, static.coupling.S_R)
        at_peak = divided_strength(static_scene(quick, DEFAULT_RULE, own_stiffness=True), 1.0)
        same: dict[str, Any] = {"name": True, "title": True, "probes": True, "coupling": {"S_R"}}
        found.runs.setdefault((at_peak.model_dump_json(exclude=same), residual.model_dump_json(exclude=same)), []).append(name)
    return found


def preflight_searches(elsewhere: bool) -> tuple[str, ...]:
    """Limits that the preflight of a study searches: not the yield acceleration where it is searched elsewhere, for the sliding block."""
    return tuple(code for code in QUESTIONS if not (elsewhere and code == "yield-acceleration"))


def preflight_seconds(scenes: Mapping[str, Scene], searches: Sequence[str] = tuple(QUESTIONS)) -> float:
    """Computing time on the reference machine of ``study_stability``, s; where all slopes stand."""
    runs, statics, quick, _ = _slopes(scenes)
    spent, slopes = 0.0, dict[str, float]()
    for (peak_key, _), names in runs.items():
        if spent <= LONGEST:
            first = peak_key not in slopes
            spent += cost(statics[names[0]]).seconds * (1 + first) + first * cost(_settled(quick[names[0]])).seconds
            coarse, fine = (len(searches) * trials for trials in QUICK_TRIALS)
            sensitivity = QUICK_SENSITIVITY * ("yield-acceleration" in searches)
            slopes.setdefault(peak_key, search_seconds(scenes[names[0]], (coarse + sensitivity, fine)))
    for number, one in enumerate(slopes.values()):
        if number == 0 or spent <= LONGEST:
            spent += one
    return spent


def search_seconds(scene: Scene, trials: Sequence[int]) -> float:
    """Computing time on the reference machine of numbers of static tests of a scene at the ``quick_spacings``, s."""
    return sum(
        number * cost(static_scene(at_spacing(scene, spacing), DEFAULT_RULE)).seconds
        for number, spacing in zip(trials, quick_spacings(scene), strict=True)
    )


def study_stability(
    scenes: Mapping[str, Scene], say: Callable[[str], None] = print, searches: Sequence[str] = tuple(QUESTIONS)
) -> list[Row]:
    """What static tests of the scenes of a study say, by the names of its runs; ``searches`` of ``QUESTIONS`` are made of its slopes.

    Each slope is tested once at its peak strength, and at every residual strength of its runs, until that has taken ``LONGEST``; then the
    limits of the first slope are searched, and of the others until all has taken that long.
    """
    runs, statics, quick, found = _slopes(scenes)
    peaks: dict[str, Peak] = {}
    slopes: dict[str, list[str]] = {}
    spent, left = 0.0, list[str]()
    for (peak_key, _), names in runs.items():
        static = statics[names[0]]
        if spent > LONGEST:
            left += names
            continue
        one, settled = cost(static).seconds, cost(_settled(quick[names[0]])).seconds
        slopes.setdefault(peak_key, []).extend(names)
        if peak_key not in peaks:
            peaks[peak_key] = _at_peak(quick[names[0]])
            spent += one + settled
        peak = peaks[peak_key]
        scene = scenes[names[0]]
        told = [_of_peak(peak, scene)]
        if peak.trial.stands:
            told += _of_mobilised(peak)
            told += _of_softening(peak, scene, lambda at=scene: _softening(standing_scene(at)))  # type: ignore[misc]
            told += [_of_residual(_at_residual(static), static), *of_residual(scene)]
            spent += one * (1 + 2 * (peak.begun and not peak.too_much))
        for each in told:
            if each not in found:
                say(f"{names[0]}: {each.line()}")
            found.setdefault(each, []).extend(names)
    if left:
        found[finding("stability-unknown", "the stability of further slopes of the study", "not tested, to save time")] = left
    unsearched = list[str]()
    for number, (peak_key, names) in enumerate(slopes.items()):
        scene = scenes[names[0]]
        if not peaks[peak_key].trial.stands or not searches:
            continue
        if number and spent > LONGEST:
            unsearched += names
            continue
        of_block = unasked_spacings(scene, scene.numerics.spacing, DEFAULT_RULE)
        for broken in broken_at(scene, [*quick_spacings(scene), *of_block]):
            say(f"{names[0]}: {broken.line()}")
            found.setdefault(broken, []).extend(names)
        factors = list[tuple[float, float]]()
        for code in searches:
            label, find, _ = QUESTIONS[code]
            try:
                search = extrapolated(find, scene, QUICK_TOLERANCE, asked=quick_spacings(scene))
                fine = len(search.searches[1].trials)
                limit, trials = _of_limit(code, search), (search.runs - fine, fine)
                factors += [(search.value, search.error)] if code == "factor-of-safety" else []
            except ValueError as error:
                limit, trials = finding("stability-unknown", label, f"not found: {error}"), QUICK_TRIALS
            spent += search_seconds(scene, trials)
            say(f"{names[0]}: {limit.line()}")
            found.setdefault(limit, []).extend(names)
        for each in of_equilibrium(scene, factors):
            say(f"{names[0]}: {each.line()}")
            found.setdefault(each, []).extend(names)
    if unsearched:
        how = "not searched, to save time; run sph fos or sph yield-acceleration on the scene or on the file of a run"
        found[finding("stability-unknown", "factor of safety and yield acceleration of further slopes of the study", how)] = unsearched
    return [Row(each, len(names), names[0]) for each, names in found.items()]


def study_findings(scenes: Mapping[str, Scene]) -> list[Row]:
    """Findings on the scenes of a study that need no run, the most harmful first.

    Each code, key and subject once, in the words of the run in which it is worst.
    """
    found: dict[tuple[str, str, str], dict[str, Finding]] = {}
    of_all = _of_own_ratios(list(scenes.values()))
    for name, scene in scenes.items():
        for each in findings(scene) + of_all:
            runs = found.setdefault((each.code, each.key, each.subject), {})
            runs[name] = min(runs.get(name, each), each, key=lambda one: one.rank)
    rows = []
    for runs in found.values():
        worst = min(runs, key=lambda name: runs[name].rank)
        rows.append(Row(runs[worst], len(runs), worst))
    return sorted(rows, key=lambda row: row.finding.rank)


def _of_own_ratios(scenes: Sequence[Scene]) -> list[Finding]:
    """A warning where the scenes differ in an S_R or gamma that does not reach layers with one of their own, and where they differ in an
    S_R that no soil feels, since residual strengths are written of all that it reaches."""
    found = []
    for key in ("S_R", "gamma"):
        kept = [name for name, layer in scenes[0].layers.items() if getattr(layer, key) is not None] if scenes else []
        if kept and len({getattr(scene.coupling, key) for scene in scenes}) > 1:
            measured = f"{', '.join(kept)} {'keeps its' if len(kept) == 1 else 'keep their'} own"
            wanted = f"varied too (a dimension layers.{kept[0]}.{key}), or left out of the layer"
            found.append(
                finding(
                    "own-strength-ratio",
                    f"the study varies {key}, which does not reach all layers",
                    measured,
                    wanted,
                    f"layers.{kept[0]}.{key}",
                )
            )
    own = [(None, *(layer.S_R for layer in scene.layers.values())) for scene in scenes]
    reached = [
        of.uses_S_R
        for scene, ratios in zip(scenes, own, strict=True)
        for of, ratio in zip(scene.materials, ratios, strict=True)
        if ratio is None
    ]
    if len({scene.coupling.S_R for scene in scenes}) > 1 and not any(reached):
        what = "the study varies S_R, which affects no soil: runs that differ only in it are identical"
        measured, wanted = "residual strengths are given", "a dimension soil.residual_friction_angle, or no residual strengths"
        found.append(finding("own-strength-ratio", what, measured, wanted, "soil.residual_cohesion and soil.residual_friction_angle"))
    return found


def write_preflight(path: Path | str, rows: Sequence[Row]) -> None:
    """Write ``preflight.csv``, the most harmful finding first."""
    order = sorted(rows, key=lambda row: row.finding.rank)
    lines = [row.finding._asdict() | {"runs": row.runs, "worst_run": row.worst_run} for row in order]
    write_csv(pd.DataFrame(lines, columns=[column.name for column in PREFLIGHT]), path)


def read_preflight(path: Path | str) -> list[Row]:
    """The rows of ``preflight.csv``; ValueError names a file that is not one."""
    table = read_csv(path, PREFLIGHT, "the preflight")
    return [
        Row(Finding(*(row[name] for name in Finding._fields)), int(row["runs"]), str(row["worst_run"])) for row in table.to_dict("records")
    ]
