"""The state of a run and the coefficients of its active terms.

``State`` is everything that changes; saving it saves the run.  ``Terms`` is everything that does
not: one small immutable pack of numbers.  An optional term is a record of its coefficients or
None; numba types the two differently, so a term that is absent is not compiled.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.scene.walls import HOLDING
from sph.solver.boundaries.absorbing import AbsorbingTerm, FreeFieldTerm, free_field_nodes, make_absorbing, make_free_field
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel, central_value, evaluate, make_kernel
from sph.solver.physics.material import LayersTerm, Material, make_layers, make_material

UNARMED, ARMED, FAILED, HELD, YIELDED = range(5)
"""Phases of a particle: the failure criterion does not count yet, counts, was met; it will count once the particle has come off the
surface at which a fixed wall holds it; it was met by gravity alone, and the particle fails in the step after the gravity stage."""

SHAKING, GRAVITY, INTERNAL, MASS_DAMPING, VISCOUS, WALLS, REPULSION = range(7)
"""Rows of ``State.work`` (J/m): work of the shaking (or of a prescribed motion) and of gravity on the soil, of strain on
the stress, and energy taken by mass-proportional damping, by artificial viscosity and stress, and by free-slip
walls, their friction and absorbing walls; energy stored in the short-range repulsion and in the contact with walls (a level, not a
sum).  The static reactions of absorbing walls are dead loads as gravity is, and their work counts with its."""
FAILURES = REPULSION + 1
"""Column of ``Team.sums`` after those of the works: particles that failed in the step."""


CONTACT = {"free_slip": 0.4, "sticky": 0.0}
"""Distance to a wall's face, over the spacing, below which the face pushes, by the kind of wall; the lattice begins at 0.5."""
CONTACT_STIFFNESS = 0.2
"""Stiffness of that push over the constrained modulus of the soil: it adds a fortieth to the square of the stiffest mode's frequency."""


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
    viscous_x: np.ndarray  # acceleration by artificial viscosity and artificial stress alone
    viscous_y: np.ndarray
    tension_xx: np.ndarray  # artificial stress over density squared
    tension_yy: np.ndarray
    tension_xy: np.ndarray
    friction_x: np.ndarray  # largest acceleration that friction on base and top can give, m/s2
    friction_y: np.ndarray  # that of the side walls
    x_pairs: np.ndarray  # positions at which the pairs were made
    y_pairs: np.ndarray
    density_pairs: np.ndarray  # and densities
    x_candidates: np.ndarray  # positions at which the candidates were made
    y_candidates: np.ndarray
    mode_x: np.ndarray  # shape of the stiffest mode, see sph.solver.time_step
    mode_y: np.ndarray
    reaction_x: np.ndarray  # (boundary that moves,) acceleration that fixing balanced, m/s2; NaN in the gravity stage
    reaction_y: np.ndarray
    free_field: np.ndarray  # (2, 5, nodes) see sph.solver.boundaries.absorbing
    work: np.ndarray  # (7,)


class RayleighTerm(NamedTuple):
    """Rayleigh damping (Sec. 2.5)."""

    mass: float
    """alpha, 1/s"""
    stiffness: float
    """beta_R, s"""


class ViscosityTerm(NamedTuple):
    """Artificial viscosity."""

    speed: float
    """alpha V_p over the reference density, m4/(s kg)"""


class CorrectionTerm(NamedTuple):
    """Gradient correction."""

    min_determinant: float


class RepulsionTerm(NamedTuple):
    """Short-range repulsion."""

    range: float
    """m"""
    stiffness: float
    """N/m for a metre of thickness"""


class SlipTerm(NamedTuple):
    """Free-slip walls."""

    first: int
    """first wall particle that slips; all after it slip too"""
    first_side: int
    """first of those that belong to a side wall; they come last"""


class FacesTerm(NamedTuple):
    """Faces of the walls, which push soil back that comes too near."""

    bottom: float
    """y of the faces, m; infinite where there is no wall"""
    top: float
    left: float
    """x of the faces, m"""
    right: float
    begin: float
    """base and top reach from this x, m"""
    end: float
    height: float
    """sides reach up to this y, m"""
    bottom_contact: float
    """distance to the face below which it pushes, m"""
    top_contact: float
    side_contact: float
    thickness: float
    """distance behind a face from which on it no longer pushes, m: what is further has come from outside"""
    stiffness: float
    """N/m for a metre of thickness"""


class FrictionTerm(NamedTuple):
    """Coulomb friction on free-slip walls."""

    base: float
    """coefficient at base and top"""
    sides: float


class PeriodTerm(NamedTuple):
    """Sides on which the soil goes on periodically."""

    length: float
    """m"""


class TensionTerm(NamedTuple):
    """Artificial stress."""

    factor: float
    exponent: float
    inverse_kernel: float
    """1 / W(spacing), m2"""


class DrivenTerm(NamedTuple):
    """Prescribed velocity gradient, 1/s."""

    xx: float
    xy: float
    yx: float
    yy: float


