"""Gradient correction: velocity gradients that are exact for linear fields, and forces conjugate to them.

The correction of a particle is the inverse of its moment matrix sum_j g_ij (x_j - x_i) / rho_i, kept with the pairs as its xx, xy and yy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.residual_viscosity import ResidualViscosity
    from sph.solver.terms import State


class GradientCorrection(NamedTuple):
    """Coefficients of the term."""

    min_determinant: float


@slot
def either(correction: GradientCorrection | None, other: Any) -> Any:
    """The correction where there is one, else another term."""
    return other


@either.of(GradientCorrection)
def _either(correction: GradientCorrection, other: Any) -> Any:
    return correction


class Sums(NamedTuple):
    """Sums over the pairs of a particle."""

    x: float
    """of g, kg/m4"""
    y: float
    m_xx: float
    """moments, of g times the vector to the neighbour, kg/m3"""
    m_xy: float
    m_yy: float


@slot
def invert(correction: GradientCorrection | None, density: float, sums: Sums) -> tuple[float, float, float]:
    """Inverse (xx, xy, yy) of the moment matrix over density for a term that uses it.

    The identity without one, or where the matrix is too singular.
    """
    return 1.0, 0.0, 1.0


@invert.of(GradientCorrection)
def inverse(correction: GradientCorrection, density: float, sums: Sums) -> tuple[float, float, float]:
    """That for the record of a term."""
    m_xx, m_xy, m_yy = sums.m_xx, sums.m_xy, sums.m_yy
    determinant = m_xx * m_yy - m_xy * m_xy
    if determinant < correction.min_determinant * density * density:
        return 1.0, 0.0, 1.0
    s = density / determinant
    return m_yy * s, -m_xy * s, m_xx * s


@slot
def correct_gradient(
    correction: GradientCorrection | None, b: np.ndarray, i: int, l_xx: float, l_xy: float, l_yx: float, l_yy: float
) -> tuple[float, float, float, float]:
    """Velocity gradient exact for linear fields, by a term that uses it: L times the correction matrix."""
    return l_xx, l_xy, l_yx, l_yy


@correct_gradient.of(GradientCorrection)
def corrected(
    correction: GradientCorrection, b: np.ndarray, i: int, l_xx: float, l_xy: float, l_yx: float, l_yy: float
) -> tuple[float, float, float, float]:
    """That for the record of a term."""
    return (
        l_xx * b[i, 0] + l_xy * b[i, 1],
        l_xx * b[i, 1] + l_xy * b[i, 2],
        l_yx * b[i, 0] + l_yy * b[i, 1],
        l_yx * b[i, 1] + l_yy * b[i, 2],
    )


@jit
def velocity_gradient(
    correction: GradientCorrection | ResidualViscosity | None, pairs: Pairs, density: np.ndarray, gradient: np.ndarray, i: int
) -> float:
    """Velocity gradient (xx, xy, yx, yy) of particle i, 1/s, from sums over its pairs."""
    s = 1.0 / density[i]
    return correct_gradient(correction, pairs.correction, i, gradient[0, i] * s, gradient[1, i] * s, gradient[2, i] * s, gradient[3, i] * s)


@slot
def store_stress(correction: GradientCorrection | None, b: np.ndarray, i: int, state: State, sxx: float, syy: float, sxy: float) -> None:
    """Stress for the momentum equation, times the correction matrix where that is on."""
    state.sxx[i] = sxx
    state.syy[i] = syy
    state.sxy[i] = sxy


@store_stress.of(GradientCorrection)
def _store_stress(correction: GradientCorrection, b: np.ndarray, i: int, state: State, sxx: float, syy: float, sxy: float) -> None:
    state.sxx[i] = sxx * b[i, 0] + sxy * b[i, 1]
    state.sxy[i] = sxx * b[i, 1] + sxy * b[i, 2]
    state.syx[i] = sxy * b[i, 0] + syy * b[i, 1]
    state.syy[i] = sxy * b[i, 1] + syy * b[i, 2]


@slot
def transposed_shear(correction: GradientCorrection | None, state: State, i: int) -> float:
    """yx component of particle i's stress in the momentum equation; without correction it is symmetric."""
    return state.sxy[i]


@transposed_shear.of(GradientCorrection)
def _transposed_shear(correction: GradientCorrection, state: State, i: int) -> float:
    return state.syx[i]


@jit
def power(correction: GradientCorrection | ResidualViscosity | None, state: State, gradient: np.ndarray, i: int) -> float:
    """Power of the momentum equation's stress on the plain gradient sums, W/kg: conjugate to the forces."""
    syx = transposed_shear(correction, state, i)
    return state.sxx[i] * gradient[0, i] + state.sxy[i] * gradient[1, i] + syx * gradient[2, i] + state.syy[i] * gradient[3, i]


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> GradientCorrection:
    assert scene.numerics.gradient_correction is not None
    return GradientCorrection(float(scene.numerics.gradient_correction.min_determinant))


TERM = Term(
    "gradient_correction",
    "numerics.gradient_correction",
    lambda scene: scene.numerics.gradient_correction is not None,
    _make,
    in_pairs=True,
)
