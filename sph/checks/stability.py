"""Findings of static tests of a scene: whether the slope stands unshaken, and its limits beside limit equilibrium.

It is tested at its peak strength and at the strength that failed soil keeps; limits are the factor of safety and the yield acceleration.
Both are searched at two spacings and extrapolated: at one, slopes come out too strong.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from sph.checks import equilibrium
from sph.checks.finding import Finding, called, finding
from sph.checks.layers import broken_at
from sph.checks.messages import NOTE
from sph.checks.soil import mobilised_strength
from sph.measures.mobilised import mobilised_by_layer
from sph.output.run import Run
from sph.scene.gravity import FAILED_AREA
from sph.scene.schema import Scene
from sph.scene.uncertain import STEEPEST
from sph.solver.run import run
from sph.stability.extrapolation import extrapolated, two_spacings
from sph.stability.record import SAFETY, SEARCHES, YIELD
from sph.stability.safety import DEFAULT_RULE
from sph.stability.search import TOLERANCE, Search, Trial, search
from sph.stability.standing import (
    divided_strength,
    judged,
    loses_strength,
    slope_height,
    stand,
    static_scene,
    weakened,
    with_strength,
)

QUESTIONS: dict[str, Callable[..., Search]] = {SEARCHES[limit].code: SEARCHES[limit].find for limit in (SAFETY, YIELD)}
"""Searches for the limits of a slope, by the code of their finding."""
TIMES = (2.0, 1.25, 1.0)
"""The peak strength, times which it is tried whether soil no longer softens under gravity: the most, the first, and that of the scene."""
WITHIN = 0.04
"""Relative width of the bracket in which that search ends."""


def stability(scene: Scene) -> list[Finding]:
    """What static tests of a scene say; factor of safety and yield acceleration extrapolated from its spacing and twice that.

    Some thirty runs, of seconds to minutes each; two where the slope does not stand.  ValueError where the scene has no slope
    or is too coarse for the tests.
    """
    found = standing(scene)
    if any(each.code == "fails-unshaken" for each in found):
        return found
    coarse: list[Finding] = []
    with suppress(ValueError):  # of spacings too close to each other, which the searches tell
        coarse = broken_at(scene, two_spacings(scene, DEFAULT_RULE))
    limits = [of_limit(code, scene) for code in QUESTIONS]
    return [*found, *coarse, *limits, *equilibrium.of_equilibrium(scene), *equilibrium.that_differ(scene, limits)]


def standing(scene: Scene) -> list[Finding]:
    """What the tests say that search for no limit: three to five runs, some ten to twenty where soil softens without shaking."""
    return of_standing(at_peak(scene), scene, static_scene(scene, DEFAULT_RULE), scene)


class Peak(NamedTuple):
    """The test of a slope at its peak strength."""

    trial: Trial
    spacing: float  # m
    yielded: float = 0.0
    """area of the soil that failed under gravity alone, m2"""
    too_much: bool = False
    """that area is one with which a run has the status ``failed_unshaken``"""
    begun: tuple[int, ...] = ()
    """numbers of the soils of which some has failed, at the end of the gravity stage or, where none has there, later; it may soften"""
    mobilised: Mapping[str, float] = {}
    """share of its peak strength that each layer uses at the end of the gravity stage"""


def at_peak(scene: Scene) -> Peak:
    """The test of a slope at its peak strength.

    Whether it stands does not depend on the stiffness; which soil yields under gravity does, where soils differ in it.
    """
    tested = divided_strength(static_scene(scene, DEFAULT_RULE), 1.0)
    result = run(tested)
    trial = judged(result, tested, DEFAULT_RULE, 1.0)
    still = settled(scene)
    settled_run, yielded = _of_gravity(still)
    begun = (soils for soils in (_soils(settled_run, yielded), *map(_failed_soils, (settled_run, Run(result.stored, tested)))) if soils)
    used = mobilised_by_layer(settled_run, settled_run.gravity_frame) if trial.stands else {}
    count, spacing = int(np.count_nonzero(yielded)), tested.numerics.spacing
    return Peak(trial, spacing, count * spacing**2, still.fails_unshaken(count), next(begun, ()), used)


def _of_gravity(still: Scene) -> tuple[Run, np.ndarray]:
    """The run of a ``settled`` scene, and which of its soil particles (n,) have failed under gravity alone."""
    found = Run(run(still).stored, still)
    return found, still.gravity.failed(found["t_f"][found.soil])


def _failed_soils(of: Run) -> tuple[int, ...]:
    return _soils(of, np.isfinite(of["t_f"][of.soil]))


def _soils(of: Run, among: np.ndarray) -> tuple[int, ...]:
    """Numbers of the soils of some of a run's soil particles (n,)."""
    return tuple(map(int, np.unique(of["layer"][of.soil][among])))


