"""The free field: columns of level ground beside absorbing sides.

Beside each side (free-field boundary: Zienkiewicz, Bicanic and Shen 1989; FLAC's manual) stands a column of level ground as high as the
ground there, shaken by the same motion on the same base.  The side is joined to it with dashpots (``sph.solver.boundaries.dashpots``),
which feel only what differs from the column's velocity, and with its stresses on upright planes, the shear stress among
them; so the waves that come up are left alone and what the slope sends out is taken.  A column is linear: elastic, with Rayleigh
damping and with what artificial viscosity amounts to there.  Horizontal and vertical motion do not know of each other in it.  It is the
sum of the lattice's rows, the same operator as that of a model with periodic sides, whose waves travel as the model's do at any
resolution; nodes are the rows, boundary rows of the base among them.  The particles of a no-slip base have no state, so that its rows are
no nodes: the lowest rows of soil see it as the soil does (``sph.solver.boundaries.no_slip``), with twice its rows' gradients as b_k,

    strain rate_k gains -v_k b_k,    a_k gains sigma_k b_k / rho_k.

A contact base is to the columns what a no-slip base is; they do not lift off it.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock, jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.compiled.threads import wait
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles, layer_index
from sph.solver.physics.artificial_viscosity import TERM as ARTIFICIAL_VISCOSITY
from sph.solver.physics.kernels import Kernel, evaluate
from sph.solver.physics.rayleigh_damping import mass_damping, stiffness_damping

if TYPE_CHECKING:
    from sph.solver.compiled.threads import Team
    from sph.solver.integration import Loads
    from sph.solver.physics.rayleigh_damping import RayleighDamping
    from sph.solver.terms import State

VELOCITY, MEAN_VELOCITY, ELASTIC_STRESS, STRESS, ACCELERATION = range(5)
"""Second index of ``State.free_field``, after the direction of motion (0: x, 1: y): velocity (m/s) half a step behind, its mean over the
kick, elastic stress on level planes (Pa), that with damping, acceleration (m/s2)."""


@by_reference
class FreeField(NamedTuple):
    """Columns of level ground beside the model, the left one's nodes first, each from the bottom up."""

    begin: np.ndarray  # (3,) first node of each column, and the end of the last
    gradient: np.ndarray  # (2 reach + 1,) volume times the sum of a row's kernel gradients, by its number above the node's own, 1/m
    wall: np.ndarray  # (nodes,) twice that sum over the rows of a no-slip base, 1/m
    viscosity: np.ndarray  # (2, 2 reach + 1) volume times the row's ``Rows.viscosity``, 1/m
    density: np.ndarray  # (nodes,)
    modulus: np.ndarray  # (2, nodes) in shear, and in compression without strain beside it, Pa
    beside: np.ndarray  # (nodes,) horizontal stress over vertical stress in that
    impedance: np.ndarray  # (nodes,) alpha rho V_p of the artificial viscosity, kg/(m2 s)
    correction: np.ndarray  # (nodes,) of the gradient
    drag: np.ndarray  # (2, nodes) deceleration by the dashpot below for a velocity of 1 m/s of the base, 1/s
    weight: np.ndarray  # (nodes,) of a row in the velocity of the base
    mobile: np.ndarray  # (nodes,) 1, or 0 for the rows of a fixed base


class Rows(NamedTuple):
    """Sums over whole rows of the lattice, by the number of the row above the particle's own; (2 reach + 1,)."""

    reach: int
    gradient: np.ndarray  # of dW/dy with respect to the particle, 1/m3
    viscosity: np.ndarray  # (2, ...) half of |W'| (x / r)^2, since every other pair approaches in shear, and |W'| (y / r)^2, 1/m3
    moment_x: np.ndarray  # of -x dW/dx, 1/m2
    moment_y: np.ndarray  # of -y dW/dy


