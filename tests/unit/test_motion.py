"""Ground motion and gravity at known times."""

from __future__ import annotations

import numpy as np
import pytest

from sph.motion import gravity_history, make_loading
from sph.scene import GravityStage, NoMotion, TaperedSine

PAPER = TaperedSine(kind="tapered_sine", amplitude=6.0, frequency=1.0, start=3.0, ramp=3.0, decay_start=9.0, end=10.0)


@pytest.mark.parametrize(
    ("time", "expected"),
    [
        (0.0, 0.0),
        (2.999, 0.0),
        (3.0, 0.0),
        (3.25, 6.0 * 0.25 / 3),  # quarter period, a twelfth of the ramp
        (3.75, -6.0 * 0.75 / 3),
        (4.5, 0.0),  # half ramp, zero crossing
        (4.25, 6.0 * 1.25 / 3),
        (6.25, 6.0),  # full amplitude
        (8.75, -6.0),
        (9.25, 6.0 * 0.75),  # a quarter into the decay
        (9.75, -6.0 * 0.25),
        (10.0, 0.0),
        (12.25, 0.0),
    ],
)
def test_tapered_sine_at_known_times(time: float, expected: float) -> None:
    # Rounding of 2 pi f t only.
    assert PAPER.acceleration(np.array([time]))[0] == pytest.approx(expected, abs=1e-12)


def test_envelope_and_zeros() -> None:
    time = np.arange(0, 15, 1e-3)
    a = PAPER.acceleration(time)
    assert np.all(a[time < 3.0] == 0)
    assert np.all(a[time >= 10.0] == 0)
    envelope = 6.0 * np.minimum(1.0, np.clip((time - 3) / 3, 0, 1)) * np.clip(10 - time, 0, 1)
    assert np.all(np.abs(a) <= envelope + 1e-12)
    assert np.abs(a).max() == pytest.approx(6.0, rel=1e-6)


def test_frequency_scales_time() -> None:
    motion = PAPER.model_copy(update={"frequency": 2.5})
    time = np.arange(6.0, 9.0, 1e-4)
    a = motion.acceleration(time)
    upward = np.count_nonzero((a[:-1] < 0) & (a[1:] >= 0))
    assert upward in (7, 8)  # 7.5 periods in three seconds


def test_zero_ramp_and_zero_decay_are_steps() -> None:
    motion = TaperedSine(kind="tapered_sine", amplitude=2.0, frequency=1.0, start=1.0, ramp=0.0, decay_start=3.0, end=3.0)
    a = motion.acceleration(np.array([0.999, 1.25, 2.75, 3.0, 3.25]))
    np.testing.assert_allclose(a, [0, 2.0, -2.0, 0, 0], atol=1e-12)


def test_no_motion() -> None:
    assert np.all(NoMotion().acceleration(np.linspace(0, 5, 7)) == 0)


def test_gravity_ramp_and_extra_damping() -> None:
    stage = GravityStage(ramp=1.0, duration=3.0, damping=20.0, acceleration=9.81)
    gravity, extra = gravity_history(stage, np.array([0.0, 0.25, 1.0, 2.0, 2.5, 3.0, 9.0]))
    np.testing.assert_allclose(gravity, [0, 9.81 / 4, 9.81, 9.81, 9.81, 9.81, 9.81], rtol=1e-14)
    # Faded out over the last third, so that none is left when failure is armed.
    np.testing.assert_allclose(extra, [20, 20, 20, 20, 10, 0, 0], atol=1e-12)


def test_gravity_at_once() -> None:
    gravity, _ = gravity_history(GravityStage(ramp=0.0, duration=1.0), np.array([0.0, 0.5]))
    np.testing.assert_array_equal(gravity, [9.81, 9.81])


def test_loading_has_an_entry_at_every_step(small_slope) -> None:
    scene = small_slope({"duration": 2.0, "numerics.time_step": 1e-3, "motion.decay_start": 1.6, "motion.end": 2.0})
    loading = make_loading(scene)
    for history in loading:
        assert history.shape == (2001,)
        assert np.isfinite(history).all()
    # The entry at a step is the history at that step's time.
    step = 1700
    assert loading.ground[step] == pytest.approx(scene.motion.acceleration(np.array([1.7]))[0], abs=1e-12)


def test_loading_does_not_depend_on_the_duration(small_slope) -> None:
    # Otherwise a run that is made longer would not equal an uninterrupted one.
    short, long = (make_loading(small_slope({"duration": d})) for d in (2.5, 3.0))
    for a, b in zip(short, long, strict=True):
        np.testing.assert_array_equal(a, b[: a.size])
