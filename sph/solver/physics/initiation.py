"""Initiation of failure over a length: a particle fails once plastic strain, averaged around it, reaches a critical value.

The paper's particle fails at the moment its stress reaches the surface.  That has no length: the finer the particles, the earlier the first
one fails, and the weaker the shaking that brings a slope down.  Here a particle at yield goes on gathering plastic strain at its full
strength,

    kappa += (1 - f) |s| / G,   |s|^2 = ((s_xx - s_yy) / 2)^2 + s_xy^2,

with the factor f that returns its trial deviator to the surface; in tension kappa is at least the strain by which it has opened.  It fails
where it is at yield and the mean over the initial arrangement of its soil

    sum_j w_ij kappa_j / sum_j w_ij,   w = (1 - r^2 / l^2)^2 for r < l,

reaches slip / length: soil that has slipped by ``slip`` over a band of ``length``.  The mean goes over soil of all layers, and around
periodic sides; particles of fixed walls have none and never fail.  It is renewed in every step in which a particle is at yield, and
decides in the next one.  Non-local averages of what softens: Bazant and Jirasek
(2002); slip before the loss of strength: Palmer and Rice (1973).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel


@by_reference
class Initiation(NamedTuple):
    """Coefficients of the term."""

    critical_strain: float
    """slip over length"""
    grid: np.ndarray
    """(places,) int32: the soil particle at each place of the initial lattice, column by column, with a margin all round; -1 for none"""
    place: np.ndarray
    """(soil,) int32: where a particle lies in the grid"""
    step: np.ndarray
    """(around,) int32: from a place to those nearer than the length"""
    weight: np.ndarray
    """(around,) w of those"""
    at_yield: np.ndarray
    """(particles,) bool: those that were at yield in this step"""


@jit
def gather_plastic_strain(term, state, i, factor, d, q, opening, shear_modulus):  # type: ignore[no-untyped-def]
    """Gather the plastic strain of a step of particle i, from its trial deviator (d, q), its return factor and its opening strain."""
    if term is None:
        return
    else:
        slipped = state.plastic_strain[i] + (1.0 - factor) * math.sqrt(d * d + q * q) / shear_modulus
        state.plastic_strain[i] = max(slipped, opening)
        term.at_yield[i] = factor < 1.0 or opening > 0.0


@jit
def average_plastic_strain(term, state, failed, first, last):  # type: ignore[no-untyped-def]
    """Average the plastic strain around those of soil particles first to last that are at yield and not in phase ``failed``."""
    if term is None:
        return
    else:
        for i in range(first, last):
            if term.at_yield[i] and state.phase[i] != failed:
                total = weight = 0.0
                for k in range(term.step.size):
                    j = term.grid[term.place[i] + term.step[k]]
                    if j >= 0:
                        weight += term.weight[k]
                        total += term.weight[k] * state.plastic_strain[j]
                state.mean_plastic_strain[i] = total / weight


@jit
def has_slipped(term, state, i):  # type: ignore[no-untyped-def]
    """Whether particle i, at yield, fails; without the term at once."""
    if term is None:
        return True
    else:
        return state.mean_plastic_strain[i] >= term.critical_strain


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Initiation:
    wanted, soil, dx = scene.coupling.initiation, slice(0, particles.n_soil), scene.numerics.spacing
    assert wanted is not None
    column, row = (np.round(place[soil] / dx - 0.5).astype(np.int32) for place in (particles.x, particles.y))
    grid = np.full(scene.lattice, -1, np.int32)
    grid[column, row] = np.arange(particles.n_soil)
    across, up = (min(math.ceil(wanted.length / dx), count) for count in scene.lattice)  # a longer length reaches no further soil
    x, y = (np.arange(-reach, reach + 1) * dx / wanted.length for reach in (across, up))
    weights = np.maximum(1.0 - x[:, None] ** 2 - y**2, 0.0) ** 2
    grid = np.pad(grid, ((0, 0), (up, up)), constant_values=-1)
    sides = ((across, across), (0, 0))
    grid = np.pad(grid, sides, mode="wrap") if scene.walls.kinds.sides.periodic else np.pad(grid, sides, constant_values=-1)
    near = np.argwhere(weights > 0.0) - (across, up)
    return Initiation(
        wanted.slip / wanted.length,
        grid.ravel(),
        ((column + across) * grid.shape[1] + row + up).astype(np.int32),
        (near @ (grid.shape[1], 1)).astype(np.int32),
        weights[weights > 0.0],
        np.zeros(particles.x.size, np.bool_),
    )


TERM = Term("initiation", "coupling.initiation: failure begins over a length", lambda scene: scene.coupling.initiation is not None, _make)
