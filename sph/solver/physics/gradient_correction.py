"""Gradient correction: velocity gradients that are exact for linear fields, and forces conjugate to them.

The correction of a particle is the inverse of its moment matrix sum_j g_ij (x_j - x_i) / rho_i, kept with the pairs as its xx, xy and yy.
"""

from __future__ import annotations

from typing import NamedTuple

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel


class GradientCorrection(NamedTuple):
    """Coefficients of the term."""

    min_determinant: float


@jit
def invert(term, residual_viscosity, density, m_xx, m_xy, m_yy):  # type: ignore[no-untyped-def]
    """Inverse of the moment matrix over density for the terms that use it; the identity without them or where it is too singular."""
    if term is None:
        return _invert(residual_viscosity, density, m_xx, m_xy, m_yy)
    else:
        return _invert(term, density, m_xx, m_xy, m_yy)


@jit
def _invert(term, density, m_xx, m_xy, m_yy):  # type: ignore[no-untyped-def]
    if term is None:
        return 1.0, 0.0, 1.0
    else:
        determinant = m_xx * m_yy - m_xy * m_xy
        if determinant < term.min_determinant * density * density:
            return 1.0, 0.0, 1.0
        s = density / determinant
        return m_yy * s, -m_xy * s, m_xx * s


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
def transposed_shear(term, state):  # type: ignore[no-untyped-def]
    """yx component of the stress of the momentum equation; without correction it is symmetric."""
    if term is None:
        return state.sxy
    else:
        return state.syx


@jit
def power(term, state, gradient, i):  # type: ignore[no-untyped-def]
    """Power of the momentum equation's stress on the plain gradient sums, W/kg: conjugate to the forces."""
    syx = state.sxy[i] if term is None else state.syx[i]
    return state.sxx[i] * gradient[0, i] + state.sxy[i] * gradient[1, i] + syx * gradient[2, i] + state.syy[i] * gradient[3, i]


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> GradientCorrection:
    assert scene.numerics.gradient_correction is not None
    return GradientCorrection(float(scene.numerics.gradient_correction.min_determinant))


TERM = Term("gradient_correction", "numerics.gradient_correction", lambda scene: scene.numerics.gradient_correction is not None, _make)
