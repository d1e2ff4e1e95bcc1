"""Verlet (leapfrog) time integration (Sec. 2.6).

    v(n+1/2) = v(n-1/2) + a(n) dt,  x(n+1) = x(n) + v(n+1/2) dt,
    stress(n+1) from the strain rates of v(n+1/2) at x(n+1),  a(n+1) from stress(n+1).

Mass-proportional damping is taken at the midpoint of the kick and is therefore stable at any step.
Stiffness damping and artificial viscosity use the velocities half a step back, which lowers the
stable step (``sph.solver.time_step``).  The step changes at frames only, if at all; velocities then lag by half of the old step, which is
an error of the size of one step's change of velocity.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sph.scene.loading import Loading
from sph.solver.boundaries.absorbing import kick_boundary, kick_free_field, strain_free_field
from sph.solver.boundaries.free_slip import first_mirror, mirror_stress, mirror_velocity, wall_work
from sph.solver.boundaries.friction import apply_wall_friction, set_friction
from sph.solver.compiled.jit import entry, jit, rows
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.threads import BLOCK, own_blocks, wait
from sph.solver.neighbours import Candidates, Pairs, allocate_pairs, find_candidates, pair_terms, update_pairs
from sph.solver.physics.artificial_stress import set_artificial_stress
from sph.solver.physics.coupling import update_stress
from sph.solver.physics.initial_arrangement import LOOK_EVERY, largest_changes, note_intact, start_pairs
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.physics.prescribed_motion import drive
from sph.solver.physics.rayleigh_damping import mass_damping
from sph.solver.physics.residual_viscosity import keep_strain_rate
from sph.solver.physics.seams import average_seams
from sph.solver.physics.seepage import with_seepage
from sph.solver.physics.slip import average_plastic_strain
from sph.solver.state import FAILURES, GRAVITY, INTERNAL, MASS_DAMPING, REPULSION, SHAKING, VISCOUS, WALLS, State
from sph.solver.terms import active_terms, add_forces

by_reference(Loading)

PAIRS_MOVE, CANDIDATES_MOVE = np.int64(0), np.int64(1)
"""Rows of ``Team.move``.  As numbers of numpy, since numba compiles a function once more for each plain number that it is given."""


@jit
def _rate(term, new, old, dt):  # type: ignore[no-untyped-def]
    """Rate at which a term has changed a velocity, m/s2."""
    if term is None:
        return 0.0
    else:
        return (new - old) / dt


@jit
def kick_and_drift(state, terms, mass, ground, vertical, gravity, extra_damping, first, last):  # type: ignore[no-untyped-def]
    """Move the soil among particles first to last by one step.

    Returns the works of shaking (or of a prescribed motion) and gravity and the energies taken by mass damping, by artificial
    viscosity and stress, and by friction on walls (J/m).
    """
    dt = terms.dt
    alpha = mass_damping(terms.rayleigh_damping)
    shaking = falling = damped = viscous = friction = 0.0
    weight_x, weight_y = gravity * terms.down_x, gravity * terms.down_y
    for i in rows(first, min(last, terms.n_soil)):
        gravity_x, gravity_y = with_seepage(terms.seepage, state.x[i], state.y[i], mass[i], gravity, weight_x, weight_y)
        rate = alpha * state.beta[i] + extra_damping
        keep = 1.0 - 0.5 * rate * dt
        lose = 1.0 / (1.0 + 0.5 * rate * dt)
        vx_old = state.vx[i]
        vy_old = state.vy[i]
        free_x = (vx_old * keep + (state.ax[i] - ground + gravity_x) * dt) * lose
        free_y = (vy_old * keep + (state.ay[i] + (gravity_y - vertical)) * dt) * lose
        held_x, held_y = apply_wall_friction(terms.wall_friction, state, i, free_x, free_y, dt)
        vx, vy = drive(terms.prescribed_motion, state.x[i], state.y[i], held_x, held_y)
        state.vx[i] = vx
        state.vy[i] = vy
        state.x[i] += vx * dt
        state.y[i] += vy * dt
        mean_x = 0.5 * (vx + vx_old)
        mean_y = 0.5 * (vy + vy_old)
        # What a prescribed motion does counts as work of the shaking, what friction takes as energy taken by the walls.
        forced_x, forced_y = _rate(terms.prescribed_motion, vx, held_x, dt), _rate(terms.prescribed_motion, vy, held_y, dt)
        shaking += mass[i] * ((forced_x - ground) * mean_x + (forced_y - vertical) * mean_y)
        falling += mass[i] * (gravity_x * mean_x + gravity_y * mean_y)
        friction += mass[i] * (
            _rate(terms.wall_friction, free_x, held_x, dt) * mean_x + _rate(terms.wall_friction, free_y, held_y, dt) * mean_y
        )
        # Damping acts on the velocity that friction or a prescribed motion has not changed yet.
        damped += mass[i] * rate * 0.5 * ((free_x + vx_old) * mean_x + (free_y + vy_old) * mean_y)
        viscous -= mass[i] * (state.viscous_x[i] * mean_x + state.viscous_y[i] * mean_y)
    return shaking * dt, falling * dt, damped * dt, viscous * dt, friction * dt


@jit
def largest_move(x, y, x_ref, y_ref, first, last):  # type: ignore[no-untyped-def]
    """Largest squared distance (m2) of particles first to last from reference positions; NaN if any is NaN or infinite."""
    largest = total = 0.0
    for i in rows(first, last):
        square = (x[i] - x_ref[i]) ** 2 + (y[i] - y_ref[i]) ** 2
        largest = max(largest, square)
        total += square
    return largest + 0.0 * total


@jit
def _note_moves(team, row, x, y, x_ref, y_ref, n):  # type: ignore[no-untyped-def]
    """Largest move of this thread's rows among the first n, for ``_moved``."""
    begin, end = own_blocks(team)
    team.move[row, team.rank] = largest_move(x, y, x_ref, y_ref, min(n, begin * BLOCK), min(n, end * BLOCK))