def settled(scene: Scene) -> Scene:
    """The static test with the soil's own stiffness, until just after the gravity stage, from whose end on failure counts."""
    static = divided_strength(static_scene(scene, DEFAULT_RULE, own_stiffness=True), 1.0)
    return static.model_copy(update={"duration": static.gravity.duration + static.outputs.frame_interval})


def at_residual(static: Scene) -> Trial:
    """The test of a static scene at the strength that failed soil keeps."""
    return stand(weakened(static, static.coupling.S_R), DEFAULT_RULE, static.coupling.S_R)


def softening_scene(scene: Scene) -> Scene:
    """The static test with the scene's loss of strength.

    With its own stiffness, which decides over what length slip develops, unless the soil is
    so soft that its elastic movement alone counts as failure."""
    own = stand(static_scene(scene, DEFAULT_RULE, own_stiffness=True), DEFAULT_RULE, 1.0).stands
    return static_scene(scene, DEFAULT_RULE, softens=True, own_stiffness=own)


def _softened(softens: Scene, value: float) -> Trial:
    return stand(softens, DEFAULT_RULE, value)


def _stays(still: Scene, value: float) -> Trial:
    """Whether a ``settled`` scene has too little failed soil to soften; ``value`` is what it tries."""
    found, yielded = _of_gravity(still)
    count = int(np.count_nonzero(yielded))
    area, wall_time = count * still.numerics.spacing**2, float(found.attrs["wall_time_s"])
    return Trial(value, not still.fails_unshaken(count), area, math.nan, str(found.status), wall_time)


def strengthened(scene: Scene, soils: Sequence[int], factor: float) -> Scene:
    """A scene with cohesion, its growth and tan(phi) of some soils, by their numbers, times a factor, as a scene file may say it.

    Cohesions are rounded up to three digits, friction angles to 0.1 degree, and these are ``STEEPEST`` at most.  Not validated.
    """

    def up(value: float) -> float:
        unit = 10.0 ** (math.floor(math.log10(value)) - 2) if value else 1.0
        return float(f"{math.ceil(value / unit - 1e-9) * unit:.3g}")

    for number in soils:
        soil = scene.soils[number]
        angle = math.degrees(math.atan(factor * math.tan(soil.friction_angle_si)))
        strength: dict[str, Any] = {"cohesion": up(factor * soil.cohesion)}
        strength["friction_angle"] = max(min(math.ceil(10.0 * angle - 1e-9) / 10.0, STEEPEST), soil.friction_angle)
        if soil.cohesion_growth is not None:
            strength["cohesion_growth"] = soil.cohesion_growth.model_copy(update={"gradient": up(factor * soil.gradient)})
        scene = with_strength(scene, number, **strength)
    return scene


def factor_needed(test: Scene, soils: Sequence[int], passes: Callable[[Scene, float], Trial], failed: float = 1.0) -> tuple[float, int]:
    """Times which peak strength of some soils a test is passed, to ``WITHIN``, that is not with it times ``failed``; and the tests made.

    NaN where ``TIMES`` of that do not do.
    """

    def trial(factor: float) -> Trial:
        return passes(strengthened(test, soils, failed * factor), failed * factor)

    known = Trial(TIMES[-1], False, math.nan, math.nan, "", 0.0)
    found = search(trial, TIMES, 1, WITHIN, known={TIMES[-1]: known})
    return failed * found.stood, sum(each is not known for each in found.trials)


def strength_needed(soils: Sequence[int], softens: Scene, still: Scene | None = None) -> dict[str, Any]:
    """With which peak strength of some soils a slope stands as it ``softens`` and, if given, ``still`` has too little failed soil: numbers
    of a finding by soil and property, or that ``TIMES`` does not do."""
    factor, made = 1.0, {"gravity_tests": 0, "static_tests": 0}
    if still is not None:
        factor, made["gravity_tests"] = factor_needed(still, soils, _stays)
        made["static_tests"] = 2  # with its own stiffness, and as it softens with this strength
    if still is None or (factor > 0.0 and not _softened(strengthened(softens, soils, factor), factor).stands):
        factor, tests = factor_needed(softens, soils, _softened, factor)
        made["static_tests"] += tests
    names = [softens.soil.name or "soil", *softens.layers]
    numbers: dict[str, Any] = made | {"soils": ", ".join(names[each] for each in soils)}
    if math.isnan(factor):
        return numbers | {"times": TIMES[0]}
    for number in soils:
        soil = strengthened(softens, soils, factor).soils[number]
        strength = {"cohesion": soil.cohesion_si, "gradient": 1e3 * soil.gradient, "friction_angle": soil.friction_angle_si}
        numbers |= {f"{names[number]}.{name}": value for name, value in strength.items() if value}
    return numbers


