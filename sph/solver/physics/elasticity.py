"""Elastic law in rate form with an objective rate (Eqs. 10 and 11, read as stated below).

The paper prints total strain in Eq. 10 and a scalar equal to a tensor in Eq. 11.  Here the
pressure follows from the density, p = K (rho / rho_0 - 1), which is -K tr(eps), and the deviator
from 2 G times the deviatoric strain rate with the Jaumann rate.  Plane strain: the out-of-plane
deviator s_zz is kept.

A rotation changes the in-plane part of a deviator only, and not its norm, the in-plane radius.
"""

from __future__ import annotations

from typing import NamedTuple

from sph.solver.compiled.jit import jit


class Deviator(NamedTuple):
    """Deviatoric stress s in plane strain, Pa: s_xx = diff - zz / 2, s_yy = -diff - zz / 2."""

    diff: float
    """(s_xx - s_yy) / 2"""
    xy: float
    zz: float
    """out of the plane"""


class Strain(NamedTuple):
    """What the velocity gradient does to a particle in a step."""

    xx: float
    """strain rates, 1/s"""
    yy: float
    xy: float
    spin: float
    """increment, 1/2 (dv_x/dy - dv_y/dx) dt"""
    dt: float
    """s"""


@jit
def pressure(bulk_modulus: float, density: float, reference_density: float) -> float:
    """p (Pa), compression positive, Eq. 11.

    Because it depends on the density and not on the history, soil that has been pulled apart
    carries no pressure before it has been pushed together again.
    """
    return bulk_modulus * (density / reference_density - 1.0)


@jit
def rotate(s: Deviator, angle: float) -> Deviator:
    """Turn a deviator by the spin increment ``angle``.

    Midpoint form (Hughes and Winget 1980): to first order the Jaumann terms, and exact in norm.
    """
    scale = 1.0 / (1.0 + angle * angle)
    cosine = (1.0 - angle * angle) * scale
    sine = 2.0 * angle * scale
    return Deviator(s.diff * cosine + s.xy * sine, s.xy * cosine - s.diff * sine, s.zz)


@jit
def elastic_rate(shear_modulus: float, strain: Strain) -> Deviator:
    """Rate of the deviator (Pa/s) for the rates of a plane strain, without that of its spin."""
    return Deviator(
        shear_modulus * (strain.xx - strain.yy),
        2.0 * shear_modulus * strain.xy,
        -2.0 / 3.0 * shear_modulus * (strain.xx + strain.yy),
    )


@jit
def strained(s: Deviator, rate: Deviator, strain: Strain) -> Deviator:
    """Deviator after a step: turned by the spin, then changed at an elastic ``rate`` (Pa/s)."""
    turned = rotate(s, strain.spin)
    return Deviator(turned.diff + rate.diff * strain.dt, turned.xy + rate.xy * strain.dt, turned.zz + rate.zz * strain.dt)


@jit
def scaled(s: Deviator, factor: float) -> Deviator:
    """A deviator times a number."""
    return Deviator(s.diff * factor, s.xy * factor, s.zz * factor)


@jit
def deviator_square(s: Deviator) -> float:
    """s : s, Pa2."""
    return 2.0 * (s.diff * s.diff + s.xy * s.xy) + 1.5 * s.zz * s.zz
