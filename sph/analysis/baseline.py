"""What a rigid sliding block does under a run's shaking: the baseline beside the simulated displacement."""

from __future__ import annotations

import math

from sph.analysis.tables import BASELINE
from sph.ground_motion import motion_of
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
