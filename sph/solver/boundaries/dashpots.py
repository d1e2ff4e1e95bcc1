"""Absorbing base and sides: boundary particles with dashpots on them, which let waves out.

A fixed box gives every wave back.  An absorbing boundary is made of the same particles as a fixed one, as many layers as fill the
kernel's support.  While gravity is brought on, those of the base are fixed and those of the sides settle with the soil as level ground
does, on rollers: a side that held the soil up would fail it.  Then the acceleration that balances the stress is noted as the static
reaction -r_i, and from there on they move as soil that does not fail, with dashpots and, at the sides, springs on them:

    a_i = (a_i by stress) - r_i - a_g - w_i / (rho_i dx) Z [(v - v_ff) + omega_1 (u_i - u_ff)] + w_i / (rho_i dx) tau_ff n.

**Base** (Lysmer and Kuhlemeyer 1969; Joyner and Chen 1975): Z = rho_r V_s,r along the base and rho_r V_p,r across it, of the bedrock below
(``walls.bedrock``; without one the soil goes on for ever), and v_ff = 0.  The frame then moves with the bedrock's *outcrop*, and so
the scene's motion is that of the outcrop, twice the wave that comes up, and displacements are relative to it.  As the impedance of the
bedrock grows the base becomes the rigid one.  The bedrock begins below the boundary particles, ``walls.layers`` spacings under y = 0.
v is the mean sum_j w_j v_j over the base's particles in a column, so that one traction -Z v acts on the column.  Dashpots on the v_i of
each layer are a drag within the soil: over stiff rock they held the upper layer too, and a layer of 20 spacings on rock of 20 times its
impedance swung 15 % too little in its first mode.  With ``walls.bedrock.spring_frequency`` f a spring of 2 pi f Z lies beside the dashpot:
rock under a loaded width b is one below V / (2 pi b).

**Sides**: Z = rho V_p across and rho V_s along, on what differs from the velocity v_ff of the level ground beside them, whose stresses
tau_ff on upright planes act too (``sph.solver.boundaries.free_field``); v is v_i.  omega_1 is the first natural frequency of that ground,
in shear for motion across the side and in compression for motion along it.  Ground on a rigid base takes waves away above omega_1 and is a
spring below it: that of a bar held along its length by such a spring is Z sqrt(omega_1^2 - omega^2), Z omega_1 at rest and i omega Z at
high frequencies, and of these two limits the side is made (Veletsos and Younan 1994 for the wall on such a layer).  Dashpots alone hold no
stress that changes for good: where the soil beside them yielded, they went away with Z v = change of traction, 1.2 m in 77 s of
shaking at 0.03 g.  What a spring holds is added to r_i.

**From column to column** the base resists bending, as the ground below it does.  Sums over neighbours do not see a motion that alternates
there, nor do dashpots on the mean of a column, and the pressure of disordered failed soil drove the columns apart by metres: slopes of 80
m/s on bedrock of 80 to 250 m/s that failed pushed their base away.  To -r_i is added

    -(V_s / 4 dx)^2 (fourth difference of u_i along the row),

with V_s of the softest soil there, and free ends as those of a beam.  Columns that alternate meet the stiffness of that soil in shear,
waves of eight spacings 2 % of it, and ground that moves or tilts as a whole nothing.

Each traction is spread over the layers by w_i as the kernel would spread the stress of the particles that are missing outside:
w_i is the sum of their kernel gradients.  Of the energy of a pulse five spacings wide 0.28 % then stay in a column, and 1.1 % at h = 2.3
spacings; dashpots on the outermost layer alone leave 1.0 and 23 %, on all layers alike 1.1 and 4.7 %.  Dashpots are integrated exactly
for a constant force and so do not limit the time step.

Limits.  A dashpot takes a wave that meets it square; grazing waves are given back in part, and waves near omega_1 as well.  Without a
spring the base holds no static load that comes later, and the static reaction goes on where the soil that it held has gone: the base then
moves for good, slowly, with Z v = change of traction.  In the paper's scene, which fails from wall to wall, it moves by 0.5 m in the end.
Keep sides at places that stay level, elastic ground.  Faces (``sph.solver.boundaries.faces``) do not guard these walls: debris that runs
over a side's ground falls out of the model and ends the run.  The static reaction is that at the end of the gravity stage: soil that still
swings then leaves a small false load.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.boundaries.free_field import (
    below,
    decay,
    first_frequencies,
    free_field_beside,
    free_field_nodes,
    layer_weights,
    move,
    rows_below,
    soil_of,
)
from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import by_reference
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import BASE, Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.rayleigh_damping import mass_damping
from sph.solver.physics.seepage import with_seepage

if TYPE_CHECKING:
    from sph.solver.integration import Loads
    from sph.solver.terms import State, Terms


@by_reference
class AbsorbingWalls(NamedTuple):
    """Boundary particles that move, by their number after the soil; directions x and y come first."""

    base: np.ndarray  # (2, boundary) deceleration by the dashpot below for a velocity of 1 m/s of its column, 1/s
    weight: np.ndarray  # (boundary,) of a particle of the base in the velocity of its column
    rate: np.ndarray  # (2, boundary) rate at which the dashpot slows the column, 1/s
    layers: int  # particles of the base in a column, which have consecutive numbers, or 1
    in_base: int  # particles of the base, which come first
    side: np.ndarray  # (2, boundary) that of the dashpots beside them
    spring: np.ndarray  # (2, boundary) stiffness of the ground beside them over their mass, 1/s2
    hold: np.ndarray  # (2, boundary) that of the bedrock below them
    bending: float  # stiffness of the base against bending over its mass, 1/s2
    outward: np.ndarray  # (boundary,) acceleration to the right by the free field's stress over that stress, m2/kg
    node: np.ndarray  # (boundary,) node of the free field beside


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
    weight = weights[np.where(particles.kind[moving] == BASE, layers + row, layers)] * scene.walls.kinds.base.absorbs
    base = over_mass * weight * below(scene, layer).impedance
    rock = scene.walls.bedrock
    held = 0.0 if rock is None or rock.spring_frequency is None else 2.0 * math.pi * rock.spring_frequency
    in_base = int(np.count_nonzero(particles.kind[moving] == BASE))
    rate = np.zeros_like(base)
    rate[:, :in_base] = np.repeat((weight * base)[:, :in_base].reshape(2, -1, layers).sum(axis=2), layers, axis=1)
    dashpots = side * soil_of(scene, layer).impedance[::-1]
    return AbsorbingWalls(
        base=base,
        weight=weight,
        rate=rate,
        layers=layers,
        in_base=in_base,
        side=dashpots,
        spring=dashpots * first_frequencies(scene, particles)[:, right.astype(int)],
        hold=held * base,
        bending=float((soil_of(scene, layer[:in_base]).s_wave_speed / (4.0 * dx)).min() ** 2) if in_base else 0.0,
        outward=np.where(right, side, -side),
        node=np.where(side > 0.0, row + rows_below(scene) + right * free_field_nodes(scene, particles)[0], 0),
    )


@jit
def _whole_column(walls: AbsorbingWalls, b: int) -> int:
    """First boundary particle from b on with which a column begins."""
    return -(-b // walls.layers) * walls.layers if 0 < b < walls.in_base else b


@jit
def _moves(
    walls: AbsorbingWalls, state: State, b: int, end: int, n_soil: int, ground: float, vertical: float, dt: float
) -> tuple[float, float]:
    """How far (m, along x and y) the column of the base of boundary particles b to end goes in a step."""
    vx = vy = ax = ay = 0.0
    for c in range(b, end):
        i, weight = n_soil + c, walls.weight[c]
        vx += weight * state.vx[i]
        vy += weight * state.vy[i]
        ax += weight * (state.ax[i] - state.reaction_x[c] - ground)
        ay += weight * (state.ay[i] - state.reaction_y[c] - vertical)
    return move(vx, ax, walls.rate[0, b], dt), move(vy, ay, walls.rate[1, b], dt)


@slot
def moved_rows(walls: AbsorbingWalls | None, n_soil: int, first: int, last: int) -> tuple[int, int]:
    """First and last row that the thread moves whose rows are first to last: whole columns of an absorbing base."""
    return first, last


@moved_rows.of(AbsorbingWalls)
def _moved_rows(walls: AbsorbingWalls, n_soil: int, first: int, last: int) -> tuple[int, int]:
    return _from_column(walls, n_soil, first), _from_column(walls, n_soil, last)


@jit
def _from_column(walls: AbsorbingWalls, n_soil: int, i: int) -> int:
    """First row from i on with which a column begins."""
    return n_soil + _whole_column(walls, i - n_soil) if i > n_soil else i


@slot
def kick_boundary(
    walls: AbsorbingWalls | None, state: State, terms: Terms, mass: np.ndarray, loads: Loads, first: int, last: int
) -> tuple[float, float, float, float]:
    """Move the absorbing boundary particles among first to last by one step; in the gravity stage only sides, and these up and down.

    Returns the works of the shaking and of gravity or the static reactions, and the
    energies taken by artificial viscosity and by the dashpots and mass damping (J/m).
    """
    return 0.0, 0.0, 0.0, 0.0


@kick_boundary.of(AbsorbingWalls)
def _kick_boundary(
    walls: AbsorbingWalls, state: State, terms: Terms, mass: np.ndarray, loads: Loads, first: int, last: int
) -> tuple[float, float, float, float]:
    shaking = held = viscous = taken = 0.0
    dt, ground, vertical, gravity = terms.dt, loads.ground, loads.vertical, loads.gravity
    rate = mass_damping(terms.rayleigh_damping) + loads.extra_damping
    if loads.time < terms.armed_from:
        for i in range(max(first, terms.n_soil), min(last, terms.n_moving)):
            b = i - terms.n_soil
            if walls.side[0, b] > 0.0 and walls.base[0, b] == 0.0:
                vy_old, weight = state.vy[i], gravity * terms.down_y
                fall = with_seepage(terms.seepage, state.x[i], state.y[i], mass[i], gravity, 0.0, weight)[1]
                keep, acting = decay(rate, dt)
                vy = vy_old * keep + (state.ay[i] + fall) * acting
                state.vy[i] = vy
                state.y[i] += vy * dt
                mean_y = 0.5 * (vy + vy_old)
                held += mass[i] * fall * mean_y
                viscous -= mass[i] * state.viscous_y[i] * mean_y
                taken += mass[i] * (state.ay[i] + fall - (vy - vy_old) / dt) * mean_y
    else:
        begin, end = max(first - terms.n_soil, 0), min(last, terms.n_moving) - terms.n_soil
        base_x = base_y = 0.0
        for b in range(_whole_column(walls, begin), _whole_column(walls, end)):
            i = b + terms.n_soil
            if b % walls.layers == 0 or b >= walls.in_base:
                members = walls.layers if b < walls.in_base else 1
                if math.isnan(state.reaction_x[b]):
                    for c in range(b, b + members):
                        state.reaction_x[c] = state.ax[terms.n_soil + c]
                        state.reaction_y[c] = state.ay[terms.n_soil + c]
                base_x, base_y = _moves(walls, state, b, b + members, terms.n_soil, ground, vertical, dt)
            free_vx, free_vy, free_xx, free_xy = free_field_beside(terms.free_field, state, walls.node[b])
            ax = state.ax[i] - state.reaction_x[b] - ground
            ay = state.ay[i] - state.reaction_y[b] - vertical
            vx_old, vy_old = state.vx[i], state.vy[i]
            keep, acting = decay(rate + walls.side[0, b], dt)
            vx = vx_old * keep + (ax + walls.side[0, b] * free_vx + walls.outward[b] * free_xx) * acting - walls.base[0, b] * base_x
            keep, acting = decay(rate + walls.side[1, b], dt)
            vy = vy_old * keep + (ay + walls.side[1, b] * free_vy + walls.outward[b] * free_xy) * acting - walls.base[1, b] * base_y
            state.vx[i] = vx
            state.vy[i] = vy
            state.x[i] += vx * dt
            state.y[i] += vy * dt
            mean_x, mean_y = 0.5 * (vx + vx_old), 0.5 * (vy + vy_old)
            shaking -= mass[i] * (ground * mean_x + vertical * mean_y)
            held -= mass[i] * (state.reaction_x[b] * mean_x + state.reaction_y[b] * mean_y)
            viscous -= mass[i] * (state.viscous_x[i] * mean_x + state.viscous_y[i] * mean_y)
            taken += mass[i] * ((ax - (vx - vx_old) / dt) * mean_x + (ay - (vy - vy_old) / dt) * mean_y)
            state.reaction_x[b] += (walls.spring[0, b] * (mean_x - free_vx) + walls.hold[0, b] * mean_x) * dt
            state.reaction_y[b] += (walls.spring[1, b] * (mean_y - free_vy) + walls.hold[1, b] * mean_y) * dt
    return shaking * dt, held * dt, viscous * dt, taken * dt


@slot
def resist_bending(walls: AbsorbingWalls | None, state: State, n_soil: int, dt: float, first: int, last: int) -> None:
    """Add to the reactions on the base's particles among first to last what resists bending in a step of ``dt``; to be called where
    velocities rest."""


@resist_bending.of(AbsorbingWalls)
def _resist_bending(walls: AbsorbingWalls, state: State, n_soil: int, dt: float, first: int, last: int) -> None:
    for i in range(max(first, n_soil), min(last, n_soil + walls.in_base)):
        b = i - n_soil
        state.reaction_x[b] += walls.bending * _fourth_difference(walls, state.vx, b, n_soil) * dt
        state.reaction_y[b] += walls.bending * _fourth_difference(walls, state.vy, b, n_soil) * dt


@jit
def _fourth_difference(walls: AbsorbingWalls, v: np.ndarray, b: int, n_soil: int) -> float:
    """That of v along the row of base particle b; its ends are free, as those of a beam."""
    return (
        _second_difference(walls, v, b - walls.layers, n_soil)
        - 2.0 * _second_difference(walls, v, b, n_soil)
        + _second_difference(walls, v, b + walls.layers, n_soil)
    )


@jit
def _second_difference(walls: AbsorbingWalls, v: np.ndarray, b: int, n_soil: int) -> float:
    left, i, right = n_soil + b - walls.layers, n_soil + b, n_soil + b + walls.layers
    if left < n_soil or right >= n_soil + walls.in_base:
        return 0.0
    return float(v[left] - 2.0 * v[i] + v[right])


class Reactions(NamedTuple):
    """What the term keeps of the state."""

    reaction_x: np.ndarray  # (boundary that moves,) acceleration that fixing balanced, m/s2; NaN in the gravity stage
    reaction_y: np.ndarray  # likewise


def _start(scene: Scene, particles: Particles) -> Reactions:
    nothing = np.full(particles.first_fixed - particles.n_soil, np.nan)
    return Reactions(nothing, nothing.copy())


TERM = Term(
    "absorbing_walls",
    "walls.base, walls.sides",
    lambda scene: any(kind.absorbs for kind in scene.walls.kinds),
    make_absorbing,
    state=Arrays(Reactions, _start, ("moving_boundary",)),
)
