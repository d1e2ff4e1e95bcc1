"""Smoothing kernels in two dimensions (Sec. 2.1).  Both end at r = 2 h."""

from __future__ import annotations

import math
from typing import NamedTuple

from sph.solver.compiled.jit import entry, jit


class WendlandTerm(NamedTuple):
    """Wendland C2 in place of the cubic spline (Dehnen and Aly 2012)."""

    constant: float
    """7 / (4 pi), the kernel's normalisation times h squared"""


class Kernel(NamedTuple):
    """A smoothing kernel: the cubic B-spline (Monaghan and Lattanzio 1985) unless told otherwise."""

    h: float
    """smoothing length, m"""
    wendland_c2: WendlandTerm | None


def make_kernel(name: str, h: float) -> Kernel:
    """Kernel by the name used in scenes, with smoothing length h (m)."""
    return Kernel(float(h), WendlandTerm(7.0 / (4.0 * math.pi)) if name == "wendland_c2" else None)


def central_value(kernel: Kernel) -> float:
    """W(0), 1/m2, without compiling anything."""
    constant = 10.0 / (7.0 * math.pi) if kernel.wendland_c2 is None else kernel.wendland_c2.constant
    return constant / (kernel.h * kernel.h)


@jit
def _cubic_spline(h, r):  # type: ignore[no-untyped-def]
    """W (1/m2) and W'/r (1/m4); without branches, so that loops over pairs vectorise."""
    q = r / h
    far = 2.0 - q if q < 2.0 else 0.0
    near = 1.0 - q if q < 1.0 else 0.0
    scale = 10.0 / (28.0 * math.pi * h * h)
    slope = (12.0 * near * near - 3.0 * far * far) / q if q > 0.0 else -12.0
    return scale * (far * far * far - 4.0 * near * near * near), scale / (h * h) * slope


@jit
def _wendland_c2(term, h, r):  # type: ignore[no-untyped-def]
    """W (1/m2) and W'/r (1/m4)."""
    q = r / h
    rest = 1.0 - 0.5 * q if q < 2.0 else 0.0
    scale = term.constant / (h * h)
    cube = rest * rest * rest
    return scale * cube * rest * (1.0 + 2.0 * q), -5.0 * scale / (h * h) * cube


@jit
def _evaluate(wendland_c2, h, r):  # type: ignore[no-untyped-def]
    if wendland_c2 is None:
        return _cubic_spline(h, r)
    else:
        return _wendland_c2(wendland_c2, h, r)


@entry
def evaluate(kernel, r):  # type: ignore[no-untyped-def]
    """Value W(r) (1/m2) and derivative over distance W'(r)/r (1/m4) at distance r (m)."""
    return _evaluate(kernel.wendland_c2, kernel.h, r)


@jit
def support(kernel):  # type: ignore[no-untyped-def]
    """Distance at which the kernel ends, m."""
    return 2.0 * kernel.h