class Terms(NamedTuple):
    """All coefficients of a run."""

    zero: np.floating[Any]  # of the type in which kernel gradients are kept
    dt: float
    down_x: float  # direction of gravity
    down_y: float
    n_soil: int
    n_moving: int  # the soil and the boundary particles that follow it
    n_stressed: int  # particles with a stress of their own; free-slip walls have none
    armed_from: float  # s, half a step before the end of the gravity stage
    pairs_tolerance: float  # m
    candidates_tolerance: float  # m
    reach: float  # support and skin, m
    close_range: float  # range of short-range forces and the tolerance, m
    reference_density: float
    least_density: float  # of a particle without neighbours, m W(0): scattered soil is not thinner
    cell_mass: float  # of the scene's own soil in the room of a particle, kg for a metre of thickness
    soil: Material
    layers: LayersTerm | None
    kernel: Kernel
    rayleigh: RayleighTerm | None
    viscosity: ViscosityTerm | None
    correction: CorrectionTerm | None
    repulsion: RepulsionTerm | None
    slip: SlipTerm | None
    faces: FacesTerm | None
    friction: FrictionTerm | None
    period: PeriodTerm | None
    tension: TensionTerm | None
    driven: DrivenTerm | None
    absorbing: AbsorbingTerm | None
    free_field: FreeFieldTerm | None


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
        "x_candidates": particles.x.copy(),
        "y_candidates": particles.y.copy(),
        "mode_x": generator.normal(size=n),
        "mode_y": generator.normal(size=n),
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


def _held(particles: Particles, scene: Scene) -> np.ndarray:
    """Particles (n,) that fixed walls hold: those of the box, and soil within the kernel's support of a fixed side wall or lid.

    Soil settles under gravity and hangs on such a wall; on a fixed base it lies.
    """
    held = np.arange(particles.x.size) >= particles.n_soil
    columns, rows = scene.lattice
    dx, support = scene.numerics.spacing, 2.0 * scene.numerics.smoothing_length
    if scene.walls.sides == "sticky":
        held |= np.minimum(particles.x, columns * dx - particles.x) < support
    if scene.walls.top == "sticky":
        held |= rows * dx - particles.y < support
    return held


def _faces(scene: Scene) -> FacesTerm | None:
    walls, dx = scene.walls, scene.numerics.spacing
    if not walls.hold:
        return None
    columns, rows = scene.lattice
    sides = walls.sides in HOLDING
    overhang = math.inf if walls.sides == "periodic" else walls.layers * dx if sides else 0.0
    base, top, side = (CONTACT.get(how, 0.0) * dx for how in (walls.base, walls.top, walls.sides))
    return FacesTerm(
        bottom=0.0 if walls.base in HOLDING else -math.inf,
        top=rows * dx if walls.top in HOLDING else math.inf,
        left=0.0 if sides else -math.inf,
        right=columns * dx if sides else math.inf,
        begin=-overhang,
        end=columns * dx + overhang,
        height=rows * dx,
        bottom_contact=base,
        top_contact=top,
        side_contact=side,
        thickness=dx,
        stiffness=CONTACT_STIFFNESS * max(soil.density * soil.p_wave_speed**2 for soil in scene.soils),
    )


def make_terms(scene: Scene, particles: Particles, substeps: int = 1) -> Terms:
    """Coefficients of a scene whose time step is divided by ``substeps``; all floats, so that one scene compiles one variant."""
    soil, numerics = scene.soil, scene.numerics
    dt, dx = numerics.time_step / substeps, numerics.spacing
    kernel = make_kernel(numerics.kernel, numerics.smoothing_length)
    damping, viscosity = scene.damping, numerics.artificial_viscosity
    correction, repulsion = numerics.gradient_correction, numerics.short_range_repulsion
    n, walls, driven, tension = particles.x.size, scene.walls, scene.prescribed_velocity_gradient, numerics.artificial_stress
    slip = None if particles.first_slip == n else SlipTerm(particles.first_slip, particles.first_slip_side)
    tilt, turn = math.radians(scene.gravity.inclination), scene.geometry.direction
    skin = numerics.neighbour_skin * dx
    pairs_tolerance = numerics.gradient_tolerance * dx
    return Terms(
        zero=np.float32(0) if numerics.precision == "mixed" else np.float64(0),
        dt=float(dt),
        down_x=-math.sin(tilt),
        down_y=-math.cos(tilt),
        n_soil=particles.n_soil,
        n_moving=particles.first_fixed,
        n_stressed=particles.first_slip,
        armed_from=float(scene.gravity.duration - 0.5 * dt),
        pairs_tolerance=float(pairs_tolerance),
        candidates_tolerance=float(0.5 * skin),
        reach=float(2.0 * numerics.smoothing_length + skin),
        close_range=0.0 if repulsion is None else float(repulsion.range * dx + 2.0 * pairs_tolerance),
        reference_density=float(soil.density),
        least_density=float(soil.density * dx * dx * central_value(kernel)),
        cell_mass=float(soil.density * dx * dx),
        soil=make_material(soil, scene.coupling, dt),
        layers=make_layers(scene, particles.layer, dt),
        kernel=kernel,
        rayleigh=None if damping is None else RayleighTerm(damping.mass_coefficient, damping.stiffness_coefficient),
        viscosity=None if viscosity is None else ViscosityTerm(viscosity.alpha * soil.p_wave_speed / soil.density),
        correction=None if correction is None else CorrectionTerm(float(correction.min_determinant)),
        repulsion=None
        if repulsion is None
        else RepulsionTerm(float(repulsion.range * dx), float(1e3 * repulsion.pressure / repulsion.range)),
        slip=slip,
        faces=_faces(scene),
        friction=None if walls.friction is None else FrictionTerm(walls.friction.base, walls.friction.sides),
        period=PeriodTerm(round(scene.geometry.width / dx) * dx) if walls.sides == "periodic" else None,
        tension=None if tension is None else TensionTerm(tension.factor, tension.exponent, 1.0 / evaluate(kernel, dx)[0]),
        driven=None if driven is None else DrivenTerm(driven.xx, turn * driven.xy, turn * driven.yx, driven.yy),
        absorbing=make_absorbing(scene, particles, kernel),
        free_field=make_free_field(scene, particles, kernel),
    )
