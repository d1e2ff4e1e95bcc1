"""Pore pressure that cyclic shear raises in undrained sand, up to its liquefaction, and the strength that it then keeps.

Drained sand compacts in every half cycle of shear strain of the amplitude gamma, by (Byrne 1991)

    d eps_vd = C1/2 gamma exp(-C2 eps_vd / gamma),   C2 = 0.4 / C1.

Undrained sand cannot: its skeleton unloads by as much, and the water takes over what the skeleton gives up,

    du = M_r d eps_vd,   p' falls by du,

so that the total stress stays as it was, and neither force nor work comes of it.  u rises by no more than the initial vertical effective
stress sigma'_v0, that of the soil above, and r_u is its rise over that.  The strength falls with p' by itself; the shear modulus of the
particle and M_r fall as (1 - r_u)^n, down to a least share.  u does not flow off while the ground shakes, and does not fall in shear, as
that of dense sand does.

**Amplitude.** The shear strain in the plane is the vector e = (e_xx - e_yy, 2 e_xy), whose norm is gamma; a turn of the axes turns it and
keeps its norm, so that no direction is preferred, and a spin of the particle turns it with its stress.  A half cycle runs from one
extreme of e to the next: the strain that lies farthest from the last extreme is one once the strain has come back from it by
``RETURN`` of their distance, or of the last half cycle's, whichever is larger.  gamma is half that distance; the first half cycle starts
from rest, so that gamma is all of it.  In simple shear it is the amplitude of the strain between its peaks.  Small cycles within a large
one are left out, as they compact next to nothing.  Steady shear in one direction raises no pressure.

**Liquefaction.** Sand whose r_u or shear strain reaches its limit is liquefied.  It fails then, and not at its yield surface, where it
yields before without a loss of strength.  Its fluid state then has no friction and the cohesion min(S_r, drained strength at sigma'_v0).

Stiffness and strength are changed in the particle's own row of the table of materials (``sph.solver.physics.material``).  Walls and
the soil above water have none of it.  The law counts from the end of the gravity stage.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.liquefaction import STRENGTHS, clean_sand_residual, volume_coefficient, volume_coefficient_of_density
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles, peak_strength
from sph.solver.physics import material
from sph.solver.physics.elasticity import Deviator, rotate, strained
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.material import FLUID_LAWS, Layers, Material
from sph.solver.physics.mohr_coulomb import MohrCoulomb
from sph.solver.physics.pore_pressure import effective_overburden, pore_pressure
from sph.solver.state import ARMED

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Strain
    from sph.solver.terms import State

BULK_MODULUS, SHEAR_MODULUS = Material._fields.index("bulk_modulus"), Material._fields.index("shear_modulus")
FLUID = Material._fields.index("solid") + len(MohrCoulomb._fields)
"""Columns of the table of materials; ``FLUID`` is the first of the surface of the fluid state, cohesion and sine."""
RETURN = 0.25
"""Part of the larger of this and the last half cycle by which the strain comes back before it counts as turned."""


@by_reference
class CyclicPorePressure(NamedTuple):
    """Coefficients of the term."""

    coefficient: np.ndarray
    """(particles with a stress of their own,) C1; 0 where no pressure rises"""
    modulus: np.ndarray
    """the same of M_r at the start, Pa"""
    shear_modulus: np.ndarray
    """the same of G at the start, Pa"""
    fluid: np.ndarray
    """(..., 2) the same of the surface of the fluid state before liquefaction: c cos(phi), Pa, and sin(phi)"""
    law_modulus: int
    """column of the table in which the law of the fluid state has G; negative where it has none"""
    vertical: np.ndarray
    """the same of sigma'_v0, Pa"""
    residual: np.ndarray
    """the same of min(S_r, drained strength), Pa; negative where soil fails at its yield surface"""
    exponent: float
    least: float
    """least share of the moduli that is left"""
    pressure_ratio: float
    """r_u at liquefaction"""
    shear_strain: float
    """gamma at liquefaction"""
    start: float
    """end of the gravity stage, s"""
    density: float
    """of the scene's own soil, kg/m3"""