@jit
def _note_changes(team, term, state, pairs, step, n):  # type: ignore[no-untyped-def]
    """Largest move of this thread's rows that the pairs see; where that is not the move itself, also that which the candidates see."""
    if term is None:
        _note_moves(team, PAIRS_MOVE, state.x, state.y, state.x_pairs, state.y_pairs, n)
    else:
        begin, end = own_blocks(team)
        first, last = min(n, begin * BLOCK), min(n, end * BLOCK)
        seen, far = largest_changes(term, state, pairs, step % LOOK_EVERY == 0, first, last)
        team.move[PAIRS_MOVE, team.rank] = seen
        team.move[CANDIDATES_MOVE, team.rank] = far


@jit
def _left_candidates(team, term, tolerance):  # type: ignore[no-untyped-def]
    """Whether a particle whose move the pairs do not see has moved further than the candidates bear (m2)."""
    if term is None:
        return False
    else:
        return not _moved(team, CANDIDATES_MOVE) <= tolerance


@jit
def _moved(team, row):  # type: ignore[no-untyped-def]
    """Largest move of all threads' rows, m2; NaN if any is."""
    largest = total = 0.0
    for rank in range(team.size):
        largest = max(largest, team.move[row, rank])
        total += team.move[row, rank]
    return largest + 0.0 * total


@jit
def _add_up(sums, work):  # type: ignore[no-untyped-def]
    """Add a step's sums, blocks in order, to ``State.work``; returns how many particles failed."""
    work[REPULSION] = 0.0
    failed = 0.0
    for block in range(sums.shape[0]):
        for column in range(FAILURES):
            work[column] += sums[block, column]
        failed += sums[block, FAILURES]
    return int(failed)


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
def fill_pairs(state, candidates, pairs, terms):  # type: ignore[no-untyped-def]
    """All pairs at the places at which the state's were made."""
    start_pairs(terms.initial_arrangement, state, pairs, np.int64(0), state.x.size)
    update_pairs(pairs, candidates, pair_terms(terms), state.x_pairs, state.y_pairs, state.density_pairs, np.int64(0), state.x.size)


