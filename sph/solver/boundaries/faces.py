"""The faces of the walls: no soil passes between the particles of a wall.

Walls are particles, and their forces alone do not keep loose soil in the box: nothing stops a particle half-way between two of the
wall's, so that debris sinks through a slip floor and a slamming soft soil enters a fixed wall.  The face, half a spacing before the wall's
first particles, therefore pushes with a linear, conservative spring: at a free-slip wall what comes nearer than 0.4 spacings, at a
fixed one, which the soil sticks to, only what is behind the face (``sph.scene.walls.KINDS``).  The initial lattice lies half a spacing away
and feels nothing; in the paper's scene no soil ever reaches a face.  Friction counts the push of a slip wall as it counts its stress.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.boundaries.friction import add_push
from sph.solver.compiled.jit import jit, rows
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel

if TYPE_CHECKING:
    from sph.solver.boundaries.friction import WallFriction
    from sph.solver.terms import State

STIFFNESS = 0.2
"""Stiffness of a face's push over the soil's constrained modulus: it adds a fortieth to the square of the stiffest mode's frequency."""


class WallFaces(NamedTuple):
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


@slot
def push_from_faces(faces: WallFaces | None, friction: WallFriction | None, state: State, mass: np.ndarray, first: int, last: int) -> float:
    """Add the push of the walls' faces to soil particles first to last, and its friction; returns the energy it stores, J/m."""
    return 0.0


@push_from_faces.of(WallFaces)
def _push_from_faces(faces: WallFaces, friction: WallFriction | None, state: State, mass: np.ndarray, first: int, last: int) -> float:
    energy = 0.0
    for i in rows(first, last):
        x, y = state.x[i], state.y[i]
        across = up = 0.0  # how far the particle is in a contact, m, with the sign of the push
        if y <= faces.height:
            across = _overlap(faces, x - faces.left, faces.right - x, faces.side_contact, faces.side_contact)
        if faces.begin <= x <= faces.end:
            up = _overlap(faces, y - faces.bottom, faces.top - y, faces.bottom_contact, faces.top_contact)
        if across != 0.0 or up != 0.0:
            energy += 0.5 * faces.stiffness * (across * across + up * up)
            state.ax[i] += faces.stiffness * across / mass[i]
            state.ay[i] += faces.stiffness * up / mass[i]
            add_push(friction, state, i, faces.stiffness * abs(across) / mass[i], faces.stiffness * abs(up) / mass[i])
    return energy


@jit
def _overlap(faces: WallFaces, low: float, high: float, low_contact: float, high_contact: float) -> float:
    """Overlap with the contact of the face below (positive) or above (negative) at these distances, m."""
    if -faces.thickness < low < low_contact:
        return low_contact - low
    if -faces.thickness < high < high_contact:
        return high - high_contact
    return 0.0


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> WallFaces:
    walls, dx = scene.walls, scene.numerics.spacing
    base, sides, top = walls.kinds
    columns, rows = scene.lattice
    overhang = math.inf if sides.periodic else walls.layers * dx if sides.stands else 0.0
    return WallFaces(
        bottom=0.0 if base.stands else -math.inf,
        top=rows * dx if top.stands else math.inf,
        left=0.0 if sides.stands else -math.inf,
        right=columns * dx if sides.stands else math.inf,
        begin=-overhang,
        end=columns * dx + overhang,
        height=rows * dx,
        bottom_contact=base.face * dx,
        top_contact=top.face * dx,
        side_contact=sides.face * dx,
        thickness=dx,
        stiffness=STIFFNESS * max(soil.density * soil.p_wave_speed**2 for soil in scene.soils),
    )


TERM = Term(
    "wall_faces", "walls: no soil passes between their particles", lambda scene: any(kind.stands for kind in scene.walls.kinds), _make
)
