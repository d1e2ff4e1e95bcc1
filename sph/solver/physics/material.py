"""Coefficients of the material of each particle: one for all, those of its layer, or its own where strength varies in space.

With one soil the coefficients are plain numbers of the compiled code; tables are compiled in only where a scene has layers, random
fields, strength that grows with depth, or excess pore pressure.  But for layers alone each particle has a row of its own, made of c and
phi at its initial place, which it carries along; excess pore pressure changes it (``sph.solver.physics.cyclic_pore_pressure``).

Particles of soils of different density sit on one lattice and take the same room.  The sums over neighbours therefore count particles,
not mass (as Hu and Adams 2006 do for fluids of different density): every particle enters them with the mass that the scene's own soil
has in its place (``Terms.cell_mass``), and the state's density is that of this mass.  Strain rates are then right at an interface,
where sums of true masses would see a jump of density as a strain.  The force between two particles is equal and opposite as before; it
accelerates a particle of true density rho by ``lightness`` = rho_0 / rho as much as one of the scene's own.  True masses enter body
forces (not at all), short-range forces, and energies.  In a scene without layers all of this is the identity.

The step of the weight at an interface is smoothed by the kernel; where densities differ by half, the stress within a few rows of it
alternates from row to row by up to some per cent, as it does beside a fixed base (``tests/physics/test_layered_soil.py``).

Artificial viscosity takes the mean impedance rho V_p of the two particles, so that it too is equal and opposite.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sph.scene.layers import LayerMaterial
from sph.scene.schema import Scene
from sph.scene.soil import Coupling
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot, with_numbers
from sph.solver.optional import Term
from sph.solver.particles import Particles, peak_strength
from sph.solver.physics import capped_viscosity, elastic_viscoplastic, loss_by_slip, loss_by_time
from sph.solver.physics.fluid_law import FluidLaw
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.mohr_coulomb import MohrCoulomb, make_mohr_coulomb
from sph.solver.physics.strength_loss import StrengthLoss

YieldSurface = MohrCoulomb
FLUID_LAWS: dict[str, FluidLaw] = {"elastic_viscoplastic": elastic_viscoplastic.LAW, "capped_viscosity": capped_viscosity.LAW}
"""Laws of the fluid state by the name used in scenes (``coupling.fluid.law``); the first is that of the paper."""
STRENGTH_LOSSES: dict[str, StrengthLoss] = {
    "time": loss_by_time.LAW,
    "linear": loss_by_slip.LINEAR,
    "exponential": loss_by_slip.EXPONENTIAL,
}
"""Laws of the loss of strength: by time, that of the paper, or by slip, in the shape that scenes name (``coupling.softening.shape``)."""


class Material(NamedTuple):
    """Coefficients of one soil."""

    bulk_modulus: float
    """K, Pa"""
    shear_modulus: float
    """G, Pa"""
    solid: YieldSurface
    fluid: YieldSurface
    fluid_law: Any
    """record of one of ``FLUID_LAWS``"""
    peak_strain: float
    """mean plastic strain at which strength begins to fall; 0 where it falls at once"""
    loss: Any
    """record of one of ``STRENGTH_LOSSES``"""


@by_reference
class Layers(NamedTuple):
    """Materials of layers."""

    layer: np.ndarray
    """(n,) row of the table: uint8, 0 for the scene's own soil, k for the k-th layer; int32, a row each, where soil of one kind differs"""
    table: np.ndarray
    """(rows, ...): the numbers of ``Material`` in order"""
    lightness: np.ndarray
    """(n,) density of the scene's own soil over the particle's"""
    impedance: np.ndarray
    """(n,) density times V_p over that of the scene's own soil"""


def make_material(of: LayerMaterial, coupling: Coupling, dt: float) -> Material:
    """Coefficients of a material at a time step (s)."""
    soil, softening = of.soil, of.softening
    solid, fluid = _surfaces(soil.cohesion_si, soil.friction_angle_si, of, coupling)
    return Material(
        bulk_modulus=float(soil.bulk_modulus_si),
        shear_modulus=float(soil.shear_modulus_si),
        solid=solid,
        fluid=fluid,
        fluid_law=FLUID_LAWS[coupling.fluid.law].make(soil, coupling.fluid),
        peak_strain=0.0 if softening is None else softening.peak_strain,
        loss=STRENGTH_LOSSES[loss_of(coupling)].make(math.exp(-of.gamma * dt), softening),
    )


