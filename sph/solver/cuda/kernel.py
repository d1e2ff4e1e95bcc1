"""The kernel: each run of an ensemble has a team of blocks of threads, which makes many steps in one launch.

``advance_run`` mirrors ``sph.solver.integration.advance``: the same functions in the same order, between the same meetings, each called
for one row (i, i + 1) at a time.  A team's thread takes every so-many-th row, so that neighbouring threads read neighbouring numbers.
What differs from the processor:

* **Candidates** are renewed on the card: particles are hung into lists of the cells of a grid, and those of a row are put in order,
  so that rows do not depend on which thread came first.  Cells beyond the edge of the grid count as those at the edge.
* **Rows** of candidates and pairs have room for ``room`` neighbours each.  A run in which that does not suffice stops with ``FULL``.
  Pairs are made one row after the other and then laid side by side, ``LANES`` rows at a time, since as many threads read them together.
* **Sums** of energies are kept for each particle and added up on the processor in order.

The blocks of a run meet by an atomic counter, which takes for granted that all of them are on the card at once; a run of one block meets
by ``syncthreads`` alone.  Only ``sph.solver.cuda.ensemble`` imports this module, and only for a run on a card.
"""

# mypy: disable-error-code="attr-defined,no-untyped-def,no-untyped-call,untyped-decorator"

from __future__ import annotations

import functools
import math
from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np
from numba import cuda

from sph.scene.loading import Loading
from sph.solver.boundaries.dashpots import kick_boundary, resist_bending
from sph.solver.boundaries.free_field import kick_free_field, strain_free_field
from sph.solver.boundaries.free_slip import mirror_stress, mirror_velocity, wall_work
from sph.solver.boundaries.friction import set_friction
from sph.solver.boundaries.periodic import Periodic, columns_around
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.compiled.threads import wait
from sph.solver.cuda.memory import Pack
from sph.solver.integration import kick_soil, loads_of
from sph.solver.neighbours import Candidates, Offsets, Pairs, Places, update_row
from sph.solver.physics.artificial_stress import set_artificial_stress
from sph.solver.physics.coupling import update_stress
from sph.solver.physics.cyclic_pore_pressure import soften_soil
from sph.solver.physics.initial_arrangement import largest_changes, note_intact, place_of_pairs, start_pairs
from sph.solver.physics.interface import weigh_soils
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.physics.residual_viscosity import keep_strain_rate
from sph.solver.physics.seams import average_seams
from sph.solver.physics.slip import average_plastic_strain
from sph.solver.physics.walls import wrap
from sph.solver.renewal import DUE, HOLD, LOST, SPENT
from sph.solver.state import GRAVITY, INTERNAL, MASS_DAMPING, REPULSION, SHAKING, VISCOUS, WALLS
from sph.solver.terms import State, add_forces

FIRST, COUNT, KICKED, BUILD = range(4)
"""Columns of what is asked of a run: first step, number of steps, whether the first one's drift is done, whether lists are to be made."""
DONE, ENDED, RENEWED, FOUND = range(4, 8)
"""Columns of what is told of a run: steps made, why it ended, how often pairs and candidates were renewed."""
FULL = 4
"""Why a run ended, beside ``HOLD`` (all steps made) and ``LOST``: its rows have no room for all neighbours."""
SEEN, FAR, GONE = np.uint32(1), np.uint32(2), np.uint32(4)
"""What a particle's move says: its pairs are due; its candidates would be; it has jumped too far or to NaN."""
LANES = 32
"""Rows that lie side by side: those of the threads of a warp."""
FULL_ROW, MET = 3, 16
"""Flags of a run after those of what was seen in three steps in turn: whether a row was full, how many blocks have come to a meeting."""
FLAGS = 32
"""Words of a run's flags: no two runs wait by the same line of the cache."""


class Member(NamedTuple):
    """A thread's place among those of a run, and the fields of a step, as ``sph.solver.compiled.threads.Team``."""

    rank: int
    gradient: np.ndarray
    strain_rate: np.ndarray
    reached: np.ndarray


