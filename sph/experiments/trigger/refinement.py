"""Dyadic refinement of a lattice in any number of dimensions: points are dense only where what is found at them changes.

A cell whose corners differ is divided into halves along every dimension, its parts again, down to a number of levels; in one
dimension this is bisection.  *Places* are coordinates in units of the undivided cells: dyadic numbers, which are exact, so that a
point is the same point at every level, and a search that continues to a finer level finds all its earlier points again.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterator, Sequence
from typing import Literal, NamedTuple

from pydantic import model_validator

from sph.scene.configuration import Section, key

Place = tuple[float, ...]
UNSHAKEN: Place = (-1.0,)
"""Lower end of the cell below the smallest value of a search along one dimension: 0, of which no run is made."""


class Span(Section):
    """One dimension of a lattice."""

    lowest: float = key("smallest value", ge=0)
    highest: float = key("largest value", gt=0)
    cells: int = key("cells before any is divided", ge=1, le=64)
    scale: Literal["linear", "logarithmic"] = key("cells of equal width or of equal ratio", default="linear")

    @model_validator(mode="after")
    def _in_order(self) -> Span:
        if not self.lowest < self.highest:
            raise ValueError(f"lowest ({self.lowest:g}) must be less than highest ({self.highest:g})")
        if self.scale == "logarithmic" and self.lowest == 0.0:
            raise ValueError("lowest: 0 is not possible on a logarithmic scale; choose a value above 0")
        return self

    def value(self, place: float) -> float:
        """The value at a place, from 0 to ``cells``; in the cell below the smallest value, from -1 to 0, between 0 and that."""
        if place < 0.0:
            return self.lowest * (1.0 + place)
        part = place / self.cells
        if self.scale == "logarithmic":
            return float(self.lowest * (self.highest / self.lowest) ** part)
        return self.lowest + (self.highest - self.lowest) * part

    def widest(self, level: int) -> float:
        """Width of the last cell, the widest on both scales, after ``level`` divisions."""
        return self.value(self.cells) - self.value(self.cells - 0.5**level)


class Cell(NamedTuple):
    """A cell: its lowest corner, and how often it has been divided."""

    corner: Place
    level: int

    @property
    def size(self) -> float:
        """Length of its edges, in undivided cells."""
        return 0.5**self.level

    def corners(self, size: float | None = None) -> list[Place]:
        """Its 2^d corners, or those of the part of another size at its lowest corner."""
        edges = itertools.product((0.0, self.size if size is None else size), repeat=len(self.corner))
        return [tuple(at + step for at, step in zip(self.corner, edge, strict=True)) for edge in edges]

    def parts(self) -> list[Cell]:
        """Its 2^d halves of the next level."""
        return [Cell(corner, self.level + 1) for corner in self.corners(0.5 * self.size)]


def leaves(cells: Sequence[int], outcome: Callable[[Place], Hashable], levels: int, lower: bool = False) -> Iterator[Cell]:
    """The cells that are not divided: those whose corners agree, and those of the last level.

    ``cells`` (d,) is the number of undivided cells along each dimension; ``outcome`` returns what is at a place, and is asked only for
    corners of cells above the last level.  With ``lower`` the cell below the smallest value is one of them.
    """
    waiting = [Cell(tuple(map(float, corner)), 0) for corner in itertools.product(*map(range, cells))]
    waiting += [Cell(UNSHAKEN, 0)] * lower
    while waiting:
        cell = waiting.pop()
        if cell.level < levels and len({outcome(corner) for corner in cell.corners()}) > 1:
            waiting.extend(cell.parts())
        else:
            yield cell
