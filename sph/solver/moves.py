"""How far particles have moved."""

from __future__ import annotations

import numpy as np

from sph.solver.compiled.jit import jit, rows


@jit
def largest_move(x: np.ndarray, y: np.ndarray, x_ref: np.ndarray, y_ref: np.ndarray, first: int, last: int) -> float:
    """Largest squared distance (m2) of particles first to last from reference positions; NaN if any is NaN or infinite."""
    largest = total = 0.0
    for i in rows(first, last):
        square = (x[i] - x_ref[i]) ** 2 + (y[i] - y_ref[i]) ** 2
        largest = max(largest, square)
        total += square
    return largest + 0.0 * total
