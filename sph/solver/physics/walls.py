"""What the loops over particles and pairs ask of the walls.

Physics knows walls as arguments of these functions, whose own bodies are the case without them.  The kinds of wall in
``sph.solver.boundaries`` know the physics, and give theirs.
"""

from __future__ import annotations

from sph.solver.compiled.slots import slot


@slot
def wrap(period, dx):  # type: ignore[no-untyped-def]
    """Horizontal distance to the nearest image of a neighbour, m."""
    return dx


@slot
def in_wall(term, i):  # type: ignore[no-untyped-def]
    """Whether particle i belongs to a no-slip wall."""
    return False


@slot
def paired(term, i, j):  # type: ignore[no-untyped-def]
    """Whether particles i and j act on each other as a pair: those of a no-slip wall do not."""
    return True


@slot
def add_wall(term, terms, beside, pairs, candidates, places, i, sums):  # type: ignore[no-untyped-def]
    """Sums over the pairs of particle i (``sph.solver.physics.gradient_correction.Sums``) with the part of no-slip walls, which is kept.

    ``beside`` says whether it has candidates in them.
    """
    return sums


@slot
def add_wall_gradient(term, contact, state, pairs, i, vx, vy, l_xx, l_xy, l_yx, l_yy):  # type: ignore[no-untyped-def]
    """Sums of velocity differences times g of particle i with the part of no-slip walls."""
    return l_xx, l_xy, l_yx, l_yy


@slot
def detached(term, pairs, i):  # type: ignore[no-untyped-def]
    """The part of the sum of g that particle i does not see in this step, because contact has let it go, kg/m4."""
    return 0.0, 0.0
