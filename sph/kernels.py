"""Smoothing kernels in two dimensions (Sec. 2.1).  Both end at r = 2 h."""

from __future__ import annotations

import math
from typing import NamedTuple

from sph.jit import jit


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


@jit
def _cubic_spline(h, r):  # type: ignore[no-untyped-def]
    """W (1/m2) and W'/r (1/m4)."""
    q = r / h
    sigma = 10.0 / (7.0 * math.pi * h * h)
    if q < 1.0:
        return sigma * (1.0 - 1.5 * q * q + 0.75 * q * q * q), sigma / (h * h) * (2.25 * q - 3.0)
    if q < 2.0:
        rest = 2.0 - q
        return 0.25 * sigma * rest * rest * rest, -0.75 * sigma * rest * rest / (h * h * q)
    return 0.0, 0.0


@jit
def _wendland_c2(term, h, r):  # type: ignore[no-untyped-def]
    """W (1/m2) and W'/r (1/m4)."""
    q = r / h
    if q < 2.0:
        sigma = term.constant / (h * h)
        rest = 1.0 - 0.5 * q
        cube = rest * rest * rest
        return sigma * cube * rest * (1.0 + 2.0 * q), -5.0 * sigma / (h * h) * cube
    return 0.0, 0.0


@jit
def _evaluate(wendland_c2, h, r):  # type: ignore[no-untyped-def]
    if wendland_c2 is None:
        return _cubic_spline(h, r)
    else:
        return _wendland_c2(wendland_c2, h, r)


@jit
def evaluate(kernel, r):  # type: ignore[no-untyped-def]
    """Value W(r) (1/m2) and derivative over distance W'(r)/r (1/m4) at distance r (m)."""
    return _evaluate(kernel.wendland_c2, kernel.h, r)


@jit
def support(kernel):  # type: ignore[no-untyped-def]
    """Distance at which the kernel ends, m."""
    return 2.0 * kernel.h
