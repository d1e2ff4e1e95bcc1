"""Ground motions: the acceleration of the box as a function of time (Sec. 3.2); sampled in ``sph.scene.loading``."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from sph.scene.configuration import Section, key
from sph.scene.ground_motion.record import Record
from sph.scene.units import Acceleration

STEPS_IN_PERIOD = 20
"""Fewest time steps in the shortest period of a motion: straight lines between the samples of a sine then miss its peak by at most
1 - cos(pi / 20) = 1.2 % (``MISSED``), and its velocity by 0.8 %."""
MISSED = 1.0 - math.cos(math.pi / STEPS_IN_PERIOD)


class TaperedSine(Section):
    """A sine with a linear ramp up and down (Sec. 3.2)."""

    kind: Literal["tapered_sine"] = key("sine with linear ramps", source="Sec. 3.2")
    amplitude: Acceleration = key("peak acceleration of the box, horizontal", "m/s2", "Sec. 3.2", ge=0, le=100, default=6.0)
    frequency: float = key("frequency", "Hz", "ours (not in the text)", gt=0, le=100, default=1.0)
    start: float = key("start of the shaking", "s", "Sec. 3.2", ge=0, le=1e4, default=3.0)
    ramp: float = key("duration of the increase", "s", "ours ('gradually')", ge=0, le=1e4, default=3.0)
    decay_start: float = key("start of the decrease", "s", "Sec. 3.2", ge=0, le=1e4, default=9.0)
    end: float = key("end of the shaking", "s", "Sec. 3.2", ge=0, le=1e4, default=10.0)

    @model_validator(mode="after")
    def _in_order(self) -> TaperedSine:
        if not self.start + self.ramp <= self.decay_start <= self.end:
            raise ValueError(
                f"motion: start + ramp ({self.start + self.ramp} s), decay_start ({self.decay_start} s) and "
                f"end ({self.end} s) must not decrease in this order"
            )
        return self

    @property
    def shortest_period(self) -> float:
        """Period of the sine, or the length of the shaking if that is shorter, s."""
        return min(1.0 / self.frequency, self.end - self.start)

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        rise = linear_ramp(time - self.start, self.ramp)
        fall = 1.0 - linear_ramp(time - self.decay_start, self.end - self.decay_start)
        phase = 2.0 * np.pi * self.frequency * (time - self.start)
        return np.where(time < self.start, 0.0, self.amplitude * rise * fall * np.sin(phase))


class Ricker(Section):
    """A Ricker wavelet: a pulse with all frequencies up to some three times its own (Ricker 1953)."""

    kind: Literal["ricker"] = key("Ricker wavelet")
    amplitude: Acceleration = key("peak acceleration of the box, horizontal", "m/s2", ge=0, le=1e4)
    frequency: float = key("frequency with the largest amplitude", "Hz", gt=0, le=1e4)
    peak: float = key("time of the peak, at least 1.5 / frequency after the gravity stage", "s", ge=0, le=1e4)

    @property
    def start(self) -> float:
        """Time before which the wavelet is below 1e-8 of its peak and taken as nothing, s."""
        return self.peak - 1.5 / self.frequency

    @property
    def end(self) -> float:
        """Time after which it is, s."""
        return self.peak + 1.5 / self.frequency

    @property
    def shortest_period(self) -> float:
        """Period of the sine with the curvature of the wavelet's peak, s."""
        return math.sqrt(2.0 / 3.0) / self.frequency

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        square = (np.pi * self.frequency * (time - self.peak)) ** 2
        return np.where(np.abs(time - self.peak) > 1.5 / self.frequency, 0.0, self.amplitude * (1.0 - 2.0 * square) * np.exp(-square))


class ConstantAcceleration(Section):
    """An acceleration that is applied gradually and stays: the pseudo-static earthquake load."""

    kind: Literal["constant"] = key("constant acceleration")
    amplitude: Acceleration = key("acceleration of the box, horizontal; positive drives the soil towards the toe", "m/s2", ge=-1e3, le=1e3)
    start: float = key("start of the linear increase", "s", ge=0, le=1e4)
    ramp: float = key("duration of the increase", "s", ge=0, le=1e4)

    @property
    def end(self) -> float:
        """Time from which on the load is constant, s."""
        return self.start + self.ramp

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        return np.where(time < self.start, 0.0, self.amplitude * linear_ramp(time - self.start, self.ramp))


