"""Factor of safety, critical strength ratio and yield acceleration: three questions to one search."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene
from sph.stability.search import TOLERANCE, Search, Trial, around, search
from sph.stability.standing import FailureRule, divided_strength, slope_height, stand, static_scene, weakened
from sph.storage.trajectory import Status

GROWTH = 1.5
"""Ratio of neighbouring values while the bracket is sought."""
FACTORS = tuple(GROWTH**power for power in range(-7, 8))
"""Factors of safety, from 0.06 to 17, by which a bracket is sought."""
STRENGTH_RATIOS = tuple(GROWTH**-power for power in range(9))
"""Strength ratios, from 1 to 0.04."""
ACCELERATIONS = (0.0, *(0.1 * GRAVITY * GROWTH**power for power in range(11)))
"""Accelerations of the box, 0 and from 0.1 to 5.8 g, m/s2."""

Report = Callable[[Trial], None]
Known = Mapping[float, Trial]
DEFAULT_RULE = FailureRule()


def factor_of_safety(
    scene: Scene,
    tolerance: float = TOLERANCE,
    rule: FailureRule = DEFAULT_RULE,
    report: Report | None = None,
    known: Known | None = None,
    near: float | None = None,
) -> Search:
    """The factor by which cohesion and tan(phi) can be divided until the slope fails, to a relative tolerance.

    The search begins around ``near`` where that is given.  ValueError where the slope stands or fails at every factor tried, and where
    the bracket ends at a run that diverged before the slope failed.
    """
    static = static_scene(scene, rule)

    def test(factor: float) -> Trial:
        return stand(divided_strength(static, factor), rule, factor)

    limit = search(test, *around(FACTORS, near, FACTORS.index(1.0)), tolerance, report=report, known=known)
    _check_verdict(scene, rule, limit)
    if math.isnan(limit.failed):
        raise ValueError(f"{scene.name}: stands even at a factor of {limit.stood:.3g}; its strength does not govern its stability")
    if math.isnan(limit.stood):
        raise ValueError(f"{scene.name}: fails even at a factor of {limit.failed:.3g}; a slope of soil without strength cannot stand")
    return limit


def critical_strength_ratio(
    scene: Scene,
    tolerance: float = TOLERANCE,
    rule: FailureRule = DEFAULT_RULE,
    report: Report | None = None,
    known: Known | None = None,
    near: float | None = None,
) -> Search:
    """The paper's S_R, on cohesion and phi, at which the fully weakened slope just stands, to a relative tolerance.

    ValueError where the slope fails at full strength or stands at every ratio tried, and for a run that diverged as above.
    """
    static = static_scene(scene, rule)

    def test(ratio: float) -> Trial:
        return stand(weakened(static, ratio), rule, ratio)

    limit = search(test, *around(STRENGTH_RATIOS, near, 0), tolerance, report=report, known=known)
    _check_verdict(scene, rule, limit)
    if math.isnan(limit.failed):
        raise ValueError(f"{scene.name}: stands even with S_R {limit.stood:.3g}; its strength does not govern its stability")
    if math.isnan(limit.stood):
        but = " but for the layers with an S_R of their own" if any(layer.S_R is not None for layer in scene.layers.values()) else ""
        raise ValueError(f"{scene.name}: fails with S_R 1, at its full strength{but}")
    return limit


def yield_acceleration(
    scene: Scene,
    tolerance: float = TOLERANCE,
    rule: FailureRule = DEFAULT_RULE,
    report: Report | None = None,
    known: Known | None = None,
    near: float | None = None,
    stronger: float = 1.0,
) -> Search:
    """The constant horizontal acceleration of the box, towards the toe, at which the slope fails (pseudo-static), m/s2.

    The tolerance is relative, and below 0.1 g relative to that.  A slope that fails without the load has yield
    acceleration 0.  With ``stronger``, cohesion and tan(phi) are first multiplied by that.  ValueError where the slope stands at every
    acceleration tried, and for a run that diverged as above.
    """

    def test(acceleration: float) -> Trial:
        static = static_scene(scene, rule, acceleration)
        return stand(static if stronger == 1.0 else divided_strength(static, 1.0 / stronger), rule, acceleration)

    limit = search(test, *around(ACCELERATIONS, near, 0), tolerance, smallest=ACCELERATIONS[1], report=report, known=known)
    _check_verdict(scene, rule, limit)
    if math.isnan(limit.failed):
        raise ValueError(f"{scene.name}: stands even at {limit.stood / GRAVITY:.3g} g")
    return limit._replace(stood=0.0) if math.isnan(limit.stood) else limit


def _check_verdict(scene: Scene, rule: FailureRule, limit: Search) -> None:
    """Refuse a bracket that ends at a run which diverged before the slope had failed: a limit of the scheme, not of the slope."""
    for trial in limit.trials:
        if (
            trial.value == limit.failed
            and trial.status == Status.DIVERGED
            and not trial.displaced_area > rule.area * slope_height(scene) ** 2
        ):
            raise ValueError(
                f"{scene.name}: the test at {trial.value:.4g} diverged before the slope failed, and does not tell whether it stands; "
                "try another numerics.spacing, a wider box, or more artificial viscosity"
            )