class CyclicState(NamedTuple):
    """What the term keeps of the state; strains as a ``Deviator`` has them, since the end of the gravity stage."""

    shear_diff: np.ndarray  # (n,) shear strain
    shear_xy: np.ndarray
    since_diff: np.ndarray  # (n,) shear strain since the last extreme
    since_xy: np.ndarray
    farthest_diff: np.ndarray  # (n,) that of them with the largest norm
    farthest_xy: np.ndarray
    last_range: np.ndarray  # (n,) norm of that between the last two extremes; 0 before the first
    compaction: np.ndarray  # (n,) eps_vd
    excess_pressure: np.ndarray  # (n,) rise of u, Pa
    liquefied_at: np.ndarray  # (n,) time of liquefaction, s; negative before


@jit
def compaction_of(coefficient: float, compaction: float, amplitude: float) -> float:
    """Volumetric strain of a half cycle of an amplitude, from C1 and that so far (Byrne 1991)."""
    return 0.5 * coefficient * amplitude * math.exp(-0.4 / coefficient * compaction / amplitude)


@slot
def compact(cyclic: CyclicPorePressure | None, layers: Layers | None, state: State, i: int, strain: Strain, time: float) -> None:
    """Raise the excess pore pressure of particle i in a step and unload its skeleton, and note whether it has liquefied."""


@compact.of(CyclicPorePressure)
def _compact(cyclic: CyclicPorePressure, layers: Layers, state: State, i: int, strain: Strain, time: float) -> None:
    if cyclic.coefficient[i] <= 0.0 or time <= cyclic.start:
        return
    amplitude = follow_shear(state, i, strain)
    if amplitude > 0.0:
        volumetric = compaction_of(cyclic.coefficient[i], state.compaction[i], amplitude)
        state.compaction[i] += volumetric
        pressure = state.excess_pressure[i] + cyclic.modulus[i] * _stiffness(cyclic, state, i) * volumetric
        rise = min(pressure, cyclic.vertical[i]) - state.excess_pressure[i]
        state.excess_pressure[i] += rise
        state.density[i] -= cyclic.density * rise / layers.table[layers.layer[i], BULK_MODULUS]
        soften(cyclic, layers, state, i)
    if cyclic.residual[i] >= 0.0 and state.phase[i] == ARMED and state.liquefied_at[i] < 0.0:
        sheared = 2.0 * math.hypot(state.shear_diff[i], state.shear_xy[i])
        if state.excess_pressure[i] >= cyclic.pressure_ratio * cyclic.vertical[i] or sheared >= cyclic.shear_strain:
            state.liquefied_at[i] = time
            soften(cyclic, layers, state, i)


@jit
def follow_shear(state: State, i: int, strain: Strain) -> float:
    """Add a step to the shear strains of particle i; returns the amplitude of the half cycle that it ends, or 0."""
    added = Deviator(0.5 * (strain.xx - strain.yy), strain.xy, 0.0)
    sheared = strained(Deviator(state.shear_diff[i], state.shear_xy[i], 0.0), added, strain)
    since = strained(Deviator(state.since_diff[i], state.since_xy[i], 0.0), added, strain)
    farthest = rotate(Deviator(state.farthest_diff[i], state.farthest_xy[i], 0.0), strain.spin)
    reach, back_diff, back_xy = math.hypot(farthest.diff, farthest.xy), since.diff - farthest.diff, since.xy - farthest.xy
    amplitude = 0.0
    if math.hypot(since.diff, since.xy) >= reach:
        farthest = since
    elif math.hypot(back_diff, back_xy) > RETURN * max(reach, state.last_range[i]):
        amplitude = reach if state.last_range[i] > 0.0 else 2.0 * reach
        state.last_range[i] = reach
        since = Deviator(back_diff, back_xy, 0.0)
        farthest = since
    state.shear_diff[i], state.shear_xy[i] = sheared.diff, sheared.xy
    state.since_diff[i], state.since_xy[i] = since.diff, since.xy
    state.farthest_diff[i], state.farthest_xy[i] = farthest.diff, farthest.xy
    return amplitude


