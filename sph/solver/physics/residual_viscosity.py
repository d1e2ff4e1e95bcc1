"""Artificial viscosity with linear reconstruction: it leaves linear motion alone.

What the plain form damps is all of the approach of two particles, smooth strain as well.  Here the part that the strain rates around them
explain is taken off first,

    u = (v_j - v_i) . n,   u' = u - r n . (d_i + d_j) / 2 . n,

with n from i to j at the distance r and strain rates d that are exact for linear fields.  What dissipates is the one nearer to zero if
both approach, and nothing otherwise (minmod), so that a pair never gains energy.  Velocities that alternate from row to row, which the sums
over neighbours do not see, are left over whole, and so is the noise of disordered particles.  Reconstruction of the velocities in the
artificial viscosity: Frontiere, Raskin and Owen (2017), Rosswog (2020).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import rows
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics import artificial_viscosity
from sph.solver.physics.gradient_correction import correct_gradient, corrected, inverse, invert, velocity_gradient
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.material import lightness, mean_impedance

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.material import Layers
    from sph.solver.terms import State


class ResidualViscosity(NamedTuple):
    """Coefficients of the term."""

    speed: float
    """alpha V_p over the reference density, m4/(s kg)"""
    min_determinant: float
    """of the moment matrix below which strain rates are not corrected"""


invert.of(ResidualViscosity)(inverse)
correct_gradient.of(ResidualViscosity)(corrected)
MIN_DETERMINANT = 0.1
"""Beside a straight free surface it is 0.3 to 0.5; below, at corners and in scattered debris, corrections grow beyond all bounds."""


@slot
def keep_distance(viscosity: ResidualViscosity | None, distance: np.ndarray, k: int, r: float) -> None:
    """Keep the distance of pair k, m."""


@keep_distance.of(ResidualViscosity)
def _keep_distance(viscosity: ResidualViscosity, distance: np.ndarray, k: int, r: float) -> None:
    distance[k] = r


@slot
def keep_strain_rate(
    viscosity: ResidualViscosity | None,
    pairs: Pairs,
    density: np.ndarray,
    gradient: np.ndarray,
    strain_rate: np.ndarray,
    first: int,
    last: int,
) -> None:
    """Strain rates of particles first to last into ``strain_rate`` (3, n): xx, yy and twice xy, 1/s."""


@keep_strain_rate.of(ResidualViscosity)
def _keep_strain_rate(
    viscosity: ResidualViscosity, pairs: Pairs, density: np.ndarray, gradient: np.ndarray, strain_rate: np.ndarray, first: int, last: int
) -> None:
    for i in rows(first, last):
        l_xx, l_xy, l_yx, l_yy = velocity_gradient(viscosity, pairs, density, gradient, i)
        strain_rate[0, i] = l_xx
        strain_rate[1, i] = l_yy
        strain_rate[2, i] = l_xy + l_yx


@slot
def residual_dissipation(
    viscosity: ResidualViscosity | None, layers: Layers | None, state: State, pairs: Pairs, strain_rate: np.ndarray, i: int, j: int, k: int
) -> float:
    """What pair k, of particles i and j, adds to the sum for the viscosity of i, over its g."""
    return 0.0


@residual_dissipation.of(ResidualViscosity)
def _residual_dissipation(
    viscosity: ResidualViscosity, layers: Layers | None, state: State, pairs: Pairs, strain_rate: np.ndarray, i: int, j: int, k: int
) -> float:
    gx, gy = pairs.gx[k], pairs.gy[k]
    inverse_norm = pairs.inverse_norm[k]
    opening = (state.vx[j] - state.vx[i]) * gx + (state.vy[j] - state.vy[i]) * gy
    explained = (strain_rate[0, i] + strain_rate[0, j]) * gx * gx + (strain_rate[1, i] + strain_rate[1, j]) * gy * gy
    explained += (strain_rate[2, i] + strain_rate[2, j]) * gx * gy
    left = opening - 0.5 * pairs.distance[k] * inverse_norm * explained
    return mean_impedance(layers, i, j, min(max(opening, left), 0.0) * inverse_norm)


@slot
def keep_residual(viscosity: ResidualViscosity | None, layers: Layers | None, state: State, i: int, sum_x: float, sum_y: float) -> None:
    """Keep the acceleration of the sums of particle i, m/s2."""


@keep_residual.of(ResidualViscosity)
def _keep_residual(viscosity: ResidualViscosity, layers: Layers | None, state: State, i: int, sum_x: float, sum_y: float) -> None:
    state.viscous_x[i] = viscosity.speed * sum_x * lightness(layers, i)
    state.viscous_y[i] = viscosity.speed * sum_y * lightness(layers, i)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> ResidualViscosity:
    return ResidualViscosity(artificial_viscosity.coefficient(scene), MIN_DETERMINANT)


class ResidualPairs(NamedTuple):
    """What the term keeps with the pairs."""

    distance: np.ndarray  # (m,) m


def _room(n: int, size: int, dtype: np.dtype[Any]) -> ResidualPairs:
    return ResidualPairs(np.empty(size, dtype))


TERM = Term(
    "residual_viscosity",
    "numerics.artificial_viscosity.reconstruction: leaves linear motion alone",
    lambda scene: scene.numerics.artificial_viscosity is not None and scene.numerics.artificial_viscosity.reconstruction == "linear",
    _make,
    damping=artificial_viscosity.damping,
    in_pairs=True,
    pairs=Arrays(ResidualPairs, _room),
)
