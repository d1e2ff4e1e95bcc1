"""The solid state of soil that has failed: elastic, as the paper prints it, or kept on its yield surface.

Eq. 10 gives the solid state no yield surface, and Eqs. 8 and 9 only let it fade.  With this term the solid state of a particle is
elastic from t_f on: its deviator is not returned and its tension not limited, and what it adds to the stress, about beta G times the
strain since t_f, is bounded by beta alone.  Soil is then let go exponentially slowly.  Without the term it stays on its yield surface
(elastic, perfectly plastic) and adds at most beta times the peak strength.  Before t_f the two are the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sph.scene.schema import Scene
from sph.solver.compiled.slots import slot
from sph.solver.optional import Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel
from sph.solver.state import FAILED

if TYPE_CHECKING:
    from sph.solver.terms import State


class ElasticAfterFailure(NamedTuple):
    """The term; it has no coefficients."""


@slot
def yields(elastic: ElasticAfterFailure | None, state: State, i: int) -> bool:
    """Whether the solid state of particle i is bounded by its yield surface."""
    return True


@yields.of(ElasticAfterFailure)
def _yields(elastic: ElasticAfterFailure, state: State, i: int) -> bool:
    return state.phase[i] != FAILED


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> ElasticAfterFailure:
    return ElasticAfterFailure()


TERM = Term(
    "elastic_after_failure",
    "coupling.solid_after_failure: elastic",
    lambda scene: scene.coupling.solid_after_failure == "elastic",
    _make,
)
