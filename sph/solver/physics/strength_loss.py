"""How failed soil loses its strength: a law is a record of coefficients, which the solver knows by its type, with the function below."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from sph.solver.compiled.slots import slot


class StrengthLoss(NamedTuple):
    """What the solver is told of a law."""

    record: type
    """of its coefficients"""
    make: Callable[[float, Any], Any]
    """the record, from the part of beta that the rate gamma leaves in a step, and the soil's section ``softening``"""


@slot
def remaining_weight(law: Any, beta: float, strain: float) -> float:
    """Weight of the solid state of a failed particle after a step, from that before and its mean plastic strain."""
    raise NotImplementedError
