"""Stress of a particle from its solid and its fluid state (Eqs. 8, 9, 14, 15).

    sigma = beta sigma_s + (1 - beta) sigma_f,   beta = 1 before t_f, then exp(-gamma (t - t_f)),

or falling with slip instead of time (``sph.solver.physics.strength_loss``).

The paper prints one global t_f and an exponent of the other sign, with which beta would grow; here
each particle has its own t_f, the moment its stress first reaches the failure surface of the solid
state.  Until then the solid state is elastic, perfectly plastic; what it is afterwards says
``sph.solver.physics.failed_solid``.  The fluid state stays on a Mohr-Coulomb surface of its own; its
deviator starts from the stress at t_f.  The elastic pressure is common to both.

At the end of the gravity stage every particle is armed.  Soil that is at yield there has failed under
gravity alone: its t_f is the end of the stage; not so soil that fails by slip, which counts from there.
Particles held by a fixed wall (``sph.solver.initial_state``) yield because the wall carries them and not
because the slope does not stand: such a one is armed once it has come off the surface clearly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.solver.compiled.jit import entry, jit, rows
from sph.solver.compiled.slots import slot
from sph.solver.physics.cyclic_pore_pressure import compact, excess_pressure, fails, mark_liquefied
from sph.solver.physics.dilation import dilate
from sph.solver.physics.elasticity import Deviator, Strain, deviator_square, elastic_rate, pressure, scaled, strained
from sph.solver.physics.failed_solid import yields
from sph.solver.physics.fluid_law import fluid_deviator
from sph.solver.physics.gradient_correction import power, store_stress, velocity_gradient
from sph.solver.physics.initial_arrangement import deform
from sph.solver.physics.interface import keep_water
from sph.solver.physics.material import YieldSurface, material_of
from sph.solver.physics.mohr_coulomb import MohrCoulomb
from sph.solver.physics.pore_pressure import carried_pressure
from sph.solver.physics.rayleigh_damping import damping_stress
from sph.solver.physics.seams import keep_normal_stress, slide, without_slip
from sph.solver.physics.slip import forget_slip, gather_plastic_strain, has_slipped, mean_strain
from sph.solver.physics.strength_loss import remaining_weight
from sph.solver.physics.yield_surface import limit_tension, return_factor, shear_demand, strength
from sph.solver.state import ARMED, FAILED, HELD, UNARMED, YIELDED

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.material import Material
    from sph.solver.terms import State, Terms

BETA_ZERO = 1e-16
"""Below this weight the solid state no longer shows in the sum and is dropped."""
OFF_THE_SURFACE = 0.95
"""A particle that a wall held at yield is armed when it asks for less than this part of its strength."""


CHUNK = 64
"""Particles treated together: the states that none of them needs are left out, and the loops over them vectorise."""


class Surfaces(NamedTuple):
    """Yield surfaces of the two states, None for a state that does not matter to any particle of a chunk."""

    solid: MohrCoulomb | None
    fluid: MohrCoulomb | None


@jit
def blend(beta: float, solid: float, fluid: float) -> float:
    """Eq. 8 for one component; with beta = 1, before failure, exactly that of the solid state."""
    return beta * solid + (1.0 - beta) * fluid


@jit
def blend_deviators(beta: float, solid: Deviator, fluid: Deviator) -> Deviator:
    """Eq. 8 for deviators, Pa."""
    return Deviator(blend(beta, solid.diff, fluid.diff), blend(beta, solid.xy, fluid.xy), blend(beta, solid.zz, fluid.zz))


@jit
def solid_deviator(state: State, i: int) -> Deviator:
    """Deviator of the solid state of particle i, Pa."""
    return Deviator(state.solid_diff[i], state.solid_xy[i], state.solid_zz[i])


@jit
def store_fluid(state: State, i: int, s: Deviator) -> None:
    """Store the deviator (Pa) of the fluid state of particle i."""
    state.fluid_diff[i] = s.diff
    state.fluid_xy[i] = s.xy
    state.fluid_zz[i] = s.zz


@jit
def blended(state: State, terms: Terms, i: int) -> tuple[float, Deviator]:
    """Pressure and deviator of Eq. 8, Pa."""
    soil = material_of(terms.layers, terms.soil, i)
    p = pressure(soil.bulk_modulus, state.density[i], terms.reference_density)
    beta = state.beta[i]
    p_solid = limit_tension(soil.solid, p) if yields(terms.elastic_after_failure, state, i) else p
    fluid = Deviator(state.fluid_diff[i], state.fluid_xy[i], state.fluid_zz[i])
    return blend(beta, p_solid, limit_tension(soil.fluid, p)), blend_deviators(beta, solid_deviator(state, i), fluid)


@slot
def _of_particle(surface: MohrCoulomb | None, own: MohrCoulomb) -> MohrCoulomb | None:
    """A particle's ``own`` surface in the place of that of its chunk; None where that is None."""
    return None