@functools.cache
def lattice_rows(kernel: Kernel, dx: float) -> Rows:
    """Row sums of a lattice of spacing dx (m)."""
    reach = math.ceil(2.0 * kernel.h / dx)
    offset = np.arange(-reach, reach + 1)
    x, y = np.meshgrid(offset * dx, offset * dx)
    r = np.hypot(x, y)
    with compile_lock(required=False):
        slope = np.array([evaluate(kernel, distance)[1] for distance in r.ravel()]).reshape(r.shape)
    weight = -slope / np.where(r > 0.0, r, 1.0)
    viscosity = np.array([0.5 * (weight * x * x).sum(1), (weight * y * y).sum(1)])
    return Rows(reach, -(slope * y).sum(1), viscosity, -(slope * x * x).sum(1), -(slope * y * y).sum(1))


def layer_weights(kernel: Kernel, dx: float, layers: int) -> np.ndarray:
    """Share (layers,) of a traction that each layer takes, the outermost first; they add up to 1."""
    rows = lattice_rows(kernel, dx)
    missing = np.cumsum(np.abs(rows.gradient[rows.reach + 1 :])[::-1])[::-1][:layers]
    missing = np.pad(missing, (0, layers - missing.size))
    return missing / missing.sum()


def ground_rows(scene: Scene, particles: Particles) -> tuple[int, int]:
    """Rows of soil under the ground at the left and the right side."""
    return tuple(  # type: ignore[return-value]
        int(np.count_nonzero(np.floor(particles.x[: particles.n_soil] / scene.numerics.spacing) == column))
        for column in (0, scene.lattice[0] - 1)
    )


def rows_below(scene: Scene) -> int:
    """Rows of the base that are nodes of the columns: all, or none where its particles have no state."""
    return 0 if scene.walls.kinds.base.reflects else scene.walls.layers


def free_field_nodes(scene: Scene, particles: Particles) -> tuple[int, int]:
    """Nodes of the left and the right column, none without absorbing sides."""
    if not scene.walls.kinds.sides.absorbs:
        return 0, 0
    left, right = ground_rows(scene, particles)
    return left + rows_below(scene), right + rows_below(scene)


def first_frequencies(scene: Scene, particles: Particles) -> np.ndarray:
    """First natural circular frequency of the ground at the left and the right side, (2, 2), 1/s, by the travel time of shear waves for
    horizontal motion and of pressure waves for vertical motion: pi / (2 sum of dx / V)."""
    found = np.zeros((2, 2))
    for side, (x, rows) in enumerate(zip((0.0, scene.geometry.width), ground_rows(scene, particles), strict=True)):
        y = (np.arange(rows) + 0.5) * scene.numerics.spacing
        soil = soil_of(scene, layer_index(scene, np.full(rows, x), y))
        for direction, speed in enumerate((soil.s_wave_speed, soil.p_wave_speed)):
            found[direction, side] = 0.5 * np.pi / (scene.numerics.spacing / speed).sum()
    return found


class Ground(NamedTuple):
    """Soil at places, or the bedrock everywhere; arrays (places,)."""

    density: np.ndarray
    s_wave_speed: np.ndarray
    p_wave_speed: np.ndarray

    @property
    def impedance(self) -> np.ndarray:
        """Of shear and of pressure waves, (2, places), kg/(m2 s)."""
        return self.density * np.array([self.s_wave_speed, self.p_wave_speed])


def soil_of(scene: Scene, layer: np.ndarray) -> Ground:
    """Soil of layers (places,)."""
    return Ground(*(np.array([getattr(soil, name) for soil in scene.soils])[layer] for name in Ground._fields))


def below(scene: Scene, layer: np.ndarray) -> Ground:
    """What an absorbing base stands on at places in these layers."""
    rock = scene.walls.bedrock
    return soil_of(scene, layer) if rock is None else Ground(*(np.full(layer.shape, getattr(rock, name)) for name in Ground._fields))


