"""What the loops over particles and pairs ask of the walls.

Physics knows walls as arguments of these functions, whose own bodies are the case without them.  The kinds of wall in
``sph.solver.boundaries`` know the physics, and give theirs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sph.solver.compiled.slots import slot

if TYPE_CHECKING:
    from sph.solver.neighbours import Candidates, Pairs, Places
    from sph.solver.physics.gradient_correction import Sums
    from sph.solver.physics.sums import GradientSums
    from sph.solver.terms import State, Terms


@slot
def wrap(period: Any, dx: float) -> float:
    """Horizontal distance to the nearest image of a neighbour, m."""
    return dx


@slot
def in_wall(no_slip: Any, i: int) -> bool:
    """Whether particle i belongs to a no-slip wall."""
    return False


@slot
def paired(no_slip: Any, i: int, j: int) -> bool:
    """Whether particles i and j act on each other as a pair: those of a no-slip wall do not."""
    return True


@slot
def add_wall(no_slip: Any, terms: Terms, beside: bool, pairs: Pairs, candidates: Candidates, places: Places, i: int, sums: Sums) -> Sums:
    """Sums over the pairs of particle i (``sph.solver.physics.gradient_correction.Sums``) with the part of no-slip walls, which is kept.

    ``beside`` says whether it has candidates in them.
    """
    return sums


@slot
def add_wall_gradient(no_slip: Any, contact: Any, state: State, pairs: Pairs, i: int, sums: GradientSums) -> GradientSums:
    """Sums of velocity differences times g of particle i with the part of no-slip walls."""
    return sums


@slot
def detached(contact: Any, pairs: Pairs, i: int) -> tuple[float, float]:
    """The part of the sum of g that particle i does not see in this step, because contact has let it go, kg/m4."""
    return 0.0, 0.0
