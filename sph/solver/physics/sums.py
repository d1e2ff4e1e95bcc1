"""Sums over the neighbours of a particle, as the terms hand them on to each other."""

from __future__ import annotations

from typing import NamedTuple


class GradientSums(NamedTuple):
    """Sums over the neighbours of a particle: (v_j - v_i) g_ij, and artificial viscosity."""

    xx: float
    xy: float
    """of dv_x times g_y"""
    yx: float
    yy: float
    viscous_x: float
    viscous_y: float


class ForceSums(NamedTuple):
    """Sums over the neighbours of a particle: stress times g_ij, and viscosity with linear reconstruction."""

    x: float
    y: float
    viscous_x: float
    viscous_y: float