@jit
def _stiffness(cyclic: CyclicPorePressure, state: State, i: int) -> float:
    """Share of the moduli of particle i that excess pore pressure has left."""
    if state.excess_pressure[i] <= 0.0:
        return 1.0
    return max(max(1.0 - state.excess_pressure[i] / cyclic.vertical[i], 0.0) ** cyclic.exponent, cyclic.least)


@slot
def excess_pressure(cyclic: CyclicPorePressure | None, state: State, i: int) -> float:
    """Excess pore pressure of particle i, Pa."""
    return 0.0


@excess_pressure.of(CyclicPorePressure)
def _excess_pressure(cyclic: CyclicPorePressure, state: State, i: int) -> float:
    return state.excess_pressure[i]


@slot
def soften_soil(cyclic: CyclicPorePressure | None, layers: Layers | None, state: State, first: int, last: int) -> None:
    """Give particles first to last the coefficients that their excess pore pressure has left them, as the table of a new run has not."""


@soften_soil.of(CyclicPorePressure)
def _soften_soil(cyclic: CyclicPorePressure, layers: Layers, state: State, first: int, last: int) -> None:
    for i in range(first, min(last, cyclic.coefficient.size)):
        soften(cyclic, layers, state, i)


@jit
def soften(cyclic: CyclicPorePressure, layers: Layers, state: State, i: int) -> None:
    """Coefficients of particle i in its row of the table: shear modulus in both states, and the surface of the fluid state."""
    row = layers.layer[i]
    modulus = cyclic.shear_modulus[i] * _stiffness(cyclic, state, i)
    layers.table[row, SHEAR_MODULUS] = modulus
    if cyclic.law_modulus >= 0:
        layers.table[row, cyclic.law_modulus] = modulus
    liquefied = state.liquefied_at[i] >= 0.0
    layers.table[row, FLUID] = cyclic.residual[i] if liquefied else cyclic.fluid[i, 0]
    layers.table[row, FLUID + 1] = 0.0 if liquefied else cyclic.fluid[i, 1]


@slot
def mark_liquefied(cyclic: CyclicPorePressure | None, state: State, i: int, reached: np.ndarray) -> None:
    """Mark particle i among those that have ``reached`` their failure surface if it has liquefied."""


@mark_liquefied.of(CyclicPorePressure)
def _mark_liquefied(cyclic: CyclicPorePressure, state: State, i: int, reached: np.ndarray) -> None:
    reached[i] = reached[i] or state.liquefied_at[i] >= 0.0


@slot
def fails(cyclic: CyclicPorePressure | None, state: State, i: int, slipped: bool) -> bool:
    """Whether particle i fails, from whether other soil would that has ``slipped`` at its yield surface."""
    return slipped


@fails.of(CyclicPorePressure)
def _fails(cyclic: CyclicPorePressure, state: State, i: int, slipped: bool) -> bool:
    return state.liquefied_at[i] >= 0.0 if cyclic.residual[i] >= 0.0 else slipped


def _coefficient(soil: Soil) -> float:
    """C1 of a soil; 0 of one without a blow count or a relative density."""
    if not soil.can_liquefy:
        return 0.0
    if soil.fines_content is None and soil.relative_density is not None:
        return volume_coefficient_of_density(soil.relative_density)
    return volume_coefficient(soil.clean_sand_blow_count)


