"""Friction and cohesion on free-slip walls.

Friction acts on the soil within the kernel's reach of a wall, each particle with as much of it as it has of the wall's
normal force: the wall's particles press on particle i with sum_j (sigma_i + sigma_j) . g_ij over them, and friction
opposes its velocity along the wall with the coefficient times that, or stops it (``sph.solver.integration``).  Cohesion c
adds the force that a normal stress of c would give.  A wall that pulls gives neither.  The soil's own shear stress, which is
there once friction acts, would pull at the wall as well (sigma_i . g_ij has a part along the wall); that part is taken away,
so that friction is all there is along the wall.
Steady sliding of an elastic body under constant friction is unstable in itself (Adams 1995): without damping a block of
stiff soil begins to hum after some tenths of a second, lifts off and slides wrongly.  Stiffness-proportional damping
(``damping`` with one of its frequencies near zero, so that no mass damping brakes the sliding) keeps it down.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import jit
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.gradient_correction import transposed_shear
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.material import lightness

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import State, Terms


class WallFriction(NamedTuple):
    """Coefficients of the term."""

    first: int
    """first particle of walls that slip"""
    first_side: int
    """first of those that belong to a side wall; they come last"""
    base: float
    """coefficient at base and top"""
    sides: float
    base_cohesion: float
    """over the square of the reference density, Pa m6/kg2"""
    sides_cohesion: float


@jit
def _held(limit: float, v: float, dt: float) -> float:
    """Velocity (m/s) after friction of at most ``limit`` (m/s2) has opposed it for a step."""
    return math.copysign(max(abs(v) - limit * dt, 0.0), v)


@slot
def apply_wall_friction(friction: WallFriction | None, state: State, i: int, vx: float, vy: float, dt: float) -> tuple[float, float]:
    """Velocity of particle i after the friction of the walls."""
    return vx, vy


@apply_wall_friction.of(WallFriction)
def _apply_wall_friction(friction: WallFriction, state: State, i: int, vx: float, vy: float, dt: float) -> tuple[float, float]:
    return _held(state.friction_x[i], vx, dt), _held(state.friction_y[i], vy, dt)


@jit
def _strength(friction: float, cohesion: float, normal: float, room: float) -> float:
    """Of the interface to a wall that presses with ``normal`` (m/s2) by kernel gradients of the sum ``room`` (kg/m4), m/s2."""
    return friction * normal + 2.0 * cohesion * room if normal > 0.0 else 0.0


@slot
def add_push(friction: WallFriction | None, state: State, i: int, push_x: float, push_y: float) -> None:
    """Add the friction that the push (m/s2) of a wall's face gives particle i."""


@add_push.of(WallFriction)
def _add_push(friction: WallFriction, state: State, i: int, push_x: float, push_y: float) -> None:
    state.friction_x[i] += friction.base * push_y
    state.friction_y[i] += friction.sides * push_x


@slot
def set_friction(friction: WallFriction | None, terms: Terms, state: State, pairs: Pairs, mass: np.ndarray, first: int, last: int) -> float:
    """Largest acceleration that the walls' friction can give soil particles first to last (m/s2), in place of the walls' shear.

    Returns the energy over dt that goes with the shear taken away, W/m.
    """
    return 0.0


@set_friction.of(WallFriction)
def _set_friction(friction: WallFriction, terms: Terms, state: State, pairs: Pairs, mass: np.ndarray, first: int, last: int) -> float:
    correction, layers, taken = terms.gradient_correction, terms.layers, 0.0
    sxx, syy, sxy = state.sxx, state.syy, state.sxy
    for i in range(first, last):
        base = side = base_shear = side_shear = base_room = side_room = 0.0
        for k in neighbours_of(pairs, pairs.start[i], pairs.end[i]):
            j = pairs.neighbour[k]
            gx, gy = pairs.gx[k], pairs.gy[k]  # towards the wall, compression is negative
            if j >= friction.first:
                shear = transposed_shear(correction, state, i) + transposed_shear(correction, state, j)
                ax = (sxx[i] + sxx[j]) * gx + (sxy[i] + sxy[j]) * gy
                ay = shear * gx + (syy[i] + syy[j]) * gy
                if j >= friction.first_side:
                    side -= math.copysign(1.0, gx) * ax
                    side_shear += ay
                    side_room += abs(gx)
                else:
                    base -= math.copysign(1.0, gy) * ay
                    base_shear += ax
                    base_room += abs(gy)
        base_shear *= lightness(layers, i)
        side_shear *= lightness(layers, i)
        state.friction_x[i] = _strength(friction.base, friction.base_cohesion, base, base_room) * lightness(layers, i)
        state.friction_y[i] = _strength(friction.sides, friction.sides_cohesion, side, side_room) * lightness(layers, i)
        state.ax[i] -= base_shear
        state.ay[i] -= side_shear
        taken += mass[i] * (base_shear * state.vx[i] + side_shear * state.vy[i])
    return taken


class FrictionState(NamedTuple):
    """What the term keeps of the state."""

    friction_x: np.ndarray  # (n,) largest acceleration that friction on base and top can give, m/s2
    friction_y: np.ndarray  # (n,) that of the side walls


def _start(scene: Scene, particles: Particles) -> FrictionState:
    n = particles.x.size
    return FrictionState(np.zeros(n), np.zeros(n))


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> WallFriction:
    wanted, unit = scene.walls.friction, 1e3 / scene.soil.density**2
    assert wanted is not None
    first, first_side = particles.first_slip, particles.first_slip_side
    return WallFriction(first, first_side, wanted.base, wanted.sides, unit * wanted.base_cohesion, unit * wanted.sides_cohesion)


TERM = Term("wall_friction", "walls.friction", lambda scene: scene.walls.friction is not None, _make, state=Arrays(FrictionState, _start))
