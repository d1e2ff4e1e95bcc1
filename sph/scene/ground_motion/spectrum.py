"""Response spectrum: the largest answer of damped oscillators to a ground acceleration.

    x'' + 2 zeta w x' + w^2 x = -a(t),   PSA = w^2 max |x|,   w = 2 pi / T

The acceleration is linear between its samples, and the answer to that is computed without error at the samples (a recurrence, as that
of Nigam and Jennings 1969).  Between them it is found at parts of the interval no longer than ``PART`` of the period.
"""

from __future__ import annotations

import math

import numpy as np
import scipy  # type: ignore[import-untyped]

DAMPING = 0.05
"""Damping ratio of the usual spectrum."""
PERIODS = np.logspace(-2, 1, 241)
"""Periods of a plotted spectrum, s."""
PART = 0.05
"""Longest interval at which the answer is looked at, over the period: its peak is missed by 1.3 % at most."""


def pseudo_acceleration(acceleration: np.ndarray, interval: float, periods: np.ndarray = PERIODS, damping: float = DAMPING) -> np.ndarray:
    """Pseudo-spectral acceleration (m,) in m/s2 at periods (m,) in s, from an acceleration (n,) in m/s2 every ``interval`` seconds.

    Oscillators start at rest; the swing after the end of the record counts.
    """
    return np.array([_largest(acceleration, interval, 2.0 * math.pi / period, damping) for period in periods])


def _largest(acceleration: np.ndarray, interval: float, frequency: float, damping: float) -> float:
    """Largest w^2 |x|, m/s2, of an oscillator with a circular frequency w (1/s)."""
    parts = math.ceil(interval * frequency / (2.0 * math.pi * PART))
    step = interval / parts
    after = math.ceil(2.0 * math.pi / frequency / step)
    fine = np.interp(np.arange((acceleration.size - 1) * parts + 1) / parts, np.arange(acceleration.size), acceleration)
    oscillator = [frequency**2], [1.0, 2.0 * damping * frequency, frequency**2]
    weights, answers, _ = scipy.signal.cont2discrete(oscillator, step, method="foh")
    return float(np.abs(scipy.signal.lfilter(weights.ravel(), answers, np.pad(fine, (0, after)))).max())
