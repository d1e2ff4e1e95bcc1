"""Threads that advance one scene together.

A team's threads run the same compiled code, each over its own rows of particles, and meet at barriers
between the parts of a time step.  Rows do not depend on each other within a part, and sums over particles
are kept by fixed blocks of ``BLOCK`` rows and added in one order, so that the result has the same bits
whatever the number of threads; one thread passes the barriers without a stop.

numba has no barrier of its own inside compiled code, and its ``prange`` starts and ends a parallel region for each loop,
which costs a small scene more than its threads save.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot

BLOCK = 256
"""Rows of particles that one thread takes together, and over which sums are kept."""

ARRIVED, ROUND = 0, 8
"""Places in the barrier's array, on cache lines of their own."""
PATIENCE = 1_000
"""Looks at the barrier before a waiting thread lets others use its core."""


@by_reference
class Team(NamedTuple):
    """One thread's place among those that advance a scene."""

    rank: int
    size: int
    barrier: np.ndarray  # (16,) int64, shared
    move: np.ndarray  # (2, size) m2, shared: how far the rows of each thread have moved since pairs and candidates were made
    sums: np.ndarray  # (2, blocks, sums), shared: sums over the rows of each block, of even and odd steps
    gradient: np.ndarray  # (4, n) shared: velocity gradients of the current step
    strain_rate: np.ndarray  # (3, n) shared: strain rates of the current step, see sph.solver.physics.residual_viscosity
    reached: np.ndarray  # (n,) bool, shared: at the yield surface in the current step, see sph.solver.physics.coupling


def make_team(size: int, n: int, n_sums: int) -> list[Team]:
    """The places of ``size`` threads that share n particles and ``n_sums`` sums."""
    blocks = -(-n // BLOCK)
    fields = np.zeros((4, n)), np.zeros((3, n)), np.zeros(n, np.bool_)
    shared = np.zeros(16, np.int64), np.zeros((2, size)), np.zeros((2, blocks, n_sums)), *fields
    return [Team(rank, size, *shared) for rank in range(size)]


def together(function: Callable[..., Any], team: list[Team], *arguments: Any) -> list[Any]:
    """Call a function that releases the interpreter lock as every member of a team at once; its results by rank."""
    if len(team) == 1:
        return [function(*arguments, team[0])]
    with ThreadPoolExecutor(len(team)) as pool:
        return list(pool.map(lambda member: function(*arguments, member), team))


@intrinsic
def _add(typingctx, array, index, value):  # type: ignore[no-untyped-def]
    """Add to array[index] as one indivisible step that all threads see; returns the value before."""

    def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.atomic_rmw("add", builder.gep(data, [arguments[1]]), arguments[2], "seq_cst")

    return types.int64(array, types.intp, types.int64), generate


_let_others_run = types.ExternalFunction("sched_yield", types.int32())


@slot
def wait(team: Any) -> None:
    """Return once every thread of the team has come here; another kind of team than threads of the processor gives its own body."""


@wait.of(Team)
def _wait(team: Team) -> None:
    if team.size > 1:
        barrier = team.barrier
        this_round = _add(barrier, ROUND, 0)  # type: ignore[call-arg, var-annotated]
        if _add(barrier, ARRIVED, 1) == team.size - 1:
            _add(barrier, ARRIVED, -team.size)
            _add(barrier, ROUND, 1)
        else:
            looks = 0
            while _add(barrier, ROUND, 0) == this_round:
                looks += 1
                if looks > PATIENCE:
                    _let_others_run()


@jit
def own_blocks(team: Team) -> tuple[int, int]:
    """First and last block of this thread."""
    blocks = team.sums.shape[1]
    return team.rank * blocks // team.size, (team.rank + 1) * blocks // team.size


@jit
def own_rows(team: Team, n: int) -> tuple[int, int]:
    """First and last row of this thread among the first n."""
    first, last = own_blocks(team)
    return min(n, first * BLOCK), min(n, last * BLOCK)
