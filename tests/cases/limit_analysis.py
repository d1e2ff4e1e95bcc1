"""Upper bound of a homogeneous slope's stability by limit analysis: rigid rotation along a logarithmic spiral; and infinite slopes.

Chen, W. F. (1975), "Limit Analysis and Soil Plasticity", Elsevier, chapter 9: soil above the spiral

    r = r_0 exp((theta - theta_0) tan(phi))

turns about its pole.  The work of its weight equals the energy dissipated along the spiral when

    gamma integral x dA = c r_0^2 (exp(2 (theta_h - theta_0) tan(phi)) - 1) / (2 tan(phi)),

with x the distance from the pole towards the crest and theta the angle below the horizontal, from theta_0 where the spiral meets the
crest to theta_h where it leaves at the toe or before it; spirals that leave on the face, which rock close below the toe makes the worst
without friction, are not tried.  The least gamma H / c of all spirals is the stability number; without friction
the spiral is Taylor's (1937) circle.

Water adds to the work (Michalowski 1995): that of the pore pressure u on the spiral, which opens by v sin(phi), and that of standing
water on the face.  Under water with one level in the slope and before it both together are the buoyancy of the soil below the level,

    gamma integral x dA - gamma_w integral x dA below the level;

with u = r_u gamma z, z the depth below the ground, gamma r_u tan(phi) integral z r^2 d(theta) is added to the work of the weight.

An upper bound lies above the exact number of a soil with associated flow, for steep slopes by up to 1.5 %: for a vertical cut without
friction it is 3.83, and the exact number lies between 3.772 and 3.786 (Pastor, Thai and Francescato 2000).
"""

# ASSUME: the apron and the crest are level and long enough for the spiral.

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

MIN_FACTOR, MAX_FACTOR = 0.01, 100.0
"""Factors of safety between which the limit is sought."""
FLATTEST = 1e-3
"""Smallest height of a slope over r_0: below it the moment is a difference of large numbers."""


POINTS = 201
"""Points of a spiral, and of the ground above it, between which the work of water is summed."""


class Wet(NamedTuple):
    """Water in a slope and before it."""

    weight: float = 0.0
    """unit weight of water over that of the soil"""
    level: float = 0.0
    """of the water above the toe, over H"""
    r_u: float = 0.0
    """pore pressure over the vertical stress of the soil above"""


DRY = Wet()


def stability_number(slope_angle: float, friction_angle: float, base_depth: float = math.inf, wet: Wet = DRY) -> float:
    """gamma H / c at which a slope fails, from angles in degrees and the depth of a rigid base below the toe over H.

    The spiral ends at the toe or before it, and stays above the base.  ValueError for a slope that is not steeper than its
    friction angle and has no r_u, or is not within 90 degrees, and for friction angles and depths below 0.
    """
    if not (0.0 <= friction_angle < 90.0 and 0.0 < slope_angle <= 90.0 and (friction_angle < slope_angle or wet.r_u > 0.0)):
        raise ValueError(f"slope_angle: {slope_angle} degrees, must lie above friction_angle: {friction_angle} (0 or more) and within 90")
    if not base_depth >= 0.0:
        raise ValueError(f"base_depth: {base_depth} H, must be 0 or more")
    slope, phi = math.radians(slope_angle), math.radians(friction_angle)
    starts, turns, steps = np.radians(np.arange(-10.0, 90.0, 10.0)), np.radians(np.arange(10.0, 130.0, 10.0)), (0.0, 0.3)
    tried = [np.array([start, turn, step]) for start in starts for turn in turns for step in steps]
    values = [_number(spiral, slope, phi, base_depth, wet) for spiral in tried]
    best = sorted(range(len(tried)), key=values.__getitem__)[:4]
    options = {"xatol": 1e-7, "fatol": 1e-10, "maxiter": 2000}

    def descend(spiral: np.ndarray) -> np.ndarray:
        found: np.ndarray = scipy.optimize.minimize(_number, spiral, (slope, phi, base_depth, wet), method="Nelder-Mead", options=options).x
        return found

    # Twice, for a simplex that has shrunk beside a bound.
    return min(
        (_number(descend(descend(tried[k])), slope, phi, base_depth, wet) for k in best if math.isfinite(values[k])), default=math.inf
    )


def limit_factor(
    slope_angle: float,
    height: float,
    unit_weight: float,
    cohesion: float,
    friction_angle: float,
    base_depth: float = math.inf,
    wet: Wet = DRY,
) -> float:
    """Factor of safety on c and tan(phi): H (m), gamma (N/m3), c (Pa), angles (degrees), depth of the base below the toe (m), water."""

    def surplus(factor: float) -> float:
        phi = math.degrees(math.atan(math.tan(math.radians(friction_angle)) / factor))
        return _surplus(slope_angle, height, unit_weight, cohesion / factor, phi, base_depth, wet)

    return float(scipy.optimize.brentq(surplus, MIN_FACTOR, MAX_FACTOR, rtol=1e-6))


