"""Who is near whom, and the kernel gradients between them.

Two lists are kept.  The *candidates* reach a skin beyond the support and are renewed when a
particle has moved half the skin.  The *pairs* are the candidates inside the support with their
kernel gradients times the neighbour's mass, g_ij = m_j grad_i W_ij; they are renewed when a
particle has moved the gradient tolerance, so that a time step only gathers fields.  Storing the
directed pair (i, j) and (j, i) separately keeps both loops free of scatter and lets them
vectorise; indices are unsigned, since signed ones test for wrap-around and do not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.jit import jit
from sph.kernels import evaluate, support


class Candidates(NamedTuple):
    """Neighbours within support + skin, by rows: those of i are neighbour[start[i]:start[i + 1]]."""

    start: np.ndarray  # (n + 1,) uint32
    neighbour: np.ndarray  # (m,) uint32


class Pairs(NamedTuple):
    """Neighbours within the support, by rows start[i] to end[i], and their gradients."""

    start: np.ndarray  # (n + 1,) uint32, of the candidates
    end: np.ndarray  # (n,) uint32
    neighbour: np.ndarray  # (m,) uint32
    gx: np.ndarray  # (m,) m_j dW/dx, kg/m3
    gy: np.ndarray  # (m,)
    inverse_norm: np.ndarray  # (m,) 1/|g|, 0 where g = 0
    sum_x: np.ndarray  # (n,) sum of gx over the row, kg/m3
    sum_y: np.ndarray  # (n,)
    correction: np.ndarray  # (n, 3) xx, xy, yy of the inverse of sum_j g_ij (x_j - x_i) / rho_i
    close_i: np.ndarray  # (c,) uint32, pairs i < j that can come within the short range
    close_j: np.ndarray  # (c,) uint32
    close_count: np.ndarray  # (1,) how many of them are in use


@jit
def find_candidates(x, y, reach):  # type: ignore[no-untyped-def]
    """All directed pairs nearer than ``reach`` (m), through a grid of cells of that size."""
    n = x.size
    x_min, y_min = x.min(), y.min()
    columns = np.int64((x.max() - x_min) / reach) + 1
    rows = np.int64((y.max() - y_min) / reach) + 1
    cell = np.empty(n, np.int64)
    first = np.zeros(columns * rows + 1, np.int64)
    for i in range(n):
        cell[i] = np.int64((x[i] - x_min) / reach) * rows + np.int64((y[i] - y_min) / reach)
        first[cell[i] + 1] += 1
    for c in range(columns * rows):
        first[c + 1] += first[c]
    fill = first[:-1].copy()
    order = np.empty(n, np.int64)
    for i in range(n):
        order[fill[cell[i]]] = i
        fill[cell[i]] += 1

    start = np.zeros(n + 1, np.uint32)
    index = np.empty(0, np.uint32)
    for count_only in (True, False):
        if not count_only:
            index = np.empty(start[n], np.uint32)
        total = 0
        for i in range(n):
            column, row = cell[i] // rows, cell[i] % rows
            start[i] = total
            for c in range(max(column - 1, 0), min(column + 2, columns)):
                low, high = max(row - 1, 0), min(row + 1, rows - 1)
                for k in range(first[c * rows + low], first[c * rows + high + 1]):
                    j = order[k]
                    if j != i and (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < reach * reach:
                        if not count_only:
                            index[total] = j
                        total += 1
        start[n] = total
    return Candidates(start, index)


@jit
def allocate_pairs(candidates):  # type: ignore[no-untyped-def]
    """Room for the pairs of a candidate list."""
    n = candidates.start.size - 1
    size = candidates.neighbour.size
    return Pairs(
        candidates.start,
        np.zeros(n, np.uint32),
        np.empty(size, np.uint32),
        np.empty(size),
        np.empty(size),
        np.empty(size),
        np.empty(n),
        np.empty(n),
        np.empty((n, 3)),
        np.empty(size // 2, np.uint32),
        np.empty(size // 2, np.uint32),
        np.zeros(1, np.int64),
    )


@jit
def _invert(term, density, m_xx, m_xy, m_yy):  # type: ignore[no-untyped-def]
    """Inverse of the moment matrix over density; the identity where it is off or too singular."""
    if term is None:
        return 1.0, 0.0, 1.0
    else:
        determinant = m_xx * m_yy - m_xy * m_xy
        if determinant < term.min_determinant * density * density:
            return 1.0, 0.0, 1.0
        s = density / determinant
        return m_yy * s, -m_xy * s, m_xx * s


@jit
def update_pairs(pairs, candidates, kernel, x, y, mass, density, close_range, correction):  # type: ignore[no-untyped-def]
    """Fill ``pairs`` with the candidates inside the support at positions x, y (m).

    Pairs nearer than ``close_range`` (m) are listed once more, each once, for short-range forces.
    """
    reach = support(kernel)
    close = 0
    for i in range(x.size):
        k_out = candidates.start[i]
        sum_x = sum_y = m_xx = m_xy = m_yy = 0.0
        for k in range(candidates.start[i], candidates.start[i + 1]):
            j = candidates.neighbour[k]
            dx = x[i] - x[j]
            dy = y[i] - y[j]
            r2 = dx * dx + dy * dy
            if r2 < reach * reach:
                r = math.sqrt(r2)
                factor = mass[j] * evaluate(kernel, r)[1]
                gx = factor * dx
                gy = factor * dy
                norm = -factor * r
                pairs.neighbour[k_out] = j
                pairs.gx[k_out] = gx
                pairs.gy[k_out] = gy
                pairs.inverse_norm[k_out] = 1.0 / norm if norm > 0.0 else 0.0
                if r < close_range and i < j:
                    pairs.close_i[close] = i
                    pairs.close_j[close] = j
                    close += 1
                sum_x += gx
                sum_y += gy
                m_xx -= gx * dx
                m_xy -= gx * dy
                m_yy -= gy * dy
                k_out += np.uint32(1)
        pairs.end[i] = k_out
        pairs.sum_x[i] = sum_x
        pairs.sum_y[i] = sum_y
        pairs.correction[i, 0], pairs.correction[i, 1], pairs.correction[i, 2] = _invert(correction, density[i], m_xx, m_xy, m_yy)
    pairs.close_count[0] = close
