"""Periodic sides: what leaves the box on one side comes in on the other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel


class Periodic(NamedTuple):
    """Coefficients of the term."""

    length: float
    """m"""


@jit
def wrap(period, dx):  # type: ignore[no-untyped-def]
    """Horizontal distance to the nearest image of a neighbour, m."""
    if period is None:
        return dx
    else:
        return dx - period.length * math.floor(dx / period.length + 0.5)


@jit
def columns_of_cells(period, x, reach):  # type: ignore[no-untyped-def]
    """Left end (m), width (m) and number of the columns of cells; of a period as many as fill it."""
    if period is None:
        x_min = x.min()
        return x_min, reach, np.int64((x.max() - x_min) / reach) + 1
    else:
        count = np.int64(period.length / reach)
        return 0.0, period.length / count, count


@jit
def column_of(period, x, x_min, width, columns):  # type: ignore[no-untyped-def]
    """Column of cells in which x lies."""
    if period is None:
        return np.int64((x - x_min) / width)
    else:
        return min(np.int64((x - period.length * math.floor(x / period.length)) / width), columns - 1)


@jit
def columns_around(period, column, columns):  # type: ignore[no-untyped-def]
    """First and last column to look at, each once; on periodic sides to be taken modulo their number."""
    if period is None:
        return max(column - 1, 0), min(column + 2, columns)
    else:
        return column - 1, column - 1 + min(columns, 3)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Periodic:
    dx = scene.numerics.spacing
    return Periodic(round(scene.geometry.width / dx) * dx)


TERM = Term("periodic", "walls.sides", lambda scene: scene.walls.kinds.sides.periodic, _make)