def limit_strength_ratio(
    slope_angle: float,
    height: float,
    unit_weight: float,
    cohesion: float,
    friction_angle: float,
    base_depth: float = math.inf,
    wet: Wet = DRY,
) -> float:
    """The S_R on c and phi at which the slope just stands; arguments as of ``limit_factor``."""

    def surplus(ratio: float) -> float:
        return _surplus(slope_angle, height, unit_weight, ratio * cohesion, ratio * friction_angle, base_depth, wet)

    return float(scipy.optimize.brentq(surplus, 1.0 / MAX_FACTOR, 1.0 / MIN_FACTOR, rtol=1e-6))


def infinite_slope_factor(
    inclination: float,
    depth: float,
    unit_weight: float,
    cohesion: float,
    friction_angle: float,
    dilation_angle: float,
    r_u: float = 0.0,
) -> float:
    """Factor of safety of an infinite slope on a rough base at a depth (m) normal to it; closed form, arguments as of ``limit_factor``.

    Along the base the soil resists with c_s + sigma tan(phi_s), where (Davis 1968)

        tan(phi_s) = eta tan(phi),  c_s = eta c,  eta = cos(psi) cos(phi) / (1 - sin(psi) sin(phi)):

    soil that shears without dilation has its principal stresses at 45 degrees to the base.  sigma is less by a pore pressure of r_u times
    the weight above the base (Duncan and Wright 2005).
    """
    slope, tangent, dilation = math.radians(inclination), math.tan(math.radians(friction_angle)), math.tan(math.radians(dilation_angle))

    def surplus(factor: float) -> float:
        phi, psi = math.atan(tangent / factor), math.atan(dilation / factor)
        eta = math.cos(psi) * math.cos(phi) / (1.0 - math.sin(psi) * math.sin(phi))
        held = cohesion / factor + unit_weight * depth * (math.cos(slope) - r_u / math.cos(slope)) * math.tan(phi)
        return eta * held - unit_weight * depth * math.sin(slope)

    return float(scipy.optimize.brentq(surplus, MIN_FACTOR, MAX_FACTOR, rtol=1e-6))


def _surplus(slope_angle: float, height: float, unit_weight: float, cohesion: float, phi: float, base_depth: float, wet: Wet) -> float:
    """Cohesion over what the slope needs, less 1; a slope no steeper than its friction angle needs none, unless its water has an r_u."""
    if phi >= slope_angle and wet.r_u == 0.0:
        return math.inf
    return stability_number(slope_angle, phi, base_depth / height, wet) * cohesion / (unit_weight * height) - 1.0


def _number(spiral: np.ndarray, slope: float, phi: float, base_depth: float, wet: Wet) -> float:
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
    if wet != DRY:
        moment += _work_of_water(np.linspace(start, end, POINTS), tangent, (head, crest, toe, foot), height, wet)
    if moment <= 0.0:
        return math.inf
    dissipation = math.expm1(2.0 * turn * tangent) / (2.0 * tangent) if tangent > 0.0 else turn
    return height * dissipation / moment


def _work_of_water(angle: np.ndarray, tangent: float, ground: Sequence[tuple[float, float]], height: float, wet: Wet) -> float:
    """Work of water on a body over gamma r_0^3 and its rate of rotation, from angles (n,) along its spiral and the ground's corners."""
    r = np.exp((angle - angle[0]) * tangent)
    x, y = r * np.cos(angle), -r * np.sin(angle)
    top_x, top_y = np.array(ground).T
    along = np.linspace(0.0, len(ground) - 1.0, len(ground) * POINTS)[::-1]
    corner = np.arange(len(ground))
    outline_x, outline_y = (np.concatenate([one, np.interp(along, corner, other)]) for one, other in ((x, top_x), (y, top_y)))
    below = _moment_below(outline_x, outline_y, ground[2][1] + wet.level * height)
    depth = np.interp(-x, -top_x, top_y) - y
    return wet.r_u * tangent * float(np.trapezoid(depth * r * r, angle)) - wet.weight * below


def _moment_below(x: np.ndarray, y: np.ndarray, level: float) -> float:
    """Integral of x dA over the part of a polygon, clockwise or not, that lies below a level: that of x min(y, level) dx around it.

    Negative where that part lies towards the toe from the pole and holds the body.
    """
    height = np.minimum(y, level)
    next_x, next_height = np.roll(x, -1), np.roll(height, -1)
    middle = 0.25 * (x + next_x) * (height + next_height)
    clockwise = np.sign(np.sum((y + np.roll(y, -1)) * (next_x - x)))
    return float(clockwise * np.sum((x * height + 4.0 * middle + next_x * next_height) * (next_x - x)) / 6.0)


def _sector(start: float, end: float, tangent: float) -> float:
    """Integral of x dA between pole and spiral, over r_0^3: that of r^3 cos(theta) / 3."""

    def antiderivative(angle: float) -> float:
        return math.exp(3.0 * (angle - start) * tangent) * (3.0 * tangent * math.cos(angle) + math.sin(angle))

    return (antiderivative(end) - antiderivative(start)) / (3.0 * (1.0 + 9.0 * tangent**2))


def _triangle(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Integral of x dA over the triangle of the pole and two points, positive for clockwise ones."""
    return (first[1] * second[0] - first[0] * second[1]) * (first[0] + second[0]) / 6.0
