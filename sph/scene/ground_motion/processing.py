"""Processing of an evenly sampled acceleration: baseline, band-pass, trim, resampling; each a section of a scene, absent where null.

The order is that of ``process``.  An acceleration is linear between its samples, as the solver takes it, so that the trapezoidal rule
gives its velocity exactly.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import scipy  # type: ignore[import-untyped]
from pydantic import model_validator

from sph.scene.configuration import Section, key

PADS = 1.5
"""Zeros before and after a record that is filtered, in periods of the lower corner times the order (Converse and Brady 1992)."""
MAX_SAMPLES = 200_000
"""Most samples of a record in a scene."""
MAX_FACTOR = 1000
"""Largest numerator and denominator of the ratio of two intervals."""


class Baseline(Section):
    """Removal of drift: a polynomial is taken out of the acceleration so that the ground is at rest at the end."""

    degree: int = key("degree of the polynomial in acceleration; 0: an offset, 1: a straight line", ge=0, le=6, default=1)


class BandPass(Section):
    """A Butterworth filter, run forwards and backwards so that it shifts no phase; the corners lose half of the amplitude."""

    low: float | None = key("lower corner; null: none", "Hz", gt=0, le=1e4, default=0.1)
    high: float | None = key("upper corner, below half of the record's sampling rate; null: none", "Hz", gt=0, le=1e4, default=25.0)
    order: int = key("order of the filter, which runs forwards and backwards", ge=1, le=10, default=4)

    @model_validator(mode="after")
    def _corners(self) -> BandPass:
        if self.low is None and self.high is None:
            raise ValueError("low and high: both are null; leave band_pass out")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError(f"low: {self.low:g} Hz must be below high: {self.high:g} Hz")
        return self


class Trim(Section):
    """The part between two shares of the horizontal component's Arias intensity; beyond it the record fades in and out."""

    start_share: float = key("share of the Arias intensity at which the part begins", ge=0, lt=1, default=0.005)
    end_share: float = key("share of the Arias intensity at which it ends", gt=0, le=1, default=0.995)
    taper: float = key("length of the cosine tapers before and after the part, within the record", "s", ge=0, le=100, default=1.0)

    @model_validator(mode="after")
    def _in_order(self) -> Trim:
        if not self.start_share < self.end_share:
            raise ValueError(f"start_share: {self.start_share:g} must be below end_share: {self.end_share:g}")
        return self


class Resample(Section):
    """Another interval of the samples; what it cannot hold is filtered out first."""

    interval: float = key("new interval of the samples", "s", ge=1e-5, le=1)


def integral(values: np.ndarray, interval: float) -> np.ndarray:
    """Integral (n,) from 0 on of a function (n,) linear between its samples."""
    return scipy.integrate.cumulative_trapezoid(values, dx=interval, initial=0.0)


def corrected(acceleration: np.ndarray, interval: float, degree: int) -> np.ndarray:
    """Acceleration (n,) without the polynomial of a degree whose velocity fits that of the record best (least squares).

    It fits exactly at the end, so that the ground stops there.
    """
    n = acceleration.size
    powers = np.linspace(0.0, 1.0, n)[:, None] ** np.arange(min(degree, n - 2) + 1)
    basis = np.array([integral(power, interval) for power in powers.T]).T
    velocity = integral(acceleration, interval)
    # The first coefficient follows from the condition at the end; the others are free.
    shapes = basis[:, 1:] - basis[:, :1] * (basis[-1, 1:] / basis[-1, 0])
    held = basis[:, 0] * (velocity[-1] / basis[-1, 0])
    free = np.linalg.lstsq(shapes, velocity - held, rcond=None)[0] if shapes.shape[1] else np.zeros(0)
    first = (velocity[-1] - basis[-1, 1:] @ free) / basis[-1, 0]
    return acceleration - powers @ np.concatenate([[first], free])


