"""Absorbing base and sides: boundary particles that let waves out.

A fixed box gives every wave back.  An absorbing boundary is made of the same particles as a fixed one, as many layers as fill the
kernel's support.  While gravity is brought on, those of the base are fixed and those of the sides settle with the soil as level ground
does, on rollers: a side that held the soil up would fail it.  Then the acceleration that balances the stress is noted as the static
reaction -r_i, and from there on they move as soil that does not fail, with dashpots on them:

    a_i = (a_i by stress) - r_i - a_g - w_i / (rho_i dx) Z (v_i - v_ff) + w_i / (rho_i dx) tau_ff n.

**Base** (Lysmer and Kuhlemeyer 1969; Joyner and Chen 1975): Z = rho_r V_s,r along the base and rho_r V_p,r across it, of the bedrock below
(``walls.bedrock``; without one the soil goes on for ever), and v_ff = 0.  The frame then moves with the bedrock's *outcrop*, and so
the scene's motion is that of the outcrop, twice the wave that comes up, and displacements are relative to it.  As the impedance of the
bedrock grows the base becomes the rigid one.  The bedrock begins below the boundary particles, ``walls.layers`` spacings under y = 0.

**Sides** (free-field boundary: Zienkiewicz, Bicanic and Shen 1989; FLAC's manual): beside each side stands a column of level ground as
high as the ground there, shaken by the same motion on the same base.  The side is joined to it with dashpots, rho V_p across and rho V_s
along, which feel only what differs from the column's velocity v_ff, and with its stresses on upright planes, the shear stress tau_ff
among them; so the waves that come up are left alone and what the slope sends out is taken.  A column is linear: elastic, with Rayleigh
damping and with what artificial viscosity amounts to there.  Horizontal and vertical motion do not know of each other in it.  It is the
sum of the lattice's rows, the same operator as that of a model with periodic sides, whose waves travel as the model's do at any
resolution; nodes are the rows, boundary rows of the base among them.  The particles of a no-slip base have no state, so that its rows are
no nodes: the lowest rows of soil see it as the soil does (``sph.solver.boundaries.no_slip``), with twice its rows' gradients as b_k,

    strain rate_k gains -v_k b_k,    a_k gains sigma_k b_k / rho_k.

A contact base is to the columns what a no-slip base is; they do not lift off it.

Each traction is spread over the layers by w_i as the kernel would spread the stress of the particles that are missing outside:
w_i is the sum of their kernel gradients.  Of the energy of a pulse five spacings wide 0.28 % then stay in a column, and 1.1 % at h = 2.3
spacings; dashpots on the outermost layer alone leave 1.0 and 23 %, on all layers alike 1.1 and 4.7 %.  Dashpots are integrated exactly
for a constant force and so do not limit the time step.

Limits.  A dashpot takes a wave that meets it square; grazing waves are given back in part.  It holds no static load that comes
later, and the static reaction goes on where the soil that it held has gone: the boundary then moves for good, slowly, with Z v = change of
traction.  In the paper's scene, which fails from wall to wall, sides move by 1.5 m in the end and the base by 0.5 m.  Keep sides at
places that stay level, elastic ground.  Faces (``sph.solver.boundaries.faces``) do not guard these walls: debris that runs over
a side's ground falls out of the model and ends the run.  The static reaction is that at the end of the gravity stage:
soil that still swings then leaves a small false load.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock, jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.threads import wait
from sph.solver.optional import Term
from sph.solver.particles import BASE, Particles, layer_index
from sph.solver.physics.artificial_viscosity import TERM as ARTIFICIAL_VISCOSITY
from sph.solver.physics.kernels import Kernel, evaluate
from sph.solver.physics.rayleigh_damping import stiffness_damping
from sph.solver.physics.seepage import with_seepage

VELOCITY, MEAN_VELOCITY, ELASTIC_STRESS, STRESS, ACCELERATION = range(5)
"""Second index of ``State.free_field``, after the direction of motion (0: x, 1: y): velocity (m/s) half a step behind, its mean over the
kick, elastic stress on level planes (Pa), that with damping, acceleration (m/s2)."""


@by_reference
class AbsorbingWalls(NamedTuple):
    """Boundary particles that move, by their number after the soil; directions x and y come first."""

    base: np.ndarray  # (2, boundary) rate at which the dashpots below slow them, 1/s
    side: np.ndarray  # (2, boundary) that of the dashpots beside them
    outward: np.ndarray  # (boundary,) acceleration to the right by the free field's stress over that stress, m2/kg
    node: np.ndarray  # (boundary,) node of the free field beside


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
    drag: np.ndarray  # (2, nodes) rate of the dashpots below, 1/s
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


def _rows_below(scene: Scene) -> int:
    """Rows of the base that are nodes of the columns: all, or none where its particles have no state."""
    return 0 if scene.walls.kinds.base.reflects else scene.walls.layers


def free_field_nodes(scene: Scene, particles: Particles) -> tuple[int, int]:
    """Nodes of the left and the right column, none without absorbing sides."""
    if not scene.walls.kinds.sides.absorbs:
        return 0, 0
    left, right = ground_rows(scene, particles)
    return left + _rows_below(scene), right + _rows_below(scene)


class Ground(NamedTuple):
    """Soil at places, or the bedrock everywhere; arrays (places,)."""

    density: np.ndarray
    s_wave_speed: np.ndarray
    p_wave_speed: np.ndarray

    @property
    def impedance(self) -> np.ndarray:
        """Of shear and of pressure waves, (2, places), kg/(m2 s)."""
        return self.density * np.array([self.s_wave_speed, self.p_wave_speed])


def _soil(scene: Scene, layer: np.ndarray) -> Ground:
    """Soil of layers (places,)."""
    return Ground(*(np.array([getattr(soil, name) for soil in scene.soils])[layer] for name in Ground._fields))


def _below(scene: Scene, layer: np.ndarray) -> Ground:
    """What an absorbing base stands on at places in these layers."""
    rock = scene.walls.bedrock
    return _soil(scene, layer) if rock is None else Ground(*(np.full(layer.shape, getattr(rock, name)) for name in Ground._fields))


def make_absorbing(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> AbsorbingWalls:
    """Dashpots of the boundary particles that move."""
    dx, columns, layers = scene.numerics.spacing, scene.lattice[0], scene.walls.layers
    moving = slice(particles.n_soil, particles.first_fixed)
    layer, over_mass = particles.layer[moving], dx / particles.mass[moving]
    column, row = (np.floor(a[moving] / dx).astype(int) for a in (particles.x, particles.y))
    right = column >= columns
    # How many layers lie outside a particle's own, where it belongs to a wall at all; the last weight is for those that do not.
    weights = np.append(layer_weights(kernel, dx, layers), 0.0)
    beside = np.where(right, layers - 1 - (column - columns), layers + column)
    side = over_mass * weights[np.where((column < 0) | right, beside, layers)] * scene.walls.kinds.sides.absorbs
    base = over_mass * weights[np.where(particles.kind[moving] == BASE, layers + row, layers)]
    return AbsorbingWalls(
        base=base * _below(scene, layer).impedance,
        side=side * _soil(scene, layer).impedance[::-1],
        outward=np.where(right, side, -side),
        node=np.where(side > 0.0, row + _rows_below(scene) + right * free_field_nodes(scene, particles)[0], 0),
    )


def make_free_field(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> FreeField:
    """Columns beside the model."""
    nodes = free_field_nodes(scene, particles)
    walls, numerics, dx = scene.walls, scene.numerics, scene.numerics.spacing
    rows = lattice_rows(kernel, dx)
    row = np.concatenate([np.arange(count) - _rows_below(scene) for count in nodes])
    layer = layer_index(scene, np.repeat([0.0, scene.geometry.width], nodes), (row + 0.5) * dx)
    soil, fixed = _soil(scene, layer), (row < 0) & (not walls.kinds.base.absorbs)
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
        drag=walls.kinds.base.absorbs * weights * _below(scene, layer).impedance / (soil.density * dx),
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
def _decay(rate, dt):  # type: ignore[no-untyped-def]
    """What is left of a velocity after dt, and the time for which a constant force acts on it, s."""
    x = rate * dt
    keep = math.exp(-x)
    return keep, (dt * (1.0 - keep) / x if x > 1e-6 else dt)


@jit
def kick_free_field(term, state, dt, rate, ground, vertical, team):  # type: ignore[no-untyped-def]
    """Kick the columns by one step, shaken with ``ground`` and ``vertical`` (m/s2); ``rate`` of mass-proportional damping in 1/s."""
    if term is None:
        return
    else:
        if team.rank == 0:
            for direction in range(2):
                column = state.free_field[direction]
                shaking = ground if direction == 0 else vertical
                for k in range(term.density.size):
                    keep, acting = _decay(rate + term.drag[direction, k], dt)
                    old = column[VELOCITY, k]
                    new = term.mobile[k] * (old * keep + (column[ACCELERATION, k] - shaking) * acting)
                    column[VELOCITY, k] = new
                    column[MEAN_VELOCITY, k] = 0.5 * (old + new)
        wait(team)


@jit
def strain_free_field(term, rayleigh, state, dt, team):  # type: ignore[no-untyped-def]
    """Bring stresses and accelerations of the columns up to the velocities, by the first of a team's threads."""
    if term is None:
        return
    else:
        if team.rank == 0:
            reach = term.gradient.size // 2
            damping = stiffness_damping(rayleigh)
            for direction in range(2):
                column = state.free_field[direction]
                for side in range(2):
                    first, last = term.begin[side], term.begin[side + 1]
                    for k in range(first, last):
                        strain_rate = -column[VELOCITY, k] * term.wall[k]
                        viscous = 0.0
                        for j in range(max(first, k - reach), min(last, k + reach + 1)):
                            dv = column[VELOCITY, j] - column[VELOCITY, k]
                            g = term.gradient[j - k + reach]
                            strain_rate += dv * g
                            if direction == 0 or dv * g < 0.0:  # pairs of particles that part do not feel the viscosity
                                viscous += 0.5 * (term.impedance[k] + term.impedance[j]) * dv * term.viscosity[direction, j - k + reach]
                        stress_rate = term.modulus[direction, k] * strain_rate * term.correction[k]
                        column[ELASTIC_STRESS, k] += stress_rate * dt
                        column[STRESS, k] = column[ELASTIC_STRESS, k] + damping * stress_rate
                        column[ACCELERATION, k] = viscous / term.density[k]
                    for k in range(first, last):
                        force = column[STRESS, k] * term.correction[k] * term.wall[k]
                        for j in range(max(first, k - reach), min(last, k + reach + 1)):
                            stress = column[STRESS, k] * term.correction[k] + column[STRESS, j] * term.correction[j]
                            force += stress * term.gradient[j - k + reach]
                        column[ACCELERATION, k] += force / term.density[k]


