"""Contact with a wall: it bears no tension, and as much shear as the soil beside it has strength.

A contact wall is a no-slip wall (``sph.solver.boundaries.no_slip``) that lets go.  Since its stress is the soil's own, its shear is
what that soil can bear at the time: failed soil slides on it with what strength it has left.  A particle that the wall would pull,

    b . S b > T |b|^2 / rho^2,   S = sigma_i / rho_i^2,

with the wall's part b of the sum of kernel gradients and the tension T that the wall bears, and that moves away from it, sees no
wall in this step, neither in its strain nor in its force.  Both loops over pairs leave out the same particles, so that contact takes
no energy, but for the power of the one step in which it lets go.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.walls import detached

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.terms import State


class Contact(NamedTuple):
    """Coefficients of the term."""

    first: int
    """first particle of contact walls, which come last of those without a state"""
    tension: float
    """that the walls bear, over the square of the reference density, Pa m6/kg2"""


@slot
def contact_part(contact: Contact | None, j: int, gx: float, gy: float, sum_x: float, sum_y: float) -> tuple[float, float]:
    """Sums of gradients over contact walls with that of wall particle j."""
    return sum_x, sum_y


@contact_part.of(Contact)
def _contact_part(contact: Contact, j: int, gx: float, gy: float, sum_x: float, sum_y: float) -> tuple[float, float]:
    touches = 1.0 if j >= contact.first else 0.0
    return sum_x + touches * gx, sum_y + touches * gy


@slot
def keep_contact(contact: Contact | None, parts: np.ndarray, i: int, sum_x: float, sum_y: float) -> None:
    """Keep the sums of particle i in ``contact`` (n, 3); its third column says which share of them is let go."""


@keep_contact.of(Contact)
def _keep_contact(contact: Contact, parts: np.ndarray, i: int, sum_x: float, sum_y: float) -> None:
    parts[i, 0] = sum_x
    parts[i, 1] = sum_y
    parts[i, 2] = 0.0


@slot
def detach(contact: Contact | None, state: State, parts: np.ndarray, i: int) -> tuple[float, float]:
    """Note whether contact lets particle i go in this step; returns the part of the wall's b that it then does not see, kg/m4."""
    return 0.0, 0.0


@detach.of(Contact)
def _detach(contact: Contact, state: State, parts: np.ndarray, i: int) -> tuple[float, float]:
    bx, by = parts[i, 0], parts[i, 1]
    pull = state.sxx[i] * bx * bx + 2.0 * state.sxy[i] * bx * by + state.syy[i] * by * by
    leaves = state.vx[i] * bx + state.vy[i] * by < 0.0
    share = 1.0 if leaves and pull > contact.tension * (bx * bx + by * by) else 0.0
    parts[i, 2] = share
    return share * bx, share * by


@detached.of(Contact)
def _detached(contact: Contact, pairs: Pairs, i: int) -> tuple[float, float]:
    parts = pairs.contact
    return parts[i, 2] * parts[i, 0], parts[i, 2] * parts[i, 1]


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Contact:
    return Contact(particles.first_contact, 1e3 * scene.walls.tension / scene.soil.density**2)


class ContactPairs(NamedTuple):
    """What the term keeps with the pairs."""

    contact: np.ndarray  # (n, 3) the part of that of contact walls, and which share of it is let go in a step


def _room(n: int, size: int, dtype: np.dtype[Any]) -> ContactPairs:
    return ContactPairs(np.zeros((n, 3)))


TERM = Term(
    "contact",
    "walls.base, walls.sides, walls.top: contact",
    lambda scene: any(kind.unilateral for kind in scene.walls.kinds),
    _make,
    in_pairs=True,
    pairs=Arrays(ContactPairs, _room),
)
