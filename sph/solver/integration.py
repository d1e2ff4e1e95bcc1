"""Verlet (leapfrog) time integration (Sec. 2.6).

    v(n+1/2) = v(n-1/2) + a(n) dt,  x(n+1) = x(n) + v(n+1/2) dt,
    stress(n+1) from the strain rates of v(n+1/2) at x(n+1),  a(n+1) from stress(n+1).

A step (``advance``) is: kick and drift; renewal of pairs where that is due; velocity gradients; stresses; forces; averages around
particles; sums of energies and failures.  Each goes over the rows of a team's members (``sph.solver.compiled.threads``), which then meet.

Mass-proportional damping is taken at the midpoint of the kick and is therefore stable at any step.
Stiffness damping and artificial viscosity use the velocities half a step back, which lowers the
stable step (``sph.solver.time_step``).  The step changes at frames only, if at all; velocities then lag by half of the old step, which is
an error of the size of one step's change of velocity.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.loading import Loading
from sph.solver.boundaries.dashpots import kick_boundary, resist_bending
from sph.solver.boundaries.free_field import kick_free_field, strain_free_field
from sph.solver.boundaries.free_slip import mirror_stress, mirror_velocity, wall_work
from sph.solver.boundaries.friction import WallFriction, apply_wall_friction, set_friction
from sph.solver.compiled.jit import entry, jit, rows
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.compiled.threads import BLOCK, own_blocks, own_rows, wait
from sph.solver.physics.artificial_stress import set_artificial_stress
from sph.solver.physics.coupling import update_stress
from sph.solver.physics.cyclic_pore_pressure import soften_soil
from sph.solver.physics.interface import weigh_soils
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.physics.prescribed_motion import PrescribedMotion, drive
from sph.solver.physics.rayleigh_damping import mass_damping
from sph.solver.physics.residual_viscosity import keep_strain_rate
from sph.solver.physics.seams import average_seams, not_slip
from sph.solver.physics.seepage import with_seepage
from sph.solver.physics.slip import average_plastic_strain
from sph.solver.renewal import DUE, HOLD, SPENT, look_at_pairs, renew_pairs
from sph.solver.state import FAILURES, GRAVITY, INTERNAL, MASS_DAMPING, REPULSION, SHAKING, VISCOUS, WALLS
from sph.solver.terms import active_terms, add_forces

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.neighbours import Candidates, Pairs
    from sph.solver.terms import State, Terms

by_reference(Loading)


class Loads(NamedTuple):
    """Loads of one step (``sph.scene.loading.Loading``)."""

    time: float
    ground: float
    vertical: float
    gravity: float
    extra_damping: float


@jit
def loads_of(loading: Loading, step: int) -> Loads:
    """``Loads`` of a step."""
    return Loads(loading.time[step], loading.ground[step], loading.vertical[step], loading.gravity[step], loading.extra_damping[step])


@slot
def _rate(term: PrescribedMotion | WallFriction | None, new: float, old: float, dt: float) -> float:
    """Rate at which a term has changed a velocity, m/s2."""
    return 0.0


@_rate.of(PrescribedMotion, WallFriction)
def _rate_of_term(term: PrescribedMotion | WallFriction, new: float, old: float, dt: float) -> float:
    return (new - old) / dt


@jit
def kick_soil(
    state: State, terms: Terms, mass: np.ndarray, loads: Loads, first: int, last: int
) -> tuple[float, float, float, float, float]:
    """Move the soil among particles first to last by one step.

    Returns the works of shaking (or of a prescribed motion) and gravity and the energies taken by mass damping, by artificial
    viscosity and stress, and by friction on walls (J/m).
    """
    dt, ground, vertical, gravity = terms.dt, loads.ground, loads.vertical, loads.gravity
    alpha = mass_damping(terms.rayleigh_damping)
    shaking = falling = damped = viscous = friction = 0.0
    weight_x, weight_y = gravity * terms.down_x, gravity * terms.down_y
    for i in rows(first, min(last, terms.n_soil)):
        gravity_x, gravity_y = with_seepage(terms.seepage, state.x[i], state.y[i], mass[i], gravity, weight_x, weight_y)
        rate = alpha * state.beta[i] * not_slip(terms.seams, state, i) + loads.extra_damping
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
def kick_and_drift(state: State, terms: Terms, mass: np.ndarray, loads: Loads, sums: np.ndarray, team: Team) -> None:
    """Move this thread's soil and absorbing walls by one step, and by the first thread the free field beside them."""
    kick_free_field(terms.free_field, terms.rayleigh_damping, state, terms.dt, loads, team)
    first, last = own_blocks(team)
    for block in range(first, last):
        begin, end = block * BLOCK, (block + 1) * BLOCK
        (
            sums[block, SHAKING],
            sums[block, GRAVITY],
            sums[block, MASS_DAMPING],
            sums[block, VISCOUS],
            sums[block, WALLS],
        ) = kick_soil(state, terms, mass, loads, begin, end)
        shaking, held, viscous, taken = kick_boundary(terms.absorbing_walls, state, terms, mass, loads, begin, end)
        sums[block, SHAKING] += shaking
        sums[block, GRAVITY] += held
        sums[block, VISCOUS] += viscous
        sums[block, WALLS] += taken


