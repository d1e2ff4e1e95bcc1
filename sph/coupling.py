"""Stress of a particle from its solid and its fluid state (Eqs. 8, 9, 14, 15).

    sigma = beta sigma_s + (1 - beta) sigma_f,   beta = 1 before t_f, then exp(-gamma (t - t_f)).

The paper prints one global t_f and an exponent of the other sign, with which beta would grow; here
each particle has its own t_f, the moment its stress first reaches the failure surface of the solid
state.  Both states stay on their own Mohr-Coulomb surface: the solid one is elastic, perfectly
plastic, since with gamma = 1/s it lives on for seconds.  The fluid deviator starts from the stress
at t_f.  The elastic pressure is common to both.

At the end of the gravity stage every particle that is not at yield is armed.  One that yields under
gravity alone (soil hanging on a sticky wall) is armed once it has come off the surface clearly, so
that it does not count as failed by a shaking that has hardly begun.
"""

from __future__ import annotations

from sph.bingham import fluid_deviator
from sph.elastic import deviator_square, elastic_increment, pressure, rotate
from sph.jit import jit
from sph.mohr_coulomb import limit_tension, return_factor, shear_demand, strength
from sph.state import ARMED, FAILED, INTERNAL, UNARMED

BETA_ZERO = 1e-16
"""Below this weight the solid state no longer shows in the sum and is dropped."""
OFF_THE_SURFACE = 0.95
"""A particle that yielded under gravity is armed when it asks for less than this part of its strength."""


@jit
def correct_gradient(term, b, i, l_xx, l_xy, l_yx, l_yy):  # type: ignore[no-untyped-def]
    """Velocity gradient exact for linear fields: L times the correction matrix."""
    if term is None:
        return l_xx, l_xy, l_yx, l_yy
    else:
        return (
            l_xx * b[i, 0] + l_xy * b[i, 1],
            l_xx * b[i, 1] + l_xy * b[i, 2],
            l_yx * b[i, 0] + l_yy * b[i, 1],
            l_yx * b[i, 1] + l_yy * b[i, 2],
        )


@jit
def store_stress(term, b, i, state, sxx, syy, sxy):  # type: ignore[no-untyped-def]
    """Stress for the momentum equation, times the correction matrix where that is on."""
    if term is None:
        state.sxx[i] = sxx
        state.syy[i] = syy
        state.sxy[i] = sxy
    else:
        state.sxx[i] = sxx * b[i, 0] + sxy * b[i, 1]
        state.sxy[i] = sxx * b[i, 1] + sxy * b[i, 2]
        state.syx[i] = sxy * b[i, 0] + syy * b[i, 1]
        state.syy[i] = sxy * b[i, 1] + syy * b[i, 2]


@jit
def power(term, state, gradient, i):  # type: ignore[no-untyped-def]
    """Power of the momentum equation's stress on the plain gradient sums, W/kg: conjugate to the forces."""
    syx = state.sxy[i] if term is None else state.syx[i]
    return state.sxx[i] * gradient[i, 0] + state.sxy[i] * gradient[i, 1] + syx * gradient[i, 2] + state.syy[i] * gradient[i, 3]


@jit
def damping_stress(term, beta, bulk_modulus, rate_d, rate_q, rate_z, trace):  # type: ignore[no-untyped-def]
    """Stiffness-proportional damping: (xx, yy, xy) of beta beta_R times the elastic stress rate, Pa."""
    if term is None:
        return 0.0, 0.0, 0.0
    else:
        scale = beta * term.stiffness
        mean = bulk_modulus * trace - 0.5 * rate_z
        return scale * (mean + rate_d), scale * (mean - rate_d), scale * rate_q


@jit
def blended(state, terms, i):  # type: ignore[no-untyped-def]
    """Pressure and deviator (p, d, q, z) of Eq. 8, Pa."""
    p = pressure(terms.bulk_modulus, state.density[i], terms.reference_density)
    if state.phase[i] != FAILED:
        return limit_tension(terms.solid, p), state.solid_d[i], state.solid_q[i], state.solid_z[i]
    b = state.beta[i]
    return (
        b * limit_tension(terms.solid, p) + (1.0 - b) * limit_tension(terms.fluid, p),
        b * state.solid_d[i] + (1.0 - b) * state.fluid_d[i],
        b * state.solid_q[i] + (1.0 - b) * state.fluid_q[i],
        b * state.solid_z[i] + (1.0 - b) * state.fluid_z[i],
    )