@_of_particle.of(YieldSurface)
def _own(surface: MohrCoulomb, own: MohrCoulomb) -> MohrCoulomb:
    return own


@slot
def _update_beta(fluid: MohrCoulomb | None, terms: Terms, soil: Material, state: State, i: int) -> float:
    """New weight of the solid state of particle i."""
    return 1.0


@_update_beta.of(YieldSurface)
def _lose(fluid: MohrCoulomb, terms: Terms, soil: Material, state: State, i: int) -> float:
    beta = remaining_weight(soil.loss, state.beta[i], mean_strain(terms.slip, state, i))
    beta = beta if beta > BETA_ZERO else 0.0
    state.beta[i] = beta if state.phase[i] == FAILED else 1.0
    return state.beta[i]


@slot
def _update_fluid(
    fluid: MohrCoulomb | None, terms: Terms, soil: Material, state: State, i: int, p: float, strain: Strain, time: float
) -> tuple[float, Deviator]:
    """New pressure and deviator of the fluid state of particle i, Pa, from its elastic pressure p."""
    return 0.0, Deviator(0.0, 0.0, 0.0)


@_update_fluid.of(YieldSurface)
def _flow(
    fluid: MohrCoulomb, terms: Terms, soil: Material, state: State, i: int, p: float, strain: Strain, time: float
) -> tuple[float, Deviator]:
    p = limit_tension(fluid, p)
    before = Deviator(state.fluid_diff[i], state.fluid_xy[i], state.fluid_zz[i])
    s = fluid_deviator(soil.fluid_law, fluid, p, before, strain)
    s = slide(terms.seams, state, i, p, s, 1.0 - state.beta[i], soil.shear_modulus, time)
    failed = state.phase[i] == FAILED
    s = Deviator(s.diff if failed else 0.0, s.xy if failed else 0.0, s.zz if failed else 0.0)
    store_fluid(state, i, s)
    return p, s


@slot
def _update_solid(
    solid: MohrCoulomb | None, terms: Terms, soil: Material, state: State, i: int, p: float, rate: Deviator, strain: Strain, time: float
) -> tuple[float, Deviator, bool]:
    """That of the solid state, from the elastic ``rate`` of its deviator (Pa/s), and whether it reached its surface."""
    return 0.0, Deviator(0.0, 0.0, 0.0), False


@_update_solid.of(YieldSurface)
def _yield(
    solid: MohrCoulomb, terms: Terms, soil: Material, state: State, i: int, p: float, rate: Deviator, strain: Strain, time: float
) -> tuple[float, Deviator, bool]:
    trial = strained(solid_deviator(state, i), rate, strain)
    bounded = yields(terms.elastic_after_failure, state, i)
    p_limited = limit_tension(solid, p) if bounded else p
    p_solid = dilate(terms.dilation, state, soil, i, p_limited, trial) if bounded else p
    factor = return_factor(solid, p_solid, trial) if bounded else 1.0
    gather_plastic_strain(terms.slip, state, i, factor, trial, (p_limited - p) / soil.bulk_modulus, soil.shear_modulus)
    s = slide(terms.seams, state, i, p_solid, scaled(trial, factor), state.beta[i], soil.shear_modulus, time)
    state.solid_diff[i] = s.diff
    state.solid_xy[i] = s.xy
    state.solid_zz[i] = s.zz
    return p_solid, s, factor < 1.0 or p_limited > p