def materials_of(scene: Scene, dt: float) -> list[Material]:
    """Coefficients of the scene's own soil and of those of its layers in order, at a time step (s)."""
    return [make_material(of, scene.coupling, dt) for of in scene.materials]


def loss_of(coupling: Coupling) -> str:
    """Name of the law by which strength is lost."""
    return coupling.softening.shape if coupling.softening is not None and coupling.softening.by_slip else "time"


def _surfaces(cohesion: float, friction_angle: float, of: LayerMaterial, coupling: Coupling) -> tuple[YieldSurface, YieldSurface]:
    """Surfaces of the solid and of the fluid state (Eqs. 14 and 15) from c (Pa) and phi (rad) at the peak."""
    cut, residual = coupling.fluid_tension_limit, of.kept(cohesion, friction_angle, kPa=1e3, degree=math.radians(1.0))
    return make_mohr_coulomb(cohesion, friction_angle), make_mohr_coulomb(*residual, None if cut is None else 1e3 * cut)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Layers:
    layer = particles.layer
    rows_of = [[m.bulk_modulus, m.shear_modulus, *m.solid, *m.fluid, *m.fluid_law, m.peak_strain, *m.loss] for m in materials_of(scene, dt)]
    table = np.array(rows_of)
    density = np.array([soil.density for soil in scene.soils])
    impedance = density * np.array([soil.p_wave_speed for soil in scene.soils])
    rows = layer.astype(np.uint8)
    if scene.strength_varies or scene.softens_by_pressure:
        table, rows = table[layer], np.arange(layer.size, dtype=np.int32)
    if scene.strength_varies:
        for row, number, (cohesion, friction_angle) in zip(table, layer, peak_strength(scene, particles).T.tolist(), strict=True):
            solid, fluid = _surfaces(cohesion, friction_angle, scene.materials[number], scene.coupling)
            row[2 : 2 + len(solid) + len(fluid)] = *solid, *fluid
    return Layers(rows, table, (density[0] / density)[layer], (impedance / impedance[0])[layer])


TERM = Term(
    "layers",
    "layers, random fields, strength that grows with depth or excess pore pressure: tables of materials",
    lambda scene: bool(scene.layers) or scene.strength_varies or scene.softens_by_pressure,
    _make,
)


@slot
def material_of(layers: Layers | None, soil: Material, i: int) -> Material:
    """Coefficients of particle i: those of ``soil`` where there are no layers."""
    return soil


@material_of.of(Layers)
def _material_of(layers: Layers, soil: Material, i: int) -> Material:
    t, k = layers.table, layers.layer[i]
    fluid = 2 + len(soil.solid)
    law = fluid + len(soil.fluid)
    return Material(
        t[k, 0],
        t[k, 1],
        with_numbers(soil.solid, t, k, 2),
        with_numbers(soil.fluid, t, k, fluid),
        with_numbers(soil.fluid_law, t, k, law),
        t[k, law + len(soil.fluid_law)],
        with_numbers(soil.loss, t, k, law + len(soil.fluid_law) + 1),
    )


@slot
def lightness(layers: Layers | None, i: int) -> float:
    """Density of the scene's own soil over that of particle i's."""
    return 1.0


@lightness.of(Layers)
def _lightness(layers: Layers, i: int) -> float:
    return layers.lightness[i]


@slot
def mean_impedance(layers: Layers | None, i: int, j: int, value: float) -> float:
    """A value times the mean impedance of particles i and j over that of the scene's own soil."""
    return value


@mean_impedance.of(Layers)
def _mean_impedance(layers: Layers, i: int, j: int, value: float) -> float:
    return value * 0.5 * (layers.impedance[i] + layers.impedance[j])
