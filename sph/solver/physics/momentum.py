"""The two loops over neighbours: velocity gradients, and the momentum equation (Eqs. 6 and 7).

Eq. 7 prints the kernel gradient with respect to x_j, with which compression would attract; it is
taken with respect to x_i.  With g_ij = m_j grad_i W_ij,

    L_i = 1/rho_i  sum_j (v_j - v_i) g_ij,
    a_i = sigma_i / rho_i^2 . sum_j g_ij  +  sum_j sigma_j / rho_j^2 . g_ij,

which are conjugate: the work of the forces equals that of the stresses.  The first term of a_i
needs no loop, because sum_j g_ij is kept with the pairs.
"""

from __future__ import annotations

from sph.solver.compiled.jit import jit, rows
from sph.solver.physics.artificial_viscosity import add_dissipation, viscous_acceleration
from sph.solver.physics.gradient_correction import transposed_shear
from sph.solver.physics.interface import add_unlike_gradients, add_unlike_stresses, alike_end
from sph.solver.physics.material import lightness
from sph.solver.physics.residual_viscosity import add_residual, keep_residual
from sph.solver.physics.walls import add_wall_gradient, detached


@jit
def velocity_gradients(state, pairs, term, walls, contact, layers, interface, gradient, first, last):  # type: ignore[no-untyped-def]
    """Sums of (v_j - v_i) g into ``gradient`` (4, n), and the artificial viscosity's acceleration, of particles first to last."""
    vx, vy = state.vx, state.vy
    for i in rows(first, last):
        vx_i = vx[i]
        vy_i = vy[i]
        l_xx = l_xy = l_yx = l_yy = 0.0
        sum_x = sum_y = 0.0
        for k in range(pairs.start[i], alike_end(interface, pairs, i)):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            dvx = vx[j] - vx_i
            dvy = vy[j] - vy_i
            l_xx += dvx * gx
            l_xy += dvx * gy
            l_yx += dvy * gx
            l_yy += dvy * gy
            sum_x, sum_y = add_dissipation(term, layers, i, j, sum_x, sum_y, dvx * gx + dvy * gy, pairs.inverse_norm[k], gx, gy)
        l_xx, l_xy, l_yx, l_yy, sum_x, sum_y = add_unlike_gradients(
            interface, term, layers, state, pairs, i, l_xx, l_xy, l_yx, l_yy, sum_x, sum_y
        )
        gradient[0, i], gradient[1, i], gradient[2, i], gradient[3, i] = add_wall_gradient(
            walls, contact, state, pairs, i, vx_i, vy_i, l_xx, l_xy, l_yx, l_yy
        )
        state.viscous_x[i] = viscous_acceleration(term, sum_x) * lightness(layers, i)
        state.viscous_y[i] = viscous_acceleration(term, sum_y) * lightness(layers, i)


@jit
def stress_accelerations(state, pairs, term, contact, layers, interface, viscosity, strain_rate, first, last):  # type: ignore[no-untyped-def]
    """Acceleration of particles first to last by stress and artificial viscosity into ``state.ax``, ``state.ay``."""
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    syx = transposed_shear(term, state)
    for i in rows(first, last):
        detached_x, detached_y = detached(contact, pairs, i)
        ax = sxx[i] * (pairs.sum_x[i] - detached_x) + sxy[i] * (pairs.sum_y[i] - detached_y)
        ay = syx[i] * (pairs.sum_x[i] - detached_x) + syy[i] * (pairs.sum_y[i] - detached_y)
        sum_x = sum_y = 0.0
        for k in range(pairs.start[i], alike_end(interface, pairs, i)):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            ax += sxx[j] * gx + sxy[j] * gy
            ay += syx[j] * gx + syy[j] * gy
            sum_x, sum_y = add_residual(viscosity, layers, state, pairs, strain_rate, i, j, k, sum_x, sum_y)
        ax, ay, sum_x, sum_y = add_unlike_stresses(interface, viscosity, layers, strain_rate, state, pairs, syx, i, ax, ay, sum_x, sum_y)
        keep_residual(viscosity, layers, state, i, sum_x, sum_y)
        state.ax[i] = ax * lightness(layers, i) + state.viscous_x[i]
        state.ay[i] = ay * lightness(layers, i) + state.viscous_y[i]
