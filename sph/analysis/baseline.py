"""What a rigid sliding block does under a run's shaking: the baseline beside the simulated displacement and the critical amplitude."""

from __future__ import annotations

import math

from scipy.optimize import brentq  # type: ignore[import-untyped]

from sph.analysis.tables import BASELINE
from sph.ground_motion import motion_of
from sph.motion import reference_amplitude
from sph.scene import Scene
from sph.stability.newmark import sliding_block


def baseline_metrics(scene: Scene, yield_acceleration: float) -> dict[str, float]:
    """The columns ``BASELINE`` of a study's table for a run, from its scene and the yield acceleration (m/s2) of its slope.

    The slip is infinite for a slope that does not stand without shaking (yield acceleration 0), NaN where the yield acceleration is.
    """
    if yield_acceleration > 0.0:
        motion = motion_of(scene)
        slip = sliding_block(motion.time, motion.acceleration, yield_acceleration).permanent
    else:
        slip = math.nan if math.isnan(yield_acceleration) else math.inf
    return dict(zip((row.name for row in BASELINE), (yield_acceleration, slip), strict=True))


def newmark_amplitude(scene: Scene, yield_acceleration: float, displacement: float) -> float:
    """Amplitude (m/s2) of the scene's motion at which the sliding block slips by a displacement (m), from its yield acceleration (m/s2).

    0 for a slope that does not stand without shaking, NaN where the yield acceleration is; ValueError for a scene that is not shaken.
    """
    if not yield_acceleration > 0.0:
        return yield_acceleration
    if reference_amplitude(scene.motion) == 0.0:
        raise ValueError(f"motion: scene {scene.name} is not shaken, there is nothing to scale")
    motion = motion_of(scene)
    shape = motion.acceleration / reference_amplitude(scene.motion)

    def excess(amplitude: float) -> float:
        return sliding_block(motion.time, amplitude * shape, yield_acceleration).permanent - displacement

    high = 2.0 * yield_acceleration
    while excess(high) < 0.0:
        high *= 2.0
    return float(brentq(excess, 0.5 * high, high, xtol=1e-6))
