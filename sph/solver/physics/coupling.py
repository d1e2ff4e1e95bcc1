"""Stress of a particle from its solid and its fluid state (Eqs. 8, 9, 14, 15).

    sigma = beta sigma_s + (1 - beta) sigma_f,   beta = 1 before t_f, then exp(-gamma (t - t_f)),

or falling with slip instead of time (``sph.solver.physics.strength_loss``).

The paper prints one global t_f and an exponent of the other sign, with which beta would grow; here
each particle has its own t_f, the moment its stress first reaches the failure surface of the solid
state.  Until then the solid state is elastic, perfectly plastic; what it is afterwards says
``sph.solver.physics.failed_solid``.  The fluid state stays on a Mohr-Coulomb surface of its own; its
deviator starts from the stress at t_f.  The elastic pressure is common to both.

At the end of the gravity stage every particle is armed.  Soil that is at yield there has failed under
gravity alone: its t_f is the end of the stage.  Particles held by a fixed wall (``sph.solver.initial_state``) yield
because the wall carries them and not because the slope does not stand: such a one is armed once it has come off the surface clearly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.solver.compiled.jit import entry, jit, rows
from sph.solver.compiled.slots import slot
from sph.solver.physics.dilation import dilate
from sph.solver.physics.elasticity import deviator_square, elastic_increment, pressure, rotate
from sph.solver.physics.failed_solid import yields
from sph.solver.physics.fluid_law import fluid_deviator
from sph.solver.physics.gradient_correction import correct_gradient, power, store_stress
from sph.solver.physics.initial_arrangement import deform
from sph.solver.physics.interface import keep_water
from sph.solver.physics.material import YieldSurface, material_of
from sph.solver.physics.pore_pressure import carried_pressure
from sph.solver.physics.rayleigh_damping import damping_stress
from sph.solver.physics.seams import keep_normal_stress, slide, without_slip
from sph.solver.physics.slip import gather_plastic_strain, has_slipped, mean_strain
from sph.solver.physics.strength_loss import remaining_weight
from sph.solver.physics.yield_surface import limit_tension, return_factor, shear_demand, strength
from sph.solver.state import ARMED, FAILED, HELD, UNARMED, YIELDED

BETA_ZERO = 1e-16
"""Below this weight the solid state no longer shows in the sum and is dropped."""
OFF_THE_SURFACE = 0.95
"""A particle that a wall held at yield is armed when it asks for less than this part of its strength."""


CHUNK = 64
"""Particles treated together: the states that none of them needs are left out, and the loops over them vectorise."""


@jit
def blend(beta, solid, fluid):  # type: ignore[no-untyped-def]
    """Eq. 8 for one component; with beta = 1, before failure, exactly that of the solid state."""
    return beta * solid + (1.0 - beta) * fluid


@jit
def blended(state, terms, i):  # type: ignore[no-untyped-def]
    """Pressure and deviator (p, d, q, z) of Eq. 8, Pa."""
    soil = material_of(terms.layers, terms.soil, i)
    p = pressure(soil.bulk_modulus, state.density[i], terms.reference_density)
    b = state.beta[i]
    p_solid = limit_tension(soil.solid, p) if yields(terms.elastic_after_failure, state, i) else p
    return (
        blend(b, p_solid, limit_tension(soil.fluid, p)),
        blend(b, state.solid_d[i], state.fluid_d[i]),
        blend(b, state.solid_q[i], state.fluid_q[i]),
        blend(b, state.solid_z[i], state.fluid_z[i]),
    )


class Strain(NamedTuple):
    """What the velocity gradient does to a particle in a step."""

    xx: float
    """strain rates, 1/s"""
    yy: float
    xy: float
    angle: float
    """spin increment"""
    dt: float
    """s"""


@slot
def _of_particle(surface, own):  # type: ignore[no-untyped-def]
    """A particle's ``own`` yield surface of a state that some particle of a chunk needs; None where no ``surface`` is given."""
    return None


@_of_particle.of(YieldSurface)
def _own(surface, own):  # type: ignore[no-untyped-def]
    return own


@slot
def _update_beta(fluid, terms, soil, state, i):  # type: ignore[no-untyped-def]
    """New weight of the solid state of particle i."""
    return 1.0


@_update_beta.of(YieldSurface)
def _lose(fluid, terms, soil, state, i):  # type: ignore[no-untyped-def]
    beta = remaining_weight(soil.loss, state.beta[i], mean_strain(terms.slip, state, i))
    beta = beta if beta > BETA_ZERO else 0.0
    state.beta[i] = beta if state.phase[i] == FAILED else 1.0
    return state.beta[i]


@slot
def _update_fluid(fluid, terms, soil, state, i, p, strain, time):  # type: ignore[no-untyped-def]
    """New pressure and deviator (p, d, q, z) of the fluid state of particle i, Pa, from its elastic pressure p."""
    return 0.0, 0.0, 0.0, 0.0


