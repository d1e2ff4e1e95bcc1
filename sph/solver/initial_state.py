"""The state of a run at its start."""

from __future__ import annotations

import numpy as np

from sph.scene.schema import Scene
from sph.solver.particles import Particles
from sph.solver.state import FAILED, HELD, UNARMED, Core
from sph.solver.terms import State, own_state


def initial_state(particles: Particles, scene: Scene) -> State:
    """Particles at the start: unstressed and at rest unless the scene says otherwise."""
    n, density = particles.x.size, scene.soil.density
    generator = np.random.default_rng(0)
    fluid = scene.coupling.initial_state == "fluid"
    held = (np.arange(n) >= particles.n_soil) | scene.held(particles.x, particles.y)
    zero = {name: np.zeros(n) for name in Core._fields}
    start = {
        "x": particles.x.copy(),
        "y": particles.y.copy(),
        "density": np.full(n, density),
        "beta": np.full(n, 0.0 if fluid else 1.0),
        "t_f": np.full(n, 0.0 if fluid else np.nan),
        "phase": np.where(fluid, FAILED, np.where(held, HELD, UNARMED)).astype(np.uint8),
        "x_pairs": particles.x.copy(),
        "y_pairs": particles.y.copy(),
        "density_pairs": np.full(n, density),
        "x_candidates": particles.x.copy(),
        "y_candidates": particles.y.copy(),
        "mode_x": generator.normal(size=n),
        "mode_y": generator.normal(size=n),
        "work": np.zeros(7),
        **own_state(scene, particles),
    }
    state = State(**(zero | start))
    if scene.initial_velocity is not None:
        geometry, soil = scene.geometry, slice(0, particles.n_soil)
        along_x, state.vy[soil] = scene.initial_velocity.at(*geometry.in_survey(particles.x[soil], particles.y[soil]))
        state.vx[soil] = geometry.direction * along_x
    return state