@jit
def renew_pairs(state, candidates, pairs, terms, first, last):  # type: ignore[no-untyped-def]
    """Pairs of particles first to last at the present positions."""
    for i in range(first, last):
        state.x_pairs[i] = state.x[i]
        state.y_pairs[i] = state.y[i]
        state.density_pairs[i] = state.density[i]
    update_pairs(pairs, candidates, pair_terms(terms), state.x, state.y, state.density, first, last)


@jit
def _block(team, n_soil, n_others, k):  # type: ignore[no-untyped-def]
    """Block that this thread takes as its k-th: each ``team.size``-th of those that hold more than soil, then its share of the soil's."""
    of_soil = n_soil // BLOCK
    if k < n_others:
        return of_soil + team.rank + k * team.size
    else:
        return team.rank * of_soil // team.size + k - n_others


@jit
def _take_turns(team, candidates, n_soil, first_mirror):  # type: ignore[no-untyped-def]
    """Note in ``team.turn`` after which of its blocks' stresses this thread can compute the accelerations of each block.

    A block's accelerations need the stresses of all blocks near it.  Soil is numbered by columns, so that these are there a few turns later
    while its pairs are still in the cache; the walls' come first.  What borders on soil of another thread, or on particles that mirror
    the soil's stress, waits for all (turn ``count``).
    Returns the numbers of this thread's blocks with others than soil and of all its blocks, and the longest wait before that.
    """
    of_soil, blocks = n_soil // BLOCK, team.sums.shape[1]
    first, last = team.rank * of_soil // team.size, (team.rank + 1) * of_soil // team.size
    n_others = (blocks - of_soil - team.rank + team.size - 1) // team.size
    count, lag = n_others + last - first, 0
    for k in range(count):
        block = _block(team, n_soil, n_others, k)
        turn = k if k >= n_others else count
        for other in candidates.near[candidates.near_start[block] : candidates.near_start[block + 1]]:
            if other < of_soil:
                turn = max(turn, n_others + other - first if first <= other < last else count)
            elif (other + 1) * BLOCK > first_mirror:
                turn = count
        team.turn[k] = turn
        lag = max(lag, turn - k if turn < count else 0)
    return n_others, count, lag


