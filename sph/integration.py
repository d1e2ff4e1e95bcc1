"""Verlet (leapfrog) time integration with a fixed step (Sec. 2.6).

    v(n+1/2) = v(n-1/2) + a(n) dt,  x(n+1) = x(n) + v(n+1/2) dt,
    stress(n+1) from the strain rates of v(n+1/2) at x(n+1),  a(n+1) from stress(n+1).

Mass-proportional damping is taken at the midpoint of the kick and is therefore stable at any step.
Stiffness damping and artificial viscosity use the velocities half a step back, which lowers the
stable step (``sph.timestep``).
"""

from __future__ import annotations

import numpy as np

from sph.coupling import update_stress
from sph.free_slip import add_wall_work, mirror_stress, mirror_velocity
from sph.jit import jit
from sph.momentum import add_repulsion, stress_accelerations, velocity_gradients
from sph.neighbours import allocate_pairs, find_candidates, update_pairs
from sph.state import GRAVITY, MASS_DAMPING, SHAKING, VISCOUS


@jit
def _mass_damping(term):  # type: ignore[no-untyped-def]
    if term is None:
        return 0.0
    else:
        return term.mass


@jit
def kick_and_drift(state, terms, mass, ground, gravity, extra_damping):  # type: ignore[no-untyped-def]
    """Move the soil by one step; works of loads and dampings go into ``state.work``."""
    dt = terms.dt
    alpha = _mass_damping(terms.rayleigh)
    shaking = falling = damped = viscous = 0.0
    for i in range(terms.n_soil):
        rate = alpha * state.beta[i] + extra_damping
        keep = 1.0 - 0.5 * rate * dt
        lose = 1.0 / (1.0 + 0.5 * rate * dt)
        vx_old = state.vx[i]
        vy_old = state.vy[i]
        vx = (vx_old * keep + (state.ax[i] - ground) * dt) * lose
        vy = (vy_old * keep + (state.ay[i] - gravity) * dt) * lose
        state.vx[i] = vx
        state.vy[i] = vy
        state.x[i] += vx * dt
        state.y[i] += vy * dt
        mean_x = 0.5 * (vx + vx_old)
        mean_y = 0.5 * (vy + vy_old)
        shaking -= mass[i] * ground * mean_x
        falling -= mass[i] * gravity * mean_y
        damped += mass[i] * rate * (mean_x * mean_x + mean_y * mean_y)
        viscous -= mass[i] * (state.viscous_x[i] * mean_x + state.viscous_y[i] * mean_y)
    state.work[SHAKING] += shaking * dt
    state.work[GRAVITY] += falling * dt
    state.work[MASS_DAMPING] += damped * dt
    state.work[VISCOUS] += viscous * dt


@jit
def largest_move(x, y, x_ref, y_ref, n):  # type: ignore[no-untyped-def]
    """Largest squared distance (m2) of the first n particles from reference positions; NaN if any is NaN."""
    largest = 0.0
    for i in range(n):
        square = (x[i] - x_ref[i]) ** 2 + (y[i] - y_ref[i]) ** 2
        if not square <= largest:
            largest = square
    return largest


@jit
def make_lists(state, terms, mass):  # type: ignore[no-untyped-def]
    """Candidates and pairs as they were when the state was saved (or at the start)."""
    candidates = find_candidates(state.x_candidates, state.y_candidates, terms.reach)
    pairs = allocate_pairs(candidates)
    update_pairs(
        pairs, candidates, terms.kernel, state.x_pairs, state.y_pairs, mass, state.density_pairs, terms.close_range, terms.correction
    )
    return candidates, pairs


TERM_NAMES = (
    "wendland_c2",
    "capped_viscosity",
    "rayleigh_damping",
    "artificial_viscosity",
    "gradient_correction",
    "short_range_repulsion",
    "free_slip",
)


@jit
def _present(term):  # type: ignore[no-untyped-def]
    return term is not None


@jit
def active_terms(terms):  # type: ignore[no-untyped-def]
    """Which optional terms the compiled variant holds, in the order of ``TERM_NAMES``."""
    return (
        _present(terms.kernel.wendland_c2),
        _present(terms.fluid_law.cap),
        _present(terms.rayleigh),
        _present(terms.viscosity),
        _present(terms.correction),
        _present(terms.repulsion),
        _present(terms.slip),
    )


@jit
def advance(state, candidates, pairs, terms, mass, loading, step, n_steps):  # type: ignore[no-untyped-def]
    """Advance ``state`` in place from step ``step`` by ``n_steps``.

    Returns the lists, the number of particles that failed, the number of steps made, which is less
    than ``n_steps`` only if a particle jumped further than the candidate skin allows or to NaN, and the
    terms that this compiled variant holds, so that the caller can check it got the one it asked for.
    """
    gradient = np.empty((state.x.size, 4))
    n_soil = terms.n_soil
    failed = 0
    for n in range(step, step + n_steps):
        kick_and_drift(state, terms, mass, loading.ground[n], loading.gravity[n], loading.extra_damping[n])
        if not largest_move(state.x, state.y, state.x_pairs, state.y_pairs, n_soil) <= terms.pairs_tolerance**2:
            move = largest_move(state.x, state.y, state.x_candidates, state.y_candidates, n_soil)
            if not move <= (terms.candidates_tolerance + terms.reach) ** 2:
                return candidates, pairs, failed, n - step, active_terms(terms)
            if move > terms.candidates_tolerance**2:
                state.x_candidates[:] = state.x
                state.y_candidates[:] = state.y
                candidates = find_candidates(state.x, state.y, terms.reach)
                pairs = allocate_pairs(candidates)
            state.x_pairs[:] = state.x
            state.y_pairs[:] = state.y
            state.density_pairs[:] = state.density
            update_pairs(pairs, candidates, terms.kernel, state.x, state.y, mass, state.density, terms.close_range, terms.correction)
        mirror_velocity(terms.slip, state, pairs, n_soil)
        velocity_gradients(state, pairs, terms.viscosity, gradient)
        failed += update_stress(state, pairs, terms, mass, gradient, n + 1)
        mirror_stress(terms.slip, state, pairs, n_soil)
        stress_accelerations(state, pairs, terms.correction, 0, n_soil)
        add_wall_work(terms.slip, state, pairs, terms.correction, mass, gradient, terms.dt)
        add_repulsion(terms.repulsion, state, pairs, mass, n_soil)
    return candidates, pairs, failed, n_steps, active_terms(terms)
