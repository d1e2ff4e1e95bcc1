"""The push of the walls' faces, and the density of scattered soil."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.schema import make_scene
from sph.solver.boundaries.faces import STIFFNESS, push_from_faces
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.kernels import evaluate
from sph.solver.renewal import make_lists
from sph.solver.run import run
from sph.solver.simulation import Simulation
from sph.solver.terms import make_terms

SLIP = {"walls.base": "free_slip", "walls.sides": "free_slip", "walls.layers": 4}
"""A box 10 m wide and high with particles 1 m apart; numbers below are metres."""


def pushed(scene: Any, place: tuple[float, float]) -> tuple[float, float, float]:
    """Acceleration (over stiffness and mass) of particle 7 at a place, and the energy stored (over the stiffness)."""
    particles = place_particles(scene)
    state, terms = initial_state(particles, scene), make_terms(scene, particles)
    state.x[7], state.y[7] = place
    energy = push_from_faces(terms.wall_faces, terms.wall_friction, state, particles.mass, 0, particles.n_soil)
    if terms.wall_faces is None:
        return 0.0, 0.0, energy
    unit = STIFFNESS * scene.soil.density * scene.soil.p_wave_speed**2
    others = np.delete(np.hypot(state.ax, state.ay), 7)
    assert others.max() == 0.0, "the lattice does not feel the faces"
    return state.ax[7] * particles.mass[7] / unit, state.ay[7] * particles.mass[7] / unit, energy / unit


@pytest.mark.uncompiled
@pytest.mark.parametrize(
    ("walls", "place", "push"),
    [
        (SLIP, (5.0, 0.4), (0.0, 0.0)),
        (SLIP, (5.0, 0.1), (0.0, 0.3)),
        (SLIP, (5.0, -0.5), (0.0, 0.9)),
        (SLIP, (0.1, 5.0), (0.3, 0.0)),
        (SLIP, (10.2, 5.0), (-0.6, 0.0)),
        (SLIP, (0.1, 0.2), (0.3, 0.2)),
        (SLIP, (-0.2, 10.5), (0.0, 0.0)),  # over the top of the wall
        (SLIP, (5.0, -1.5), (0.0, 0.0)),  # came from outside
        ({"walls.base": "fixed", "walls.sides": "fixed"}, (5.0, 0.1), (0.0, 0.0)),
        ({"walls.base": "fixed", "walls.sides": "fixed"}, (5.0, -0.3), (0.0, 0.3)),
        ({"walls.base": "fixed", "walls.sides": "fixed"}, (10.3, 5.0), (-0.3, 0.0)),
        ({"walls.base": "fixed", "walls.sides": "none"}, (10.3, -0.3), (0.0, 0.0)),  # past the open end
        ({"walls.base": "fixed", "walls.sides": "periodic"}, (99.0, -0.3), (0.0, 0.3)),
        ({"walls.base": "fixed", "walls.top": "free_slip", "walls.layers": 4}, (5.0, 9.8), (0.0, -0.2)),
        ({}, (5.0, -0.3), (0.0, 0.0)),
    ],
)
def test_a_face_pushes_back_what_comes_too_near(
    free_block: SceneBuilder, walls: dict[str, Any], place: tuple[float, float], push: Any
) -> None:
    x, y, energy = pushed(free_block(walls), place)
    assert (x, y) == pytest.approx(push, abs=1e-12)
    assert energy == pytest.approx(0.5 * (push[0] ** 2 + push[1] ** 2), abs=1e-12)


@pytest.mark.uncompiled
def test_friction_counts_the_push(free_block: SceneBuilder) -> None:
    scene = free_block(SLIP | {"walls.friction": {"base": 0.5, "sides": 0.2}})
    particles = place_particles(scene)
    state, terms = initial_state(particles, scene), make_terms(scene, particles)
    state.x[7], state.y[7] = 0.1, 0.2
    push_from_faces(terms.wall_faces, terms.wall_friction, state, particles.mass, 0, particles.n_soil)
    assert state.friction_x[7] == pytest.approx(0.5 * state.ay[7]) and state.friction_y[7] == pytest.approx(0.2 * state.ax[7])


def test_debris_stays_on_a_slip_floor() -> None:
    # Without the faces this soil sinks half a metre between the particles of the floor.
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "debris",
            "duration": 6.0,
            "geometry": {"shape": "slope", "slope_angle": 60.0},
            "walls": {"base": "free_slip", "sides": "free_slip"},
            "gravity": {"ramp": 0.5, "duration": 1.0},
            "motion": {"kind": "tapered_sine", "amplitude": 8.0, "start": 1.0, "ramp": 0.5, "decay_start": 3.0, "end": 4.0},
            "coupling": {"S_R": 0.05},
            "numerics": {"spacing": 2.5, "smoothing_ratio": 1.3, "time_step": 1e-2, "adaptive_step": {}},
        }
    )
    result = run(scene)
    soil = result.trajectory["kind"].values == 0
    assert result.status == "complete", result.trajectory.attrs["status_reason"]
    assert float(np.hypot(result.trajectory["displacement_x"][-1], result.trajectory["displacement_y"][-1]).max()) > 15.0, "it has to move"
    assert result.trajectory["y"].values[:, soil].min() > 0.0


@pytest.mark.uncompiled
def test_scattered_soil_is_no_thinner_than_a_particle_alone(free_block: SceneBuilder) -> None:
    # Continuity multiplies the density by 1 - dt div v: in spray that collides it fell below zero.
    simulation = Simulation(free_block({}))
    simulation.candidates, simulation.pairs = make_lists(simulation.state, simulation.list_terms)
    simulation.state.density[7] = 1e-3
    simulation.advance_steps(1)
    scene, terms = simulation.scene, simulation.terms
    alone = scene.soil.density * scene.numerics.spacing**2 * evaluate(terms.kernel, 0.0)[0]
    assert simulation.state.density[7] == pytest.approx(alone) and 0.05 < alone / scene.soil.density < 0.5
    assert simulation.state.density[8] > 0.9 * scene.soil.density