def band_passed(acceleration: np.ndarray, interval: float, band: BandPass) -> np.ndarray:
    """Acceleration (n,) within a band; ValueError for a corner at or above half of the sampling rate.

    The record is padded with zeros before and after, and cut to its length again.
    """
    half = 0.5 / interval
    for name in ("low", "high"):
        corner = getattr(band, name)
        if corner is not None and corner >= half:
            raise ValueError(f"band_pass.{name}: {corner:g} Hz must be below half of the sampling rate, {half:g} Hz")
    kind = "lowpass" if band.low is None else "highpass" if band.high is None else "bandpass"
    corners = [corner for corner in (band.low, band.high) if corner is not None]
    filters = scipy.signal.butter(band.order, corners if len(corners) > 1 else corners[0], kind, fs=2.0 * half, output="sos")
    pads = min(int(np.ceil(PADS * band.order / min(corners) / interval)), MAX_SAMPLES)
    padded = np.pad(acceleration, pads)
    return scipy.signal.sosfiltfilt(filters, padded, padtype=None)[pads : pads + acceleration.size]


def arias_window(acceleration: np.ndarray, start_share: float, end_share: float) -> tuple[int, int]:
    """First and last sample between which an acceleration (n,) goes from one share of its Arias intensity to another."""
    square = integral(acceleration**2, 1.0)
    if not square[-1] > 0:
        raise ValueError("trim: the record is zero throughout")
    first = int(np.searchsorted(square, start_share * square[-1], side="right")) - 1
    last = int(np.searchsorted(square, end_share * square[-1], side="left"))
    return max(first, 0), min(last, acceleration.size - 1)


def faded(acceleration: np.ndarray, first: int, last: int, taper: int) -> np.ndarray:
    """Samples first to last with cosine tapers of at most ``taper`` samples before and after."""
    before, after = min(taper, first), min(taper, acceleration.size - 1 - last)
    part = acceleration[first - before : last + after + 1].copy()
    part[:before] *= 0.5 - 0.5 * np.cos(np.pi * np.arange(before) / max(before, 1))
    part[part.size - after :] *= (0.5 - 0.5 * np.cos(np.pi * np.arange(after) / max(after, 1)))[::-1]
    return part


def resampled(acceleration: np.ndarray, old: float, new: float) -> np.ndarray:
    """Acceleration every ``new`` instead of every ``old`` seconds, what the new interval cannot hold filtered out (a linear-phase FIR).

    ValueError where the ratio is none of small whole numbers, and for too many samples.
    """
    ratio = Fraction(old / new).limit_denominator(MAX_FACTOR)
    if ratio.numerator > MAX_FACTOR or ratio == 0 or abs(ratio * new / old - 1) > 1e-6:
        raise ValueError(f"resample.interval: {new:g} s and the record's {old:g} s must have a ratio of whole numbers up to {MAX_FACTOR}")
    if acceleration.size * ratio > MAX_SAMPLES:
        raise ValueError(f"resample.interval: {new:g} s makes more than {MAX_SAMPLES:,} samples of the record's {acceleration.size:,}")
    return scipy.signal.resample_poly(acceleration, ratio.numerator, ratio.denominator)


def process(
    components: list[np.ndarray],
    interval: float,
    baseline: Baseline | None,
    band_pass: BandPass | None,
    trim: Trim | None,
    resample: Resample | None,
) -> tuple[list[np.ndarray], float]:
    """Components, horizontal first, as processed, and their interval (s).  ValueError for a section that the record does not bear.

    1. baseline, so that an offset does not count as shaking; 2. band-pass; 3. trim, all components to the window of the first;
    4. resampling; 5. what these have left of a velocity at the end: the baseline once more.
    """
    if baseline is not None:
        components = [corrected(values, interval, baseline.degree) for values in components]
    if band_pass is not None:
        components = [band_passed(values, interval, band_pass) for values in components]
    if trim is not None:
        first, last = arias_window(components[0], trim.start_share, trim.end_share)
        components = [faded(values, first, last, round(trim.taper / interval)) for values in components]
    if resample is not None:
        components = [resampled(values, interval, resample.interval) for values in components]
        interval = resample.interval
    if components[0].size < 2:
        raise ValueError("trim, resample: fewer than two samples are left of the record")
    if baseline is not None and (band_pass or trim or resample):
        components = [corrected(values, interval, baseline.degree) for values in components]
    return components, interval