@jit
def take_gradients(state: State, pairs: Pairs, terms: Terms, team: Team) -> None:
    """Velocity gradients of this thread's particles, and what they need of free field, walls that mirror the soil, and interfaces."""
    first, last = own_rows(team, state.x.size)
    strain_free_field(terms.free_field, terms.rayleigh_damping, state, terms.dt, team)
    mirror_velocity(terms.free_slip, state, pairs, terms.n_soil, first, last, team)
    weigh_soils(terms.interface, terms, state, pairs, first, last, team)
    resist_bending(terms.absorbing_walls, state, terms.n_soil, terms.dt, first, last)
    velocity_gradients(state, pairs, terms, team.gradient, first, last)
    keep_strain_rate(terms.residual_viscosity, pairs, state.density, team.gradient, team.strain_rate, first, last)


@jit
def take_stresses(state: State, pairs: Pairs, terms: Terms, time: float, sums: np.ndarray, team: Team) -> None:
    """Stresses of this thread's particles at a time (s), and which of them fail."""
    first, last = own_blocks(team)
    for block in range(first, last):
        begin, end = block * BLOCK, min(state.x.size, (block + 1) * BLOCK)
        sums[block, FAILURES], internal = update_stress(state, pairs, terms, time, team, begin, end)
        sums[block, INTERNAL] = internal * terms.dt
        set_artificial_stress(terms.artificial_stress, state, begin, min(end, terms.n_stressed))


@jit
def take_forces(state: State, pairs: Pairs, terms: Terms, mass: np.ndarray, sums: np.ndarray, team: Team) -> None:
    """Accelerations of this thread's particles by the stresses around them and by other forces."""
    n_moving = terms.n_moving
    mirror_stress(terms.free_slip, state, pairs, terms.n_soil, *own_rows(team, state.x.size), team)
    first_block, last_block = own_blocks(team)
    for block in range(first_block, last_block):
        first, last = block * BLOCK, min(state.x.size, (block + 1) * BLOCK)
        stress_accelerations(state, pairs, terms, team.strain_rate, first, min(last, n_moving))
        rubbed = set_friction(terms.wall_friction, terms, state, pairs, mass, first, min(last, terms.n_soil))
        taken = wall_work(terms.free_slip, terms, state, pairs, team.gradient, first, last)
        sums[block, WALLS] += terms.dt * (rubbed + taken)
        sums[block, REPULSION] = add_forces(terms, state, pairs, mass, first, min(last, n_moving))


@jit
def take_averages(state: State, pairs: Pairs, terms: Terms, team: Team) -> None:
    """Averages of slip around this thread's soil particles, which decide in the next step."""
    first, last = own_rows(team, terms.n_soil)
    average_plastic_strain(terms.slip, state, first, last)
    average_seams(terms.seams, state, pairs, first, last)


@jit
def add_up(sums: np.ndarray, work: np.ndarray) -> int:
    """Add a step's sums, blocks in order, to ``State.work``; returns how many particles failed."""
    work[REPULSION] = 0.0
    failed = 0.0
    for block in range(sums.shape[0]):
        for column in range(FAILURES):
            work[column] += sums[block, column]
        failed += sums[block, FAILURES]
    return int(failed)


@entry
def advance(
    state: State,
    candidates: Candidates,
    pairs: Pairs,
    terms: Terms,
    mass: np.ndarray,
    loading: Loading,
    step: int,
    n_steps: int,
    kicked: bool,
    team: Team,
) -> tuple[int, int, bool, tuple[bool, ...]]:
    """Advance ``state`` in place from step ``step`` by ``n_steps``, as one of a team's threads.

    Returns the number of particles that failed (to the first thread), the number of steps made, whether
    the candidates are spent, and the terms that this compiled variant holds, so that the caller can check
    it got the one it asked for.  Spent candidates stop the run between the drift and the rest of a step;
    renewed, it goes on from there with ``kicked``.  Fewer steps without that mean that a particle jumped
    further than the candidates' skin allows or to NaN.
    """
    failed = done = 0
    found = HOLD
    soften_soil(terms.cyclic_pore_pressure, terms.layers, state, *own_rows(team, state.x.size))
    for s in range(step, step + n_steps):
        sums = team.sums[s % 2]  # those of one step are added up while other threads are already at the next
        if kicked and s == step:
            found = DUE
        else:
            kick_and_drift(state, terms, mass, loads_of(loading, s), sums, team)
            found = look_at_pairs(state, pairs, terms, s, team)
        if found not in (HOLD, DUE):
            break
        if found == DUE:
            renew_pairs(state, candidates, pairs, terms, team)
            wait(team)
        take_gradients(state, pairs, terms, team)
        wait(team)
        take_stresses(state, pairs, terms, loading.time[s + 1], sums, team)
        wait(team)
        take_forces(state, pairs, terms, mass, sums, team)
        wait(team)
        take_averages(state, pairs, terms, team)
        wait(team)
        if team.rank == 0:
            failed += add_up(sums, state.work)
        done += 1
    return failed, done, found == SPENT, active_terms(terms)
