"""Whether what a run tells is final: how much of its debris still moves at its end, and for how long it would.

Debris is soil that has moved more than ``moved_threshold``, or moves.  A particle moves that is faster than ``moving_speed`` and than
``RATE`` of its displacement a second: what comes still is then more than a hundredth of what is told of it.  A run is at rest once no more
than ``SHARE`` of its debris moves, and its probe does not: a few particles that roll on are no debris, as a row of particles is no depth.
Of a failure that has just begun, or of none, the debris counts as ``FAILED_AREA`` of H^2 at least, the least soil that is a failure.

Of 38 runs, of the paper's slope at 1.67 m and of ``slope_on_rock`` at 0.5 to 2.5 m, 29 are at rest at their end.  From the first frame at
rest on, their run-out and displacement of A changed by less than 0.02 of a spacing, or of a fiftieth of them where that is more.  Soil that
still loses strength with time (gamma of 1 1/s) can stand and go on later, which this does not see.  One to two seconds before
it is at rest a slide went on for 0.7 to 2.5 times the time that is told here, earlier for 0.1 to 1.3 times.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.measures.mobilised import height_of
from sph.output.run import ProbeHistory, Run
from sph.scene.gravity import FAILED_AREA

SHARE = 0.01
"""Share of the debris, by its area, that may move in a run at rest."""
RATE = 0.01
"""Share of its displacement that a particle at rest passes in a second at most, 1/s."""
SLOWING = 1.0
"""Time at least over which the deceleration is taken that tells how long soil moves on, s."""


class Rest(NamedTuple):
    """How a run ends."""

    moving_share: float  # of the debris, by its area
    time_to_rest: float  # in which the motion ends if it slows down as in the last second, s; NaN if it does not slow down, 0 at rest

    @property
    def at_rest(self) -> bool:
        """Whether displacement of the probe, run-out and depths are final."""
        return self.time_to_rest == 0.0


def rest(run: Run, probe: ProbeHistory, moved: float, speed: float, window: float) -> Rest:
    """The end of a run by its last frame, with debris that has ``moved`` (m) and moves faster than ``speed`` (m/s), the ``probe`` by the
    distance between its places at the two ends of the ``window`` (s)."""
    last = len(run["time"]) - 1
    before = max(int(np.searchsorted(run["time"], run["time"][-1] - SLOWING, side="right")) - 1, min(run.gravity_frame, last))
    (share, excess), (_, earlier) = (_debris(run, frame, moved, speed) for frame in (last, before))
    now, then = (_probe(probe, probe.time[-1] - back, speed, window) for back in (0.0, SLOWING))
    times = [_left(excess, earlier, run["time"][last] - run["time"][before]), _left(now, then, SLOWING)]
    return Rest(share, float(np.max(times, initial=0.0)))  # NaN where one of them is


def _debris(run: Run, frame: int, moved: float, speed: float) -> tuple[float, float]:
    """The share of debris that moves in a frame, and how much faster than at rest all but ``SHARE`` of it at most are, m/s."""
    displacement = np.hypot(*run.displacement(frame))[run.soil]
    excess = np.hypot(*run.soil_at(frame, "velocity_x", "velocity_y")) - np.maximum(speed, RATE * displacement)
    least = FAILED_AREA * (height_of(run.scene) / run.scene.numerics.spacing) ** 2
    count = max(float(np.count_nonzero((displacement > moved) | (excess > 0.0))), least)
    allowed = min(math.floor(SHARE * count), excess.size - 1)
    return float(np.count_nonzero(excess > 0.0) / count), float(np.partition(excess, -1 - allowed)[-1 - allowed])


def _probe(probe: ProbeHistory, time: float, speed: float, window: float) -> float:
    """How much faster than at rest a probe is in the window that ends at a time (s), m/s."""
    ends = np.clip(np.searchsorted(probe.time, [time - window, time], side="right") - 1, 0, None)
    duration = max(float(np.diff(probe.time[ends])[0]), 1e-12)
    way = math.hypot(*(float(np.diff(along[ends])[0]) for along in (probe.displacement_horizontal, probe.displacement_vertical)))
    return way / duration - max(speed, RATE * float(probe.displacement_magnitude[ends[1]]))


def _left(now: float, before: float, time: float) -> float:
    """How long it takes until an excess speed is none, if it falls as within a time (s) before; NaN if it does not fall."""
    if now <= 0.0:
        return 0.0
    return now * time / (before - now) if before > now else math.nan
