"""The state of a run: everything that changes, so that saving it saves the run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.boundaries.absorbing import free_field_nodes
from sph.solver.compiled.records import by_reference
from sph.solver.particles import Particles
from sph.solver.physics.seams import seam_sides

UNARMED, ARMED, FAILED, HELD, YIELDED = range(5)
"""Phases of a particle: the failure criterion does not count yet, counts, was met; it will count once the particle has come off the
surface at which a fixed wall holds it; it was met by gravity alone, and the particle fails in the step after the gravity stage."""

SHAKING, GRAVITY, INTERNAL, MASS_DAMPING, VISCOUS, WALLS, REPULSION = range(7)
"""Rows of ``State.work`` (J/m): work of the shaking (or of a prescribed motion) and of gravity and seepage on the soil, of strain on
the stress, and energy taken by mass-proportional damping, by artificial viscosity and stress, and by free-slip
walls, their friction and absorbing walls; energy stored in the short-range repulsion and in the contact with walls (a level, not a
sum).  The static reactions of absorbing walls are dead loads as gravity is, and their work counts with its."""
FAILURES = REPULSION + 1
"""Column of ``Team.sums`` after those of the works: particles that failed in the step."""


@by_reference
class State(NamedTuple):
    """Arrays over all n particles unless said otherwise; SI units."""

    x: np.ndarray
    y: np.ndarray
    vx: np.ndarray  # half a step behind the positions
    vy: np.ndarray
    ax: np.ndarray  # acceleration by stress, repulsion and artificial viscosity
    ay: np.ndarray
    density: np.ndarray  # of the scene's own soil in the particle's place, see sph.solver.physics.material
    solid_d: np.ndarray  # deviator of the solid state, see sph.solver.physics.elasticity
    solid_q: np.ndarray
    solid_z: np.ndarray
    fluid_d: np.ndarray  # deviator of the fluid state
    fluid_q: np.ndarray
    fluid_z: np.ndarray
    beta: np.ndarray  # weight of the solid state
    t_f: np.ndarray  # time of failure, NaN before
    phase: np.ndarray  # uint8: UNARMED, ARMED, FAILED, HELD, YIELDED
    sxx: np.ndarray  # stress of the momentum equation over density squared
    syy: np.ndarray
    sxy: np.ndarray
    syx: np.ndarray
    viscous_x: np.ndarray  # acceleration by artificial viscosity, artificial stress and other forces that dissipate
    viscous_y: np.ndarray
    tension_xx: np.ndarray  # artificial stress over density squared
    tension_yy: np.ndarray
    tension_xy: np.ndarray
    friction_x: np.ndarray  # largest acceleration that friction on base and top can give, m/s2
    friction_y: np.ndarray  # that of the side walls
    plastic_strain: np.ndarray  # gathered by the solid state at yield, see sph.solver.physics.slip; without that term empty
    mean_plastic_strain: np.ndarray  # its average around the particle
    seam_strain: np.ndarray  # plastic shear along a seam since the gravity stage, see sph.solver.physics.seams; without seams empty
    seam_slip: np.ndarray  # displacement across the seam, m
    seam_normal: np.ndarray  # mean normal stress on it, Pa
    x_pairs: np.ndarray  # positions at which the pairs were made
    y_pairs: np.ndarray
    density_pairs: np.ndarray  # and densities
    intact: np.ndarray  # uint8: not failed when the pairs were made, and not of a wall on which soil slides; for this and the next two see
    # sph.solver.physics.initial_arrangement, empty without that term
    stretch: np.ndarray  # (4, n) deformation gradient less the identity: xx, xy, yx, yy
    stretch_pairs: np.ndarray  # (4, n) that when the pairs were made
    x_candidates: np.ndarray  # positions at which the candidates were made
    y_candidates: np.ndarray
    mode_x: np.ndarray  # shape of the stiffest mode, see sph.solver.time_step
    mode_y: np.ndarray
    reaction_x: np.ndarray  # (boundary that moves,) acceleration that fixing balanced, m/s2; NaN in the gravity stage
    reaction_y: np.ndarray
    free_field: np.ndarray  # (2, 5, nodes) see sph.solver.boundaries.absorbing
    work: np.ndarray  # (7,)


def initial_state(particles: Particles, scene: Scene) -> State:
    """Particles at the start: unstressed and at rest unless the scene says otherwise."""
    n, density = particles.x.size, scene.soil.density
    generator = np.random.default_rng(0)
    fluid = scene.coupling.initial_state == "fluid"
    zero = {name: np.zeros(n) for name in State._fields}
    start = {
        "x": particles.x.copy(),
        "y": particles.y.copy(),
        "density": np.full(n, density),
        "beta": np.full(n, 0.0 if fluid else 1.0),
        "t_f": np.full(n, 0.0 if fluid else np.nan),
        "phase": np.where(fluid, FAILED, np.where(_held(particles, scene), HELD, UNARMED)).astype(np.uint8),
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
        **{name: np.zeros(n if scene.seams else 0) for name in ("seam_strain", "seam_slip", "seam_normal")},
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


def _held(particles: Particles, scene: Scene) -> np.ndarray:
    """Particles (n,) that fixed walls hold: those of the box, and soil within the kernel's support of a fixed side wall or lid.

    Soil settles under gravity and hangs on such a wall; on a fixed base it lies.
    """
    held = np.arange(particles.x.size) >= particles.n_soil
    columns, rows = scene.lattice
    dx, support = scene.numerics.spacing, 2.0 * scene.numerics.smoothing_length
    if scene.walls.kinds.sides.holds_soil:
        held |= np.minimum(particles.x, columns * dx - particles.x) < support
    if scene.walls.kinds.top.holds_soil:
        held |= rows * dx - particles.y < support
    return held
