"""Limit equilibrium of a body of soil cut into vertical slices: Bishop's simplified method and Spencer's method.

All bases have the same factor of safety F, by which cohesion and tan(phi) are divided, and the body slides to the left.

* **Bishop (1955)**, simplified, for circles: moments about the centre, and vertical forces on every slice without shear between slices.
* **Spencer (1967)**, for any surface: the forces between slices all have one inclination theta to the horizontal.  With it the net force of
  the neighbours on a slice follows from its own balance; these net forces and their moments must sum to zero, which gives F and theta.

A horizontal force k W acts at the centroid of every slice (the pseudo-static load), positive towards the toe.  The critical coefficient is
the k at which F = 1.  Terms: Duncan, Wright and Brandon (2014), "Soil Strength and Slope Stability", chapters 6 and 14.

Strength is never negative: a base in so much tension that c + sigma' tan(phi) < 0 holds nothing.  Less tension stays, as in limit analysis
and in the particles' solid state; ``tension`` says on how much of the surface.

Every function takes many surfaces at once: arrays have the shape (surfaces, slices), results (surfaces,), infinite where there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

MAX_TENSION = 0.05
"""Share of a surface in tension above which Spencer's answer is not taken."""
MIN_SHARE = 0.2
"""Least cos(alpha) + sin(alpha) tan(phi) / F of a base: below it the normal force grows without limit (Whitman and Bailey 1967)."""
ROUNDS = 10
"""Most iterations; a surface that needs more has no answer."""
NEAR, FOUND = 1e-7, 1e-5
"""Relative change, or change of an inclination (rad), at which an iteration ends, and up to which it has an answer."""
SMALLEST = 1e-3
"""Value below which its change counts over this, since a critical coefficient may be 0."""
SAME_ROOT = 1e-3
"""Largest difference from 1 of the factor of safety under a critical coefficient."""
PARTS, CONVEX = (0.0, 0.25, 0.5, 0.75), 0.01
"""Parts of a critical coefficient from whose factors of safety, two by two, that under the whole follows at least, since it falls along a
convex line; and by how much of F - 1 that may exceed 1."""
LEAST_COEFFICIENT = 0.1
"""Critical coefficient, at least, over (F - 1) sin(alpha); it is 1 / (cos(alpha) + sin(alpha) tan(phi)) on a plane."""
MAX_TURN = 0.35
"""Largest change of an inclination in a round, rad."""
TINY = 1e-9
"""Less than any length (m) or stress (Pa) that counts."""
FLAT = 1e-3
"""Largest difference of inclinations of a plane, rad."""
TENSION_ROUNDS = 3
"""Times that bases which would hold less than nothing are taken out and F is found anew."""


class Slices(NamedTuple):
    """Slices of bodies of soil, for a metre of thickness; x to the right, y upwards, the toe on the left."""

    x: np.ndarray
    """middle of the base, m"""
    y: np.ndarray
    """m"""
    width: np.ndarray
    """m"""
    inclination: np.ndarray
    """of the base, rad, positive where it rises to the right"""
    weight: np.ndarray
    """of the soil, less the buoyancy by the water that stands before the toe, N/m"""
    full_weight: np.ndarray
    """of soil and pore water, on which the horizontal coefficient acts, N/m"""
    centroid: np.ndarray
    """height of its centre of mass above the middle of the base, m"""
    cohesion: np.ndarray
    """along the base, Pa"""
    friction: np.ndarray
    """tan(phi) along the base"""
    pressure: np.ndarray
    """of the pore water on the base, beyond that of the water before the toe, Pa"""
    load: np.ndarray
    """(surfaces, slices, 2) force of other standing water on the top along x and y, N/m"""
    height: np.ndarray
    """of the middle of the top above that of the base, m"""

    @property
    def length(self) -> np.ndarray:
        """Length of the base, m."""
        return self.width / np.cos(self.inclination)


class Balance(NamedTuple):
    """Answer of a method for each of many surfaces."""

    value: np.ndarray
    """(surfaces,) factor of safety, or critical coefficient; infinite where the method finds none"""
    tension: np.ndarray
    """(surfaces,) share of the surface whose effective normal stress is tension"""