@jit
def update_stress(state, pairs, terms, mass, gradient, step):  # type: ignore[no-untyped-def]
    """Advance density, both states and beta to time ``step`` dt.

    ``gradient`` (n, 4) holds sums of (v_j - v_i) times g: xx, xy (dv_x/dy), yx, yy.  Returns the
    number of particles that failed in this step.
    """
    dt = terms.dt
    bulk, shear = terms.bulk_modulus, terms.shear_modulus
    newly_failed = 0
    internal_work = 0.0
    for i in range(terms.n_stressed):
        density = state.density[i]
        s = 1.0 / density
        l_xx, l_xy, l_yx, l_yy = correct_gradient(
            terms.correction, pairs.correction, i, gradient[i, 0] * s, gradient[i, 1] * s, gradient[i, 2] * s, gradient[i, 3] * s
        )
        trace = l_xx + l_yy
        d_xy = 0.5 * (l_xy + l_yx)
        angle = 0.5 * (l_xy - l_yx) * dt
        rate_d, rate_q, rate_z = elastic_increment(shear, l_xx, l_yy, d_xy)
        new_density = density * (1.0 - trace * dt)
        state.density[i] = new_density
        p = pressure(bulk, new_density, terms.reference_density)
        phase = state.phase[i]

        if phase == FAILED:
            p_fluid = limit_tension(terms.fluid, p)
            state.fluid_d[i], state.fluid_q[i], state.fluid_z[i] = fluid_deviator(
                terms.fluid_law, terms.fluid, p_fluid,
                state.fluid_d[i], state.fluid_q[i], state.fluid_z[i], l_xx, l_yy, d_xy, angle, dt,
            )  # fmt: skip
            beta = state.beta[i] * terms.beta_decay
            state.beta[i] = beta if beta > BETA_ZERO else 0.0

        if state.beta[i] > 0.0:
            d, q = rotate(state.solid_d[i], state.solid_q[i], angle)
            d += rate_d * dt
            q += rate_q * dt
            z = state.solid_z[i] + rate_z * dt
            p_solid = limit_tension(terms.solid, p)
            factor = return_factor(terms.solid, p_solid, d, q, z)
            state.solid_d[i] = d * factor
            state.solid_q[i] = q * factor
            state.solid_z[i] = z * factor
            if phase != FAILED and step >= terms.armed_from_step:
                reached = factor < 1.0 or p_solid > p
                if phase == UNARMED:
                    limit = 1.0 if step == terms.armed_from_step else OFF_THE_SURFACE
                    if not reached and shear_demand(terms.solid, d, q, z) <= limit * strength(terms.solid, p_solid):
                        state.phase[i] = ARMED
                elif reached:
                    state.phase[i] = FAILED
                    state.t_f[i] = step * dt
                    state.fluid_d[i] = state.solid_d[i]
                    state.fluid_q[i] = state.solid_q[i]
                    state.fluid_z[i] = state.solid_z[i]
                    newly_failed += 1

        p, d, q, z = blended(state, terms, i)
        damp_xx, damp_yy, damp_xy = damping_stress(terms.rayleigh, state.beta[i], bulk, rate_d, rate_q, rate_z, trace)
        s = 1.0 / (new_density * new_density)
        mean = -p - 0.5 * z
        half = 0.5 * mass[i]
        internal_work += half * power(terms.correction, state, gradient, i)
        store_stress(terms.correction, pairs.correction, i, state, (mean + d + damp_xx) * s, (mean - d + damp_yy) * s, (q + damp_xy) * s)
        internal_work += half * power(terms.correction, state, gradient, i)
    state.work[INTERNAL] += internal_work * dt
    return newly_failed


@jit
def elastic_energy(state, terms, mass):  # type: ignore[no-untyped-def]
    """Energy stored in the blended stress, J/m: sum of V (p^2 / 2K + s:s / 4G)."""
    total = 0.0
    for i in range(state.x.size):
        p, d, q, z = blended(state, terms, i)
        volume = mass[i] / state.density[i]
        total += volume * (0.5 * p * p / terms.bulk_modulus + 0.25 * deviator_square(d, q, z) / terms.shear_modulus)
    return total


@jit
def cauchy_stress(state, terms, out):  # type: ignore[no-untyped-def]
    """Fill ``out`` (n, 4) with the stress xx, yy, zz, xy of Eq. 8 (Pa, tension positive)."""
    for i in range(state.x.size):
        p, d, q, z = blended(state, terms, i)
        out[i, 0] = -p - 0.5 * z + d
        out[i, 1] = -p - 0.5 * z - d
        out[i, 2] = -p + z
        out[i, 3] = q
