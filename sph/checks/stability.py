"""Findings of static tests of a scene: whether the slope stands unshaken, and its limits beside limit equilibrium.

It is tested at its peak strength and at the strength that failed soil keeps; limits are the factor of safety and the yield acceleration.
Both are searched at two spacings and extrapolated: at one, slopes come out too strong.
"""

from __future__ import annotations

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
from sph.solver.run import run
from sph.stability.extrapolation import extrapolated, two_spacings
from sph.stability.record import SAFETY, SEARCHES, YIELD
from sph.stability.safety import DEFAULT_RULE
from sph.stability.search import TOLERANCE, Search, Trial
from sph.stability.standing import divided_strength, judged, loses_strength, slope_height, stand, static_scene, weakened

QUESTIONS: dict[str, Callable[..., Search]] = {SEARCHES[limit].code: SEARCHES[limit].find for limit in (SAFETY, YIELD)}
"""Searches for the limits of a slope, by the code of their finding."""


def stability(scene: Scene) -> list[Finding]:
    """What static tests of a scene say; factor of safety and yield acceleration extrapolated from its spacing and twice that.

    Some thirty runs, of seconds to minutes each; two where the slope does not stand.  ValueError where the scene has no slope
    or is too coarse for the tests.
    """
    static = static_scene(scene, DEFAULT_RULE)
    peak = at_peak(scene)
    standing = of_standing(peak, scene, static, lambda: softening(scene))
    if not peak.trial.stands:
        return standing
    coarse: list[Finding] = []
    with suppress(ValueError):  # of spacings too close to each other, which the searches tell
        coarse = broken_at(scene, two_spacings(scene, DEFAULT_RULE))
    limits = [of_limit(code, scene) for code in QUESTIONS]
    return [*standing, *coarse, *limits, *equilibrium.of_equilibrium(scene, limits)]


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


def at_peak(scene: Scene) -> Peak:
    """The test of a slope at its peak strength.

    Whether it stands does not depend on the stiffness; which soil yields under gravity does, where soils differ in it.
    """
    tested = divided_strength(static_scene(scene, DEFAULT_RULE), 1.0)
    result = run(tested)
    trial = judged(result, tested, DEFAULT_RULE, 1.0)
    still = settled(scene)
    settled_run = Run(run(still).stored, still)
    count = int(np.count_nonzero(still.gravity.failed(settled_run["t_f"][settled_run.soil])))
    begun = any(np.isfinite(each["t_f"][each.soil]).any() for each in (Run(result.stored, tested), settled_run))
    used = mobilised_by_layer(settled_run, settled_run.gravity_frame) if trial.stands else {}
    spacing = tested.numerics.spacing
    return Peak(trial, spacing, count * spacing**2, still.fails_unshaken(count), begun, used)


def settled(scene: Scene) -> Scene:
    """The static test with the soil's own stiffness, until just after the gravity stage, from whose end on failure counts."""
    static = divided_strength(static_scene(scene, DEFAULT_RULE, own_stiffness=True), 1.0)
    return static.model_copy(update={"duration": static.gravity.duration + static.outputs.frame_interval})


def at_residual(static: Scene) -> Trial:
    """The test of a static scene at the strength that failed soil keeps."""
    return stand(weakened(static, static.coupling.S_R), DEFAULT_RULE, static.coupling.S_R)


def softening(scene: Scene) -> Trial:
    """The static test with the scene's loss of strength.

    With its own stiffness, which decides over what length slip develops, unless the soil is
    so soft that its elastic movement alone counts as failure."""

    def trial(softens: bool, own_stiffness: bool) -> Trial:
        return stand(static_scene(scene, DEFAULT_RULE, softens=softens, own_stiffness=own_stiffness), DEFAULT_RULE, 1.0)

    return trial(softens=True, own_stiffness=trial(softens=False, own_stiffness=True).stands)


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


def of_softening(peak: Peak, scene: Scene, softening: Callable[[], Trial]) -> list[Finding]:
    """An error where so much soil is at its strength under gravity that runs of the scene have the status ``failed_unshaken``, or where
    the slope fails unshaken as its soil softens.

    Without soil that fails at the peak strength none softens, and the test at that strength is the answer.
    """
    if not peak.begun or not any(map(loses_strength, scene.materials)):
        return []
    slip = "coupling.softening" if scene.coupling.softening is None else "coupling.softening.slip_at_peak"
    keys = (slip, "soil.cohesion", "soil.friction_angle")
    if peak.too_much:
        bound = FAILED_AREA * slope_height(scene) ** 2
        return [finding("softens-unshaken", *keys, value=peak.yielded, bound=bound, **_spacings(peak, scene))]
    trial = softening()
    if trial.stands:
        return []
    failed: dict[str, Any] = {"displaced_area": trial.displaced_area, "status": str(trial.status)}
    return [finding("fails-softened", *keys, **failed, **_spacings(peak, scene))]


def of_standing(peak: Peak, scene: Scene, static: Scene, softening: Callable[[], Trial]) -> list[Finding]:
    """What is found of a slope at its peak strength and, if it stands, as it softens and, by its ``static`` test, at residual strength."""
    if not peak.trial.stands:
        return [of_peak(peak, scene)]
    told = [of_peak(peak, scene), *of_mobilised(peak, scene), *of_softening(peak, scene, softening)]
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
