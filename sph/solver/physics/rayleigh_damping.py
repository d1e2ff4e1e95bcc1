"""Rayleigh damping (Sec. 2.5): alpha on the velocity and beta_R on the rate of the elastic stress, both times beta."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Damping, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel, Lattice

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator


class RayleighDamping(NamedTuple):
    """Coefficients of the term."""

    mass: float
    """alpha, 1/s"""
    stiffness: float
    """beta_R, s"""


@slot
def mass_damping(damping: RayleighDamping | None) -> float:
    """Rate of the mass-proportional part, 1/s."""
    return 0.0


@mass_damping.of(RayleighDamping)
def _mass_damping(damping: RayleighDamping) -> float:
    return damping.mass


@slot
def stiffness_damping(damping: RayleighDamping | None) -> float:
    """Time of the stiffness-proportional part, s."""
    return 0.0


@stiffness_damping.of(RayleighDamping)
def _stiffness_damping(damping: RayleighDamping) -> float:
    return damping.stiffness


@slot
def damping_stress(
    damping: RayleighDamping | None, beta: float, bulk_modulus: float, rate: Deviator, trace: float
) -> tuple[float, float, float]:
    """Stiffness-proportional damping: (xx, yy, xy) of beta beta_R times the elastic stress rate, Pa.

    The rate is that of a deviator (Pa/s) and of a volume, whose strain rate is ``trace`` (1/s).
    """
    return 0.0, 0.0, 0.0


@damping_stress.of(RayleighDamping)
def _damping_stress(damping: RayleighDamping, beta: float, bulk_modulus: float, rate: Deviator, trace: float) -> tuple[float, float, float]:
    scale = beta * damping.stiffness
    mean = bulk_modulus * trace - 0.5 * rate.zz
    return scale * (mean + rate.diff), scale * (mean - rate.diff), scale * rate.xy


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> RayleighDamping:
    assert scene.damping is not None
    return RayleighDamping(scene.damping.mass_coefficient, scene.damping.stiffness_coefficient)


def _damping(scene: Scene, lattice: Lattice, omega: float) -> Damping:
    assert scene.damping is not None
    beta = scene.damping.stiffness_coefficient
    return Damping(beta * omega, "stiffness damping", f"beta_R = {beta:.3g} s")


TERM = Term("rayleigh_damping", "damping (Sec. 2.5)", lambda scene: scene.damping is not None, _make, damping=_damping)
