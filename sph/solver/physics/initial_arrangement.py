"""Strain of soil that has not failed, taken from where its particles were placed (total Lagrangian).

Kernel gradients between particles as they lie follow every motion of theirs, also those that the gradients do not see as strain.
Rows of particles then creep past each other without resistance, and gradients that are renewed only now and then feed such motion with
energy: an elastic column of soft soil under a steady load goes on moving.  So two particles that have not failed, and were neighbours at
the start, keep the vector between them as it was, deformed as the soil around them is,

    r_ij = (F_i + F_j) / 2 . (x_i - x_j) at the start,   dF/dt = L F,

with the velocity gradient L of Eq. 6.  Of such motion F knows nothing.  From the moment at which a particle fails its pairs are those of
the particles as they lie (updated Lagrangian); so are pairs with walls of contact, pairs of soil that meets other soil, and those that
lie elsewhere than their deformation puts them (``FAR_OFF``).  Gradients are scaled so that a uniform strain is exact inside the lattice
(``sph.solver.physics.kernels.kernel_of``).

Total Lagrangian particles have no tensile instability and no such modes: Belytschko, Guo, Liu and Xiao (2000), Int. J. Numer. Meth.
Engng. 48, 1359-1400; Bonet and Kulasegaram (2001), ibid. 52, 1203-1220.

Pairs as they lie are made at the middle of a step, so that the strain that they give is of second order in it.  Made at its end, as without
this arrangement, they overstate the rate of compression by dt/2 sum_j m_j/rho (v_j - v_i) . grad grad W . (v_j - v_i), which is
positive on average where particles keep their distance: density runs ahead of them, pressure pushes them apart, and a flow swells, lifts
off its base and speeds up without end (``docs/evidence/validation.md``, V25).

Pairs that are as they were need no renewal.  They are renewed when a particle that has others has moved by the gradient tolerance, or
when soil has deformed so much that this moves soil ``ARM`` spacings away by as much.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.moves import largest_move
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.seams import seam_sides
from sph.solver.physics.walls import wrap
from sph.solver.state import FAILED

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs, Places
    from sph.solver.terms import State

FAR_OFF = 0.2
"""Distance between where a neighbour lies and where the deformation puts it, over its distance at the start, from which on it counts as it
lies."""
SLID = 0.5
"""Distance in spacings by which soil may have slid along a smooth wall whose particles still mirror it as at the start."""
ARM = 10.0
"""Arm of the deformation that asks for new pairs, in spacings."""
LOOK_EVERY = 4
"""Steps from one look at the deformations to the next."""


@by_reference
class InitialArrangement(NamedTuple):
    """Coefficients of the term."""

    x: np.ndarray
    """(particles,) where they were placed, m"""
    y: np.ndarray
    reach_square: float
    """square of the distance within which particles were neighbours, m2"""
    arm_square: float
    """m2"""
    first_slip: int
    """first particle of walls along which soil slides freely"""
    slide_square: float
    """square of the distance by which it may have slid, m2"""


@slot
def is_intact(arrangement: InitialArrangement | None, pairs: Pairs, i: int) -> bool:
    """Whether particle i is intact, so that neighbours may be as at the start."""
    return False


@is_intact.of(InitialArrangement)
def _is_intact(arrangement: InitialArrangement, pairs: Pairs, i: int) -> bool:
    return pairs.half_gradient[i, 0] == pairs.half_gradient[i, 0]


@slot
def offset(
    arrangement: InitialArrangement | None, intact: bool, period: Any, pairs: Pairs, places: Places, i: int, j: int
) -> tuple[float, float, bool]:
    """Vector from particle j to i (m) that the pair has, and whether it is that of the start; ``intact`` says whether i is.

    The same for all of a row, so that a loop over it is compiled once for either.
    """
    return wrap(period, places.x[i] - places.x[j]), places.y[i] - places.y[j], False


@offset.of(InitialArrangement)
def _offset(
    arrangement: InitialArrangement, intact: bool, period: Any, pairs: Pairs, places: Places, i: int, j: int
) -> tuple[float, float, bool]:
    dx, dy = wrap(period, places.x[i] - places.x[j]), places.y[i] - places.y[j]
    if not intact:
        return dx, dy, False
    first_x, first_y = wrap(period, arrangement.x[i] - arrangement.x[j]), arrangement.y[i] - arrangement.y[j]
    f = pairs.half_gradient
    new_x = (f[i, 0] + f[j, 0]) * first_x + (f[i, 1] + f[j, 1]) * first_y
    new_y = (f[i, 2] + f[j, 2]) * first_x + (f[i, 3] + f[j, 3]) * first_y
    first_square, off_square = first_x * first_x + first_y * first_y, (new_x - dx) ** 2 + (new_y - dy) ** 2
    # The vector of those that are not intact is NaN, and so is how far off it is.
    allowed = arrangement.slide_square if max(i, j) >= arrangement.first_slip else FAR_OFF**2 * first_square
    kept = (first_square < arrangement.reach_square) & (off_square <= allowed)
    return new_x if kept else dx, new_y if kept else dy, kept


@slot
def keep_whether_all(arrangement: InitialArrangement | None, pairs: Pairs, i: int, as_they_lie: int) -> None:
    """Keep whether particle i has neighbours, ``as_they_lie`` of them, that are not as at the start."""


@keep_whether_all.of(InitialArrangement)
def _keep_whether_all(arrangement: InitialArrangement, pairs: Pairs, i: int, as_they_lie: int) -> None:
    pairs.changing[i] = as_they_lie > np.uint64(0)


@slot
def start_pairs(arrangement: InitialArrangement | None, state: State, pairs: Pairs, first: int, last: int) -> None:
    """Set the deformation with which the pairs of particles first to last are made, from what was last noted of it."""


@start_pairs.of(InitialArrangement)
def _start_pairs(arrangement: InitialArrangement, state: State, pairs: Pairs, first: int, last: int) -> None:
    for i in range(first, last):
        half = 0.5 if state.intact[i] else math.nan
        for k in range(4):
            pairs.half_gradient[i, k] = half * (state.stretch_pairs[k, i] + (1.0 if k == 0 or k == 3 else 0.0))


@slot
def note_intact(arrangement: InitialArrangement | None, state: State, pairs: Pairs, first: int, last: int) -> None:
    """Note which of particles first to last are intact now, and how they are deformed."""


@note_intact.of(InitialArrangement)
def _note_intact(arrangement: InitialArrangement, state: State, pairs: Pairs, first: int, last: int) -> None:
    for i in range(first, last):
        state.intact[i] = state.intact[i] & (state.phase[i] != FAILED)
        for k in range(4):
            state.stretch_pairs[k, i] = state.stretch[k, i]
    start_pairs(arrangement, state, pairs, first, last)


@slot
def place_of_pairs(arrangement: InitialArrangement | None, state: State, dt: float, i: int) -> tuple[float, float]:
    """Place (m) of particle i, which has moved for a step ``dt`` (s; 0 if it is held), at which its pairs are made."""
    return state.x[i], state.y[i]


@place_of_pairs.of(InitialArrangement)
def _half_way(arrangement: InitialArrangement, state: State, dt: float, i: int) -> tuple[float, float]:
    return state.x[i] - 0.5 * dt * state.vx[i], state.y[i] - 0.5 * dt * state.vy[i]


@slot
def deform(arrangement: InitialArrangement | None, state: State, i: int, xx: float, xy: float, yx: float, yy: float) -> None:
    """Deform particle i by the increment of a displacement gradient."""


@deform.of(InitialArrangement)
def _deform(arrangement: InitialArrangement, state: State, i: int, xx: float, xy: float, yx: float, yy: float) -> None:
    f = state.stretch
    f_xx, f_xy, f_yx, f_yy = 1.0 + f[0, i], f[1, i], f[2, i], 1.0 + f[3, i]
    f[0, i] += xx * f_xx + xy * f_yx
    f[1, i] += xx * f_xy + xy * f_yy
    f[2, i] += yx * f_xx + yy * f_yx
    f[3, i] += yx * f_xy + yy * f_yy


@slot
def largest_changes(
    arrangement: InitialArrangement | None, state: State, pairs: Pairs, step: int, first: int, last: int
) -> tuple[float, float]:
    """Largest squared moves (m2) of particles first to last that their pairs see, and that their pairs do not see and the candidates would.

    They are NaN if any is NaN or infinite.
    """
    return largest_move(state.x, state.y, state.x_pairs, state.y_pairs, first, last), 0.0


@largest_changes.of(InitialArrangement)
def _largest_changes(arrangement: InitialArrangement, state: State, pairs: Pairs, step: int, first: int, last: int) -> tuple[float, float]:
    seen = far = total = 0.0
    for i in range(first, last):
        square = (state.x[i] - state.x_pairs[i]) ** 2 + (state.y[i] - state.y_pairs[i]) ** 2
        changing = (pairs.changing[i] > 0) | (state.phase[i] == FAILED)
        seen = max(seen, square if changing else 0.0)
        far = max(far, (state.x[i] - state.x_candidates[i]) ** 2 + (state.y[i] - state.y_candidates[i]) ** 2)
        total += square
    if step % LOOK_EVERY == 0:
        for i in range(first, last):
            strain = 0.0
            for k in range(4):
                strain += (state.stretch[k, i] - state.stretch_pairs[k, i]) ** 2
            seen = max(seen, arrangement.arm_square * strain if state.intact[i] else 0.0)
    return seen + 0.0 * total, far + 0.0 * total


def _intact(scene: Scene, particles: Particles) -> np.ndarray:
    """Particles (n,) whose pairs are those of the start: soil away from seams, and walls but those of contact, which soil may leave."""
    number = np.arange(particles.x.size)
    keeps = (number < particles.first_contact) | (number >= particles.first_slip)
    solid = scene.coupling.initial_state == "solid"
    return (solid & keeps & (seam_sides(scene, particles)[0] == 0)).astype(np.uint8)


class Arrangement(NamedTuple):
    """What the term keeps of the state."""

    intact: np.ndarray  # (n,) uint8: not failed when the pairs were made, and not of a wall on which soil slides
    stretch: np.ndarray  # (4, n) deformation gradient less the identity: xx, xy, yx, yy
    stretch_pairs: np.ndarray  # (4, n) that when the pairs were made


def _start(scene: Scene, particles: Particles) -> Arrangement:
    n = particles.x.size
    return Arrangement(_intact(scene, particles), np.zeros((4, n)), np.zeros((4, n)))


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> InitialArrangement:
    return InitialArrangement(
        particles.x.copy(),
        particles.y.copy(),
        4.0 * kernel.h * kernel.h,
        (ARM * scene.numerics.spacing) ** 2,
        particles.first_slip,
        (SLID * scene.numerics.spacing) ** 2,
    )


class ArrangementPairs(NamedTuple):
    """What the term keeps with the pairs."""

    half_gradient: np.ndarray  # (n, 4) half of the deformation gradient of intact particles, NaN for others
    changing: np.ndarray  # (n,) uint8: has a neighbour that is not as at the start


def _room(n: int, size: int, dtype: np.dtype[Any]) -> ArrangementPairs:
    return ArrangementPairs(np.zeros((n, 4)), np.ones(n, np.uint8))


TERM = Term(
    "initial_arrangement",
    "numerics.reference: initial",
    lambda scene: scene.numerics.reference == "initial",
    _make,
    in_pairs=True,
    state=Arrays(Arrangement, _start, ("component", "particle")),
    pairs=Arrays(ArrangementPairs, _room),
)
