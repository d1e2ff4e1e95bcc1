"""Mohr-Coulomb surface in plane strain, for both states (Sec. 2.3, Eqs. 14 and 15).

In the plane: radius <= c cos(phi) + p_plane sin(phi) with p_plane = -(s_xx + s_yy) / 2 = p + s_zz / 2,
where p is the mean pressure and s_zz the out-of-plane deviator.  The return keeps the pressure and the
direction of the deviator (no dilation); since s_zz shrinks with the deviator, the factor solves

    f (radius - s_zz/2 sin(phi)) = c cos(phi) + p sin(phi).

In tension the surface ends at its apex, p = -c cot(phi).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.solver.compiled.slots import with_numbers
from sph.solver.physics.yield_surface import limit_tension, shear_demand, strength

if TYPE_CHECKING:
    from sph.solver.physics.elasticity import Deviator


class MohrCoulomb(NamedTuple):
    """Strength of one state."""

    cohesion_term: float
    """c cos(phi), Pa"""
    sine: float
    """sin(phi)"""
    tension_limit: float
    """largest mean tension, Pa"""


def make_mohr_coulomb(cohesion: float, friction_angle: float, tension_limit: float | None = None) -> MohrCoulomb:
    """Surface from c (Pa), phi (rad) and, below the apex, an optional cut-off in tension (Pa)."""
    sine = math.sin(friction_angle)
    apex = math.inf
    if cohesion == 0:
        apex = 0.0
    elif sine > 0:
        apex = cohesion * math.cos(friction_angle) / sine
    limit = apex if tension_limit is None else min(apex, tension_limit)
    return MohrCoulomb(float(cohesion * math.cos(friction_angle)), float(sine), float(limit))


@limit_tension.of(MohrCoulomb)
def _limit_tension(surface: MohrCoulomb, p: float) -> float:
    return max(p, -surface.tension_limit)


@strength.of(MohrCoulomb)
def _strength(surface: MohrCoulomb, p: float) -> float:
    """c cos(phi) + p sin(phi)."""
    return max(surface.cohesion_term + p * surface.sine, 0.0)


@shear_demand.of(MohrCoulomb)
def _shear_demand(surface: MohrCoulomb, s: Deviator) -> float:
    """Radius - s_zz/2 sin(phi)."""
    return math.sqrt(s.diff * s.diff + s.xy * s.xy) - 0.5 * s.zz * surface.sine


@with_numbers.of(MohrCoulomb)
def _with_numbers(record: MohrCoulomb, table: np.ndarray, k: int, first: int) -> Any:
    return MohrCoulomb(table[k, first], table[k, first + 1], table[k, first + 2])
