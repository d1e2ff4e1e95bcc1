"""Measures of an evenly sampled ground acceleration: peaks, Arias intensity, significant durations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.scene.gravity import GRAVITY
from sph.scene.ground_motion.processing import integral


class Measures(NamedTuple):
    """Numbers of one component in SI units; the names are those of ``sph motion --json``."""

    peak_acceleration: float  # PGA, m/s2
    peak_velocity: float  # PGV, m/s
    peak_displacement: float  # PGD, m
    arias_intensity: float  # m/s
    duration_5_75: float  # from 5 % to 75 % of the Arias intensity, s
    duration_5_95: float  # to 95 %, s
    final_velocity: float  # of the ground at the end, m/s; not 0: drift, or a record that is cut off


def measure(acceleration: np.ndarray, interval: float) -> Measures:
    """Measures of an acceleration (n,) in m/s2 every ``interval`` seconds, whose ground is at rest at the start.

    The Arias intensity is pi / (2 g) times the integral of the square (Arias 1970), the durations are those of its share (Trifunac
    and Brady 1975), interpolated between the samples; 0 where the ground stands still.
    """
    velocity = integral(acceleration, interval)
    pga, pgv, pgd = (float(np.abs(history).max()) for history in (acceleration, velocity, integral(velocity, interval)))
    share = arias_share(acceleration)
    time = interval * np.arange(acceleration.size)
    start, middle, end = np.interp((0.05, 0.75, 0.95), share, time) if share[-1] > 0 else (0.0, 0.0, 0.0)
    return Measures(
        pga,
        pgv,
        pgd,
        float(np.pi / (2.0 * GRAVITY) * integral(acceleration**2, interval)[-1]),
        float(middle - start),
        float(end - start),
        float(velocity[-1]),
    )


def arias_share(acceleration: np.ndarray) -> np.ndarray:
    """Share (n,) of the Arias intensity that has come at each sample (Husid 1969); zeros where the ground stands still."""
    square = integral(acceleration**2, 1.0)
    return square / square[-1] if square[-1] > 0 else square
