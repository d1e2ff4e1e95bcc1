"""Loss of strength by slip: beta falls from 1 to 0 as the slip goes from that at the peak to that at the residual strength.

With the mean plastic strain kappa of a failed particle (``sph.solver.physics.slip``) and its values kappa_p at the peak and kappa_r at the
residual strength,

    beta = 1 - (kappa - kappa_p) / (kappa_r - kappa_p)                   linear
    beta = exp(-3 (kappa - kappa_p) / (kappa_r - kappa_p))               exponential: 5 % are left at kappa_r

and never rises.  Both states are on their own yield surfaces, so that strength falls from the peak to the residual one as a shear test
shows it against displacement (Skempton 1985).  A rate gamma above 0 takes its part beside it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sph.solver.compiled.slots import with_numbers
from sph.solver.physics.strength_loss import StrengthLoss, remaining_weight


class LinearLossBySlip(NamedTuple):
    """Coefficients of the linear law."""

    decay: float
    """exp(-gamma dt)"""
    peak: float
    """kappa_p"""
    span: float
    """kappa_r - kappa_p"""


class ExponentialLossBySlip(NamedTuple):
    """Coefficients of the exponential law."""

    decay: float
    """exp(-gamma dt)"""
    peak: float
    """kappa_p"""
    span: float
    """kappa_r - kappa_p"""


@remaining_weight.of(LinearLossBySlip)
def _linear(law: LinearLossBySlip, beta: float, strain: float) -> float:
    return min(beta * law.decay, max(1.0 - (strain - law.peak) / law.span, 0.0))


@remaining_weight.of(ExponentialLossBySlip)
def _exponential(law: ExponentialLossBySlip, beta: float, strain: float) -> float:
    return min(beta * law.decay, math.exp(-3.0 * max(strain - law.peak, 0.0) / law.span))


@with_numbers.of(LinearLossBySlip)
def _with_numbers(record: LinearLossBySlip, table: np.ndarray, k: int, first: int) -> Any:
    return LinearLossBySlip(table[k, first], table[k, first + 1], table[k, first + 2])


@with_numbers.of(ExponentialLossBySlip)
def _with_numbers_too(record: ExponentialLossBySlip, table: np.ndarray, k: int, first: int) -> Any:
    return ExponentialLossBySlip(table[k, first], table[k, first + 1], table[k, first + 2])


def _law(record: Any) -> StrengthLoss:
    return StrengthLoss(record, lambda decay, softening: record(decay, softening.peak_strain, softening.span))


LINEAR, EXPONENTIAL = _law(LinearLossBySlip), _law(ExponentialLossBySlip)
