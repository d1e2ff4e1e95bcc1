"""Dyadic refinement on functions whose boundaries are known."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable

import pytest
from pydantic import ValidationError

from sph.experiments.trigger.refinement import UNSHAKEN, Cell, Place, Span, leaves


def asked(cells: list[int], found: Callable[[Place], Hashable], levels: int) -> set[Place]:
    """Points that a search of so many levels needs: corners of all its cells."""
    return {corner for cell in leaves(cells, found, levels) for corner in cell.corners()}


def test_one_dimension_is_bisection() -> None:
    limit = 1.37

    def above(place: Place) -> bool:
        return place[0] > limit

    for levels in range(8):
        split = [cell for cell in leaves([4], above, levels) if cell.corner[0] < limit < cell.corner[0] + cell.size]
        assert split == [Cell((math.floor(limit * 2**levels) / 2**levels,), levels)]
        assert len(asked([4], above, levels)) == 5 + levels, "one point a level more than the ends of the cells"


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_cells_fill_the_lattice_and_differ_only_at_the_last_level(dimensions: int) -> None:
    def inside(place: Place) -> bool:
        return math.hypot(*place) < 1.6

    cells = list(leaves([2] * dimensions, inside, 3))
    assert sum(cell.size**dimensions for cell in cells) == 2.0**dimensions
    assert len({cell.corner for cell in cells}) == len(cells)
    differing = [cell for cell in cells if len({inside(corner) for corner in cell.corners()}) > 1]
    assert differing and {cell.level for cell in differing} == {3}
    assert dimensions == 1 or len(asked([2] * dimensions, inside, 3)) < (2 * 2**3 + 1) ** dimensions


def test_a_deeper_search_asks_for_every_point_of_the_shallower_one_and_only_above_the_last_level() -> None:
    known: set[Place] = set()

    def found(place: Place) -> str:
        assert place in known, "asked for what no earlier round has run"
        return "diverged" if 0.9 < place[0] < 1.1 else str(place[0] + place[1] > 1.3)

    for levels in range(4):
        wanted = asked([2, 1], found, levels)
        assert known < wanted
        known |= wanted


def test_equal_corners_are_left_alone() -> None:
    assert all(cell.level == 0 for cell in leaves([3, 2], lambda place: "diverged", 5))


def test_spans() -> None:
    linear, ratio = Span(lowest=0.0, highest=16.0, cells=4), Span(lowest=1.0, highest=100.0, cells=2, scale="logarithmic")
    assert [linear.value(place) for place in (0.0, 0.125, 4.0)] == [0.0, 0.5, 16.0]
    assert [ratio.value(place) for place in (0.0, 1.0, 2.0)] == pytest.approx([1.0, 10.0, 100.0])
    for bad in ({"lowest": 2.0}, {"lowest": 0.0, "scale": "logarithmic"}, {"cells": 0}, {"lowest": -1.0}):
        with pytest.raises(ValidationError):
            Span(**({"lowest": 1.0, "highest": 2.0, "cells": 1} | bad))


@pytest.mark.parametrize("limit", [0.7, 0.3, 0.01])
def test_a_search_goes_on_below_its_smallest_value(limit: float) -> None:
    span, levels = Span(lowest=1.0, highest=3.0, cells=2), 5
    values: list[float] = []

    def above(place: Place) -> bool:
        if place != UNSHAKEN:
            values.append(span.value(place[0]))
        return place != UNSHAKEN and span.value(place[0]) > limit

    cells = list(leaves([2], above, levels, lower=True))
    (found,) = (cell for cell in cells if len({above(corner) for corner in cell.corners()}) > 1)
    low, high = (span.value(place) for (place,) in found.corners())
    assert found.level == levels and low <= limit < high and high - low == pytest.approx(0.5**levels) and min(values) > 0.0
    assert sum(cell.size for cell in cells) == 3.0


def test_a_search_that_finds_nothing_at_its_smallest_value_asks_for_nothing_below() -> None:
    below = [cell for cell in leaves([2], lambda place: place[0] > 1.2, 4, lower=True) if cell.corner[0] < 0.0]
    assert below == [Cell(UNSHAKEN, 0)]