@_update_fluid.of(YieldSurface)
def _flow(fluid, terms, soil, state, i, p, strain, time):  # type: ignore[no-untyped-def]
    p = limit_tension(fluid, p)
    d, q, z = fluid_deviator(
        soil.fluid_law,
        fluid,
        p,
        state.fluid_d[i],
        state.fluid_q[i],
        state.fluid_z[i],
        strain.xx,
        strain.yy,
        strain.xy,
        strain.angle,
        strain.dt,
    )
    d, q = slide(terms.seams, state, i, p, d, q, z, 1.0 - state.beta[i], soil.shear_modulus, time)
    failed = state.phase[i] == FAILED
    state.fluid_d[i] = d if failed else 0.0
    state.fluid_q[i] = q if failed else 0.0
    state.fluid_z[i] = z if failed else 0.0
    return p, state.fluid_d[i], state.fluid_q[i], state.fluid_z[i]


@slot
def _update_solid(solid, terms, soil, state, i, p, rates, strain, time, reached, k):  # type: ignore[no-untyped-def]
    """That of the solid state, from elastic ``rates`` (d, q, z) of its deviator, Pa/s; notes in reached[k] if it reached its surface."""
    return 0.0, 0.0, 0.0, 0.0


@_update_solid.of(YieldSurface)
def _yield(solid, terms, soil, state, i, p, rates, strain, time, reached, k):  # type: ignore[no-untyped-def]
    rate_d, rate_q, rate_z = rates
    dt, shear_modulus, bulk_modulus = strain.dt, soil.shear_modulus, soil.bulk_modulus
    d, q = rotate(state.solid_d[i], state.solid_q[i], strain.angle)
    d += rate_d * dt
    q += rate_q * dt
    z = state.solid_z[i] + rate_z * dt
    bounded = yields(terms.elastic_after_failure, state, i)
    p_limited = limit_tension(solid, p) if bounded else p
    p_solid = dilate(terms.dilation, solid, state, i, p_limited, d, q, z, shear_modulus, bulk_modulus) if bounded else p
    factor = return_factor(solid, p_solid, d, q, z) if bounded else 1.0
    gather_plastic_strain(terms.slip, state, i, factor, d, q, (p_limited - p) / bulk_modulus, shear_modulus)
    state.solid_z[i] = z * factor
    state.solid_d[i], state.solid_q[i] = slide(
        terms.seams, state, i, p_solid, d * factor, q * factor, state.solid_z[i], state.beta[i], shear_modulus, time
    )
    reached[k] = 1.0 if factor < 1.0 or p_limited > p else 0.0
    return p_solid, state.solid_d[i], state.solid_q[i], state.solid_z[i]


@jit
def _advance_chunk(solid, fluid, state, pairs, terms, gradient, reached, time, first, last):  # type: ignore[no-untyped-def]
    """Density, both states, beta and stress of particles first to last; a state whose yield surface is None does not matter to any.

    Notes in ``reached`` who reached the failure surface; returns the internal work over dt, W/m.
    """
    dt = terms.dt
    half = 0.5 * terms.cell_mass
    internal = 0.0
    for i in rows(first, last):
        soil = material_of(terms.layers, terms.soil, i)
        own_solid, own_fluid = _of_particle(solid, soil.solid), _of_particle(fluid, soil.fluid)
        bulk = soil.bulk_modulus
        density = state.density[i]
        s = 1.0 / density
        l_xx, l_xy, l_yx, l_yy = correct_gradient(
            terms.gradient_correction, pairs.correction, i, gradient[0, i] * s, gradient[1, i] * s, gradient[2, i] * s, gradient[3, i] * s
        )
        trace = l_xx + l_yy
        strain = Strain(l_xx, l_yy, 0.5 * (l_xy + l_yx), 0.5 * (l_xy - l_yx) * dt, dt)
        deform(terms.initial_arrangement, state, i, l_xx * dt, l_xy * dt, l_yx * dt, l_yy * dt)
        rates = elastic_increment(soil.shear_modulus, strain.xx, strain.yy, strain.xy)
        new_density = max(density * (1.0 - trace * dt), terms.least_density)
        state.density[i] = new_density
        p = pressure(bulk, new_density, terms.reference_density)
        beta = _update_beta(own_fluid, terms, soil, state, i)
        p_f, d_f, q_f, z_f = _update_fluid(own_fluid, terms, soil, state, i, p, strain, time)
        p_s, d_s, q_s, z_s = _update_solid(own_solid, terms, soil, state, i, p, rates, strain, time, reached, i - np.uint64(first))
        d, q, z = blend(beta, d_s, d_f), blend(beta, q_s, q_f), blend(beta, z_s, z_f)
        keep_normal_stress(terms.seams, i, blend(beta, p_s, p_f), d, q, z)
        water = carried_pressure(terms.pore_pressure, soil, i, beta, p, time)
        keep_water(terms.interface, i, water / (new_density * new_density))
        mean = -blend(beta, p_s, p_f) - 0.5 * z - water
        rate_d, rate_q = without_slip(terms.seams, i, rates[0], rates[1])
        damp_xx, damp_yy, damp_xy = damping_stress(terms.rayleigh_damping, beta, bulk, rate_d, rate_q, rates[2], trace)
        s = 1.0 / (new_density * new_density)
        internal += half * power(terms.gradient_correction, state, gradient, i)
        store_stress(
            terms.gradient_correction, pairs.correction, i, state, (mean + d + damp_xx) * s, (mean - d + damp_yy) * s, (q + damp_xy) * s
        )
        internal += half * power(terms.gradient_correction, state, gradient, i)
    return internal