def _modulus(soil: Soil) -> float:
    """M_r of a soil, Pa."""
    skeleton = soil.bulk_modulus_si + 4.0 / 3.0 * soil.shear_modulus_si
    return skeleton if soil.rebound_modulus is None else 1e3 * soil.rebound_modulus


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> CyclicPorePressure:
    assert scene.water is not None and scene.water.excess_pressure is not None
    wanted, stressed = scene.water.excess_pressure, slice(0, particles.first_no_slip)
    table = material.TERM.make(scene, particles, kernel, dt).table[stressed]
    law = FLUID_LAWS[scene.coupling.fluid.law].record._fields  # type: ignore[attr-defined]
    layer, sand, limits = particles.layer[stressed], _liquefying(scene, particles)[stressed], wanted.liquefaction
    return CyclicPorePressure(
        coefficient=np.where(sand, np.array([_coefficient(soil) for soil in scene.soils])[layer], 0.0),
        modulus=np.array([_modulus(soil) for soil in scene.soils])[layer],
        shear_modulus=table[:, SHEAR_MODULUS].copy(),
        fluid=table[:, FLUID : FLUID + 2].copy(),
        law_modulus=FLUID + len(MohrCoulomb._fields) + law.index("shear_modulus") if "shear_modulus" in law else -1,
        vertical=effective_overburden(scene, particles.x[stressed], particles.y[stressed]),
        residual=np.full(layer.size, -1.0) if limits is None else residual_strength(scene, particles, limits.strength)[stressed],
        exponent=float(wanted.stiffness_exponent),
        least=float(wanted.least_stiffness),
        pressure_ratio=math.inf if limits is None else float(limits.r_u),
        shear_strain=math.inf if limits is None else float(limits.shear_strain),
        start=float(scene.gravity.duration),
        density=float(scene.soil.density),
    )


def can_liquefy(scene: Scene, x: np.ndarray, y: np.ndarray, layer: np.ndarray) -> np.ndarray:
    """Which places (n,) of the initial slope, of soil of these layers (n,), are sand below water that can liquefy."""
    sand = np.array([soil.can_liquefy for soil in scene.soils])[layer]
    return np.asarray(sand & (pore_pressure(scene, x, y) > 0.0) & (effective_overburden(scene, x, y) > 0.0))


def _liquefying(scene: Scene, particles: Particles) -> np.ndarray:
    """Which particles (n,) can liquefy; none of the walls."""
    return can_liquefy(scene, particles.x, particles.y, particles.layer) & (np.arange(particles.x.size) < particles.n_soil)


def residual_strength(scene: Scene, particles: Particles, law: str) -> np.ndarray:
    """Strength (n,) that particles keep once liquefied, by a law of ``STRENGTHS`` where their soil gives no number, and no more than the
    drained one, Pa; -1 for those that cannot liquefy."""
    vertical, sand = effective_overburden(scene, particles.x, particles.y), _liquefying(scene, particles)
    cohesion, friction_angle = peak_strength(scene, particles)
    found = np.full(vertical.size, -1.0)
    for number, soil in enumerate(scene.soils):
        there = sand & (particles.layer == number)
        if there.any():
            found[there] = _residual(soil, law, vertical[there])
    return np.minimum(found, cohesion + vertical * np.tan(friction_angle))


def _residual(soil: Soil, law: str, vertical: np.ndarray) -> np.ndarray:
    """S_r (n,) of a soil under initial vertical effective stresses (n,), Pa."""
    if soil.liquefied_strength is not None:
        return np.full(vertical.shape, 1e3 * soil.liquefied_strength)
    if soil.liquefied_strength_ratio is not None:
        return soil.liquefied_strength_ratio * vertical
    return STRENGTHS[law](clean_sand_residual(soil.equivalent_blow_count, soil.fines_content or 0.0), vertical)


def _start(scene: Scene, particles: Particles) -> CyclicState:
    n = particles.x.size
    return CyclicState(*(np.full(n, -1.0) if name == "liquefied_at" else np.zeros(n) for name in CyclicState._fields))


def pressure_ratio(cyclic: CyclicPorePressure | None, state: State) -> np.ndarray:
    """r_u (n,) of the particles of a run; 0 where no pressure rises."""
    found = np.zeros(state.x.size)
    if cyclic is not None:
        sand = np.flatnonzero(cyclic.coefficient)
        found[sand] = state.excess_pressure[sand] / cyclic.vertical[sand]
    return found


TERM = Term(
    "cyclic_pore_pressure",
    "water.excess_pressure: cyclic shear raises the pore pressure of sand",
    lambda scene: scene.water is not None and scene.water.excess_pressure is not None,
    _make,
    state=Arrays(CyclicState, _start),
)
