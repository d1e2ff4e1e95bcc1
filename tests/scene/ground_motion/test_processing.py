"""Processing: what each step promises, for any record."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sph.scene.ground_motion.processing import (
    BandPass,
    Baseline,
    Resample,
    Trim,
    arias_window,
    band_passed,
    corrected,
    faded,
    integral,
    process,
    resampled,
)

INTERVAL = 0.01
TIME = np.arange(4000) * INTERVAL
WAVES = arrays(float, st.integers(2, 300), elements=st.floats(-10, 10, allow_subnormal=False))


def sine(frequency: float) -> np.ndarray:
    return np.sin(2 * np.pi * frequency * TIME)


def middle(values: np.ndarray) -> np.ndarray:
    """Without the ends, where filters see that the record is finite."""
    return values[values.size // 4 : -values.size // 4]


@given(WAVES, st.integers(0, 6))
def test_the_ground_stops_after_the_baseline(wave: np.ndarray, degree: int) -> None:
    after = integral(corrected(wave, INTERVAL, degree), INTERVAL)
    assert abs(after[-1]) <= 1e-9 * max(np.abs(integral(np.abs(wave), INTERVAL)).max(), 1e-12)


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_a_polynomial_drift_is_taken_out(degree: int) -> None:
    # A polynomial of the degree goes in full; of a motion without drift whose velocity has no trend almost nothing goes.
    drift = np.polynomial.Polynomial([0.3, -0.2, 0.5, 0.1][: degree + 1])(TIME / 40)
    assert np.abs(corrected(drift, INTERVAL, degree)).max() < 1e-12
    pulse = (1 - 2 * (TIME - 20) ** 2) * np.exp(-((TIME - 20) ** 2))
    np.testing.assert_allclose(corrected(pulse + drift, INTERVAL, degree), pulse, atol=2e-3)


def test_the_velocity_of_the_correction_fits_best() -> None:
    # Any other polynomial that makes the ground stop leaves a larger velocity.
    noise = np.random.default_rng(1).normal(size=500)
    left = integral(corrected(noise, INTERVAL, 2), INTERVAL)
    for shape in (np.polynomial.Polynomial([0, 1]), np.polynomial.Polynomial([0, 0, 1])):
        other = integral(shape(np.linspace(0, 1, 500)), INTERVAL)
        other = other - integral(np.ones(500), INTERVAL) * other[-1] / integral(np.ones(500), INTERVAL)[-1]
        assert abs(left @ other) < 1e-9 * np.linalg.norm(left) * np.linalg.norm(other)


@pytest.mark.parametrize(
    ("frequency", "gain"),
    [(1.0, 1.0), (5.0, 1.0), (0.5, 0.5), (10.0, 0.5), (0.1, 0.0), (40.0, 0.0)],
)
def test_the_band_keeps_what_is_inside_without_a_shift(frequency: float, gain: float) -> None:
    # Twice a Butterworth filter of order 4: 1/2 at the corners, 1 / (1 + (w / c)^8) elsewhere.
    filtered = band_passed(sine(frequency), INTERVAL, BandPass(low=0.5, high=10.0, order=4))
    np.testing.assert_allclose(middle(filtered), gain * middle(sine(frequency)), atol=0.01)


@pytest.mark.parametrize("band", [BandPass(low=None, high=10.0), BandPass(low=0.5, high=None)])
def test_one_corner_alone(band: BandPass) -> None:
    offset = 1.0 if band.low is None else 0.0
    wanted = offset + sine(3.0) + (0.0 if band.low is None else 1.0) * sine(40.0)
    np.testing.assert_allclose(middle(band_passed(1.0 + sine(3.0) + sine(40.0), INTERVAL, band)), middle(wanted), atol=0.02)


@pytest.mark.parametrize("band", [BandPass(low=None, high=50.0), BandPass(low=50.0, high=None), BandPass(low=1.0, high=60.0)])
def test_a_corner_that_the_record_cannot_have(band: BandPass) -> None:
    with pytest.raises(ValueError, match=r"band_pass\.(low|high): [56]0 Hz .*50 Hz"):
        band_passed(TIME, INTERVAL, band)


@pytest.mark.parametrize("new", [0.02, 0.015, 0.005, 1 / 60])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.8])
def test_resampling_keeps_what_the_new_interval_holds(new: float, part: float) -> None:
    # Up to 0.8 of half the lower sampling rate: to 1 % (measured: 0.3 % at 0.8).
    frequency = part * 0.5 / max(new, INTERVAL)
    after = resampled(sine(frequency), INTERVAL, new)
    time = np.arange(after.size) * new
    np.testing.assert_allclose(middle(after), middle(np.sin(2 * np.pi * frequency * time)), atol=0.01)


@pytest.mark.parametrize("part", [1.25, 1.5, 1.9])
def test_resampling_does_not_fold_what_it_cannot_hold(part: float) -> None:
    # Samples of the sine itself every 0.02 s would show it in full, at another frequency.
    assert np.abs(middle(resampled(sine(part * 25.0), INTERVAL, 0.02))).max() < 0.01
    assert np.abs(middle(sine(part * 25.0)[::2])).max() > 0.9


@pytest.mark.parametrize(("new", "words"), [(0.01 * np.sqrt(2), "ratio of whole numbers"), (1e-5, "more than 200,000 samples")])
def test_intervals_that_are_refused(new: float, words: str) -> None:
    with pytest.raises(ValueError, match=f"resample.interval: .*{words}"):
        resampled(TIME, INTERVAL, new)


@given(WAVES.filter(lambda wave: np.abs(wave).max() > 1e-3), st.floats(0, 0.4), st.floats(0.6, 1), st.integers(0, 50))
def test_the_trimmed_part_has_its_share_of_the_arias_intensity(wave: np.ndarray, begin: float, end: float, taper: int) -> None:
    first, last = arias_window(wave, begin, end)
    square = integral(wave**2, 1.0)
    assert square[last] - square[first] >= (end - begin - 1e-9) * square[-1], "at least the part between the shares"
    if first + 1 < last:
        narrower = square[last - 1] - square[first + 1]
        assert narrower <= (end - begin + 1e-9) * square[-1], "and no sample more on both sides"
    part = faded(wave, first, last, taper)
    before = min(taper, first)
    np.testing.assert_array_equal(part[before : before + last - first + 1], wave[first : last + 1], "inside the window nothing changes")
    assert part.size <= last - first + 1 + 2 * taper
    if before:
        assert part[0] == 0.0
    assert np.all(np.abs(part) <= np.abs(wave[first - before : first - before + part.size]))


@given(WAVES.filter(lambda wave: wave.size > 20 and np.abs(wave).max() > 0.1), st.booleans(), st.booleans(), st.booleans())
def test_whatever_comes_between_the_ground_stops(wave: np.ndarray, filtered: bool, trimmed: bool, coarser: bool) -> None:
    assume(np.abs(corrected(wave, INTERVAL, 1)).max() > 1e-3)
    components, interval = process(
        [wave, 0.5 * wave],
        INTERVAL,
        Baseline(),
        BandPass(low=None, high=20.0) if filtered else None,
        Trim(start_share=0.05, end_share=0.95, taper=0.02) if trimmed else None,
        Resample(interval=0.015) if coarser else None,
    )
    assert interval == (0.015 if coarser else INTERVAL)
    np.testing.assert_allclose(components[1], 0.5 * components[0], atol=1e-9)
    for component in components:
        assert abs(integral(component, interval)[-1]) < 1e-9


def test_the_window_is_that_of_the_first_component() -> None:
    quiet, late = np.exp(-((TIME - 10) ** 2)), np.exp(-((TIME - 30) ** 2))
    components, _ = process([quiet, late], INTERVAL, None, None, Trim(taper=0.0), None)
    assert components[0].size == components[1].size < 500
    assert np.abs(components[0]).max() > 0.99 and np.abs(components[1]).max() < 1e-3


def test_a_record_that_stands_still_has_no_strong_part() -> None:
    with pytest.raises(ValueError, match="trim: .*zero throughout"):
        process([np.zeros(10)], INTERVAL, None, None, Trim(), None)
