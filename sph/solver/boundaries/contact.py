"""Contact with a wall: it bears no tension, and as much shear as the soil beside it has strength.

A contact wall is a no-slip wall (``sph.solver.boundaries.no_slip``) that lets go.  Since its stress is the soil's own, its shear is
what that soil can bear at the time: failed soil slides on it with what strength it has left.  A particle that the wall would pull,

    b . S b > T |b|^2 / rho^2,   S = sigma_i / rho_i^2,

with the wall's part b of the sum of kernel gradients and the tension T that the wall bears, and that moves away from it, sees no
wall in this step, neither in its strain nor in its force.  Both loops over pairs leave out the same particles, so that contact takes
no energy, but for the power of the one step in which it lets go.
"""

from __future__ import annotations

from typing import NamedTuple

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.physics.walls import detached


class Contact(NamedTuple):
    """Coefficients of the term."""

    first: int
    """first particle of contact walls, which come last of those without a state"""
    tension: float
    """that the walls bear, over the square of the reference density, Pa m6/kg2"""


@slot
def contact_part(term, j, gx, gy, sum_x, sum_y):  # type: ignore[no-untyped-def]
    """Sums of gradients over contact walls with that of wall particle j."""
    return sum_x, sum_y


@contact_part.of(Contact)
def _contact_part(term, j, gx, gy, sum_x, sum_y):  # type: ignore[no-untyped-def]
    touches = 1.0 if j >= term.first else 0.0
    return sum_x + touches * gx, sum_y + touches * gy


@slot
def keep_contact(term, contact, i, sum_x, sum_y):  # type: ignore[no-untyped-def]
    """Keep the sums of particle i in ``contact`` (n, 3); its third column says which share of them is let go."""


@keep_contact.of(Contact)
def _keep_contact(term, contact, i, sum_x, sum_y):  # type: ignore[no-untyped-def]
    contact[i, 0] = sum_x
    contact[i, 1] = sum_y
    contact[i, 2] = 0.0


@slot
def detach(term, state, contact, i):  # type: ignore[no-untyped-def]
    """Note whether contact lets particle i go in this step; returns the part of the wall's b that it then does not see, kg/m4."""
    return 0.0, 0.0


@detach.of(Contact)
def _detach(term, state, contact, i):  # type: ignore[no-untyped-def]
    bx, by = contact[i, 0], contact[i, 1]
    pull = state.sxx[i] * bx * bx + 2.0 * state.sxy[i] * bx * by + state.syy[i] * by * by
    leaves = state.vx[i] * bx + state.vy[i] * by < 0.0
    share = 1.0 if leaves and pull > term.tension * (bx * bx + by * by) else 0.0
    contact[i, 2] = share
    return share * bx, share * by


@detached.of(Contact)
def _detached(term, pairs, i):  # type: ignore[no-untyped-def]
    contact = pairs.contact
    return contact[i, 2] * contact[i, 0], contact[i, 2] * contact[i, 1]


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> Contact:
    return Contact(particles.first_contact, 1e3 * scene.walls.tension / scene.soil.density**2)


TERM = Term(
    "contact", "walls.base, walls.sides, walls.top: contact", lambda scene: any(kind.unilateral for kind in scene.walls.kinds), _make
)
