"""Synthetic ground motions of the stochastic model of Rezaeian and Der Kiureghian (2010).

    x(t) = q(t) / s(t) * integral of h(t - u, u) w(u) du,    s(t)^2 = integral of h(t - u, u)^2 du
    q(t) = a1 t^(a2 - 1) exp(-a3 t)
    h(t, u) = W(u) / sqrt(1 - Z^2) exp(-Z W(u) t) sin(W(u) sqrt(1 - Z^2) t),    W(u) = W_mid + W' (u - t_mid)
    z'' + 2 W_c z' + W_c^2 z = x

with white noise w; the acceleration is z''.  The square of the modulating function q is a gamma density times a constant: a2 and a3
follow from D5-95 and t_mid, the time of 45 % of the Arias intensity, and a1 from the Arias intensity.  The last line is the high-pass
filter, a critically damped oscillator, by which the ground comes to rest.

"Simulation of synthetic ground motions for specified earthquake and site characteristics", Earthquake Engng Struct. Dyn. 39, 1155-1180.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from pydantic import model_validator

from sph.scene.configuration import Section, key
from sph.scene.gravity import GRAVITY

INTERVAL = 0.01
"""Interval of the samples, s."""
HIGHEST = 25.0
"""Highest frequency of the filter, Hz: four samples in its period."""
MID = 0.45
"""Share of the Arias intensity that has come at ``time_mid``."""
TAILS = 0.01
"""Before and after these shares of the Arias intensity the filter's frequency stays as it is (ours): a line would run below 0."""
LEFT_OUT = 1e-3
"""Share of the Arias intensity after the end of the noise that is left out."""
SETTLING = 12.0
"""Time after the noise in which the high-pass filter comes to rest, over 1 / W_c: (1 + 12) exp(-12) = 8e-5 of its swing is left."""
SHAPES = (1.0, 1000.0)
"""Least and largest shape of the gamma density, 2 a2 - 1: the model has a2 > 1."""
ROWS = 256
"""Samples that are filtered at once."""


class Stochastic(Section):
    """A synthetic motion; every key is required.  The ranges are those that Rezaeian and Der Kiureghian (2010) fitted to records."""

    arias_intensity: float = key(
        "expected Arias intensity, before the high-pass filter",
        "m/s",
        "Rezaeian and Der Kiureghian (2010)",
        gt=0,
        le=100,
    )
    duration: float = key(
        "effective duration D5-95, between 5 % and 95 % of the Arias intensity",
        "s",
        "Rezaeian and Der Kiureghian (2010)",
        gt=0,
        le=100,
    )
    time_mid: float = key(
        "time after the start at which 45 % of the Arias intensity is reached",
        "s",
        "Rezaeian and Der Kiureghian (2010)",
        gt=0,
        le=100,
    )
    frequency_mid: float = key(
        "frequency of the filter at time_mid, W_mid / 2 pi",
        "Hz",
        "Rezaeian and Der Kiureghian (2010)",
        gt=0,
        le=HIGHEST,
    )
    frequency_rate: float = key(
        "rate of that frequency, W' / 2 pi",
        "Hz/s",
        "Rezaeian and Der Kiureghian (2010)",
        ge=-10,
        le=10,
    )
    damping: float = key(
        "damping ratio of the filter, Z: the bandwidth",
        source="Rezaeian and Der Kiureghian (2010)",
        ge=0.01,
        lt=1,
    )
    high_pass: float = key(
        "corner of the high-pass filter, W_c / 2 pi, below the filter's frequency at all times; 0.1 to 0.2 are usual", "Hz", gt=0, le=1
    )
    seed: int = key("seed of the white noise: the same seed gives the same motion, bit for bit", ge=0, le=2**32 - 1)

    @model_validator(mode="after")
    def _possible(self) -> Stochastic:
        longest, shortest = (_spread(shape) for shape in SHAPES)
        if not shortest <= self.duration / self.time_mid < longest:
            raise ValueError(
                f"duration: {self.duration:g} s with time_mid: {self.time_mid:g} s: the modulating function has D5-95 between "
                f"{shortest * self.time_mid:.3g} and {longest * self.time_mid:.3g} s for this time_mid; change one of them"
            )
        ends = self.frequency(np.array([0.0, math.inf]))
        if ends.min() <= self.high_pass or ends.max() > HIGHEST:
            raise ValueError(
                f"frequency_rate: {self.frequency_rate:g} Hz/s takes the filter's frequency from {ends[0]:.3g} to {ends[1]:.3g} Hz; "
                f"it must stay above high_pass ({self.high_pass:g} Hz) and at most {HIGHEST:g} Hz; choose a rate nearer 0"
            )
        return self

    def frequency(self, time: np.ndarray) -> np.ndarray:
        """Frequency of the filter (Hz) at times (s) from the start: linear between 1 % and 99 % of the Arias intensity, else constant."""
        envelope = self.modulation
        within = np.clip(time, envelope.time_of(TAILS), envelope.time_of(1.0 - TAILS))
        return self.frequency_mid + self.frequency_rate * (within - self.time_mid)

    @property
    def modulation(self) -> Modulation:
        """The modulating function."""
        shape = scipy.optimize.brentq(lambda value: _spread(value) - self.duration / self.time_mid, *SHAPES)
        return Modulation(self.arias_intensity, shape, float(scipy.special.gammaincinv(shape, MID)) / self.time_mid)


