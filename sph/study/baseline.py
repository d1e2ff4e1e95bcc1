"""Response of a rigid sliding block to a run's shaking: the baseline for the simulated displacement and the critical amplitude."""

from __future__ import annotations

import math

import scipy  # type: ignore[import-untyped]

from sph.scene.loading import motion_of
from sph.scene.motion import ConstantAcceleration, reference_amplitude
from sph.scene.schema import Scene
from sph.stability.newmark import sliding_block
from sph.study.tables import BASELINE


def baseline_metrics(scene: Scene, yield_acceleration: float) -> dict[str, float]:
    """The columns ``BASELINE`` of a study's table for a run, from its scene and the yield acceleration (m/s2) of its slope.

    The slip is infinite for a slope that does not stand without shaking (yield acceleration 0), and under a load that stays and is larger;
    it is NaN where the yield acceleration is.
    """
    if math.isnan(yield_acceleration):
        slip = math.nan
    elif yield_acceleration == 0.0 or isinstance(scene.motion, ConstantAcceleration) and scene.motion.amplitude > yield_acceleration:
        slip = math.inf
    else:
        motion = motion_of(scene)
        slip = sliding_block(motion.time, motion.acceleration, yield_acceleration).permanent
    return dict(zip((row.name for row in BASELINE), (yield_acceleration, slip), strict=True))


def newmark_factor(scene: Scene, yield_acceleration: float, displacement: float) -> float:
    """Factor on the scene's motion with which the sliding block slips by a displacement (m), from its yield acceleration (m/s2).

    0 for a slope that does not stand without shaking, the yield acceleration over the load under one that stays, infinite for a motion that
    nowhere drives the block downslope, NaN where the yield acceleration or the displacement is; ValueError for a scene that is not shaken.
    """
    if not yield_acceleration > 0.0:
        return yield_acceleration
    if math.isnan(displacement):
        return math.nan
    if reference_amplitude(scene.motion) == 0.0:
        raise ValueError(f"motion: scene {scene.name} is not shaken, so there is nothing to scale")
    if isinstance(scene.motion, ConstantAcceleration):
        return yield_acceleration / scene.motion.amplitude
    motion = motion_of(scene)
    if not motion.acceleration.max() > 0.0:
        return math.inf

    def excess(factor: float) -> float:
        return sliding_block(motion.time, factor * motion.acceleration, yield_acceleration).permanent - displacement

    low = high = yield_acceleration / float(motion.acceleration.max())
    while excess(high) < 0.0:
        low, high = high, 2.0 * high
    return float(scipy.optimize.brentq(excess, low, high, xtol=1e-7)) if high > low else high
