"""A velocity gradient that the soil is made to follow, for tests of the material."""

from __future__ import annotations

from typing import NamedTuple

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel


class PrescribedMotion(NamedTuple):
    """Velocity gradient, 1/s."""

    xx: float
    xy: float
    yx: float
    yy: float


@slot
def drive(motion: PrescribedMotion | None, x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
    """Velocity of a particle in the prescribed motion; without one as it is."""
    return vx, vy


@drive.of(PrescribedMotion)
def _drive(motion: PrescribedMotion, x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
    return motion.xx * x + motion.xy * y, motion.yx * x + motion.yy * y


def stopped(motion: PrescribedMotion | None) -> PrescribedMotion | None:
    """The motion with the velocity zero everywhere; None without one."""
    return None if motion is None else PrescribedMotion(0.0, 0.0, 0.0, 0.0)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> PrescribedMotion:
    driven, turn = scene.prescribed_velocity_gradient, scene.geometry.direction
    assert driven is not None
    return PrescribedMotion(driven.xx, turn * driven.xy, turn * driven.yx, driven.yy)


TERM = Term("prescribed_motion", "prescribed_velocity_gradient", lambda scene: scene.prescribed_velocity_gradient is not None, _make)