@jit
def _advance_chunk(surfaces: Surfaces, state: State, pairs: Pairs, terms: Terms, time: float, team: Team, first: int, last: int) -> float:
    """Density, both states, beta and stress of particles first to last.

    Notes in ``team.reached`` who reached the failure surface; returns the internal work over dt, W/m.
    """
    gradient, reached = team.gradient, team.reached
    half = 0.5 * terms.cell_mass
    internal = 0.0
    for i in rows(first, last):
        soil = material_of(terms.layers, terms.soil, i)
        l_xx, l_xy, l_yx, l_yy = velocity_gradient(terms.gradient_correction, pairs, state.density, gradient, i)
        strain = Strain(l_xx, l_yy, 0.5 * (l_xy + l_yx), 0.5 * (l_xy - l_yx) * terms.dt, terms.dt)
        deform(terms.initial_arrangement, state, i, l_xx * terms.dt, l_xy * terms.dt, l_yx * terms.dt, l_yy * terms.dt)
        compact(terms.cyclic_pore_pressure, terms.layers, state, i, strain, time)
        density = max(state.density[i] * (1.0 - (l_xx + l_yy) * terms.dt), terms.least_density)
        state.density[i] = density
        p = pressure(soil.bulk_modulus, density, terms.reference_density)
        own_solid, own_fluid = _of_particle(surfaces.solid, soil.solid), _of_particle(surfaces.fluid, soil.fluid)
        rate = elastic_rate(soil.shear_modulus, strain)
        beta = _update_beta(own_fluid, terms, soil, state, i)
        p_fluid, s_fluid = _update_fluid(own_fluid, terms, soil, state, i, p, strain, time)
        p_solid, s_solid, reached[i] = _update_solid(own_solid, terms, soil, state, i, p, rate, strain, time)
        mark_liquefied(terms.cyclic_pore_pressure, state, i, reached)
        p_effective, s = blend(beta, p_solid, p_fluid), blend_deviators(beta, s_solid, s_fluid)
        keep_normal_stress(terms.seams, i, p_effective, s)
        water = carried_pressure(terms.pore_pressure, soil, i, beta, p, excess_pressure(terms.cyclic_pore_pressure, state, i), time)
        internal += terms.cell_mass * keep_water(terms.interface, state, i, water / (density * density))
        mean = -p_effective - 0.5 * s.zz - water
        damped = without_slip(terms.seams, i, rate)
        damp_xx, damp_yy, damp_xy = damping_stress(terms.rayleigh_damping, beta, soil.bulk_modulus, damped, l_xx + l_yy)
        scale = 1.0 / (density * density)
        internal += half * power(terms.gradient_correction, state, gradient, i)
        sxx, syy, sxy = (mean + s.diff + damp_xx) * scale, (mean - s.diff + damp_yy) * scale, (s.xy + damp_xy) * scale
        store_stress(terms.gradient_correction, pairs.correction, i, state, sxx, syy, sxy)
        internal += half * power(terms.gradient_correction, state, gradient, i)
    return internal


@jit
def _fails(terms: Terms, state: State, i: int, reached: bool) -> bool:
    slipped = reached and has_slipped(terms.slip, state, i, material_of(terms.layers, terms.soil, i).peak_strain)
    return fails(terms.cyclic_pore_pressure, state, i, slipped)


