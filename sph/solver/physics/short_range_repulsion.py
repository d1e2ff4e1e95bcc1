"""Short-range repulsion: a linear spring that pushes once two particles are nearer than its range.

A lattice at its initial spacing does not feel it.  It is conservative and prevents pairing, where the gradient of
the cubic spline fades at short distance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import rows
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.seams import across
from sph.solver.physics.walls import wrap

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.seams import Seams
    from sph.solver.terms import State


class ShortRangeRepulsion(NamedTuple):
    """Coefficients of the term."""

    range: float
    """m"""
    stiffness: float
    """N/m for a metre of thickness"""


@slot
def add_repulsion(
    repulsion: ShortRangeRepulsion | None,
    period: Any,
    seams: Seams | None,
    state: State,
    pairs: Pairs,
    mass: np.ndarray,
    n_moving: int,
    first: int,
    last: int,
) -> float:
    """Add the repulsion's acceleration to particles first to last; returns the energy it stores in them, J/m.

    What moves shares a spring's energy with what moves, and has that with what stands still.
    """
    return 0.0


@add_repulsion.of(ShortRangeRepulsion)
def _add_repulsion(
    repulsion: ShortRangeRepulsion,
    period: Any,
    seams: Seams | None,
    state: State,
    pairs: Pairs,
    mass: np.ndarray,
    n_moving: int,
    first: int,
    last: int,
) -> float:
    energy = 0.0
    for i in rows(first, last):
        for k in neighbours_of(pairs, pairs.start[i], pairs.close_end[i]):
            j = pairs.close[k]
            dx = wrap(period, state.x[i] - state.x[j])
            dy = state.y[i] - state.y[j]
            r = math.sqrt(dx * dx + dy * dy)
            if 0.0 < r < repulsion.range and not across(seams, i, j):
                overlap = repulsion.range - r
                force = repulsion.stiffness * overlap / r
                energy += (0.25 if j < n_moving else 0.5) * repulsion.stiffness * overlap * overlap
                state.ax[i] += force * dx / mass[i]
                state.ay[i] += force * dy / mass[i]
    return energy


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> ShortRangeRepulsion:
    repulsion = scene.numerics.short_range_repulsion
    assert repulsion is not None
    return ShortRangeRepulsion(float(repulsion.range * scene.numerics.spacing), float(1e3 * repulsion.pressure / repulsion.range))


TERM = Term(
    "short_range_repulsion",
    "numerics.short_range_repulsion: prevents pairing",
    lambda scene: scene.numerics.short_range_repulsion is not None,
    _make,
)
