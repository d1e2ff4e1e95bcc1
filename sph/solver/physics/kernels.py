"""Smoothing kernels in two dimensions (Sec. 2.1).  All end at r = 2 h."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock, entry, jit
from sph.solver.compiled.slots import slot


class CubicSpline(NamedTuple):
    """The cubic B-spline (Monaghan and Lattanzio 1985)."""

    h: float
    """smoothing length, m"""
    constant: float = 10.0 / (7.0 * math.pi)
    """W(0) h^2"""
    gradient_scale: float = 1.0
    """by which sums of gradients are multiplied; ``value_and_slope`` leaves it out"""


class WendlandC2(NamedTuple):
    """Wendland C2 (Dehnen and Aly 2012)."""

    h: float
    """smoothing length, m"""
    constant: float = 7.0 / (4.0 * math.pi)
    """W(0) h^2"""
    gradient_scale: float = 1.0
    """by which sums of gradients are multiplied; ``value_and_slope`` leaves it out"""


Kernel = CubicSpline | WendlandC2
KERNELS: dict[str, type[CubicSpline] | type[WendlandC2]] = {"cubic_spline": CubicSpline, "wendland_c2": WendlandC2}
"""Kernels by the name used in scenes; the first is that of the paper."""


def make_kernel(name: str, h: float) -> Kernel:
    """Kernel by the name used in scenes, with smoothing length h (m)."""
    return KERNELS[name](float(h))


def central_value(kernel: Kernel) -> float:
    """W(0), 1/m2, without compiling anything."""
    return kernel.constant / (kernel.h * kernel.h)


@slot
def value_and_slope(kernel: Kernel, r: float) -> tuple[float, float]:
    """W(r) (1/m2) and W'(r)/r (1/m4) at distance r (m); without branches, so that loops over pairs vectorise."""
    raise NotImplementedError


@value_and_slope.of(CubicSpline)
def _cubic_spline(kernel: CubicSpline, r: float) -> tuple[float, float]:
    h = kernel.h
    q = r / h
    far = 2.0 - q if q < 2.0 else 0.0
    near = 1.0 - q if q < 1.0 else 0.0
    scale = 10.0 / (28.0 * math.pi * h * h)
    slope = (12.0 * near * near - 3.0 * far * far) / q if q > 0.0 else -12.0
    return scale * (far * far * far - 4.0 * near * near * near), scale / (h * h) * slope


@value_and_slope.of(WendlandC2)
def _wendland_c2(kernel: WendlandC2, r: float) -> tuple[float, float]:
    h = kernel.h
    q = r / h
    rest = 1.0 - 0.5 * q if q < 2.0 else 0.0
    scale = kernel.constant / (h * h)
    cube = rest * rest * rest
    return scale * cube * rest * (1.0 + 2.0 * q), -5.0 * scale / (h * h) * cube


@entry
def evaluate(kernel: Kernel, r: float) -> tuple[float, float]:
    """Value W(r) (1/m2) and derivative over distance W'(r)/r (1/m4), scaled as sums of it are, at distance r (m).

    To be called under ``compile_lock``.
    """
    value, slope = value_and_slope(kernel, r)
    return value, kernel.gradient_scale * slope


@jit
def support(kernel: Kernel) -> float:
    """Distance at which the kernel ends, m."""
    return 2.0 * kernel.h


class Lattice(NamedTuple):
    """Neighbours of a particle on the initial lattice, m apart, and what the kernel gives them."""

    x: np.ndarray  # (neighbours,) horizontal distance, m
    volume: float  # m2
    factor: np.ndarray  # (neighbours,) W'(r)/r, 1/m4


def lattice_of(scene: Scene) -> Lattice:
    """The initial lattice of a scene."""
    return _lattice(kernel_of(scene), scene.numerics.spacing)


def _lattice(kernel: Kernel, spacing: float) -> Lattice:
    reach = int(np.ceil(2.0 * kernel.h / spacing))
    offsets = np.arange(-reach, reach + 1) * spacing
    x, y = (a.ravel() for a in np.meshgrid(offsets, offsets))
    r = np.hypot(x, y)
    x, r = x[r > 0], r[r > 0]
    with compile_lock(required=False):
        factor = np.array([evaluate(kernel, distance)[1] for distance in r])
    return Lattice(x, spacing**2, factor)


def kernel_of(scene: Scene) -> Kernel:
    """Kernel of a scene.

    Where unfailed soil is strained in its initial arrangement, gradients are scaled so that they are exact there: sums over a lattice are
    not the integrals that the kernel is normalised for (at h = 1.3 spacings they give 1 % too much strain, and 1 % too fast waves).
    """
    numerics = scene.numerics
    kernel = make_kernel(numerics.kernel, numerics.smoothing_length)
    if numerics.reference == "current":
        return kernel
    x, volume, factor = _lattice(kernel, numerics.spacing)
    return kernel._replace(gradient_scale=float(-1.0 / (volume * (factor * x * x).sum())))
