"""Pore pressure, and the term of soil that carries it along: undrained soil.

The pore pressure u (Pa) at a place of the initial slope is

    u = gamma_w (y_w - y) below a phreatic line of height y_w(x), or u = r_u sigma_v,

with the vertical stress sigma_v of the soil above (r_u: Bishop and Morgenstern 1960).  What follows from the strains, the state's pressure
and deviator, is the effective stress (Terzaghi 1943), and both yield surfaces take that; so failed soil below water keeps its pore
pressure, and c_f and phi_f are strengths on effective stress as c_s and phi_s are.

This water is for ``water.pressure: carried``.  A particle keeps the u of its initial place and the momentum equation gets the total stress,

    sigma = sigma' - u I.

Where the skeleton opens, its pressure below what the surface bears in tension, the water opens with it: u falls by the cut-off tension,
and no lower than zero, so that soil without cover does not burst.  What cyclic shear adds to u is another term
(``sph.solver.physics.cyclic_pore_pressure``), which a particle carries along beside water by place as well: then this u is that rise alone,
and the pressure of the place acts as seepage.  A change of the mean stress is taken by the skeleton.  Undrained soil keeps its volume: with
a dilation angle the water's constant pressure would make energy, and such scenes are refused.  While gravity is brought on u grows with it.
The work of the water on changes of volume counts as dissipated energy.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles, layer_index, overburden
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.yield_surface import limit_tension

if TYPE_CHECKING:
    from sph.solver.physics.material import Material


@by_reference
class PorePressure(NamedTuple):
    """Coefficients of the term."""

    pressure: np.ndarray
    """(particles with a stress of their own,) u at the start, Pa; 0 where seepage acts by place"""
    ramp: float
    """time in which gravity is brought on, s"""


@slot
def carried_pressure(water: PorePressure | None, soil: Material, i: int, beta: float, p: float, excess: float, time: float) -> float:
    """Pore pressure (Pa) of particle i at a time (s), from its weight beta, its pressure p before the cut-off in tension and its excess."""
    return 0.0


@carried_pressure.of(PorePressure)
def _carried_pressure(water: PorePressure, soil: Material, i: int, beta: float, p: float, excess: float, time: float) -> float:
    grown = time / water.ramp if time < water.ramp else 1.0
    opened = beta * (limit_tension(soil.solid, p) - p) + (1.0 - beta) * (limit_tension(soil.fluid, p) - p)
    return max(water.pressure[i] * grown + excess - opened, 0.0)


def pore_pressure(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """u (n,) at places (n,) of the initial slope in the box, Pa; a scene without water has none."""
    water = scene.water
    if water is None:
        return np.zeros(np.shape(x))
    if water.r_u is None:
        surface = water.surface(scene.geometry, x + scene.numerics.lattice_shift * scene.numerics.spacing)
        return np.maximum(1e3 * water.unit_weight * (surface - y), 0.0)
    ratios = np.array([material.r_u for material in scene.materials])
    vertical = scene.gravity.acceleration * overburden(scene, x, y) / math.cos(math.radians(scene.gravity.inclination))
    return ratios[layer_index(scene, x, y)] * vertical


def effective_overburden(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Vertical effective stress (n,) of soil and standing water above places (n,) of the initial slope, Pa, compression; never tension."""
    vertical = scene.gravity.acceleration * overburden(scene, x, y)
    return vertical if scene.water is None else np.maximum(vertical + _standing(scene, x) - pore_pressure(scene, x, y), 0.0)


def _standing(scene: Scene, x: np.ndarray) -> np.ndarray:
    """Pressure (n,) of standing water on the ground at places (n,), Pa."""
    assert scene.water is not None
    if scene.water.r_u is not None:
        return np.zeros(np.shape(x))
    x = x + scene.numerics.lattice_shift * scene.numerics.spacing
    return np.maximum(1e3 * scene.water.unit_weight * (scene.water.surface(scene.geometry, x) - scene.geometry.ground(x)), 0.0)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> PorePressure:
    assert scene.water is not None
    stressed = slice(0, particles.first_no_slip)
    u = pore_pressure(scene, particles.x[stressed], particles.y[stressed])
    return PorePressure(u if scene.water.pressure == "carried" else np.zeros_like(u), float(scene.gravity.ramp))


TERM = Term(
    "pore_pressure",
    "water.pressure: carried, undrained soil; water.excess_pressure",
    lambda scene: scene.water is not None and scene.water.is_carried,
    _make,
)