@jit
def _beside(term, state, node):  # type: ignore[no-untyped-def]
    """Mean velocity over the step (x and y, m/s), and stress on an upright plane (xx and xy, Pa), of the free field."""
    if term is None:
        return 0.0, 0.0, 0.0, 0.0
    else:
        column = state.free_field
        return (
            column[0, MEAN_VELOCITY, node],
            column[1, MEAN_VELOCITY, node],
            term.beside[node] * column[1, STRESS, node],
            column[0, STRESS, node],
        )


@jit
def kick_boundary(term, state, terms, mass, rate, ground, vertical, gravity, time, first, last):  # type: ignore[no-untyped-def]
    """Move the absorbing boundary particles among first to last by one step; in the gravity stage only sides, and these up and down.

    ``rate`` of mass-proportional damping in 1/s.  Returns the works of the shaking and of gravity or the static reactions, and the
    energies taken by artificial viscosity and by the dashpots and mass damping (J/m).
    """
    if term is None:
        return 0.0, 0.0, 0.0, 0.0
    else:
        shaking = held = viscous = taken = 0.0
        dt = terms.dt
        if time < terms.armed_from:
            for i in range(max(first, terms.n_soil), min(last, terms.n_moving)):
                b = i - terms.n_soil
                if term.side[0, b] > 0.0 and term.base[0, b] == 0.0:
                    vy_old, weight = state.vy[i], gravity * terms.down_y
                    fall = with_seepage(terms.seepage, state.x[i], state.y[i], mass[i], gravity, 0.0, weight)[1]
                    keep, acting = _decay(rate, dt)
                    vy = vy_old * keep + (state.ay[i] + fall) * acting
                    state.vy[i] = vy
                    state.y[i] += vy * dt
                    mean_y = 0.5 * (vy + vy_old)
                    held += mass[i] * fall * mean_y
                    viscous -= mass[i] * state.viscous_y[i] * mean_y
                    taken += mass[i] * (state.ay[i] + fall - (vy - vy_old) / dt) * mean_y
        else:
            for i in range(max(first, terms.n_soil), min(last, terms.n_moving)):
                b = i - terms.n_soil
                if math.isnan(state.reaction_x[b]):
                    state.reaction_x[b] = state.ax[i]
                    state.reaction_y[b] = state.ay[i]
                free_vx, free_vy, free_xx, free_xy = _beside(terms.free_field, state, term.node[b])
                ax = state.ax[i] - state.reaction_x[b] - ground
                ay = state.ay[i] - state.reaction_y[b] - vertical
                vx_old, vy_old = state.vx[i], state.vy[i]
                keep, acting = _decay(rate + term.base[0, b] + term.side[0, b], dt)
                vx = vx_old * keep + (ax + term.side[0, b] * free_vx + term.outward[b] * free_xx) * acting
                keep, acting = _decay(rate + term.base[1, b] + term.side[1, b], dt)
                vy = vy_old * keep + (ay + term.side[1, b] * free_vy + term.outward[b] * free_xy) * acting
                state.vx[i] = vx
                state.vy[i] = vy
                state.x[i] += vx * dt
                state.y[i] += vy * dt
                mean_x, mean_y = 0.5 * (vx + vx_old), 0.5 * (vy + vy_old)
                shaking -= mass[i] * (ground * mean_x + vertical * mean_y)
                held -= mass[i] * (state.reaction_x[b] * mean_x + state.reaction_y[b] * mean_y)
                viscous -= mass[i] * (state.viscous_x[i] * mean_x + state.viscous_y[i] * mean_y)
                taken += mass[i] * ((ax - (vx - vx_old) / dt) * mean_x + (ay - (vy - vy_old) / dt) * mean_y)
        return shaking * dt, held * dt, viscous * dt, taken * dt


ABSORBING_WALLS = Term(
    "absorbing_walls", "walls.base, walls.sides", lambda scene: any(kind.absorbs for kind in scene.walls.kinds), make_absorbing
)
FREE_FIELD = Term("free_field", "walls.sides", lambda scene: scene.walls.kinds.sides.absorbs, make_free_field)
