"""Newmark's rigid sliding block, integrated exactly.

Newmark, N. M. (1965), "Effects of earthquakes on dams and embankments", Geotechnique 15 (2), 139-160: a rigid block rests on
moving ground and slides as soon as the ground's acceleration a exceeds the yield acceleration a_y, until both move as one again,

    dv/dt = a(t) - a_y        while the block slides downslope (v > 0) or a > a_y,
    dv/dt = a(t) + a_y,up     while it slides upslope (v < 0) or a < -a_y,up,

with v the velocity of the block relative to the ground.

Signs: positive accelerations of the ground drive the block downslope, which is the positive direction of displacement and
velocity.  This is the sign of a scene's motion: its toe is on the left and the soil feels the body force -a, so a box that
accelerates to the right (a > 0) drives the soil to the left, towards the toe.

The acceleration is taken as linear between the samples, so velocity is quadratic and displacement cubic there, and starts and
ends of sliding are roots in closed form.  Nothing depends on a time step.
"""

# ASSUME: the ground accelerates parallel to the slip surface; its slope and strength are all in the yield acceleration, which
# does not change with displacement.

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike


class SlidingBlock(NamedTuple):
    """Motion of the block relative to the ground, positive downslope."""

    displacement: np.ndarray  # (n,) at the samples, m
    velocity: np.ndarray  # (n,) at the samples, m/s
    permanent: float  # displacement once the block has come to rest, m
    sliding_time: float  # total time in sliding, s


def sliding_block(
    time: ArrayLike, acceleration: ArrayLike, yield_acceleration: float, upslope_yield_acceleration: float | None = None
) -> SlidingBlock:
    """Slide a rigid block, from rest, on ground with an acceleration (n,) in m/s2 at times (n,) in s; signs as above.

    The block slides downslope only; with ``upslope_yield_acceleration`` (m/s2) upslope as well.  After the record the ground
    does not accelerate: a block still sliding comes to rest over v^2 / (2 a_y) in v / a_y, which ``permanent`` and
    ``sliding_time`` include.

    Raises ValueError for times that do not increase, lengths that differ, numbers that are not finite, and yield accelerations
    that are not positive.
    """
    t, a = _checked(time, acceleration)
    down = _positive("yield_acceleration", yield_acceleration)
    up = math.inf if upslope_yield_acceleration is None else _positive("upslope_yield_acceleration", upslope_yield_acceleration)

    displacement, velocity = np.zeros(t.size), np.zeros(t.size)
    lengths = np.diff(t)
    exceeds = (np.maximum(a[:-1], a[1:]) > down) | (np.minimum(a[:-1], a[1:]) < -up)
    x = v = sliding_time = 0.0
    # Plain numbers instead of elements of arrays halve the time of 150,000 samples, to 0.13 s at most.
    intervals = zip(exceeds.tolist(), a[:-1].tolist(), (np.diff(a) / lengths).tolist(), lengths.tolist(), strict=True)
    for k, (may_start, start, slope, length) in enumerate(intervals, 1):
        if v != 0.0 or may_start:
            moved, v, slid = _slide(v, start, slope, length, down, up)
            x += moved
            sliding_time += slid
            velocity[k] = v
        displacement[k] = x
    resistance = down if v > 0.0 else -up
    return SlidingBlock(displacement, velocity, x + 0.5 * v * v / resistance, sliding_time + v / resistance)


def _slide(v: float, a: float, slope: float, length: float, down: float, up: float) -> tuple[float, float, float]:
    """Displacement (m), velocity at the end (m/s) and time in sliding (s) of an interval with linear acceleration.

    It begins with velocity v and acceleration a, which has a slope (m/s3) and lasts for a length (s).
    """
    x = slid = 0.0
    left = length
    while left > 0.0:
        if v == 0.0 and -up <= a <= down:  # at rest until the acceleration leaves the band
            bound = down if slope > 0.0 else -up
            wait = (bound - a) / slope if slope != 0.0 else math.inf
            if wait >= left:
                break
            left -= wait
            a = bound
            sign = math.copysign(1.0, slope)
        else:
            sign = math.copysign(1.0, v if v != 0.0 else a)
        # From here on seen in the direction of sliding.
        speed, net, rise = sign * v, sign * a - (down if sign > 0.0 else up), sign * slope
        stop = _time_to_rest(speed, net, rise)
        s = min(stop, left)
        x += sign * s * (speed + s * (net / 2 + s * rise / 6))
        v = 0.0 if stop <= left else sign * max(0.0, speed + s * (net + s * rise / 2))
        a += slope * s
        left -= s
        slid += s
    return x, v, slid


def _time_to_rest(speed: float, net: float, rise: float) -> float:
    """Smallest positive root s of speed + net s + rise s^2 / 2 = 0 (s), infinity without one; no cancellation."""
    discriminant = net * net - 2.0 * rise * speed
    if discriminant < 0.0 or (net >= 0.0 and rise >= 0.0):
        return math.inf
    if net > 0.0:
        return (net + math.sqrt(discriminant)) / -rise
    return 2.0 * speed / (math.sqrt(discriminant) - net)


def _checked(time: ArrayLike, acceleration: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    t, a = np.asarray(time, dtype=float), np.asarray(acceleration, dtype=float)
    if t.ndim != 1 or t.shape != a.shape or t.size < 2:
        raise ValueError(f"time: {t.shape} and acceleration: {a.shape}; both must be (n,) with the same n >= 2")
    for name, values in (("time", t), ("acceleration", a)):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise ValueError(f"{name}[{bad[0]}]: {values[bad[0]]} must be finite")
    still = np.flatnonzero(np.diff(t) <= 0)
    if still.size:
        raise ValueError(f"time[{still[0] + 1}]: {t[still[0] + 1]} s must be greater than {t[still[0]]} s before it")
    return t, a


def _positive(name: str, value: float) -> float:
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name}: {value} m/s2 must be positive and finite")
    return float(value)