def _spacings(peak: Peak, scene: Scene) -> dict[str, Any]:
    return {"spacing": peak.spacing, "run_spacing": scene.numerics.spacing}


def of_peak(peak: Peak, scene: Scene) -> Finding:
    """Whether the slope stands at its peak strength."""
    if peak.trial.stands:
        return finding("stands-unshaken", **_spacings(peak, scene))
    failed: dict[str, Any] = {"displaced_area": peak.trial.displaced_area, "status": str(peak.trial.status)}
    return finding("fails-unshaken", "soil.cohesion", "soil.friction_angle", "geometry", **failed, **_spacings(peak, scene))


def of_mobilised(peak: Peak, scene: Scene) -> list[Finding]:
    """How much of its peak strength each layer uses before the shaking, the most first."""
    shares = sorted(peak.mobilised.items(), key=lambda pair: -pair[1])
    return called([mobilised_strength(name, share) for name, share in shares], scene.soil.name)


def of_softening(peak: Peak, scene: Scene, tested: Scene, seeks: bool = True) -> list[Finding]:
    """An error where so much soil is at its strength under gravity that runs of the scene have the status ``failed_unshaken``, or where
    the slope fails unshaken as its soil softens; if it ``seeks``, with the strength of the failed soils with which it does neither.

    Without soil that fails at the peak strength none softens, and the test at that strength is the answer.  ``tested`` is the scene at
    the spacing of the tests.
    """
    soils = peak.begun
    if not soils or not any(map(loses_strength, scene.materials)):
        return []
    slip = "coupling.softening" if scene.coupling.softening is None else "coupling.softening.slip_at_peak"
    keys = (slip, *(f"{scene.soil_keys[soil]}.{name}" for soil in soils for name in ("cohesion", "friction_angle")))
    spacings = _spacings(peak, scene)
    if peak.too_much:
        needed = strength_needed(soils, softening_scene(tested), settled(tested)) if seeks else {}
        bound = FAILED_AREA * slope_height(scene) ** 2
        return [finding("softens-unshaken", *keys, value=peak.yielded, bound=bound, **needed, **spacings)]
    softens = softening_scene(tested)
    trial = _softened(softens, 1.0)
    if trial.stands:
        return []
    needed = strength_needed(soils, softens) if seeks else {}
    return [finding("fails-softened", *keys, displaced_area=trial.displaced_area, status=str(trial.status), **needed, **spacings)]


def of_standing(peak: Peak, scene: Scene, static: Scene, tested: Scene, seeks: bool = True) -> list[Finding]:
    """What is found of a slope at its peak strength and, if it stands, as it softens and, by its ``static`` test, at residual strength;
    ``tested`` and ``seeks`` as in ``of_softening``."""
    if not peak.trial.stands:
        return [of_peak(peak, scene)]
    told = [of_peak(peak, scene), *of_mobilised(peak, scene), *of_softening(peak, scene, tested, seeks)]
    return [*told, of_residual(at_residual(static), static), *equilibrium.of_residual(scene)]


def of_residual(trial: Trial, scene: Scene) -> Finding:
    """Whether the slope stands at the strength that failed soil keeps."""
    return finding("stands-at-residual" if trial.stands else "fails-at-residual", **equilibrium.strength_ratios(scene))


def of_limit(code: str, scene: Scene, tolerance: float = TOLERANCE, spacings: Sequence[float] | None = None) -> Finding:
    """The limit that a search for one of ``QUESTIONS`` finds, by default at the scene's spacing and twice that; why where it finds none."""
    try:
        limit = extrapolated(QUESTIONS[code], scene, tolerance, asked=spacings)
    except ValueError as error:
        return finding("stability-unknown", subject=code, reason=str(error))
    (coarse, fine), fine_tests = limit.spacings, len(limit.searches[1].trials)
    how = {"coarse": coarse, "fine": fine, "coarse_tests": limit.runs - fine_tests, "fine_tests": fine_tests}
    made = finding(code, value=limit.value, error=limit.error, step_taken=limit.step_taken, subject="", **how)
    return made if made.severity == NOTE else replace(made, keys=("soil.cohesion", "soil.friction_angle", "geometry"))
