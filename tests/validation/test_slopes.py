"""The level of the water at which a slope is least safe, from points on both sides of it."""

from __future__ import annotations

import numpy as np
import pytest

from cases.slopes import lowest_between


def test_the_lowest_point_of_a_parabola_is_found_between_its_points() -> None:
    x = np.array([1.0, 0.0, 0.6, 0.2, 0.4])
    assert lowest_between(x, (x - 0.53) ** 2 + 1.3) == pytest.approx(0.53, rel=1e-9)


@pytest.mark.parametrize(("slope", "end"), [(1.0, 0.2), (-1.0, 0.8)])
def test_an_end_that_is_lowest_is_the_lowest(slope: float, end: float) -> None:
    x = np.array([0.2, 0.4, 0.8])
    assert lowest_between(x, slope * x) == end
