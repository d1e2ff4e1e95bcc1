"""Slip of soil at its strength: the plastic strain of the solid state, averaged over a width.

The paper's particle fails at the moment its stress reaches the surface, and has no length: the finer the particles, the earlier the first
one fails, and the weaker the shaking that brings a slope down.  Here a particle at yield gathers plastic strain,

    kappa += (1 - f) |s| / G,   |s|^2 = ((s_xx - s_yy) / 2)^2 + s_xy^2,

with the factor f that returns its trial deviator to the surface; in tension kappa is at least the strain by which it has opened.  What
decides is the mean over the initial arrangement,

    kappa_mean = sum_j w_ij kappa_j / sum_j w_ij,   w = (1 - r^2 / l^2)^2 for r < l,

times the width l: the slip.  For a slip surface through the middle this is 16/15 / (pi/3) = 1.02 times the displacement across it, however
thin the particles make it, since the mean of a strain delta / t over a band of thickness t is delta / l.  The particle fails where it is
at yield and its mean reaches the peak's (``coupling.softening``); what it then loses says ``sph.solver.physics.strength_loss``.

The sum in the numerator is over the particle's own soil, that in the denominator over all soil and over the places of walls that hold
it, which do not slip: slip in a weak seam does not soften the soil beside it, and is not more slip because the seam is thin or lies on the
base.  Both go around periodic sides; particles of fixed walls have no strain and never fail.  The mean is renewed in every step in which a
particle is at yield, and decides in the next one.  A particle gathers while its solid state has a weight.  At the end of the gravity stage
both are set to 0: ground that stands has not come to its stress by the way gravity is brought on here, and a slope that yields on that way
would soften before it is shaken.  Non-local averages of what
softens: Bazant and Jirasek (2002); slip before the loss of strength: Palmer and Rice (1973).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator
    from sph.solver.terms import State

NONE, WALL = np.int32(-1), np.int32(-2)
"""Places of the grid without soil: free, or of a wall that holds the soil."""


@by_reference
class Slip(NamedTuple):
    """Coefficients of the term."""

    grid: np.ndarray
    """(places,) int32: soil particle at each place of the initial lattice, column by column, with ``NONE`` or ``WALL`` all round"""
    place: np.ndarray
    """(soil,) int32: where a particle lies in the grid"""
    soil: np.ndarray
    """(soil,) uint8: number of its layer"""
    step: np.ndarray
    """(around,) int32: from a place to those nearer than the width"""
    weight: np.ndarray
    """(around,) w of those"""
    at_yield: np.ndarray
    """(particles,) bool: those whose solid state was at yield in this step"""


@slot
def gather_plastic_strain(
    slip: Slip | None, state: State, i: int, factor: float, s: Deviator, opening: float, shear_modulus: float
) -> None:
    """Gather the plastic strain of a step of particle i, from its trial deviator s, its return factor and its opening strain."""


@gather_plastic_strain.of(Slip)
def _gather_plastic_strain(slip: Slip, state: State, i: int, factor: float, s: Deviator, opening: float, shear_modulus: float) -> None:
    slipped = state.plastic_strain[i] + (1.0 - factor) * math.sqrt(s.diff * s.diff + s.xy * s.xy) / shear_modulus
    carries = state.beta[i] > 0.0
    state.plastic_strain[i] = max(slipped, opening) if carries else state.plastic_strain[i]
    slip.at_yield[i] = carries and (factor < 1.0 or opening > 0.0)


@slot
def average_plastic_strain(slip: Slip | None, state: State, first: int, last: int) -> None:
    """Average the plastic strain around those of soil particles first to last whose solid state has a weight and is at yield."""


@average_plastic_strain.of(Slip)
def _average_plastic_strain(slip: Slip, state: State, first: int, last: int) -> None:
    for i in range(first, last):
        if state.beta[i] > 0.0 and slip.at_yield[i]:  # what is left of a step in which it had a weight says nothing
            total = weight = 0.0
            for k in range(slip.step.size):
                j = slip.grid[slip.place[i] + slip.step[k]]
                if j >= 0:
                    weight += slip.weight[k]
                    total += slip.weight[k] * state.plastic_strain[j] if slip.soil[j] == slip.soil[i] else 0.0
                elif j == WALL:
                    weight += slip.weight[k]
            state.mean_plastic_strain[i] = total / weight


@slot
def mean_strain(slip: Slip | None, state: State, i: int) -> float:
    """Mean plastic strain of particle i; 0 without the term."""
    return 0.0


@mean_strain.of(Slip)
def _mean_strain(slip: Slip, state: State, i: int) -> float:
    return state.mean_plastic_strain[i]


@slot
def has_slipped(slip: Slip | None, state: State, i: int, peak_strain: float) -> bool:
    """Whether particle i, at yield, fails; without the term at once."""
    return True


@has_slipped.of(Slip)
def _has_slipped(slip: Slip, state: State, i: int, peak_strain: float) -> bool:
    return state.mean_plastic_strain[i] >= peak_strain


@slot
def forget_slip(slip: Slip | None, state: State, i: int) -> None:
    """Count the slip of particle i from now on."""


@forget_slip.of(Slip)
def _forget_slip(slip: Slip, state: State, i: int) -> None:
    state.plastic_strain[i] = state.mean_plastic_strain[i] = 0.0


class SlipState(NamedTuple):
    """What the term keeps of the state."""

    plastic_strain: np.ndarray  # (n,) gathered by the solid state at yield
    mean_plastic_strain: np.ndarray  # (n,) its average around the particle


def _start(scene: Scene, particles: Particles) -> SlipState:
    n = particles.x.size
    return SlipState(np.zeros(n), np.zeros(n))


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Slip:
    wanted, soil, dx = scene.coupling.softening, slice(0, particles.n_soil), scene.numerics.spacing
    assert wanted is not None
    column, row = (np.round(place[soil] / dx - 0.5).astype(np.int32) for place in (particles.x, particles.y))
    grid = np.full(scene.lattice, NONE, np.int32)
    grid[column, row] = np.arange(particles.n_soil)
    across, up = (min(math.ceil(wanted.width / dx), count) for count in scene.lattice)  # a larger width reaches no further soil
    x, y = (np.arange(-reach, reach + 1) * dx / wanted.width for reach in (across, up))
    weights = np.maximum(1.0 - x[:, None] ** 2 - y**2, 0.0) ** 2
    base, side, top = (WALL if kind.holds_soil or kind.reflects else NONE for kind in scene.walls.kinds)
    base = WALL if scene.walls.kinds.base.absorbs else base
    grid = np.pad(grid, ((0, 0), (up, up)), constant_values=((NONE, NONE), (base, top)))
    sides = ((across, across), (0, 0))
    grid = np.pad(grid, sides, mode="wrap") if scene.walls.kinds.sides.periodic else np.pad(grid, sides, constant_values=side)
    near = np.argwhere(weights > 0.0) - (across, up)
    return Slip(
        grid.ravel(),
        ((column + across) * grid.shape[1] + row + up).astype(np.int32),
        particles.layer[soil].astype(np.uint8),
        (near @ (grid.shape[1], 1)).astype(np.int32),
        weights[weights > 0.0],
        np.zeros(particles.x.size, np.bool_),
    )


TERM = Term(
    "slip",
    "coupling.softening: strength falls after slip over a width",
    lambda scene: scene.coupling.softening is not None,
    _make,
    state=Arrays(SlipState, _start),
)