def bishop(slices: Slices, centre: np.ndarray, k: float = 0.0) -> Balance:
    """Factors of safety of circles about centres (surfaces, 2), m, by Bishop's simplified method."""
    x, y = slices.x - centre[:, :1], slices.y - centre[:, 1:]
    by_load = x * slices.load[..., 1] - (y + slices.height) * slices.load[..., 0]
    drive = (slices.weight * x - by_load - k * slices.full_weight * (y + slices.centroid)).sum(axis=1)
    cosine, sine, length = np.cos(slices.inclination), np.sin(slices.inclination), slices.length
    vertical, radius = slices.weight - slices.load[..., 1] - slices.pressure * slices.width, np.hypot(x, y).mean(axis=1)

    def solve(s: Slices) -> tuple[np.ndarray, np.ndarray]:
        inverse = np.zeros(len(x))  # 1 / F
        for _ in range(ROUNDS):
            share = cosine + sine * s.friction * inverse[:, None]
            normal = (vertical - s.cohesion * length * sine * inverse[:, None]) / share
            old, inverse = inverse, drive / (radius * (s.cohesion * length + normal * s.friction).sum(axis=1))
            if not (np.abs(inverse - old) > NEAR * inverse).any():
                break
        sound = (np.minimum(share, cosine) >= MIN_SHARE).all(axis=1) & (drive > 0.0) & (inverse > 0.0)
        return np.where(sound, 1.0 / inverse, np.inf), normal

    return _without_negative_strength(slices, solve)


def spencer(slices: Slices, k: float | np.ndarray = 0.0) -> Balance:
    """Factors of safety of surfaces of any shape by Spencer's method, under one coefficient or one for each (surfaces,)."""
    return _without_negative_strength(slices, lambda s: _spencer(s, k))


def spencer_coefficient(slices: Slices) -> Balance:
    """Critical coefficients of surfaces of any shape by Spencer's method; negative where F < 1 without a load.

    The two equations may have further roots, with another theta, that no load from nothing upwards comes to, and which count as none: under
    that k the factor of safety is not 1, or under parts of it there is none, or it does not fall along a convex line; or k has not the sign
    of F - 1, or is next to nothing of what it is on a plane as steep as the chord.
    """
    balance = _without_negative_strength(slices, lambda s: _spencer(s, None))
    there = np.isfinite(balance.value)
    k = np.where(there, balance.value, 0.0)
    excess = [spencer(slices, part * k).value - 1.0 for part in PARTS]
    unloaded, loaded = excess[0], spencer(slices, k).value - 1.0
    rise, length = (slices.length * np.sin(slices.inclination)).sum(axis=1), slices.length.sum(axis=1)
    # No factor under the whole, as close to much tension, tells nothing.
    other = np.isfinite(loaded) & (np.abs(loaded) > SAME_ROOT) | ~np.isfinite([*excess, loaded]).any(axis=0)
    with np.errstate(invalid="ignore"):
        for (part, before), (next_part, after) in pairwise(zip(PARTS, excess, strict=True)):
            lowest = after + (after - before) * (1.0 - next_part) / (next_part - part)
            other |= np.isfinite(lowest) & (lowest > np.maximum(CONVEX * np.abs(unloaded), SAME_ROOT))
        least = LEAST_COEFFICIENT * unloaded * rise / length
        other |= (np.abs(unloaded) > SAME_ROOT) & np.isfinite(unloaded) & (k * np.sign(unloaded) < np.abs(least))
    return balance._replace(value=np.where(there & ~other, balance.value, np.inf))


def _without_negative_strength(slices: Slices, solve: Callable[[Slices], tuple[np.ndarray, np.ndarray]]) -> Balance:
    """Solve for a value and the effective normal forces, again without the bases that would hold less than nothing."""
    with np.errstate(all="ignore"):
        s, length = slices, slices.length
        value, normal = solve(s)
        for _ in range(TENSION_ROUNDS):
            gone = np.isfinite(value)[:, None] & (s.cohesion * length + normal * s.friction < 0.0) & (s.cohesion + s.friction > 0.0)
            if not gone.any():
                break
            s = s._replace(cohesion=np.where(gone, 0.0, s.cohesion), friction=np.where(gone, 0.0, s.friction))
            value, normal = solve(s)
        tension = _in_tension(normal / np.maximum(length, TINY), length)
        sound = np.isfinite(value) & np.isfinite(tension)  # no NaN, which would win every comparison
        return Balance(np.where(sound, value, np.inf), np.where(sound, tension, 1.0))


