"""Who is near whom, and the kernel gradients between them.

Two lists are kept.  The *candidates* reach a skin beyond the support and are renewed when a
particle has moved half the skin.  The *pairs* are the candidates inside the support with their
kernel gradients times the neighbour's mass, g_ij = m_j grad_i W_ij; they are renewed when a
particle has moved the gradient tolerance, so that a time step only gathers fields.  Storing the
directed pair (i, j) and (j, i) separately keeps both loops free of scatter, so that they vectorise
and threads share them by rows; indices are unsigned, since signed ones test for wrap-around and do not.

The gradients may be kept in single precision (``numerics.precision``): the loops over them are bound by
memory, while the fields and all sums stay double.  Rounding is the same for (i, j) and (j, i) and for both
loops, so that momentum and energy are conserved as before.
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.solver.boundaries.periodic import Periodic, columns_around, columns_of_cells
from sph.solver.compiled.jit import entry, jit, rows
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import neighbours_of
from sph.solver.physics.artificial_stress import keep_nearness
from sph.solver.physics.gradient_correction import Sums, either, invert
from sph.solver.physics.initial_arrangement import is_intact, keep_whether_all, offset
from sph.solver.physics.interface import part_unlike
from sph.solver.physics.kernels import support, value_and_slope
from sph.solver.physics.residual_viscosity import keep_distance
from sph.solver.physics.seams import turn_gradients
from sph.solver.physics.walls import add_wall, in_wall, paired, wrap
from sph.solver.terms import TERMS, Terms

MIN_NORM = 1e-30
"""kg/m4: below this a gradient counts as zero, because one over its norm would exceed what single precision holds (3e38)."""


@by_reference
class Candidates(NamedTuple):
    """Neighbours within support + skin, by rows: those of i are neighbour[start[i]:end[i]]."""

    start: np.ndarray  # (n,) uint32
    end: np.ndarray  # (n,) uint32
    neighbour: np.ndarray  # (m,) uint32


class CorePairs(NamedTuple):
    """Neighbours within the support, by rows start[i] to end[i], and their gradients.  What a term keeps says its file."""

    start: np.ndarray  # (n,) uint32
    end: np.ndarray  # (n,) uint32
    neighbour: np.ndarray  # (m,) uint32
    gx: np.ndarray  # (m,) m_j dW/dx, kg/m4, single or double precision
    gy: np.ndarray  # (m,) likewise
    inverse_norm: np.ndarray  # (m,) likewise, 1/|g|, 0 below MIN_NORM
    sum_x: np.ndarray  # (n,) sum of gx over the row, kg/m4
    sum_y: np.ndarray  # (n,)
    correction: np.ndarray  # (n, 3) xx, xy, yy of the inverse of sum_j g_ij (x_j - x_i) / rho_i
    close: np.ndarray  # (m,) uint32, rows start[i] to close_end[i]: neighbours that can come within the short range
    close_end: np.ndarray  # (n,) uint32


if TYPE_CHECKING:

    class Pairs(CorePairs):
        """``CorePairs``, and the arrays that the optional terms keep."""

        def __getattr__(self, name: str) -> Any: ...
        def _replace(self, **changes: Any) -> Pairs: ...
else:
    _own = (name for term in TERMS if term.pairs for name in term.pairs.record._fields)
    Pairs = by_reference(namedtuple("Pairs", (*CorePairs._fields, *_own)))


@neighbours_of.of(Pairs)
def _one_after_the_other(pairs: Pairs, start: int, end: int) -> range:
    return range(start, end)


def find_candidates(x: np.ndarray, y: np.ndarray, reach: float, period: Periodic | None) -> Candidates:
    """All directed pairs nearer than ``reach`` (m), through a grid of cells of that size."""
    n, y_min = x.size, y.min()
    column, columns = columns_of_cells(period, x, reach)
    rows_of_cells = int((y.max() - y_min) / reach) + 1
    cell = column * rows_of_cells + ((y - y_min) / reach).astype(np.int64)
    first = np.zeros(columns * rows_of_cells + 1, np.int64)
    first[1:] = np.bincount(cell, minlength=first.size - 1).cumsum()
    order = np.argsort(cell, kind="stable").astype(np.uint32)
    start, index, done = np.zeros(n + 1, np.uint32), np.empty(64 * n, np.uint32), 0
    while (done := gather_candidates(x, y, reach, period, cell, first, order, columns, rows_of_cells, start, index, done)) < n:
        index = np.concatenate((index, np.empty(index.size + n, np.uint32)))
    return Candidates(start[:-1], start[1:], index[: start[n]].copy())


@entry
def gather_candidates(
    x: np.ndarray,
    y: np.ndarray,
    reach: float,
    period: Periodic | None,
    cell: np.ndarray,
    first: np.ndarray,
    order: np.ndarray,
    columns: int,
    rows_of_cells: int,
    start: np.ndarray,
    index: np.ndarray,
    done: int,
) -> int:
    """Fill the rows of candidates from row ``done`` on; returns the row before which ``index`` had no room, or the number of rows.

    The particles of cell c are order[first[c]:first[c + 1]], and cells count up the columns.
    """
    reach_square = reach * reach
    total = np.uint64(start[done])
    for i in range(done, x.size):
        column, row = cell[i] // rows_of_cells, cell[i] % rows_of_cells
        low, high = max(row - 1, 0), min(row + 1, rows_of_cells - 1)
        left, right = columns_around(period, column, columns)
        for c in range(left, right):
            base = (c % columns) * rows_of_cells
            begin, end = first[base + low], first[base + high + 1]
            if total + np.uint64(end - begin) > np.uint64(index.size):
                return i
            for k in rows(begin, end):
                j = order[k]
                # Without branches: written always, kept where the count goes on.
                index[total] = j
                total += np.uint64((j != i) & (wrap(period, x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < reach_square))
        start[i + 1] = total
    return x.size


class Places(NamedTuple):
    """Where the particles are for whom pairs are made."""

    x: np.ndarray  # (n,) m
    y: np.ndarray
    density: np.ndarray  # (n,) kg/m3


def allocate_pairs(candidates: Candidates, zero: np.floating[Any], terms: Terms) -> Pairs:
    """Room for the pairs of a candidate list; gradients get the type of the number ``zero``, what absent terms keep is empty."""
    n, size = candidates.start.size, candidates.neighbour.size
    core = CorePairs(
        start=np.zeros(n, np.uint32),
        end=np.zeros(n, np.uint32),
        neighbour=np.empty(size, np.uint32),
        gx=np.empty(size, zero.dtype),
        gy=np.empty(size, zero.dtype),
        inverse_norm=np.empty(size, zero.dtype),
        sum_x=np.empty(n),
        sum_y=np.empty(n),
        correction=np.empty((n, 3)),
        close=np.empty(size, np.uint32),
        close_end=np.zeros(n, np.uint32),
    )
    own: list[np.ndarray] = []
    for term in TERMS:
        if term.pairs is not None:
            held = getattr(terms, term.name) is not None
            own += term.pairs.make(*((n, size) if held else (0, 0)), zero.dtype)
    return Pairs(*core, *own)


class Offsets(NamedTuple):
    """Room for vectors to the candidates of one particle, or to its neighbours, side by side."""

    dx: np.ndarray  # m
    dy: np.ndarray
    square: np.ndarray  # m2


class Row(NamedTuple):
    """What is found while the neighbours of a particle are chosen."""

    begin: np.uint64
    """place of its first pair"""
    size: np.uint64
    """number of pairs"""
    close: np.uint64
    """of those that short-range forces need"""
    beside_wall: np.bool_
    """whether it has candidates in no-slip walls"""


@jit
def update_pairs(pairs: Pairs, candidates: Candidates, terms: Terms, places: Places, first: int, last: int) -> None:
    """Fill rows first to last of ``pairs`` with the candidates inside the support.

    The rows follow each other without gaps, since reading them is what a large scene
    spends its time on.  Pairs nearer than ``terms.close_range`` (m) are listed once more for short-range forces.
    """
    longest = np.uint32(1)
    for i in rows(first, last):
        longest = max(longest, candidates.end[i] - candidates.start[i])
    # Room for one row: loops that choose, and loops that gather and store at once, do not vectorise.
    room = Offsets(np.empty(longest), np.empty(longest), np.empty(longest))
    begin = np.uint64(candidates.start[first])
    for i in rows(first, last):
        begin = update_row(pairs, candidates, terms, places, room, i, begin)


@jit
def update_row(pairs: Pairs, candidates: Candidates, terms: Terms, places: Places, room: Offsets, i: int, begin: np.uint64) -> np.uint64:
    """Fill row i of ``pairs`` from place ``begin`` on; returns its end."""
    row = choose_neighbours(pairs, candidates, terms, places, room, i, begin)
    make_gradients(pairs, terms, room, i, row)
    sum_gradients(pairs, candidates, terms, places, room, i, row)
    end = begin + row.size
    pairs.start[i] = begin
    pairs.close_end[i] = begin + row.close
    pairs.end[i] = end
    return end


@jit
def choose_neighbours(pairs: Pairs, candidates: Candidates, terms: Terms, places: Places, room: Offsets, i: int, begin: np.uint64) -> Row:
    """List the neighbours of particle i from place ``begin`` on, and their offsets in ``room``; those across an interface last."""
    period, x, y = terms.periodic, places.x, places.y
    row_dx, row_dy, row_square = room.dx, room.dy, room.square
    reach_square, close_square = support(terms.kernel) ** 2, terms.close_range * terms.close_range
    x_i, y_i = x[i], y[i]
    row = np.uint64(candidates.start[i])
    size = np.uint64(candidates.end[i]) - row
    close_candidates = wall_candidates = as_they_lie = np.uint64(0)
    intact = is_intact(terms.initial_arrangement, pairs, i)
    for k in range(size):
        j = candidates.neighbour[row + k]
        near = wrap(period, x_i - x[j]) ** 2 + (y_i - y[j]) ** 2
        dx, dy, kept = offset(terms.initial_arrangement, intact, period, pairs, places, i, j)
        r_square = dx * dx + dy * dy
        row_dx[k] = dx
        row_dy[k] = dy
        row_square[k] = r_square
        close_candidates += np.uint64(near < close_square)
        as_they_lie += np.uint64((r_square < reach_square) & (not kept))
        wall_candidates += np.uint64(in_wall(terms.no_slip, j))
    # Without branches: written always, kept where the count goes on.
    count = close = np.uint64(0)
    for k in range(size):
        j = candidates.neighbour[row + k]
        pairs.neighbour[begin + count] = j
        row_dx[count] = row_dx[k]
        row_dy[count] = row_dy[k]
        count += np.uint64((row_square[k] < reach_square) & paired(terms.no_slip, i, j))
    part_unlike(terms.interface, terms.seams, pairs, i, begin, count, row_dx, row_dy)
    if close_candidates > np.uint64(0):
        for k in range(size):
            j = candidates.neighbour[row + k]
            pairs.close[begin + close] = j
            close += np.uint64(wrap(period, x_i - x[j]) ** 2 + (y_i - y[j]) ** 2 < close_square)
    keep_whether_all(terms.initial_arrangement, pairs, i, as_they_lie)
    return Row(begin, count, close, wall_candidates > np.uint64(0))


@jit
def make_gradients(pairs: Pairs, terms: Terms, room: Offsets, i: int, row: Row) -> None:
    """Kernel gradients of the pairs of particle i, from their offsets."""
    begin, row_dx, row_dy = row.begin, room.dx, room.dy
    for k in range(row.size):
        dx = row_dx[k]
        dy = row_dy[k]
        r = math.sqrt(dx * dx + dy * dy)
        value, slope = value_and_slope(terms.kernel, r)
        factor = terms.gradient_mass * slope
        keep_nearness(terms.artificial_stress, pairs.nearness, begin + k, value)
        keep_distance(terms.residual_viscosity, pairs.distance, begin + k, r)
        norm = -factor * r
        pairs.gx[begin + k] = factor * dx
        pairs.gy[begin + k] = factor * dy
        pairs.inverse_norm[begin + k] = 1.0 / norm if norm > MIN_NORM else 0.0
    turn_gradients(terms.seams, pairs, i, begin, row.size)


@jit
def sum_gradients(pairs: Pairs, candidates: Candidates, terms: Terms, places: Places, room: Offsets, i: int, row: Row) -> None:
    """Sums of the gradients of particle i as they are stored, rounded, and the correction that follows from their moments."""
    row_dx, row_dy = room.dx, room.dy
    sum_x = sum_y = m_xx = m_xy = m_yy = 0.0
    for k in range(row.size):
        gx = np.float64(pairs.gx[row.begin + k])
        gy = np.float64(pairs.gy[row.begin + k])
        sum_x += gx
        sum_y += gy
        m_xx -= gx * row_dx[k]
        m_xy -= gx * row_dy[k]
        m_yy -= gy * row_dy[k]
    sums = Sums(sum_x, sum_y, m_xx, m_xy, m_yy)
    sums = add_wall(terms.no_slip, terms, row.beside_wall, pairs, candidates, places, i, sums)
    pairs.sum_x[i] = sums.x
    pairs.sum_y[i] = sums.y
    pairs.correction[i, 0], pairs.correction[i, 1], pairs.correction[i, 2] = invert(
        either(terms.gradient_correction, terms.residual_viscosity), places.density[i], sums
    )