@jit
def _has_slipped(terms, state, i):  # type: ignore[no-untyped-def]
    return has_slipped(terms.slip, state, i, material_of(terms.layers, terms.soil, i).peak_strain)


@jit
def _arm_and_fail(state, terms, reached, first, last, time):  # type: ignore[no-untyped-def]
    """Arm particles, and let fail those armed that reached the surface; returns how many failed."""
    newly_failed = 0
    for i in range(first, min(last, terms.n_failing)):
        if state.phase[i] == UNARMED:
            state.phase[i] = YIELDED if reached[i - first] > 0.0 and _has_slipped(terms, state, i) else ARMED
        elif state.phase[i] == HELD:
            limit = 1.0 if time < terms.armed_from + terms.dt else OFF_THE_SURFACE
            soil = material_of(terms.layers, terms.soil, i)
            p = limit_tension(soil.solid, pressure(soil.bulk_modulus, state.density[i], terms.reference_density))
            demand = shear_demand(soil.solid, state.solid_d[i], state.solid_q[i], state.solid_z[i])
            if reached[i - first] == 0.0 and demand <= limit * strength(soil.solid, p):
                state.phase[i] = ARMED
        elif state.phase[i] == YIELDED or (state.phase[i] == ARMED and reached[i - first] > 0.0 and _has_slipped(terms, state, i)):
            state.t_f[i] = time if state.phase[i] == ARMED else time - terms.dt
            state.phase[i] = FAILED
            state.fluid_d[i] = state.solid_d[i]
            state.fluid_q[i] = state.solid_q[i]
            state.fluid_z[i] = state.solid_z[i]
            newly_failed += 1
    return newly_failed


@jit
def _any_reached(reached, count):  # type: ignore[no-untyped-def]
    """Whether one of the first particles of a chunk is at the yield surface; a loop, since numba compiles ``max`` for half a second."""
    some = False
    for i in rows(0, count):
        some |= reached[i] > 0.0
    return some


@jit
def update_stress(state, pairs, terms, gradient, reached, time, first, last):  # type: ignore[no-untyped-def]
    """Advance density, both states and beta of particles first to last to ``time`` (s).

    ``gradient`` (4, n) holds sums of (v_j - v_i) times g: xx, xy (dv_x/dy), yx, yy; ``reached``
    (CHUNK,) is room to work in.  Returns the number of particles that failed and the internal work over dt, W/m.
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
            internal += _advance_chunk(solid, None, state, pairs, terms, gradient, reached, time, begin, end)
        elif some_solid:
            internal += _advance_chunk(solid, fluid, state, pairs, terms, gradient, reached, time, begin, end)
        else:
            internal += _advance_chunk(None, fluid, state, pairs, terms, gradient, reached, time, begin, end)
        if time >= terms.armed_from and (some_to_arm or some_armed and _any_reached(reached, end - begin)):
            failed += _arm_and_fail(state, terms, reached, begin, end, time)
    return failed, internal


@entry
def elastic_energy(state, terms):  # type: ignore[no-untyped-def]
    """Energy stored in the blended stress, J/m: sum of V (p^2 / 2K + s:s / 4G)."""
    total = 0.0
    for i in range(state.x.size):
        p, d, q, z = blended(state, terms, i)
        soil = material_of(terms.layers, terms.soil, i)
        volume = terms.cell_mass / state.density[i]
        total += volume * (0.5 * p * p / soil.bulk_modulus + 0.25 * deviator_square(d, q, z) / soil.shear_modulus)
    return total


@entry
def cauchy_stress(state, terms, out):  # type: ignore[no-untyped-def]
    """Fill ``out`` (n, 4) with the stress xx, yy, zz, xy of Eq. 8 (Pa, tension positive)."""
    for i in range(state.x.size):
        p, d, q, z = blended(state, terms, i)
        out[i, 0] = -p - 0.5 * z + d
        out[i, 1] = -p - 0.5 * z - d
        out[i, 2] = -p + z
        out[i, 3] = q
