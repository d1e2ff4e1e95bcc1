"""No-slip walls without particles' states: soil sees its own velocity reversed behind the face, and its own stress.

With v_w = -v_i and sigma_w = sigma_i for every pair of a soil particle and one of the wall, the wall enters by one vector a particle,

    b_i = 2 sum over the wall of g_ij,    L_i gains -v_i b_i / rho_i,    a_i gains sigma_i / rho_i^2 . b_i,

and its particles need neither stress nor a place among the pairs.  The power of the force cancels that of the strain rate on the stress for
every particle, so that the wall takes no energy and gives none.  Fixed particles with a stress of their own (``fixed``) hold a layer that
slides on them by none to two thirds of its yield stress; this wall holds it by all of it (``docs/evidence/validation.md``, V7).

The wall's part in the moment matrix of the corrected gradient is that of a velocity which falls linearly to the face, so that the corrected
gradient is exact for such a field.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.boundaries.contact import contact_part, detach, keep_contact
from sph.solver.compiled.jit import jit, rows
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.gradient_correction import Sums
from sph.solver.physics.initial_arrangement import is_intact, offset
from sph.solver.physics.kernels import Kernel, support, value_and_slope
from sph.solver.physics.sums import GradientSums
from sph.solver.physics.walls import add_wall, add_wall_gradient, in_wall, paired

if TYPE_CHECKING:
    from sph.solver.boundaries.contact import Contact
    from sph.solver.neighbours import Candidates, Pairs, Places
    from sph.solver.terms import State, Terms


class NoSlip(NamedTuple):
    """Coefficients of the term."""

    first: int
    """first particle of the walls"""
    end: int
    """first particle after them"""
    bottom: float
    """y of the faces, m; infinite where there is no such wall"""
    top: float
    left: float
    """x of the faces, m"""
    right: float


@in_wall.of(NoSlip)
def _in_wall(no_slip: NoSlip, i: int) -> bool:
    return (i >= no_slip.first) & (i < no_slip.end)


@paired.of(NoSlip)
def _paired(no_slip: NoSlip, i: int, j: int) -> bool:
    return not (in_wall(no_slip, i) | in_wall(no_slip, j))


@jit
def _from_image(no_slip: NoSlip, x_i: float, y_i: float, x_j: float, y_j: float) -> tuple[float, float]:
    """Vector to particle i from its image behind the face of the wall of particle j, m."""
    if y_j < no_slip.bottom:
        return 0.0, 2.0 * max(y_i - no_slip.bottom, 0.0)
    if y_j > no_slip.top:
        return 0.0, 2.0 * min(y_i - no_slip.top, 0.0)
    if x_j < no_slip.left:
        return 2.0 * max(x_i - no_slip.left, 0.0), 0.0
    return 2.0 * min(x_i - no_slip.right, 0.0), 0.0


@add_wall.of(NoSlip)
def _add_wall(
    no_slip: NoSlip, terms: Terms, beside: bool, pairs: Pairs, candidates: Candidates, places: Places, i: int, sums: Sums
) -> Sums:
    kernel, contact, arrangement, x, y = terms.kernel, terms.contact, terms.initial_arrangement, places.x, places.y
    reach = support(kernel)
    b_x = b_y = contact_x = contact_y = 0.0
    m_xx, m_xy, m_yy = sums.m_xx, sums.m_xy, sums.m_yy
    if beside and not in_wall(no_slip, i):
        intact = is_intact(arrangement, pairs, i)
        for k in rows(candidates.start[i], candidates.end[i]):
            j = candidates.neighbour[k]
            dx, dy, _ = offset(arrangement, intact, terms.periodic, pairs, places, i, j)
            r_square = dx * dx + dy * dy
            if in_wall(no_slip, j) and r_square < reach * reach:
                slope = value_and_slope(kernel, math.sqrt(r_square))[1]
                gx, gy = 2.0 * terms.gradient_mass * slope * dx, 2.0 * terms.gradient_mass * slope * dy
                across, up = _from_image(no_slip, x[j] + dx, y[j] + dy, x[j], y[j])
                b_x += gx
                b_y += gy
                contact_x, contact_y = contact_part(contact, j, gx, gy, contact_x, contact_y)
                m_xx -= 0.5 * gx * across
                m_xy -= 0.25 * (gx * up + gy * across)
                m_yy -= 0.5 * gy * up
    pairs.wall[i, 0] = b_x
    pairs.wall[i, 1] = b_y
    keep_contact(contact, pairs.contact, i, contact_x, contact_y)
    return Sums(sums.x + b_x, sums.y + b_y, m_xx, m_xy, m_yy)


@add_wall_gradient.of(NoSlip)
def _add_wall_gradient(no_slip: NoSlip, contact: Contact | None, state: State, pairs: Pairs, i: int, sums: GradientSums) -> GradientSums:
    detached_x, detached_y = detach(contact, state, pairs.contact, i)
    b_x, b_y = pairs.wall[i, 0] - detached_x, pairs.wall[i, 1] - detached_y
    vx, vy = state.vx[i], state.vy[i]
    return GradientSums(sums.xx - vx * b_x, sums.xy - vx * b_y, sums.yx - vy * b_x, sums.yy - vy * b_y, sums.viscous_x, sums.viscous_y)


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> NoSlip:
    columns, count = scene.lattice
    dx = scene.numerics.spacing
    base, sides, top = scene.walls.kinds
    return NoSlip(
        particles.first_no_slip,
        particles.first_slip,
        bottom=0.0 if base.reflects else -math.inf,
        top=count * dx if top.reflects else math.inf,
        left=0.0 if sides.reflects else -math.inf,
        right=columns * dx if sides.reflects else math.inf,
    )


class NoSlipPairs(NamedTuple):
    """What the term keeps with the pairs."""

    wall: np.ndarray  # (n, 2) twice the sum of g over no-slip walls, kg/m4


def _room(n: int, size: int, dtype: np.dtype[Any]) -> NoSlipPairs:
    return NoSlipPairs(np.zeros((n, 2)))


TERM = Term(
    "no_slip",
    "walls.base, walls.sides, walls.top",
    lambda scene: any(kind.reflects for kind in scene.walls.kinds),
    _make,
    in_pairs=True,
    pairs=Arrays(NoSlipPairs, _room),
)
