"""The guard against particles that jump: no NaN goes unseen.  The order in which blocks of rows are taken."""

from __future__ import annotations

import numpy as np
import pytest

from sph.solver.compiled.threads import BLOCK, make_team
from sph.solver.moves import largest_move
from sph.solver.neighbours import find_candidates
from sph.solver.schedule import block_at, make_schedule

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


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("mirrors", [0, 300])
def test_accelerations_wait_for_the_stresses_around(size: int, mirrors: int) -> None:
    # A band of soil in columns, fixed particles below it, and mirroring ones at its right end.
    n_soil, n_fixed = 20 * BLOCK + 17, 3 * BLOCK
    x = np.concatenate((np.arange(n_soil) // 10, np.linspace(0, n_soil // 10, n_fixed), np.full(mirrors, n_soil // 10 + 1.0)))
    y = np.concatenate((np.arange(n_soil) % 10, np.full(n_fixed, -1.0), np.linspace(0, 10, mirrors)))
    candidates = find_candidates(x, y, 2.5, None)
    blocks, of_soil, first_mirror = -(-x.size // BLOCK), n_soil // BLOCK, n_soil + n_fixed
    taken, early = [], 0
    for member in make_team(size, x.size, 1, 1):
        schedule = make_schedule(member, candidates, n_soil, first_mirror)
        n_others, count, lag = schedule.n_others, schedule.blocks, schedule.lag
        mine = [block_at(member, schedule, k) for k in range(count)]
        taken += mine
        for k, block in enumerate(mine):
            turn, around = member.turn[k], candidates.near[candidates.near_start[block] : candidates.near_start[block + 1]]
            if turn == count:
                continue  # after all threads have met
            early += 1
            assert k <= turn <= k + lag and k >= n_others, "after its own stresses, and within the blocks that are looked at"
            for other in around:
                if other >= of_soil:
                    assert (other + 1) * BLOCK <= first_mirror, "walls with a stress of their own are done, those that mirror it are not"
                else:
                    assert other in mine and mine.index(other) <= turn, "the stresses of soil around are there"
    assert sorted(taken) == list(range(blocks)), "every block is taken once"
    assert early >= of_soil - 3 * size - (4 if mirrors else 0), "most do not wait for all"