@jit
def _arm_and_fail(state: State, terms: Terms, reached: np.ndarray, first: int, last: int, time: float) -> int:
    """Arm particles, and let fail those armed that reached the surface; returns how many failed."""
    newly_failed = 0
    arming = time < terms.armed_from + terms.dt
    for i in range(first, min(last, terms.n_failing)):
        if arming:
            forget_slip(terms.slip, state, i)
        if state.phase[i] == UNARMED:
            state.phase[i] = YIELDED if _fails(terms, state, i, reached[i]) else ARMED
        elif state.phase[i] == HELD:
            limit = 1.0 if arming else OFF_THE_SURFACE
            soil = material_of(terms.layers, terms.soil, i)
            p = limit_tension(soil.solid, pressure(soil.bulk_modulus, state.density[i], terms.reference_density))
            demand = shear_demand(soil.solid, solid_deviator(state, i))
            if not reached[i] and demand <= limit * strength(soil.solid, p):
                state.phase[i] = ARMED
        elif state.phase[i] == YIELDED or (state.phase[i] == ARMED and _fails(terms, state, i, reached[i])):
            state.t_f[i] = time if state.phase[i] == ARMED else time - terms.dt
            state.phase[i] = FAILED
            store_fluid(state, i, solid_deviator(state, i))
            newly_failed += 1
    return newly_failed


@jit
def _any_reached(reached: np.ndarray, first: int, last: int) -> bool:
    """Whether one of particles first to last is at the yield surface."""
    some = False
    for i in rows(first, last):
        some |= reached[i]
    return some


@jit
def update_stress(state: State, pairs: Pairs, terms: Terms, time: float, team: Team, first: int, last: int) -> tuple[int, float]:
    """Advance density, both states and beta of particles first to last to ``time`` (s).

    ``team.gradient`` holds sums of (v_j - v_i) times g: xx, xy (dv_x/dy), yx, yy.  Notes in ``team.reached``
    who reached the failure surface; returns the number of particles that failed and the internal work over dt, W/m.
    """
    solid, fluid = terms.soil.solid, terms.soil.fluid
    failed = 0
    internal = 0.0
    for begin in range(first, min(last, terms.n_stressed), CHUNK):
        end = min(begin + CHUNK, last, terms.n_stressed)
        some_failed = some_armed = some_to_arm = some_solid = False
        for i in rows(begin, end):
            some_failed |= state.phase[i] == FAILED
            some_armed |= state.phase[i] == ARMED
            some_to_arm |= state.phase[i] != ARMED and state.phase[i] != FAILED
            some_solid |= state.beta[i] > 0.0
        if not some_failed:
            internal += _advance_chunk(Surfaces(solid, None), state, pairs, terms, time, team, begin, end)
        elif some_solid:
            internal += _advance_chunk(Surfaces(solid, fluid), state, pairs, terms, time, team, begin, end)
        else:
            internal += _advance_chunk(Surfaces(None, fluid), state, pairs, terms, time, team, begin, end)
        if time >= terms.armed_from and (some_to_arm or some_armed and _any_reached(team.reached, begin, end)):
            failed += _arm_and_fail(state, terms, team.reached, begin, end, time)
    return failed, internal


@entry
def elastic_energy(state: State, terms: Terms) -> float:
    """Energy stored in the blended stress, J/m: sum of V (p^2 / 2K + s:s / 4G)."""
    total = 0.0
    for i in range(state.x.size):
        p, s = blended(state, terms, i)
        soil = material_of(terms.layers, terms.soil, i)
        volume = terms.cell_mass / state.density[i]
        total += volume * (0.5 * p * p / soil.bulk_modulus + 0.25 * deviator_square(s) / soil.shear_modulus)
    return total


@entry
def cauchy_stress(state: State, terms: Terms, out: np.ndarray) -> None:
    """Fill ``out`` (n, 4) with the stress xx, yy, zz, xy of Eq. 8 (Pa, tension positive)."""
    for i in range(state.x.size):
        p, s = blended(state, terms, i)
        out[i, 0] = -p - 0.5 * s.zz + s.diff
        out[i, 1] = -p - 0.5 * s.zz - s.diff
        out[i, 2] = -p + s.zz
        out[i, 3] = s.xy