@entry
def advance(state, candidates, pairs, terms, mass, loading, step, n_steps, kicked, team):  # type: ignore[no-untyped-def]
    """Advance ``state`` in place from step ``step`` by ``n_steps``, as one of a team's threads.

    Returns the number of particles that failed (to the first thread), the number of steps made, whether
    the candidates are spent, and the terms that this compiled variant holds, so that the caller can check
    it got the one it asked for.  Spent candidates stop the run between the drift and the rest of a step;
    renewed, it goes on from there with ``kicked``.  Fewer steps without that mean that a particle jumped
    further than the candidates' skin allows or to NaN.
    """
    n_soil, n_moving, n = terms.n_soil, terms.n_moving, state.x.size
    first_block, last_block = own_blocks(team)
    first_row, last_row = first_block * BLOCK, min(n, last_block * BLOCK)
    n_others, count, lag = _take_turns(team, candidates, n_soil, first_mirror(terms.free_slip, n))
    failed = done = 0
    spent = False
    for s in range(step, step + n_steps):
        # Those of one step are added up while other threads are already at the next.
        sums = team.sums[s % 2]
        renew = kicked and s == step
        if not renew:
            rate, vertical = mass_damping(terms.rayleigh_damping) + loading.extra_damping[s], loading.vertical[s]
            kick_free_field(terms.free_field, state, terms.dt, rate, loading.ground[s], vertical, team)
            for block in range(first_block, last_block):
                (
                    sums[block, SHAKING],
                    sums[block, GRAVITY],
                    sums[block, MASS_DAMPING],
                    sums[block, VISCOUS],
                    sums[block, WALLS],
                ) = kick_and_drift(
                    state,
                    terms,
                    mass,
                    loading.ground[s],
                    vertical,
                    loading.gravity[s],
                    loading.extra_damping[s],
                    block * BLOCK,
                    (block + 1) * BLOCK,
                )
                shaking, held, viscous, taken = kick_boundary(
                    terms.absorbing_walls,
                    state,
                    terms,
                    mass,
                    rate,
                    loading.ground[s],
                    vertical,
                    loading.gravity[s],
                    loading.time[s],
                    block * BLOCK,
                    (block + 1) * BLOCK,
                )
                sums[block, SHAKING] += shaking
                sums[block, GRAVITY] += held
                sums[block, VISCOUS] += viscous
                sums[block, WALLS] += taken
            _note_changes(team, terms.initial_arrangement, state, pairs, s, n_moving)
            wait(team)
            renew = not _moved(team, PAIRS_MOVE) <= terms.pairs_tolerance**2
            renew |= _left_candidates(team, terms.initial_arrangement, terms.candidates_tolerance**2)
            if renew:
                _note_moves(team, CANDIDATES_MOVE, state.x, state.y, state.x_candidates, state.y_candidates, n_moving)
                wait(team)
                move = _moved(team, CANDIDATES_MOVE)
                spent = terms.candidates_tolerance**2 < move <= (terms.candidates_tolerance + terms.reach) ** 2
                if not move <= terms.candidates_tolerance**2:
                    break
        if renew:
            note_intact(terms.initial_arrangement, state, pairs, first_row, last_row)
            wait(team)
            renew_pairs(state, candidates, pairs, terms, first_row, last_row)
            wait(team)
        strain_free_field(terms.free_field, terms.rayleigh_damping, state, terms.dt, team)
        mirror_velocity(terms.free_slip, state, pairs, n_soil, first_row, last_row, team)
        for turn in range(count + 1):
            if turn == n_others:
                wait(team)
            if turn < count:
                block = _block(team, n_soil, n_others, turn)
                first, last = block * BLOCK, min(n, (block + 1) * BLOCK)
                velocity_gradients(
                    state, pairs, terms.artificial_viscosity, terms.no_slip, terms.contact, terms.layers, team.gradient, first, last
                )
                keep_strain_rate(terms.residual_viscosity, pairs.correction, state.density, team.gradient, team.strain_rate, first, last)
                sums[block, FAILURES], internal = update_stress(
                    state, pairs, terms, team.gradient, team.reached, loading.time[s + 1], first, last
                )
                sums[block, INTERNAL] = internal * terms.dt
                set_artificial_stress(terms.artificial_stress, state, first, min(last, terms.n_stressed))
            else:
                wait(team)
                mirror_stress(terms.free_slip, state, pairs, n_soil, first_row, last_row, team)
            for k in range(max(0, turn - lag) if turn < count else 0, min(turn + 1, count)):
                if team.turn[k] == turn:
                    block = _block(team, n_soil, n_others, k)
                    first, last = block * BLOCK, min(n, (block + 1) * BLOCK)
                    stress_accelerations(
                        state,
                        pairs,
                        terms.gradient_correction,
                        terms.contact,
                        terms.layers,
                        terms.residual_viscosity,
                        team.strain_rate,
                        first,
                        min(last, n_moving),
                    )
                    rubbed = set_friction(
                        terms.wall_friction,
                        terms.layers,
                        terms.free_slip,
                        terms.gradient_correction,
                        state,
                        pairs,
                        mass,
                        first,
                        min(last, n_soil),
                    )
                    taken = wall_work(
                        terms.free_slip, terms.layers, state, pairs, terms.gradient_correction, terms.cell_mass, team.gradient, first, last
                    )
                    sums[block, WALLS] += terms.dt * (rubbed + taken)
                    sums[block, REPULSION] = add_forces(terms, state, pairs, mass, first, min(last, n_moving))
        average_plastic_strain(terms.slip, state, first_row, min(last_row, n_soil))
        average_seams(terms.seams, state, pairs, first_row, min(last_row, n_soil))
        wait(team)
        if team.rank == 0:
            failed += _add_up(sums, state.work)
        done += 1
    return failed, done, spent, active_terms(terms)
