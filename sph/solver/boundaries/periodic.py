"""Periodic sides: what leaves the box on one side comes in on the other."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.walls import wrap


class Periodic(NamedTuple):
    """Coefficients of the term."""

    length: float
    """m"""


@wrap.of(Periodic)
def _wrap(period: Periodic, dx: float) -> float:
    return dx - period.length * math.floor(dx / period.length + 0.5)


def columns_of_cells(period: Periodic | None, x: np.ndarray, reach: float) -> tuple[np.ndarray, int]:
    """Column of cells in which each x (n,) lies, and the number of columns; they are ``reach`` (m) wide, or as many as fill a period."""
    if period is None:
        x_min = x.min()
        return ((x - x_min) / reach).astype(np.int64), int((x.max() - x_min) / reach) + 1
    columns = int(period.length / reach)
    inside = x - period.length * np.floor(x / period.length)
    return np.minimum((inside / (period.length / columns)).astype(np.int64), columns - 1), columns


@slot
def columns_around(period: Periodic | None, column: int, columns: int) -> tuple[int, int]:
    """First and last column to look at, each once; on periodic sides to be taken modulo their number."""
    return max(column - 1, 0), min(column + 2, columns)


@columns_around.of(Periodic)
def _columns_around(period: Periodic, column: int, columns: int) -> tuple[int, int]:
    return column - 1, column - 1 + min(columns, 3)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Periodic:
    dx = scene.numerics.spacing
    return Periodic(round(scene.geometry.width / dx) * dx)


TERM = Term("periodic", "walls.sides", lambda scene: scene.walls.kinds.sides.periodic, _make, in_pairs=True)