@wait.of(Member)
def _no_wait(team: Member) -> None:
    """Functions are called for single rows; ``meet`` comes after the loop over them."""


class Grid(NamedTuple):
    """Cells as wide as the reach of candidates, counted up the columns."""

    x_min: float  # m
    y_min: float
    columns: int
    rows: int


Laid = namedtuple("Laid", Pairs._fields)  # type: ignore[misc]
"""Pairs whose rows lie side by side: what is of pairs, and places in it, are the card's own; the rest is that of the pairs as made."""


@neighbours_of.of(Laid)
def _side_by_side(pairs: Any, start: int, end: int) -> range:
    return range(start, end, LANES)


@slot
def lay_row(own: Any, made: Pairs, i: int, room: int) -> None:
    """Lay row i of pairs side by side with those of the threads beside; ``own`` holds the arrays for it."""


@functools.cache
def class_of_own(by_pair: tuple[str, ...], places: tuple[str, ...]) -> type:
    """Record of the arrays that are laid side by side and of places in them, by their names in ``Pairs``."""
    own = namedtuple("Own", (*by_pair, *places))  # type: ignore[misc]
    copied = "".join(f"\n        own.{name}[at + {LANES} * k] = made.{name}[first + k]" for name in by_pair)
    placed = "".join(f"\n    own.{name}[i] = at + {LANES} * (made.{name}[i] - first)" for name in places)
    source = f"""
def lay(own, made, i, room):
    first = made.start[i]
    at = np.uint32((i // {LANES}) * {LANES} * room + i % {LANES})
    for k in range(np.uint32(max(made.end[i], made.close_end[i])) - first):{copied}{placed}
"""
    space: dict[str, Any] = {"np": np}
    exec(source, space)
    lay_row.of(own)(space["lay"])
    return own


class Lists(NamedTuple):
    """What only the card has of a run."""

    pairs: Pairs  # as they are made
    own: Any  # arrays of ``class_of_own``
    candidates: Candidates
    head: np.ndarray  # (cells,) int32: a particle in each cell, or -1
    following: np.ndarray  # (n,) int32: the next one in a particle's cell, or -1
    gradient: np.ndarray  # (4, n)
    strain_rate: np.ndarray  # (3, n)
    reached: np.ndarray  # (n,) bool
    offsets: np.ndarray  # (threads, 3, room) m, m2: room for a row in the making


class Fixed(NamedTuple):
    """What does not change in a run but with its time step."""

    terms: Any
    mass: np.ndarray  # (n,) kg
    meets: Meets
    grid: Grid


class Meets(NamedTuple):
    """Whether a run's team has to meet for the sake of a term."""

    free_field: bool
    columns: bool  # of an absorbing base, which one thread moves as a whole
    mirror: bool
    interface: bool
    averages: bool


class Run(NamedTuple):
    """What changes in a run and is read back."""

    state: State
    work: np.ndarray  # (7, n) J/m, of each particle since the launch


@slot
def column_of(period: Any, grid: Grid, reach: float, x: float) -> int:
    """Column of cells in which x lies."""
    return min(max(int((x - grid.x_min) / reach), 0), grid.columns - 1)


@column_of.of(Periodic)
def _column_of(period: Periodic, grid: Grid, reach: float, x: float) -> int:
    inside = x - period.length * math.floor(x / period.length)
    return min(int(inside / (period.length / grid.columns)), grid.columns - 1)


@cuda.jit(device=True)
def meet(flags, r, blocks, turn):
    """All threads of a run come here before any goes on; returns the number of the next meeting."""
    cuda.syncthreads()
    if blocks > 1:
        if cuda.threadIdx.x == 0:
            cuda.threadfence()
            cuda.atomic.add(flags, (r, MET), np.uint32(1))
            goal = np.uint32((turn + 1) * blocks)
            while np.int32(cuda.atomic.add(flags, (r, MET), np.uint32(0)) - goal) < 0:
                pass
            cuda.threadfence()
        cuda.syncthreads()
    return turn + 1


