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
from typing import NamedTuple

import numpy as np

SMALLEST_SHARE = 0.2
"""Least cos(alpha) + sin(alpha) tan(phi) / F of a base: below it the normal force grows without limit (Whitman and Bailey 1967)."""
ANGLES = np.radians(np.arange(-10.0, 85.0, 10.0))
"""Inclinations of the forces between slices among which Spencer's is sought, rad."""
ROUNDS = 40
"""Most iterations; a surface that needs more has no answer."""
CLOSE = 1e-6
"""Change of Spencer's inclination at which it is found, rad."""
LARGEST = 100.0
"""Factor of safety with which Bishop's iteration begins."""
SAME = 1e-4
"""Relative difference of values that are the same for every inclination."""
CLOSED = 1e-5
"""Moments left over the normal forces times the width of the body, at most: a change of sign may be a pole."""
NEAR = 1e-8
"""Relative change at which an iteration ends."""
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
    angle: np.ndarray
    """(surfaces,) inclination of the forces between slices, rad; 0 in Bishop's method"""
    tension: np.ndarray
    """(surfaces,) share of the surface whose effective normal stress is tension"""


Method = Callable[[Slices], Balance]


def bishop(slices: Slices, centre: np.ndarray, k: float = 0.0) -> Balance:
    """Factors of safety of circles about centres (surfaces, 2), m, by Bishop's simplified method."""
    drive, pushed, radius = _moments(slices, centre)
    drive = drive + k * pushed

    def solve(s: Slices) -> tuple[np.ndarray, np.ndarray]:
        factor = np.where(drive > 0.0, LARGEST, np.nan)
        for _ in range(ROUNDS):
            old, factor = factor, radius * _bishop_bases(s, factor)[0].sum(axis=1) / drive
            if not (np.abs(factor - old) > NEAR * factor).any():
                break
        return factor, _bishop_bases(s, factor)[1]

    return _without_negative_strength(slices, solve)


def bishop_coefficient(slices: Slices, centre: np.ndarray) -> Balance:
    """Critical coefficients of circles by Bishop's method: in closed form, since it takes no part in the vertical forces."""
    drive, pushed, radius = _moments(slices, centre)

    def solve(s: Slices) -> tuple[np.ndarray, np.ndarray]:
        held, normal = _bishop_bases(s, np.ones(len(drive)))
        return np.where(pushed > 0.0, (radius * held.sum(axis=1) - drive) / np.where(pushed > 0.0, pushed, 1.0), np.inf), normal

    return _without_negative_strength(slices, solve)