def make_free_field(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> FreeField:
    """Columns beside the model."""
    nodes = free_field_nodes(scene, particles)
    walls, numerics, dx = scene.walls, scene.numerics, scene.numerics.spacing
    rows = lattice_rows(kernel, dx)
    row = np.concatenate([np.arange(count) - rows_below(scene) for count in nodes])
    layer = layer_index(scene, np.repeat([0.0, scene.geometry.width], nodes), (row + 0.5) * dx)
    soil, fixed = soil_of(scene, layer), (row < 0) & (not walls.kinds.base.absorbs)
    weights = np.append(layer_weights(kernel, dx, walls.layers), 0.0)[np.minimum(row + walls.layers, walls.layers)]
    wall = dx * dx * _no_slip_base(scene, rows, row)
    # With linear reconstruction the motion of a column, smooth as it is, is left alone.
    plain = numerics.artificial_viscosity if ARTIFICIAL_VISCOSITY.wanted(scene) else None
    shear_modulus = soil.density * soil.s_wave_speed**2
    modulus = soil.density * soil.p_wave_speed**2
    return FreeField(
        begin=np.cumsum((0, *nodes)),
        gradient=dx * dx * rows.gradient,
        wall=wall,
        viscosity=dx * dx * rows.viscosity,
        density=soil.density,
        modulus=np.array([shear_modulus, modulus]),
        beside=1.0 - 2.0 * shear_modulus / modulus,
        impedance=(0.0 if plain is None else plain.alpha) * soil.impedance[1],
        correction=np.concatenate([_correction(scene, rows, count) for count in nodes]),
        drag=walls.kinds.base.absorbs * weights * below(scene, layer).impedance / (soil.density * dx),
        weight=weights,
        mobile=np.where(fixed, 0.0, 1.0),
    )


def _no_slip_base(scene: Scene, rows: Rows, row: np.ndarray) -> np.ndarray:
    """Twice the gradients (rows,) of all rows of a no-slip base, 1/m3; ``row`` counts from the first row of soil."""
    below = np.append(np.cumsum(rows.gradient[: rows.reach])[::-1], 0.0)
    return 2.0 * scene.walls.kinds.base.reflects * below[np.clip(row, 0, rows.reach)]


def _correction(scene: Scene, rows: Rows, count: int) -> np.ndarray:
    """Correction (count,) of the vertical gradient in a column of so many rows."""
    wanted = scene.numerics.gradient_correction
    if wanted is None:
        return np.ones(count)
    dx, row = scene.numerics.spacing, np.arange(count)
    moment_x, moment_y = (dx * dx * np.convolve(np.ones(count), moment)[rows.reach :][:count] for moment in (rows.moment_x, rows.moment_y))
    moment_y -= dx * dx * _no_slip_base(scene, rows, row) * (row + 0.5) * dx  # of a velocity that falls linearly to the face
    return np.where(moment_x * moment_y >= wanted.min_determinant, 1.0 / moment_y, 1.0)


@jit
def decay(rate: float, dt: float) -> tuple[float, float]:
    """What is left of a velocity after dt, and the time for which a constant force acts on it, s."""
    x = rate * dt
    keep = math.exp(-x)
    return keep, (dt * (1.0 - keep) / x if x > 1e-6 else dt)


@jit
def move(speed: float, push: float, rate: float, dt: float) -> float:
    """How far (m) a dashpot that slows at this rate lets go in dt what has this speed, under a constant acceleration."""
    keep, acting = decay(rate, dt)
    return (speed * (1.0 - keep) + push * (dt - acting)) / rate if rate * dt > 1e-6 else speed * dt


@slot
def kick_free_field(ground: FreeField | None, rayleigh: RayleighDamping | None, state: State, dt: float, loads: Loads, team: Team) -> None:
    """Kick the columns by one step, by the first of a team's threads."""


@kick_free_field.of(FreeField)
def _kick_free_field(ground: FreeField, rayleigh: RayleighDamping | None, state: State, dt: float, loads: Loads, team: Team) -> None:
    if team.rank == 0:
        rate = mass_damping(rayleigh) + loads.extra_damping
        for direction in range(2):
            column = state.free_field[direction]
            shaking = loads.ground if direction == 0 else loads.vertical
            for side in range(2):
                speed = push = slowed = 0.0
                for k in range(ground.begin[side], ground.begin[side + 1]):
                    speed += ground.weight[k] * column[VELOCITY, k]
                    push += ground.weight[k] * (column[ACCELERATION, k] - shaking)
                    slowed += ground.weight[k] * ground.drag[direction, k]
                base = move(speed, push, slowed, dt)
                keep, acting = decay(rate, dt)
                for k in range(ground.begin[side], ground.begin[side + 1]):
                    old = column[VELOCITY, k]
                    new = old * keep + (column[ACCELERATION, k] - shaking) * acting - ground.drag[direction, k] * base
                    new *= ground.mobile[k]
                    column[VELOCITY, k] = new
                    column[MEAN_VELOCITY, k] = 0.5 * (old + new)
    wait(team)


@slot
def strain_free_field(ground: FreeField | None, rayleigh: RayleighDamping | None, state: State, dt: float, team: Team) -> None:
    """Bring stresses and accelerations of the columns up to the velocities, by the first of a team's threads."""


@strain_free_field.of(FreeField)
def _strain_free_field(ground: FreeField, rayleigh: RayleighDamping | None, state: State, dt: float, team: Team) -> None:
    if team.rank == 0:
        reach = ground.gradient.size // 2
        damping = stiffness_damping(rayleigh)
        for direction in range(2):
            column = state.free_field[direction]
            for side in range(2):
                first, last = ground.begin[side], ground.begin[side + 1]
                for k in range(first, last):
                    strain_rate = -column[VELOCITY, k] * ground.wall[k]
                    viscous = 0.0
                    for j in range(max(first, k - reach), min(last, k + reach + 1)):
                        dv = column[VELOCITY, j] - column[VELOCITY, k]
                        g = ground.gradient[j - k + reach]
                        strain_rate += dv * g
                        if direction == 0 or dv * g < 0.0:  # pairs of particles that part do not feel the viscosity
                            viscous += 0.5 * (ground.impedance[k] + ground.impedance[j]) * dv * ground.viscosity[direction, j - k + reach]
                    stress_rate = ground.modulus[direction, k] * strain_rate * ground.correction[k]
                    column[ELASTIC_STRESS, k] += stress_rate * dt
                    column[STRESS, k] = column[ELASTIC_STRESS, k] + damping * stress_rate
                    column[ACCELERATION, k] = viscous / ground.density[k]
                for k in range(first, last):
                    force = column[STRESS, k] * ground.correction[k] * ground.wall[k]
                    for j in range(max(first, k - reach), min(last, k + reach + 1)):
                        stress = column[STRESS, k] * ground.correction[k] + column[STRESS, j] * ground.correction[j]
                        force += stress * ground.gradient[j - k + reach]
                    column[ACCELERATION, k] += force / ground.density[k]


@slot
def free_field_beside(ground: FreeField | None, state: State, node: int) -> tuple[float, float, float, float]:
    """Mean velocity over the step (x and y, m/s), and stress on an upright plane (xx and xy, Pa), of the free field."""
    return 0.0, 0.0, 0.0, 0.0


@free_field_beside.of(FreeField)
def _free_field_beside(ground: FreeField, state: State, node: int) -> tuple[float, float, float, float]:
    column = state.free_field
    return (
        column[0, MEAN_VELOCITY, node],
        column[1, MEAN_VELOCITY, node],
        ground.beside[node] * column[1, STRESS, node],
        column[0, STRESS, node],
    )


class FreeFieldState(NamedTuple):
    """What the term keeps of the state."""

    free_field: np.ndarray  # (2, 5, nodes) by direction of motion and ``VELOCITY`` to ``ACCELERATION``


def _start(scene: Scene, particles: Particles) -> FreeFieldState:
    return FreeFieldState(np.zeros((2, 5, sum(free_field_nodes(scene, particles)))))


TERM = Term(
    "free_field",
    "walls.sides",
    lambda scene: scene.walls.kinds.sides.absorbs,
    make_free_field,
    state=Arrays(FreeFieldState, _start, ("direction", "quantity", "node")),
)