@cuda.jit(device=True)
def fill_candidates(lists, grid, terms, x, y, i):
    """Row of candidates of particle i, in the order of ``sph.solver.neighbours.gather_candidates``; whether it had no room for all."""
    candidates, reach, columns, room = lists.candidates, terms.reach, grid.columns, lists.offsets.shape[2]
    reach_square = reach * reach
    column = column_of(terms.periodic, grid, reach, x[i])
    row = min(max(int((y[i] - grid.y_min) / reach), 0), grid.rows - 1)
    left, right = columns_around(terms.periodic, column, columns)
    begin = i * room
    place, limit = begin, begin + room
    full = False
    for c in range(left, right):
        for r in range(max(row - 1, 0), min(row + 2, grid.rows)):
            first = place  # of this cell, whose particles are put in order as they come
            j = lists.head[(c % columns) * grid.rows + r]
            while j >= 0:
                if j != i and wrap(terms.periodic, x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < reach_square:
                    if place < limit:
                        k = place
                        while k > first and candidates.neighbour[k - 1] > j:
                            candidates.neighbour[k] = candidates.neighbour[k - 1]
                            k -= 1
                        candidates.neighbour[k] = j
                        place += 1
                    else:
                        full = True
                j = lists.following[j]
    candidates.start[i] = begin
    candidates.end[i] = place
    return full


@cuda.jit(device=True)
def find_candidates(lists, grid, terms, state, flags, r, blocks, turn, rank, threads):
    """Candidates of a run at the places in its state; returns the number of the next meeting."""
    x, y = state.x_candidates, state.y_candidates
    n = x.size
    for c in range(rank, grid.columns * grid.rows, threads):
        lists.head[c] = -1
    turn = meet(flags, r, blocks, turn)
    for i in range(rank, n, threads):
        row = min(max(int((y[i] - grid.y_min) / terms.reach), 0), grid.rows - 1)
        cell = column_of(terms.periodic, grid, terms.reach, x[i]) * grid.rows + row
        lists.following[i] = cuda.atomic.exch(lists.head, cell, np.int32(i))
    turn = meet(flags, r, blocks, turn)
    for i in range(rank, n, threads):
        if fill_candidates(lists, grid, terms, x, y, i):
            cuda.atomic.max(flags, (r, FULL_ROW), np.uint32(1))
    return meet(flags, r, blocks, turn)


@cuda.jit(device=True)
def fill_rows(lists, terms, state, rank, threads):
    """Pairs of this thread's rows at the places in the state."""
    places = Places(state.x_pairs, state.y_pairs, state.density_pairs)
    offsets = Offsets(lists.offsets[rank, 0], lists.offsets[rank, 1], lists.offsets[rank, 2])
    for i in range(rank, state.x.size, threads):
        update_row(lists.pairs, lists.candidates, terms, places, offsets, i, np.uint64(lists.candidates.start[i]))
        lay_row(lists.own, lists.pairs, i, offsets.dx.size)


@cuda.jit(device=True)
def kick(run, terms, mass, loads, i):
    """Move particle i, or the column of an absorbing base that begins with it."""
    shaking, falling, damped, viscous, friction = kick_soil(run.state, terms, mass, loads, i, i + 1)
    driven, held, resisted, taken = kick_boundary(terms.absorbing_walls, run.state, terms, mass, loads, i, i + 1)
    run.work[SHAKING, i] += shaking + driven
    run.work[GRAVITY, i] += falling + held
    run.work[MASS_DAMPING, i] += damped
    run.work[VISCOUS, i] += viscous + resisted
    run.work[WALLS, i] += friction + taken


@cuda.jit(device=True)
def look(state, pairs, terms, step, i):
    """What the move of particle i says of the lists (``sph.solver.renewal.look_at_pairs``)."""
    seen, far = largest_changes(terms.initial_arrangement, state, pairs, step, i, i + 1)
    allowed = terms.candidates_tolerance**2
    move = (state.x[i] - state.x_candidates[i]) ** 2 + (state.y[i] - state.y_candidates[i]) ** 2
    found = np.uint32(0)
    if not (seen <= terms.pairs_tolerance**2 and far <= allowed):
        found |= SEEN
    if not move <= allowed:
        found |= FAR
    if not move <= (terms.candidates_tolerance + terms.reach) ** 2:
        found |= GONE
    return found


@cuda.jit(device=True)
def take_stress(run, pairs, terms, time, member, i):
    """Stress of particle i at a time (s), and whether it fails."""
    _, internal = update_stress(run.state, pairs, terms, time, member, i, i + 1)
    run.work[INTERNAL, i] += internal * terms.dt
    set_artificial_stress(terms.artificial_stress, run.state, i, min(i + 1, terms.n_stressed))


@cuda.jit(device=True)
def take_force(run, pairs, terms, mass, member, i):
    """Acceleration of particle i by stresses and other forces."""
    state, last = run.state, min(i + 1, terms.n_moving)
    stress_accelerations(state, pairs, terms, member.strain_rate, i, last)
    rubbed = set_friction(terms.wall_friction, terms, state, pairs, mass, i, min(i + 1, terms.n_soil))
    taken = wall_work(terms.free_slip, terms, state, pairs, member.gradient, i, i + 1)
    run.work[WALLS, i] += terms.dt * (rubbed + taken)
    run.work[REPULSION, i] = add_forces(terms, state, pairs, mass, i, last)


@cuda.jit(device=True)
def advance_run(run, fixed, lists, pairs, loading, asked, flags, blocks, r):
    """Advance a run by the steps that are asked for, as one of its threads.  ``loading`` begins with the first of them."""
    state, terms, mass, meets = run.state, fixed.terms, fixed.mass, fixed.meets
    first, count = asked[r, FIRST], asked[r, COUNT]
    n, threads = state.x.size, cuda.blockDim.x * blocks
    rank = cuda.blockIdx.x * cuda.blockDim.x + cuda.threadIdx.x
    member = Member(rank, lists.gradient, lists.strain_rate, lists.reached)
    turn, done, ended, renewed, searched = 0, 0, HOLD, 0, 0
    for i in range(rank, n, threads):
        soften_soil(terms.cyclic_pore_pressure, terms.layers, state, i, i + 1)
        for row in range(run.work.shape[0]):
            run.work[row, i] = 0.0
    if asked[r, BUILD] != 0:
        turn = find_candidates(lists, fixed.grid, terms, state, flags, r, blocks, turn, rank, threads)
        for i in range(rank, n, threads):
            start_pairs(terms.initial_arrangement, state, pairs, i, i + 1)
        turn = meet(flags, r, blocks, turn)
        if flags[r, FULL_ROW] != 0:
            ended, count = FULL, 0
        else:
            fill_rows(lists, terms, state, rank, threads)
            turn = meet(flags, r, blocks, turn)
    for s in range(first, first + count):
        slot_of_step = s % 3
        found = DUE
        if asked[r, KICKED] == 0 or s > first:
            loads = loads_of(loading, s - first)
            if meets.free_field:
                kick_free_field(terms.free_field, terms.rayleigh_damping, state, terms.dt, loads, member)
                turn = meet(flags, r, blocks, turn)
            for i in range(rank, n, threads):
                kick(run, terms, mass, loads, i)
            if meets.columns:
                turn = meet(flags, r, blocks, turn)
            for i in range(rank, min(n, terms.n_moving), threads):
                flag = look(state, pairs, terms, s, i)
                if flag != 0:
                    cuda.atomic.or_(flags, (r, slot_of_step), flag)
            turn = meet(flags, r, blocks, turn)
            seen = flags[r, slot_of_step]
            if rank == 0:
                flags[r, (s + 1) % 3] = 0  # read by all two steps ago, written by none before the next
            if seen & SEEN == 0:
                found = HOLD
            elif seen & GONE != 0:
                found = LOST
            elif seen & FAR != 0:
                found = SPENT
        if found == LOST:
            ended = LOST
            break
        if found == SPENT:
            for i in range(rank, n, threads):
                state.x_candidates[i] = state.x[i]
                state.y_candidates[i] = state.y[i]
            turn = meet(flags, r, blocks, turn)
            turn = find_candidates(lists, fixed.grid, terms, state, flags, r, blocks, turn, rank, threads)
            searched += 1
            if flags[r, FULL_ROW] != 0:
                ended = FULL
                break
        if found != HOLD:
            for i in range(rank, n, threads):
                note_intact(terms.initial_arrangement, state, pairs, i, i + 1)
                dt = terms.dt if i < terms.n_moving else 0.0
                state.x_pairs[i], state.y_pairs[i] = place_of_pairs(terms.initial_arrangement, state, dt, i)
                state.density_pairs[i] = state.density[i]
            turn = meet(flags, r, blocks, turn)
            fill_rows(lists, terms, state, rank, threads)
            renewed += 1
            turn = meet(flags, r, blocks, turn)
        strain_free_field(terms.free_field, terms.rayleigh_damping, state, terms.dt, member)
        if meets.mirror:
            for i in range(rank, n, threads):
                mirror_velocity(terms.free_slip, state, pairs, terms.n_soil, i, i + 1, member)
            turn = meet(flags, r, blocks, turn)
        if meets.interface:
            for i in range(rank, n, threads):
                weigh_soils(terms.interface, terms, state, pairs, i, i + 1, member)
            turn = meet(flags, r, blocks, turn)
        for i in range(rank, n, threads):
            resist_bending(terms.absorbing_walls, state, terms.n_soil, terms.dt, i, i + 1)
            velocity_gradients(state, pairs, terms, member.gradient, i, i + 1)
            keep_strain_rate(terms.residual_viscosity, pairs, state.density, member.gradient, member.strain_rate, i, i + 1)
        turn = meet(flags, r, blocks, turn)
        time = loading.time[s - first + 1]
        for i in range(rank, n, threads):
            take_stress(run, pairs, terms, time, member, i)
        turn = meet(flags, r, blocks, turn)
        if meets.mirror:
            for i in range(rank, n, threads):
                mirror_stress(terms.free_slip, state, pairs, terms.n_soil, i, i + 1, member)
            turn = meet(flags, r, blocks, turn)
        for i in range(rank, n, threads):
            take_force(run, pairs, terms, mass, member, i)
        turn = meet(flags, r, blocks, turn)
        if meets.averages:
            for i in range(rank, terms.n_soil, threads):
                average_plastic_strain(terms.slip, state, i, i + 1)
                average_seams(terms.seams, state, pairs, i, i + 1)
            turn = meet(flags, r, blocks, turn)
        done += 1
    if rank == 0:
        asked[r, DONE], asked[r, ENDED], asked[r, RENEWED], asked[r, FOUND] = done, ended, renewed, searched


def make_kernel(run: Pack, fixed: Pack, lists: Pack) -> Any:
    """The function of the kernel for records that lie in these packs; the runs are the second axis of the grid."""
    names = [*run.arguments, *fixed.arguments, *lists.arguments]
    loading = f"Loading({', '.join(f'loads[r, {row}]' for row in range(len(Loading._fields)))})"
    at = lists.sources
    laid = ", ".join(at.get(f"own.{name}", at[f"pairs.{name}"]) for name in Pairs._fields)
    source = f"""
def advance_runs(asked, flags, loads, {", ".join(names)}):
    r = cuda.blockIdx.y
    if asked[r, {COUNT}] > 0 or asked[r, {BUILD}] != 0:
        advance_run({run.source}, {fixed.source}, {lists.source}, Laid({laid}), {loading}, asked, flags, cuda.gridDim.x, r)
"""
    space = {"cuda": cuda, "advance_run": advance_run, "Loading": Loading, "Laid": Laid, **run.classes, **fixed.classes, **lists.classes}
    return _kernel(source, tuple(space.items()))


@functools.cache
def _kernel(source: str, space: tuple[tuple[str, Any], ...]) -> Any:
    """The same function again for packs alike, so that it is compiled once in a process."""
    names = dict(space)
    exec(source, names)
    return names["advance_runs"]
