"""Drained soil: the gradient of the pore pressure of the place acts on it, as seepage and buoyancy.

For ``water.pressure: by_place``.  The stress of the soil is the effective one (``sph.solver.physics.pore_pressure``), and equilibrium of
the soil with its water,

    div sigma' + rho g - grad u = 0,

has the water as a body force -grad u: buoyancy under hydrostatic water, and the drag of the water where the phreatic line falls.  u is
continuous from the soil into standing water, so that the ground of a flooded slope bears no effective stress and needs no load of its
own.  The force is exact where the sums over neighbours are not, at the ground and beside walls, and walls bear effective stress.

u is kept at the corners of the lattice's cells and is linear along their sides: a particle in its initial place feels the mean gradient of
its cell, of which a part may lie above the water.  It is that of the initial slope: water neither flows on nor follows the debris, and the
water's own inertia against the ground is left out (its mass in the pores is in the soil's density).  While gravity is brought on
the force grows with it.  Its work counts with that of gravity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.pore_pressure import pore_pressure


@by_reference
class Seepage(NamedTuple):
    """Coefficients of the term."""

    push: np.ndarray
    """(columns + 1, rows + 1) at the corners of cells: u times the spacing over gravity, kg for a metre of thickness"""
    left: float
    """x of the first corner, m"""
    bottom: float
    spacing: float


@slot
def with_seepage(
    seepage: Seepage | None, x: float, y: float, mass: np.ndarray, gravity: float, weight_x: float, weight_y: float
) -> tuple[float, float]:
    """Acceleration (m/s2) by weight and water of a particle of a mass (kg/m) at a place, under the present gravity (m/s2)."""
    return weight_x, weight_y


@with_seepage.of(Seepage)
def _with_seepage(
    seepage: Seepage, x: float, y: float, mass: np.ndarray, gravity: float, weight_x: float, weight_y: float
) -> tuple[float, float]:
    u = seepage.push
    across, up = (x - seepage.left) / seepage.spacing, (y - seepage.bottom) / seepage.spacing
    k = min(max(int(across), 0), u.shape[0] - 2)
    m = min(max(int(up), 0), u.shape[1] - 2)
    right, above = min(max(across - k, 0.0), 1.0), min(max(up - m, 0.0), 1.0)
    along_x = (u[k + 1, m] - u[k, m]) * (1.0 - above) + (u[k + 1, m + 1] - u[k, m + 1]) * above
    along_y = (u[k, m + 1] - u[k, m]) * (1.0 - right) + (u[k + 1, m + 1] - u[k + 1, m]) * right
    return weight_x - gravity * along_x / mass, weight_y - gravity * along_y / mass


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Seepage:
    dx, margin = scene.numerics.spacing, scene.walls.layers
    x, y = (np.arange(-margin, count + margin + 1) * dx for count in scene.lattice)
    pressure = pore_pressure(scene, np.repeat(x, y.size), np.tile(y, x.size)).reshape(x.size, y.size)
    return Seepage(pressure * dx / scene.gravity.acceleration, float(x[0]), float(y[0]), float(dx))


TERM = Term(
    "seepage",
    "water.pressure: by_place, drained soil",
    lambda scene: scene.water is not None and scene.water.pressure == "by_place",
    _make,
)
