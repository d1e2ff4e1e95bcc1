"""Free-slip walls.

The paper's fixed boundary particles hold the soil: the back wall carries its weight, and it yields early.  A
free-slip wall particle mirrors the soil beside it instead of having a state of its own: it takes
the soil's mean velocity along the wall and stands still across, so that no shear strain arises, and it
takes the soil's mean normal stresses without shear.  Means are weighted with the norm of the kernel
gradient; any positive weight would do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.compiled.threads import wait
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.gradient_correction import power, transposed_shear
from sph.solver.physics.kernels import Kernel

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import State, Terms


class FreeSlip(NamedTuple):
    """Coefficients of the term."""

    first: int
    """first wall particle that slips; all after it slip too"""
    first_side: int
    """first of those that belong to a side wall; they come last"""


@jit
def _mean_of_soil(pairs: Pairs, i: int, n_soil: int, values: np.ndarray) -> float:
    total = weights = 0.0
    for k in neighbours_of(pairs, pairs.start[i], pairs.end[i]):
        j = pairs.neighbour[k]
        if j < n_soil and pairs.inverse_norm[k] > 0.0:
            weight = 1.0 / pairs.inverse_norm[k]
            total += weight * values[j]
            weights += weight
    return total / weights if weights > 0.0 else 0.0


@slot
def mirror_velocity(walls: FreeSlip | None, state: State, pairs: Pairs, n_soil: int, first: int, last: int, team: Team) -> None:
    """Velocity along the wall of the wall particles among first to last, from the soil beside them, m/s."""


@mirror_velocity.of(FreeSlip)
def _mirror_velocity(walls: FreeSlip, state: State, pairs: Pairs, n_soil: int, first: int, last: int, team: Team) -> None:
    for i in range(max(walls.first, first), min(walls.first_side, last)):
        state.vx[i] = _mean_of_soil(pairs, i, n_soil, state.vx)
    for i in range(max(walls.first_side, first), last):
        state.vy[i] = _mean_of_soil(pairs, i, n_soil, state.vy)
    wait(team)


@slot
def mirror_stress(walls: FreeSlip | None, state: State, pairs: Pairs, n_soil: int, first: int, last: int, team: Team) -> None:
    """Normal stresses of the wall particles among first to last from the soil beside them; no shear."""


@mirror_stress.of(FreeSlip)
def _mirror_stress(walls: FreeSlip, state: State, pairs: Pairs, n_soil: int, first: int, last: int, team: Team) -> None:
    for i in range(max(walls.first, first), last):
        state.sxx[i] = _mean_of_soil(pairs, i, n_soil, state.sxx)
        state.syy[i] = _mean_of_soil(pairs, i, n_soil, state.syy)
    wait(team)


@slot
def wall_work(walls: FreeSlip | None, terms: Terms, state: State, pairs: Pairs, gradient: np.ndarray, first: int, last: int) -> float:
    """Energy that the walls among particles first to last take from the soil, over dt (W/m, negative: give).

    A frictionless wall should take none.  This one's particles stay where they are while the soil slides
    past, so the mirror is not exact: in a collapsing slope it gives some per cent of the energy released.
    """
    return 0.0


@wall_work.of(FreeSlip)
def _wall_work(walls: FreeSlip, terms: Terms, state: State, pairs: Pairs, gradient: np.ndarray, first: int, last: int) -> float:
    correction, taken = terms.gradient_correction, 0.0
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    for i in range(max(walls.first, first), last):
        syx = transposed_shear(correction, state, i)
        ax, ay = sxx[i] * pairs.sum_x[i] + sxy[i] * pairs.sum_y[i], syx * pairs.sum_x[i] + syy[i] * pairs.sum_y[i]
        for k in neighbours_of(pairs, pairs.start[i], pairs.end[i]):
            j = pairs.neighbour[k]
            gx, gy = pairs.gx[k], pairs.gy[k]
            ax += sxx[j] * gx + sxy[j] * gy
            ay += transposed_shear(correction, state, j) * gx + syy[j] * gy
        taken += terms.cell_mass * (power(correction, state, gradient, i) + ax * state.vx[i] + ay * state.vy[i])
    return taken


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> FreeSlip:
    return FreeSlip(particles.first_slip, particles.first_slip_side)


TERM = Term("free_slip", "walls.base, walls.sides, walls.top", lambda scene: any(kind.slips for kind in scene.walls.kinds), _make)
