"""Upper bound of a homogeneous slope's stability by limit analysis: a rigid body that turns on a logarithmic spiral.

Chen, W. F. (1975), "Limit Analysis and Soil Plasticity", Elsevier, chapter 9: soil above the spiral

    r = r_0 exp((theta - theta_0) tan(phi))

turns about its pole.  The work of its weight equals the energy dissipated along the spiral when

    gamma integral x dA = c r_0^2 (exp(2 (theta_h - theta_0) tan(phi)) - 1) / (2 tan(phi)),

with x the distance from the pole towards the crest and theta the angle below the horizontal, from theta_0 where the spiral meets the
crest to theta_h where it leaves at the toe or before it.  The least gamma H / c of all spirals is the stability number; without friction
the spiral is Taylor's (1937) circle.

An upper bound lies above the exact number of a soil with associated flow, for steep slopes by up to 1.5 %: for a vertical cut without
friction it is 3.83, and the exact number lies between 3.772 and 3.786 (Pastor, Thai and Francescato 2000).
"""

# ASSUME: the apron and the crest are level and long enough for the spiral.

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq, minimize  # type: ignore[import-untyped]

SMALLEST_FACTOR, LARGEST_FACTOR = 0.01, 100.0
"""Factors of safety between which the limit is sought."""
FLATTEST = 1e-3
"""Smallest height of a slope over r_0: below it the moment is a difference of large numbers."""


def stability_number(slope_angle: float, friction_angle: float, base_depth: float = math.inf) -> float:
    """gamma H / c at which a slope fails, from angles in degrees and the depth of a rigid base below the toe over H.

    The spiral ends at the toe or before it, and stays above the base.  ValueError for a slope that is not steeper than its
    friction angle, or not within 90 degrees, and for friction angles and depths below 0.
    """
    if not 0.0 <= friction_angle < slope_angle <= 90.0:
        raise ValueError(f"slope_angle: {slope_angle} degrees, must lie above friction_angle: {friction_angle} (0 or more) and within 90")
    if not base_depth >= 0.0:
        raise ValueError(f"base_depth: {base_depth} H, must be 0 or more")
    slope, phi = math.radians(slope_angle), math.radians(friction_angle)
    starts, turns, steps = np.radians(np.arange(-10.0, 90.0, 10.0)), np.radians(np.arange(10.0, 130.0, 10.0)), (0.0, 0.3)
    tried = [np.array([start, turn, step]) for start in starts for turn in turns for step in steps]
    values = [_number(spiral, slope, phi, base_depth) for spiral in tried]
    best = sorted(range(len(tried)), key=values.__getitem__)[:4]
    options = {"xatol": 1e-7, "fatol": 1e-10, "maxiter": 2000}

    def descend(spiral: np.ndarray) -> np.ndarray:
        found: np.ndarray = minimize(_number, spiral, (slope, phi, base_depth), method="Nelder-Mead", options=options).x
        return found

    # Twice, for a simplex that has shrunk beside a bound.
    return min(_number(descend(descend(tried[k])), slope, phi, base_depth) for k in best if math.isfinite(values[k]))


def limit_factor(
    slope_angle: float, height: float, unit_weight: float, cohesion: float, friction_angle: float, base_depth: float = math.inf
) -> float:
    """Factor of safety on c and tan(phi): H (m), gamma (N/m3), c (Pa), angles (degrees), depth of the base below the toe (m)."""

    def surplus(factor: float) -> float:
        phi = math.degrees(math.atan(math.tan(math.radians(friction_angle)) / factor))
        return _surplus(slope_angle, height, unit_weight, cohesion / factor, phi, base_depth)

    return float(brentq(surplus, SMALLEST_FACTOR, LARGEST_FACTOR, rtol=1e-6))


def limit_strength_ratio(
    slope_angle: float, height: float, unit_weight: float, cohesion: float, friction_angle: float, base_depth: float = math.inf
) -> float:
    """The S_R on c and phi at which the slope just stands; arguments as of ``limit_factor``."""

    def surplus(ratio: float) -> float:
        return _surplus(slope_angle, height, unit_weight, ratio * cohesion, ratio * friction_angle, base_depth)

    return float(brentq(surplus, 1.0 / LARGEST_FACTOR, 1.0 / SMALLEST_FACTOR, rtol=1e-6))


def _surplus(slope_angle: float, height: float, unit_weight: float, cohesion: float, phi: float, base_depth: float) -> float:
    """Cohesion over what the slope needs, less 1; a slope no steeper than its friction angle has all it needs."""
    if phi >= slope_angle:
        return math.inf
    return stability_number(slope_angle, phi, base_depth / height) * cohesion / (unit_weight * height) - 1.0


def _number(spiral: np.ndarray, slope: float, phi: float, base_depth: float) -> float:
    """gamma H / c of one spiral, infinite where there is none.

    It begins at an angle (rad), turns by an angle (rad) and ends a distance (H) before the toe.
    """
    start, turn, step = spiral.tolist()
    end, tangent = start + turn, math.tan(phi)
    if not (turn > 0.0 and end < math.pi and step >= 0.0):
        return math.inf
    radius = math.exp(turn * tangent)  # lengths over r_0, the pole at the origin, y upwards
    height = radius * math.sin(end) - math.sin(start)
    if height < FLATTEST:
        return math.inf
    head, foot = (math.cos(start), -math.sin(start)), (radius * math.cos(end), -radius * math.sin(end))
    toe = (foot[0] + step * height, foot[1])
    crest = (toe[0] + height / math.tan(slope), head[1])
    to_toe = math.atan2(-toe[1], toe[0]) - start
    if crest[0] > head[0] or math.hypot(*toe) > math.exp(to_toe * tangent) * (1 + 1e-9):
        return math.inf  # the spiral crosses the face
    lowest = 0.5 * math.pi + phi
    if end > lowest and math.exp((lowest - start) * tangent) * math.sin(lowest) + foot[1] > base_depth * height * (1 + 1e-9):
        return math.inf
    moment = _sector(start, end, tangent) - sum(_triangle(*side) for side in ((head, crest), (crest, toe), (toe, foot)))
    if moment <= 0.0:
        return math.inf
    dissipation = math.expm1(2.0 * turn * tangent) / (2.0 * tangent) if tangent > 0.0 else turn
    return height * dissipation / moment


def _sector(start: float, end: float, tangent: float) -> float:
    """Integral of x dA between pole and spiral, over r_0^3: that of r^3 cos(theta) / 3."""

    def antiderivative(angle: float) -> float:
        return math.exp(3.0 * (angle - start) * tangent) * (3.0 * tangent * math.cos(angle) + math.sin(angle))

    return (antiderivative(end) - antiderivative(start)) / (3.0 * (1.0 + 9.0 * tangent**2))


def _triangle(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Integral of x dA over the triangle of the pole and two points, positive for clockwise ones."""
    return (first[1] * second[0] - first[0] * second[1]) * (first[0] + second[0]) / 6.0
