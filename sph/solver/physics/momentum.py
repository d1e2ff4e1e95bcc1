"""The two loops over neighbours: velocity gradients, and the momentum equation (Eqs. 6 and 7).

Eq. 7 prints the kernel gradient with respect to x_j, with which compression would attract; it is
taken with respect to x_i.  With g_ij = m_j grad_i W_ij,

    L_i = 1/rho_i  sum_j (v_j - v_i) g_ij,
    a_i = sigma_i / rho_i^2 . sum_j g_ij  +  sum_j sigma_j / rho_j^2 . g_ij,

which are conjugate: the work of the forces equals that of the stresses.  The first term of a_i
needs no loop, because sum_j g_ij is kept with the pairs.
"""

from __future__ import annotations

import math

from sph.solver.compiled.jit import jit, rows
from sph.solver.neighbours import wrap
from sph.solver.physics.material import lightness, mean_impedance


@jit
def _dissipation(term, layers, i, j, sum_x, sum_y, opening, inverse_norm, gx, gy):  # type: ignore[no-untyped-def]
    """Add one pair's artificial viscosity; only approaching pairs (opening < 0) dissipate."""
    if term is None:
        return sum_x, sum_y
    else:
        strength = mean_impedance(layers, i, j, min(opening, 0.0) * inverse_norm)
        return sum_x + strength * gx, sum_y + strength * gy


@jit
def _scale(term, value):  # type: ignore[no-untyped-def]
    if term is None:
        return 0.0
    else:
        return term.speed * value


@jit
def velocity_gradients(state, pairs, term, layers, gradient, first, last):  # type: ignore[no-untyped-def]
    """Sums of (v_j - v_i) g into ``gradient`` (4, n), and the artificial viscosity's acceleration, of particles first to last.

    Artificial viscosity in the signal-speed form of Monaghan (1997): it acts along the line between
    two approaching particles, with alpha V_p times their approach speed.
    """
    vx, vy = state.vx, state.vy
    for i in rows(first, last):
        vx_i = vx[i]
        vy_i = vy[i]
        l_xx = l_xy = l_yx = l_yy = 0.0
        sum_x = sum_y = 0.0
        for k in range(pairs.start[i], pairs.end[i]):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            dvx = vx[j] - vx_i
            dvy = vy[j] - vy_i
            l_xx += dvx * gx
            l_xy += dvx * gy
            l_yx += dvy * gx
            l_yy += dvy * gy
            sum_x, sum_y = _dissipation(term, layers, i, j, sum_x, sum_y, dvx * gx + dvy * gy, pairs.inverse_norm[k], gx, gy)
        gradient[0, i] = l_xx
        gradient[1, i] = l_xy
        gradient[2, i] = l_yx
        gradient[3, i] = l_yy
        state.viscous_x[i] = _scale(term, sum_x) * lightness(layers, i)
        state.viscous_y[i] = _scale(term, sum_y) * lightness(layers, i)


@jit
def transposed_shear(term, state):  # type: ignore[no-untyped-def]
    """yx component of the stress of the momentum equation; without correction it is symmetric."""
    if term is None:
        return state.sxy
    else:
        return state.syx


@jit
def stress_accelerations(state, pairs, term, layers, first, last):  # type: ignore[no-untyped-def]
    """Acceleration of particles first to last by stress and artificial viscosity into ``state.ax``, ``state.ay``."""
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    syx = transposed_shear(term, state)
    for i in rows(first, last):
        ax = sxx[i] * pairs.sum_x[i] + sxy[i] * pairs.sum_y[i]
        ay = syx[i] * pairs.sum_x[i] + syy[i] * pairs.sum_y[i]
        for k in range(pairs.start[i], pairs.end[i]):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            ax += sxx[j] * gx + sxy[j] * gy
            ay += syx[j] * gx + syy[j] * gy
        state.ax[i] = ax * lightness(layers, i) + state.viscous_x[i]
        state.ay[i] = ay * lightness(layers, i) + state.viscous_y[i]


@jit
def add_repulsion(term, period, state, pairs, mass, n_moving, first, last):  # type: ignore[no-untyped-def]
    """Add the short-range repulsion's acceleration to particles first to last; returns the energy it stores in them, J/m.

    A linear spring that pushes once two particles are nearer than its range; a lattice at its
    initial spacing does not feel it.  It is conservative and cures pairing, where the gradient of
    the cubic spline fades at short distance.  What moves shares a spring's energy with what moves, and has that with what stands still.
    """
    if term is None:
        return 0.0
    else:
        energy = 0.0
        for i in rows(first, last):
            for k in range(pairs.start[i], pairs.close_end[i]):
                j = pairs.close[k]
                dx = wrap(period, state.x[i] - state.x[j])
                dy = state.y[i] - state.y[j]
                r = math.sqrt(dx * dx + dy * dy)
                if 0.0 < r < term.range:
                    overlap = term.range - r
                    force = term.stiffness * overlap / r
                    energy += (0.25 if j < n_moving else 0.5) * term.stiffness * overlap * overlap
                    state.ax[i] += force * dx / mass[i]
                    state.ay[i] += force * dy / mass[i]
        return energy


@jit
def set_artificial_stress(term, state, first, last):  # type: ignore[no-untyped-def]
    """Artificial stress of particles first to last: minus a share of each principal tension (Gray, Monaghan and Swift 2001)."""
    if term is None:
        return
    else:
        for i in rows(first, last):
            mean = 0.5 * (state.sxx[i] + state.syy[i])
            d = 0.5 * (state.sxx[i] - state.syy[i])
            q = state.sxy[i]
            radius = math.sqrt(d * d + q * q)
            first_principal = -term.factor * max(mean + radius, 0.0)
            second_principal = -term.factor * max(mean - radius, 0.0)
            middle, half = 0.5 * (first_principal + second_principal), 0.5 * (first_principal - second_principal)
            cosine, sine = (d / radius, q / radius) if radius > 0.0 else (1.0, 0.0)
            state.tension_xx[i] = middle + half * cosine
            state.tension_yy[i] = middle - half * cosine
            state.tension_xy[i] = half * sine


@jit
def add_artificial_stress(term, layers, state, pairs, first, last):  # type: ignore[no-untyped-def]
    """Add the artificial stress' acceleration to particles first to last; equal and opposite for a pair."""
    if term is None:
        return
    else:
        for i in rows(first, last):
            ax = ay = 0.0
            for k in range(pairs.start[i], pairs.end[i]):
                j = pairs.neighbour[k]
                xy = state.tension_xy[i] + state.tension_xy[j]
                ax += pairs.nearness[k] * ((state.tension_xx[i] + state.tension_xx[j]) * pairs.gx[k] + xy * pairs.gy[k])
                ay += pairs.nearness[k] * (xy * pairs.gx[k] + (state.tension_yy[i] + state.tension_yy[j]) * pairs.gy[k])
            ax *= lightness(layers, i)
            ay *= lightness(layers, i)
            state.viscous_x[i] += ax
            state.viscous_y[i] += ay
            state.ax[i] += ax
            state.ay[i] += ay
