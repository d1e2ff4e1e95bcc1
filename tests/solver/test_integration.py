"""The guard against particles that jump: no NaN goes unseen."""

from __future__ import annotations

import numpy as np
import pytest

from sph.solver.moves import largest_move

SIZE = 37
"""Some vectors of the processor and a rest."""


def moves(x: np.ndarray, y: np.ndarray, first: int = 0, last: int = SIZE) -> float:
    return largest_move(x, y, np.zeros(SIZE), np.zeros(SIZE), first, last)


def test_largest_move_of_a_range() -> None:
    x, y = np.random.default_rng(2).normal(size=(2, SIZE))
    # A square and a sum, perhaps in one rounding: 1e-15.
    assert moves(x, y) == pytest.approx((x**2 + y**2).max(), rel=1e-15)
    assert moves(x, y, 5, 9) == pytest.approx((x**2 + y**2)[5:9].max(), rel=1e-15)
    assert moves(x, y, 9, 9) == moves(x, y, 9, 5) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_move_that_is_not_a_number_is_seen_wherever_it_is(bad: float) -> None:
    for where in range(SIZE):
        for axis in range(2):
            position = np.ones((2, SIZE))
            position[axis, where] = bad
            assert np.isnan(moves(*position)), f"{bad} at {where}"
            assert moves(*position, where + 1) == (2.0 if where + 1 < SIZE else 0.0), "others do not see it"
