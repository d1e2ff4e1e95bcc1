"""When candidates and pairs are made anew, and making them.

Pairs are renewed once a particle has moved the gradient tolerance, by each thread for its own rows; candidates once one has moved half of
the skin, by the caller in Python, since their number is not known before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sph.solver.boundaries.dashpots import moved_rows
from sph.solver.compiled.jit import entry, jit
from sph.solver.compiled.threads import own_rows, wait
from sph.solver.moves import largest_move
from sph.solver.neighbours import Candidates, Pairs, Places, allocate_pairs, find_candidates, update_pairs
from sph.solver.physics.initial_arrangement import largest_changes, note_intact, place_of_pairs, start_pairs
from sph.solver.terms import State

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.terms import Terms

PAIRS_MOVE, CANDIDATES_MOVE = np.int64(0), np.int64(1)
"""Rows of ``Team.move``.  As numbers of numpy, since numba compiles a function once more for each plain number that it is given."""
HOLD, DUE, SPENT, LOST = range(4)
"""What becomes of the pairs after a drift: they hold; they are to be renewed; so are the candidates before them; a particle has jumped
further than the candidates' skin allows, or to NaN."""


@jit
def _of_all(team: Team, row: int) -> float:
    """Largest move of all threads' rows, m2; NaN if any is."""
    largest = total = 0.0
    for rank in range(team.size):
        largest = max(largest, team.move[row, rank])
        total += team.move[row, rank]
    return largest + 0.0 * total


@jit
def look_at_pairs(state: State, pairs: Pairs, terms: Terms, step: int, team: Team) -> int:
    """Whether the pairs still hold after the drift of a step: ``HOLD``, ``DUE``, ``SPENT`` or ``LOST``, the same for all threads."""
    # What this thread has moved, since the others may not have moved theirs yet
    first, last = moved_rows(terms.absorbing_walls, terms.n_soil, *own_rows(team, terms.n_moving))
    seen, far = largest_changes(terms.initial_arrangement, state, pairs, step, first, last)
    team.move[PAIRS_MOVE, team.rank] = seen
    team.move[CANDIDATES_MOVE, team.rank] = far
    wait(team)
    allowed = terms.candidates_tolerance**2
    if _of_all(team, PAIRS_MOVE) <= terms.pairs_tolerance**2 and _of_all(team, CANDIDATES_MOVE) <= allowed:
        return HOLD
    team.move[CANDIDATES_MOVE, team.rank] = largest_move(state.x, state.y, state.x_candidates, state.y_candidates, first, last)
    wait(team)
    move = _of_all(team, CANDIDATES_MOVE)
    if move <= allowed:
        return DUE
    return SPENT if move <= (terms.candidates_tolerance + terms.reach) ** 2 else LOST


@jit
def renew_pairs(state: State, candidates: Candidates, pairs: Pairs, terms: Terms, team: Team) -> None:
    """Pairs of this thread's particles, at the present positions or half a step before."""
    first, last = own_rows(team, state.x.size)
    note_intact(terms.initial_arrangement, state, pairs, first, last)
    for i in range(first, last):
        state.x_pairs[i], state.y_pairs[i] = place_of_pairs(terms.initial_arrangement, state, terms.dt if i < terms.n_moving else 0.0, i)
        state.density_pairs[i] = state.density[i]
    wait(team)
    update_pairs(pairs, candidates, terms, Places(state.x_pairs, state.y_pairs, state.density_pairs), first, last)


def renew_candidates(state: State, terms: Any, pairs: Pairs) -> tuple[Candidates, Pairs]:
    """Candidates at the present positions, and room for their pairs: that of the pairs before, which are lost, if it suffices."""
    state.x_candidates[:] = state.x
    state.y_candidates[:] = state.y
    candidates = find_candidates(state.x, state.y, terms.reach, terms.periodic)
    enough = pairs.neighbour.size >= candidates.neighbour.size
    return candidates, pairs if enough else allocate_pairs(candidates, terms.zero, terms)


def make_lists(state: State, terms: Any) -> tuple[Candidates, Pairs]:
    """Candidates and pairs as they were when the state was saved (or at the start)."""
    candidates = find_candidates(state.x_candidates, state.y_candidates, terms.reach, terms.periodic)
    pairs = allocate_pairs(candidates, terms.zero, terms)
    fill_pairs(state, candidates, pairs, terms)
    return candidates, pairs


@entry
def fill_pairs(state: State, candidates: Candidates, pairs: Pairs, terms: Terms) -> None:
    """All pairs at the places at which the state's were made."""
    places = Places(state.x_pairs, state.y_pairs, state.density_pairs)
    start_pairs(terms.initial_arrangement, state, pairs, np.int64(0), state.x.size)
    update_pairs(pairs, candidates, terms, places, np.int64(0), state.x.size)
