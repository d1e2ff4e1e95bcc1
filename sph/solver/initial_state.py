"""The state of a run at its start."""

from __future__ import annotations

import numpy as np

from sph.scene.schema import Scene
from sph.solver.boundaries.free_field import free_field_nodes
from sph.solver.particles import Particles
from sph.solver.physics.seams import seam_sides
from sph.solver.state import FAILED, HELD, UNARMED, State


def initial_state(particles: Particles, scene: Scene) -> State:
    """Particles at the start: unstressed and at rest unless the scene says otherwise."""
    n, density = particles.x.size, scene.soil.density
    generator = np.random.default_rng(0)
    fluid = scene.coupling.initial_state == "fluid"
    held = (np.arange(n) >= particles.n_soil) | scene.held(particles.x, particles.y)
    zero = {name: np.zeros(n) for name in State._fields}
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
        "intact": _intact(scene, particles),
        **{name: np.zeros((4, n if scene.numerics.reference == "initial" else 0)) for name in ("stretch", "stretch_pairs")},
        "x_candidates": particles.x.copy(),
        "y_candidates": particles.y.copy(),
        "mode_x": generator.normal(size=n),
        "mode_y": generator.normal(size=n),
        **{name: np.zeros(n if scene.coupling.softening else 0) for name in ("plastic_strain", "mean_plastic_strain")},
        **{name: np.zeros(n if scene.seams else 0) for name in ("seam_strain", "seam_slip", "seam_normal", "seam_speed")},
        "reaction_x": np.full(particles.first_fixed - particles.n_soil, np.nan),
        "reaction_y": np.full(particles.first_fixed - particles.n_soil, np.nan),
        "free_field": np.zeros((2, 5, sum(free_field_nodes(scene, particles)))),
        "work": np.zeros(7),
    }
    state = State(**(zero | start))
    if scene.initial_velocity is not None:
        geometry, soil = scene.geometry, slice(0, particles.n_soil)
        along_x, state.vy[soil] = scene.initial_velocity.at(*geometry.in_survey(particles.x[soil], particles.y[soil]))
        state.vx[soil] = geometry.direction * along_x
    return state


def _intact(scene: Scene, particles: Particles) -> np.ndarray:
    """Particles (n,) whose pairs are those of the start: soil away from seams, and walls but those of contact, which soil may leave."""
    if scene.numerics.reference == "current":
        return np.zeros(0, np.uint8)
    number = np.arange(particles.x.size)
    keeps = (number < particles.first_contact) | (number >= particles.first_slip)
    solid = scene.coupling.initial_state == "solid"
    return (solid & keeps & (seam_sides(scene, particles)[0] == 0)).astype(np.uint8)
