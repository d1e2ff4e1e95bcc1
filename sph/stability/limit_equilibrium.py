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

import math
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sph.solver.compiled.jit import compile_lock, entry

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
    """F under a coefficient, or the critical coefficient if that is None, and the effective normal forces."""
    critical = k is None
    given = np.zeros(len(s.x)) + (0.0 if k is None else k)
    value, sound, normal = _compiled()(Slices(*map(np.ascontiguousarray, s)), given, critical)
    return np.where(sound, value if critical else 1.0 / value, np.inf), normal


@cache
def _compiled() -> Callable[[Slices, np.ndarray, bool], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """``close_forces``, which a call with no surfaces compiles or loads."""
    nothing = Slices._make(np.zeros((0, 0, 2) if name == "load" else (0, 0)) for name in Slices._fields)
    with compile_lock(required=False):
        close_forces(nothing, np.zeros(0), False)
    return close_forces


@entry
def close_forces(s, k, critical):  # type: ignore[no-untyped-def]
    """Newton's iteration of Spencer's method, a surface at a time: 1 / F under ``k``, or the critical coefficient, and theta.

    The net force of the neighbours on a slice is Q = (A - R / F) / (cos(alpha - theta) + sin(alpha - theta) tan(phi) / F), with the force A
    along its base and its strength R without neighbours.  The sums of Q and of its moments are closed together, for theta and for 1 / F or
    k, in which Q is nearly linear.  On a plane every theta gives the same value.  Returns the values (surfaces,), whether they are sound,
    and the effective normal forces (surfaces, slices), N/m.
    """
    surfaces, slices = s.x.shape
    values, sound, normal = np.zeros(surfaces), np.zeros(surfaces, np.bool_), np.zeros((surfaces, slices))
    cosines, sines = np.zeros(slices), np.zeros(slices)
    for row in range(surfaces):
        width = rise = moment_by_k = 0.0
        for i in range(slices):
            cosines[i], sines[i] = math.cos(s.inclination[row, i]), math.sin(s.inclination[row, i])
            width += s.width[row, i]
            rise += s.width[row, i] * sines[i] / cosines[i]
            moment_by_k += s.full_weight[row, i] * s.centroid[row, i]
        chord, bend = math.atan2(rise, width), 0.0
        middle_x, middle_y = s.x[row].mean(), s.y[row].mean()
        for i in range(slices):
            bend = max(bend, abs(s.inclination[row, i] - chord))
        value, theta, open_by, least, driven, length_all, length_torn = 0.0, chord, np.inf, np.inf, 0.0, 0.0, 0.0
        for _ in range(ROUNDS):
            pushed, inverse = (value, 1.0) if critical else (k[row], value)
            level, steep = math.cos(theta), math.sin(theta)
            force = force_value = force_theta = rest_theta = driven = length_all = length_torn = 0.0
            rest, rest_value, least = -pushed * moment_by_k, -moment_by_k if critical else 0.0, np.inf
            for i in range(slices):
                cosine, sine, friction, length = cosines[i], sines[i], s.friction[row, i], s.width[row, i] / cosines[i]
                down, left = s.weight[row, i] - s.load[row, i, 1], pushed * s.full_weight[row, i] - s.load[row, i, 0]
                alone = down * cosine - left * sine - s.pressure[row, i] * length
                pull, hold = left * cosine + down * sine, s.cohesion[row, i] * length + alone * friction
                across, along = level * cosine + steep * sine, level * sine - steep * cosine
                share = across + along * friction * inverse
                q = (pull - hold * inverse) / share
                by_k = s.full_weight[row, i] * (cosine + sine * friction)
                q_value = (by_k if critical else -hold - q * along * friction) / share
                q_theta = q * (across * friction * inverse - along) / share
                x, y = s.x[row, i] - middle_x, s.y[row, i] - middle_y
                arm, arm_theta = x * steep - y * level, x * level + y * steep
                force += q
                force_value += q_value
                force_theta += q_theta
                rest += q * arm + s.load[row, i, 0] * s.height[row, i]
                rest_value += q_value * arm
                rest_theta += q_theta * arm + q * arm_theta
                driven += pull
                length_all += length
                normal[row, i] = alone + q * along
                length_torn += length if normal[row, i] < 0.0 else 0.0
                least = min(least, share)
            turn = (force * rest_value - rest * force_value) / (force_value * rest_theta - force_theta * rest_value)
            turn = 0.0 if bend <= FLAT else min(max(turn, -MAX_TURN), MAX_TURN)
            change = -(force + force_theta * turn) / force_value
            value, theta = value + change, theta + turn
            open_by = max(abs(change) / max(abs(value), SMALLEST), abs(turn))
            if not open_by > NEAR:
                break
        values[row] = value
        # With forces that hold the upper slices up by pulling the lower ones down the two equations have a further root.  Where much is in
        # tension no theta tells.
        held = theta >= 0.0 or length_torn > MAX_TENSION * length_all
        sound[row] = open_by <= FOUND and least >= MIN_SHARE and held and (critical or (value > 0.0 and driven > 0.0))
    return values, sound, normal


def _sum(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Sums (surfaces,) of products over the slices."""
    sums: np.ndarray = np.einsum("ij,ij->i", one, other)
    return sums
