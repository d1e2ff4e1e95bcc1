"""The two loops over neighbours: velocity gradients, and the momentum equation (Eqs. 6 and 7).

Eq. 7 prints the kernel gradient with respect to x_j, with which compression would attract; it is
taken with respect to x_i.  With g_ij = m_j grad_i W_ij,

    L_i = 1/rho_i  sum_j (v_j - v_i) g_ij,
    a_i = sigma_i / rho_i^2 . sum_j g_ij  +  sum_j sigma_j / rho_j^2 . g_ij,

which are conjugate: the work of the forces equals that of the stresses.  The first term of a_i
needs no loop, because sum_j g_ij is kept with the pairs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sph.solver.compiled.jit import jit, rows
from sph.solver.compiled.slots import neighbours_of
from sph.solver.physics.artificial_viscosity import dissipation, viscous_acceleration
from sph.solver.physics.gradient_correction import transposed_shear
from sph.solver.physics.interface import add_unlike_gradients, add_unlike_stresses, alike_end
from sph.solver.physics.material import lightness
from sph.solver.physics.residual_viscosity import keep_residual, residual_dissipation
from sph.solver.physics.sums import ForceSums, GradientSums
from sph.solver.physics.walls import add_wall_gradient, detached

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import State, Terms


@jit
def velocity_gradients(state: State, pairs: Pairs, terms: Terms, gradient: np.ndarray, first: int, last: int) -> None:
    """Sums of (v_j - v_i) g into ``gradient`` (4, n), and the artificial viscosity's acceleration, of particles first to last."""
    viscosity, layers, interface = terms.artificial_viscosity, terms.layers, terms.interface
    vx, vy = state.vx, state.vy
    for i in rows(first, last):
        vx_i = vx[i]
        vy_i = vy[i]
        xx = xy = yx = yy = 0.0
        viscous_x = viscous_y = 0.0
        for k in neighbours_of(pairs, pairs.start[i], alike_end(interface, pairs, i)):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            dvx = vx[j] - vx_i
            dvy = vy[j] - vy_i
            xx += dvx * gx
            xy += dvx * gy
            yx += dvy * gx
            yy += dvy * gy
            strength = dissipation(viscosity, layers, i, j, dvx * gx + dvy * gy, pairs.inverse_norm[k])
            viscous_x += strength * gx
            viscous_y += strength * gy
        sums = GradientSums(xx, xy, yx, yy, viscous_x, viscous_y)
        sums = add_unlike_gradients(interface, terms, state, pairs, i, sums)
        sums = add_wall_gradient(terms.no_slip, terms.contact, state, pairs, i, sums)
        gradient[0, i], gradient[1, i], gradient[2, i], gradient[3, i] = sums.xx, sums.xy, sums.yx, sums.yy
        state.viscous_x[i] = viscous_acceleration(viscosity, sums.viscous_x) * lightness(layers, i)
        state.viscous_y[i] = viscous_acceleration(viscosity, sums.viscous_y) * lightness(layers, i)


@jit
def stress_accelerations(state: State, pairs: Pairs, terms: Terms, strain_rate: np.ndarray, first: int, last: int) -> None:
    """Acceleration of particles first to last by stress and artificial viscosity into ``state.ax``, ``state.ay``."""
    correction, viscosity, layers, interface = terms.gradient_correction, terms.residual_viscosity, terms.layers, terms.interface
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    for i in rows(first, last):
        detached_x, detached_y = detached(terms.contact, pairs, i)
        whole_x, whole_y = pairs.sum_x[i] - detached_x, pairs.sum_y[i] - detached_y
        ax = sxx[i] * whole_x + sxy[i] * whole_y
        ay = transposed_shear(correction, state, i) * whole_x + syy[i] * whole_y
        viscous_x = viscous_y = 0.0
        for k in neighbours_of(pairs, pairs.start[i], alike_end(interface, pairs, i)):
            j = pairs.neighbour[k]
            gx = pairs.gx[k]
            gy = pairs.gy[k]
            ax += sxx[j] * gx + sxy[j] * gy
            ay += transposed_shear(correction, state, j) * gx + syy[j] * gy
            strength = residual_dissipation(viscosity, layers, state, pairs, strain_rate, i, j, k)
            viscous_x += strength * gx
            viscous_y += strength * gy
        sums = add_unlike_stresses(interface, terms, state, pairs, strain_rate, i, ForceSums(ax, ay, viscous_x, viscous_y))
        keep_residual(viscosity, layers, state, i, sums.viscous_x, sums.viscous_y)
        state.ax[i] = sums.x * lightness(layers, i) + state.viscous_x[i]
        state.ay[i] = sums.y * lightness(layers, i) + state.viscous_y[i]