class VelocityPulse(Section):
    """A near-fault velocity pulse: a harmonic under a raised cosine (Mavroeidis and Papageorgiou 2003, Eqs. 2 and 3).

        v(t) = A / 2 (1 + cos(2 pi f s / gamma)) cos(2 pi f s + nu),  s = t - t0, |s| <= gamma / (2 f)

    with f the prevailing frequency, gamma the number of half cycles and nu the phase; velocity and acceleration are 0 at both ends.
    "A mathematical representation of near-fault ground motions", Bull. Seism. Soc. Am. 93 (3), 1099-1131.
    """

    kind: Literal["velocity_pulse"] = key("near-fault velocity pulse")
    amplitude: Acceleration = key("peak acceleration of the box, horizontal", "m/s2", ge=0, le=1e3)
    frequency: float = key("prevailing frequency f", "Hz", gt=0, le=100)
    cycles: float = key("oscillations in the pulse, gamma: 1 to 3 in records", gt=1, le=100, default=2.0)
    phase: float = key("phase nu; 0: velocity symmetric about the middle, 90: antisymmetric", "degree", ge=-360, le=360, default=0.0)
    start: float = key("start of the pulse", "s", ge=0, le=1e4)

    @property
    def end(self) -> float:
        """End of the pulse, s."""
        return self.start + self.cycles / self.frequency

    @property
    def shortest_period(self) -> float:
        """Period of the highest of the three sines that make the pulse, f (1 + 1 / gamma), s."""
        return self.cycles / (self.frequency * (self.cycles + 1.0))

    @property
    def peak_velocity(self) -> float:
        """A, the largest velocity that the envelope allows, m/s."""
        shape = np.abs(self._shape(np.linspace(-0.5, 0.5, 20_001) * self.cycles / self.frequency))
        return self.amplitude / float(shape.max())

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        since = time - self.start - 0.5 * self.cycles / self.frequency
        return np.where((time < self.start) | (time > self.end), 0.0, self.peak_velocity * self._shape(since))

    def _shape(self, since: np.ndarray) -> np.ndarray:
        """Acceleration over A at times (s) from the middle of the pulse, 1/s."""
        envelope, harmonic = 2.0 * np.pi * self.frequency * since / self.cycles, 2.0 * np.pi * self.frequency * since
        harmonic = harmonic + np.radians(self.phase)
        change = np.sin(envelope) * np.cos(harmonic) + self.cycles * np.sin(harmonic) * (1.0 + np.cos(envelope))
        return -np.pi * self.frequency / self.cycles * change


class NoMotion(Section):
    """No shaking."""

    kind: Literal["none"] = key("no shaking", default="none")

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        return np.zeros_like(time)


def linear_ramp(time: np.ndarray, length: float) -> np.ndarray:
    """0 before time 0, 1 after ``length`` (s), linear between."""
    with np.errstate(over="ignore"):  # of a length next to nothing
        return np.clip(time / length, 0.0, 1.0) if length > 0 else np.where(time < 0.0, 0.0, 1.0)


Motion = Annotated[TaperedSine | Ricker | ConstantAcceleration | VelocityPulse | Record | NoMotion, Field(discriminator="kind")]


def vertical_acceleration(motion: Motion, time: np.ndarray) -> np.ndarray:
    """Vertical acceleration of the box at times (s), m/s2, positive upwards; only records have one."""
    return motion.vertical_acceleration(time) if isinstance(motion, Record) else np.zeros_like(time)


def reference_amplitude(motion: Motion) -> float:
    """Amplitude to which the horizontal accelerations of a motion are in proportion, m/s2: of a record its peak; 0 without one."""
    if isinstance(motion, NoMotion):
        return 0.0
    return motion.peak if isinstance(motion, Record) else motion.amplitude
