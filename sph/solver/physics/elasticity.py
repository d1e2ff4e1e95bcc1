"""Elastic law in rate form with an objective rate (Eqs. 10 and 11, read as stated below).

The paper prints total strain in Eq. 10 and a scalar equal to a tensor in Eq. 11.  Here the
pressure follows from the density, p = K (rho / rho_0 - 1), which is -K tr(eps), and the deviator
from 2 G times the deviatoric strain rate with the Jaumann rate.  Plane strain: the out-of-plane
deviator s_zz is kept.

A deviator is stored as (d, q, z) = ((s_xx - s_yy) / 2, s_xy, s_zz); s_xx = d - z/2 and
s_yy = -d - z/2.  A rotation changes d and q only, and their norm is the in-plane radius.
"""

from __future__ import annotations

from sph.solver.compiled.jit import jit


@jit
def pressure(bulk_modulus, density, reference_density):  # type: ignore[no-untyped-def]
    """p (Pa), compression positive, Eq. 11.

    Because it depends on the density and not on the history, soil that has been pulled apart
    carries no pressure before it has been pushed together again.
    """
    return bulk_modulus * (density / reference_density - 1.0)


@jit
def rotate(d, q, angle):  # type: ignore[no-untyped-def]
    """Turn (d, q) by the spin increment ``angle`` = 1/2 (dv_x/dy - dv_y/dx) dt.

    Midpoint form (Hughes and Winget 1980): to first order the Jaumann terms, and exact in norm.
    """
    scale = 1.0 / (1.0 + angle * angle)
    cosine = (1.0 - angle * angle) * scale
    sine = 2.0 * angle * scale
    return d * cosine + q * sine, q * cosine - d * sine


@jit
def elastic_increment(shear_modulus, d_xx, d_yy, d_xy):  # type: ignore[no-untyped-def]
    """Rate of the deviator (d, q, z) (Pa/s) for strain rates d_xx, d_yy, d_xy (1/s), d_zz = 0."""
    return (
        shear_modulus * (d_xx - d_yy),
        2.0 * shear_modulus * d_xy,
        -2.0 / 3.0 * shear_modulus * (d_xx + d_yy),
    )


@jit
def deviator_square(d, q, z):  # type: ignore[no-untyped-def]
    """s : s of a deviator (d, q, z), Pa2."""
    return 2.0 * (d * d + q * q) + 1.5 * z * z