class Modulation(NamedTuple):
    """The modulating function q: pi / (2 g) q^2 is the Arias intensity times a gamma density."""

    arias_intensity: float  # m/s
    shape: float  # 2 a2 - 1
    rate: float  # 2 a3, 1/s

    def time_of(self, share: float) -> float:
        """Time (s) at which a share of the Arias intensity has come."""
        return float(scipy.special.gammaincinv(self.shape, share)) / self.rate

    def at(self, time: np.ndarray) -> np.ndarray:
        """q (n,) in m/s2 at times above 0 (s)."""
        density = (self.shape - 1.0) * np.log(self.rate * time) - self.rate * time - math.lgamma(self.shape)
        return np.sqrt(2.0 * GRAVITY / math.pi * self.arias_intensity * self.rate * np.exp(density))


def _spread(shape: float) -> float:
    """D5-95 over t_mid of a gamma density."""
    start, middle, end = scipy.special.gammaincinv(shape, np.array([0.05, MID, 0.95]))
    return float((end - start) / middle)


def synthesised(parameters: Stochastic) -> np.ndarray:
    """Acceleration (n,) in m/s2 every ``INTERVAL`` seconds from the start, at rest at both ends.

    The noise is made of the raw numbers of numpy's PCG64, whose stream numpy keeps from version to version, by the inverse of the
    normal distribution.
    """
    envelope = parameters.modulation
    size = math.ceil(envelope.time_of(1.0 - LEFT_OUT) / INTERVAL)
    uniform = ((np.random.PCG64(parameters.seed).random_raw(size) >> np.uint64(11)) + 0.5) * 2.0**-53
    time = INTERVAL * np.arange(1, size + 1)
    corner = 2.0 * math.pi * parameters.high_pass
    settling = math.ceil(SETTLING / corner / INTERVAL)
    shaking = np.pad(envelope.at(time) * _coloured(scipy.special.ndtri(uniform), time, parameters), (1, settling))
    weights, answers, _ = scipy.signal.cont2discrete(([1.0, 0.0, 0.0], [1.0, 2.0 * corner, corner**2]), INTERVAL, method="foh")
    return scipy.signal.lfilter(weights.ravel(), answers, shaking)


def _coloured(noise: np.ndarray, time: np.ndarray, parameters: Stochastic) -> np.ndarray:
    """White noise (n,) at times (n,) in s after the filter, of unit variance at every time."""
    circular = 2.0 * np.pi * parameters.frequency(time)
    decay, swing = parameters.damping * circular, math.sqrt(1.0 - parameters.damping**2) * circular
    made = np.empty_like(noise)
    for first in range(0, time.size, ROWS):
        rows = slice(first, min(first + ROWS, time.size))
        # The answer at a time to the pulse at the same time is 0; a pulse lies half an interval before its sample.
        since = time[rows, None] - time[None, : rows.stop] + 0.5 * INTERVAL
        causal = np.where(since > 0.0, since, 0.0)
        answer = circular[: rows.stop] * np.exp(-decay[: rows.stop] * causal) * np.sin(swing[: rows.stop] * causal)
        made[rows] = (answer * noise[: rows.stop]).sum(axis=1) / np.sqrt((answer**2).sum(axis=1))
    return made