def _moments(s: Slices, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Moments (surfaces,) about the centre that drive the body, by weight and water (N) and by k = 1, and the mean arm of the bases, m."""
    x, y = s.x - centre[:, :1], s.y - centre[:, 1:]
    by_load = x * s.load[..., 1] - (y + s.height) * s.load[..., 0]
    drive = (s.weight * x - by_load).sum(axis=1)
    pushed = (-(y + s.centroid) * s.full_weight).sum(axis=1)
    return drive, pushed, np.hypot(x, y).mean(axis=1)


def _bishop_bases(s: Slices, factor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Strength and effective normal force (surfaces, slices) of the bases, N/m; infinite where a base is too steep for the method."""
    cosine, sine = np.cos(s.inclination), np.sin(s.inclination)
    vertical, reduced = s.weight - s.load[..., 1] - s.pressure * s.width, factor[:, None]
    share = cosine + sine * s.friction / reduced
    sound = np.where(share >= SMALLEST_SHARE, share, np.nan)
    normal = (vertical - s.cohesion * s.length * sine / reduced) / sound
    return s.cohesion * s.length + normal * s.friction, normal


def spencer(slices: Slices, k: float = 0.0) -> Balance:
    """Factors of safety of surfaces of any shape by Spencer's method."""

    def solve(s: Slices) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return _balance(_Forces.of(s, k), _Forces.factor)

    return _spencer(slices, solve)


def spencer_coefficient(slices: Slices) -> Balance:
    """Critical coefficients of surfaces of any shape by Spencer's method; negative where F < 1 without a load."""

    def solve(s: Slices) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return _balance(_Forces.of(s, 0.0), _Forces.coefficient)

    return _spencer(slices, solve)


def _spencer(slices: Slices, solve: Callable[[Slices], tuple[np.ndarray, np.ndarray, np.ndarray]]) -> Balance:
    angle = np.zeros(len(slices.x))

    def solve_and_keep(s: Slices) -> tuple[np.ndarray, np.ndarray]:
        value, normal, found = solve(s)
        angle[:] = found
        return value, normal

    balance = _without_negative_strength(slices, solve_and_keep)
    return balance._replace(angle=angle)


def _without_negative_strength(slices: Slices, solve: Callable[[Slices], tuple[np.ndarray, np.ndarray]]) -> Balance:
    """Solve for a value and the effective normal forces, again without the bases that would hold less than nothing."""
    with np.errstate(all="ignore"):
        s = slices
        value, normal = solve(s)
        for _ in range(TENSION_ROUNDS):
            gone = np.isfinite(value)[:, None] & (s.cohesion * s.length + normal * s.friction < 0.0) & (s.cohesion + s.friction > 0.0)
            if not gone.any():
                break
            s = s._replace(cohesion=np.where(gone, 0.0, s.cohesion), friction=np.where(gone, 0.0, s.friction))
            value, normal = solve(s)
        tension = np.where(normal < 0.0, slices.length, 0.0).sum(axis=1) / slices.length.sum(axis=1)
        return Balance(np.where(np.isfinite(value), value, np.inf), np.zeros(len(value)), tension)


class _Forces(NamedTuple):
    """The parts of the net force of the neighbours on a slice, Q = (A F - R) / (C F + S), and what its moment needs."""

    slices: Slices
    cosine: np.ndarray
    sine: np.ndarray
    driving: np.ndarray  # A: along the base, N/m
    normal: np.ndarray  # effective normal force without the neighbours, N/m
    holding: np.ndarray  # R: strength without the neighbours, N/m
    moment: np.ndarray  # (surfaces,) of load and k about the bases, anticlockwise, N
    x: np.ndarray  # from the mean, m
    y: np.ndarray

    @classmethod
    def of(cls, s: Slices, k: float) -> _Forces:
        cosine, sine = np.cos(s.inclination), np.sin(s.inclination)
        down, left = s.weight - s.load[..., 1], k * s.full_weight - s.load[..., 0]
        normal = down * cosine - left * sine - s.pressure * s.length
        moment = (k * s.full_weight * s.centroid - s.load[..., 0] * s.height).sum(axis=1)
        x, y = (each - each.mean(axis=1, keepdims=True) for each in (s.x, s.y))
        return cls(s, cosine, sine, left * cosine + down * sine, normal, s.cohesion * s.length + normal * s.friction, moment, x, y)

    def some(self, rows: np.ndarray) -> _Forces:
        """Those of some surfaces."""
        return _Forces(Slices(*(each[rows] for each in self.slices)), *(each[rows] for each in self[1:]))

    def turned(self, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cosine and sine of alpha - theta, for angles (surfaces, angles): (surfaces, angles, slices)."""
        cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
        own_cosine, own_sine = self.cosine[:, None], self.sine[:, None]
        return cosine * own_cosine + sine * own_sine, cosine * own_sine - sine * own_cosine

    def factor(self, angle: np.ndarray) -> _Trial:
        """F at which the horizontal forces balance.

        The sum of Q rises with F and is concave beyond its last pole: Newton's iteration from below does not overshoot.
        """
        cosine, sine = self.turned(angle)
        s = sine * self.slices.friction[:, None]
        driving, holding = self.driving[:, None], self.holding[:, None]
        pole = np.maximum((-s / cosine).max(axis=-1), 0.0)
        slope = driving * s + holding * cosine
        factor = np.maximum(holding.sum(axis=-1) / driving.sum(axis=-1), 1.1 * pole + 0.01)
        for _ in range(ROUNDS):
            share = cosine * factor[..., None] + s
            step = ((driving * factor[..., None] - holding) / share).sum(axis=-1) / (slope / share**2).sum(axis=-1)
            old, factor = factor, np.maximum(factor - step, 0.5 * (factor + pole))
            if not ((np.abs(factor - old) > NEAR * factor) & (factor < LARGEST)).any():
                break
        share = cosine * factor[..., None] + s
        sound = (share >= SMALLEST_SHARE * factor[..., None]).all(axis=-1) & (driving.sum(axis=-1) > 0.0)
        q = (driving * factor[..., None] - holding) / share
        normal = self.normal[:, None] + q * sine
        return _Trial(np.where(sound, factor, np.nan), self.rest(q, angle, self.moment[:, None]), normal)

    def coefficient(self, angle: np.ndarray) -> _Trial:
        """The coefficient at which the horizontal forces balance with F = 1: Q is linear in it."""
        cosine, sine = self.turned(angle)
        friction, full = self.slices.friction[:, None], self.slices.full_weight[:, None]
        share = cosine + sine * friction
        q = (self.driving - self.holding)[:, None] / share
        q_of_k = full * (self.cosine + self.sine * self.slices.friction)[:, None] / share
        k = -q.sum(axis=-1) / q_of_k.sum(axis=-1)
        q = q + q_of_k * k[..., None]
        moment = self.moment[:, None] + k * (full * self.slices.centroid[:, None]).sum(axis=-1)
        normal = self.normal[:, None] - k[..., None] * full * self.sine[:, None] + q * sine
        sound = (share >= SMALLEST_SHARE).all(axis=-1)
        return _Trial(np.where(sound, k, np.nan), self.rest(q, angle, moment), normal)

    def rest(self, q: np.ndarray, angle: np.ndarray, moment: np.ndarray) -> np.ndarray:
        """Moment (surfaces, angles) that the net forces leave, N: each acts where it balances its slice."""
        across = np.sin(angle)[..., None] * self.x[:, None] - np.cos(angle)[..., None] * self.y[:, None]
        found: np.ndarray = (q * across).sum(axis=-1) - moment
        return found


class _Trial(NamedTuple):
    """What balances the forces (surfaces, angles) for inclinations of the forces between slices."""

    value: np.ndarray
    rest: np.ndarray  # of the moments, N
    normal: np.ndarray  # (surfaces, angles, slices) effective normal forces, N/m


def _balance(forces: _Forces, balanced: Callable[[_Forces, np.ndarray], _Trial]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, effective normal forces and angle at which the moments balance as well: the change of sign nearest to level forces, closed by
    regula falsi (Illinois).

    Where the forces alone give the same value for every inclination, as on a plane, that is the answer.
    """
    surfaces = len(forces.x)
    trial = balanced(forces, np.broadcast_to(ANGLES, (surfaces, ANGLES.size)))
    width = forces.slices.width.sum(axis=-1)[:, None]
    nothing = np.abs(trial.rest) <= NEAR * np.abs(trial.normal).sum(axis=-1) * width
    rest = np.where(np.isfinite(trial.value), np.where(nothing, 0.0, trial.rest), np.nan)
    crosses = rest[:, :-1] * rest[:, 1:] <= 0.0
    rows = np.flatnonzero(crosses.any(axis=1))
    sound = np.isfinite(trial.value)
    level = np.where(sound, np.abs(ANGLES), np.inf).argmin(axis=1)
    most, least = np.where(sound, trial.value, -np.inf).max(axis=1), np.where(sound, trial.value, np.inf).min(axis=1)
    plane = (np.count_nonzero(sound, axis=1) > 2) & (most - least <= SAME * np.abs(least))
    every = np.arange(surfaces)
    value, found = np.where(plane, trial.value[every, level], np.inf), np.where(plane, ANGLES[level], 0.0)
    normal = np.where(plane[:, None], trial.normal[every, level], 0.0)
    if not rows.size:
        return value, normal, found
    at = np.where(crosses, np.abs(ANGLES[:-1] + ANGLES[1:]), np.inf).argmin(axis=1)[rows]
    low, high, below, above = ANGLES[at], ANGLES[at + 1], rest[rows, at], rest[rows, at + 1]
    angle, forces = low, forces.some(rows)
    for _ in range(ROUNDS):
        old, angle = angle, np.where(above == below, low, (low * above - high * below) / (above - below))
        left = balanced(forces, angle[:, None]).rest[:, 0]
        stays = left * above > 0.0
        low, below = np.where(stays, low, high), np.where(stays, 0.5 * below, above)
        high, above = angle, left
        if not (np.abs(angle - old) > CLOSE).any():
            break
    trial = balanced(forces, angle[:, None])
    closed = np.abs(trial.rest[:, 0]) <= CLOSED * np.abs(trial.normal[:, 0]).sum(axis=-1) * width[rows, 0]
    rows, trial = rows[closed], _Trial(*(each[closed] for each in trial))
    value[rows], normal[rows], found[rows] = trial.value[:, 0], trial.normal[:, 0], angle[closed]
    return value, normal, found