def _in_tension(stress: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Share (surfaces,) of the length in tension, with stresses that change linearly from the middle of one base to that of the next."""
    low, high = np.minimum(stress[:, :-1], stress[:, 1:]), np.maximum(stress[:, :-1], stress[:, 1:])
    share = np.clip(-low / np.maximum(high - low, TINY), 0.0, 1.0)
    between = 0.5 * (length[:, :-1] + length[:, 1:])
    return _sum(share, between) / between.sum(axis=1)


def _spencer(s: Slices, k: float | np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """F under a coefficient, or the critical coefficient if that is None, and the effective normal forces.

    The net force of the neighbours on a slice is Q = (A - R / F) / (cos(alpha - theta) + sin(alpha - theta) tan(phi) / F), with the force A
    along its base and its strength R without neighbours.  Newton's iteration closes the sums of Q and of its moments together, for theta
    and for 1 / F or k, in which Q is nearly linear.  On a plane every theta gives the same value.
    """
    critical = k is None
    cosine, sine, friction, length = np.cos(s.inclination), np.sin(s.inclination), s.friction, s.length
    x, y = (each - each.mean(axis=1, keepdims=True) for each in (s.x, s.y))
    by_k, moment_by_k = s.full_weight * (cosine + sine * friction), _sum(s.full_weight, s.centroid)
    chord = np.arctan2((length * sine).sum(axis=1), s.width.sum(axis=1))
    plane = np.abs(s.inclination - chord[:, None]).max(axis=1) <= FLAT
    value, theta = np.zeros(len(x)), chord
    for number in range(ROUNDS):
        if critical or number == 0:
            pushed = value if critical else np.full(len(x), k)
            down, left = s.weight - s.load[..., 1], pushed[:, None] * s.full_weight - s.load[..., 0]
            alone = down * cosine - left * sine - s.pressure * length
            pull, hold = left * cosine + down * sine, s.cohesion * length + alone * friction
            moment = pushed * moment_by_k - _sum(s.load[..., 0], s.height)
        inverse = np.ones((len(x), 1)) if critical else value[:, None]
        level, steep = np.cos(theta)[:, None], np.sin(theta)[:, None]
        across, along = level * cosine + steep * sine, level * sine - steep * cosine
        share = across + along * friction * inverse
        q = (pull - hold * inverse) / share
        q_value = (by_k if critical else -hold - q * along * friction) / share
        q_theta = q * (across * friction * inverse - along) / share
        arm, arm_theta = x * steep - y * level, x * level + y * steep
        force, force_value, force_theta = q.sum(axis=1), q_value.sum(axis=1), q_theta.sum(axis=1)
        rest, rest_theta = _sum(q, arm) - moment, _sum(q_theta, arm) + _sum(q, arm_theta)
        rest_value = _sum(q_value, arm) - (moment_by_k if critical else 0.0)
        turn = (force * rest_value - rest * force_value) / (force_value * rest_theta - force_theta * rest_value)
        turn = np.where(plane, 0.0, np.clip(turn, -MAX_TURN, MAX_TURN))
        change = -(force + force_theta * turn) / force_value
        value, theta = value + change, theta + turn
        open_by = np.maximum(np.abs(change) / np.maximum(np.abs(value), SMALLEST), np.abs(turn))
        if not (open_by > NEAR).any():
            break
    normal = alone + q * along
    # With forces that hold the upper slices up by pulling the lower ones down the two equations have a further root.  Where much is in
    # tension no theta tells.
    held = (theta >= 0.0) | (_sum(normal < 0.0, length) > MAX_TENSION * length.sum(axis=1))
    sound = (open_by <= FOUND) & (share >= MIN_SHARE).all(axis=1) & held
    if not critical:
        sound &= (value > 0.0) & (pull.sum(axis=1) > 0.0)
        value = 1.0 / value
    return np.where(sound, value, np.inf), normal


def _sum(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Sums (surfaces,) of products over the slices."""
    sums: np.ndarray = np.einsum("ij,ij->i", one, other)
    return sums
