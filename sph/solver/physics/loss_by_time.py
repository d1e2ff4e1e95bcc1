"""Loss of strength by time (Eq. 9): beta = exp(-gamma (t - t_f)), however little the soil moves."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sph.solver.compiled.slots import with_numbers
from sph.solver.physics.strength_loss import StrengthLoss, remaining_weight


class LossByTime(NamedTuple):
    """Coefficients of the law."""

    decay: float
    """exp(-gamma dt)"""


@remaining_weight.of(LossByTime)
def _remaining_weight(law: LossByTime, beta: float, strain: float) -> float:
    return beta * law.decay


@with_numbers.of(LossByTime)
def _with_numbers(record: LossByTime, table: np.ndarray, k: int, first: int) -> Any:
    return LossByTime(table[k, first])


LAW = StrengthLoss(LossByTime, lambda decay, softening: LossByTime(decay))
