"""Ground motion and gravity at known times."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import SLOPE

from sph.scene.configuration import merge
from sph.scene.gravity import GRAVITY, GravityStage
from sph.scene.ground_motion.processing import integral
from sph.scene.loading import gravity_history, make_loading
from sph.scene.motion import (
    MISSED,
    STEPS_IN_PERIOD,
    ConstantAcceleration,
    NoMotion,
    Ricker,
    TaperedSine,
    VelocityPulse,
    reference_amplitude,
    vertical_acceleration,
)
from sph.scene.schema import make_scene
from sph.scene.units import beside_g, in_both
from sph.study.dimensions import Dimension

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


# ---------------------------------------------------------------- other kinds

WAVELETS = st.builds(
    Ricker,
    kind=st.just("ricker"),
    amplitude=st.floats(0.1, 100.0),
    frequency=st.floats(0.1, 100.0),
    peak=st.floats(0.0, 100.0),
)


@given(WAVELETS)
def test_a_ricker_wavelet_is_a_pulse_without_net_velocity(wavelet: Ricker) -> None:
    # Peak at its time, symmetric, side lobes of -2 exp(-3/2), zero outside start to end.  The integral from minus to plus infinity is 0;
    # the parts cut off are below 1e-9 of amplitude / frequency, and the sum of so smooth a function is exact but for rounding.
    time = np.linspace(wavelet.start, wavelet.end, 4001)
    a = wavelet.acceleration(time)
    assert wavelet.acceleration(np.array([wavelet.peak]))[0] == wavelet.amplitude == a.max()
    assert a.min() == pytest.approx(-2 * np.exp(-1.5) * wavelet.amplitude, rel=1e-4)
    np.testing.assert_allclose(a[1:-1], a[-2:0:-1], atol=1e-6 * wavelet.amplitude)
    assert abs(a.sum() * (time[1] - time[0])) < 1e-8 * wavelet.amplitude / wavelet.frequency
    outside = np.array([wavelet.start - 1e-3 / wavelet.frequency, wavelet.end + 1e-3 / wavelet.frequency, 1e4])
    assert not wavelet.acceleration(outside).any()
    assert np.abs(a[[1, -2]]).max() < 1.1e-8 * wavelet.amplitude, "what is cut off is nothing"


def test_a_ricker_wavelet_by_hand() -> None:
    # (1 - 2 s^2) exp(-s^2) with s = pi f (t - t_p): zero at s = 1 / sqrt(2); its spectrum, s^2-like, peaks at f.
    wavelet = Ricker(kind="ricker", amplitude=2.0, frequency=4.0, peak=1.0)
    zero = 1.0 + 1.0 / (np.sqrt(2.0) * np.pi * 4.0)
    quarter = 2.0 * (1 - np.pi**2 / 2) * np.exp(-(np.pi**2) / 4)  # at t_p + 1 / 8 s
    np.testing.assert_allclose(wavelet.acceleration(np.array([zero, 1.125])), [0.0, quarter], atol=1e-12)
    frequencies = np.linspace(1.0, 10.0, 91)
    time = np.arange(0.0, 2.0, 1e-3)
    spectrum = np.abs(np.exp(-2j * np.pi * np.outer(frequencies, time)) @ wavelet.acceleration(time))
    assert frequencies[spectrum.argmax()] == pytest.approx(4.0)


@pytest.mark.parametrize("amplitude", [3.0, -3.0])
def test_a_constant_motion_is_brought_on_and_stays(amplitude: float) -> None:
    motion = ConstantAcceleration(kind="constant", amplitude=amplitude, start=1.0, ramp=2.0)
    a = motion.acceleration(np.array([0.0, 0.999, 1.0, 1.5, 3.0, 1e4]))
    np.testing.assert_allclose(a, amplitude * np.array([0, 0, 0, 0.25, 1, 1]), atol=1e-12)
    assert motion.end == 3.0
    at_once = ConstantAcceleration(kind="constant", amplitude=amplitude, start=1.0, ramp=0.0)
    np.testing.assert_array_equal(at_once.acceleration(np.array([0.999, 1.0, 2.0])), [0.0, amplitude, amplitude])


def test_loading_of_the_other_kinds(small_slope) -> None:
    # The history at the steps' times; in the gravity stage there is none.
    for motion in (
        {"kind": "ricker", "amplitude": 2.0, "frequency": 2.0, "peak": 2.0},
        {"kind": "constant", "amplitude": -1.0, "start": 1.0, "ramp": 0.5},
    ):
        data = small_slope({}).model_dump() | {"motion": motion}
        loading = make_loading(make_scene(data))
        assert not loading.ground[:1000].any()
        assert loading.ground[2000] == pytest.approx(motion["amplitude"], rel=1e-9)


@given(
    st.builds(
        VelocityPulse,
        kind=st.just("velocity_pulse"),
        amplitude=st.floats(0.1, 100.0),
        frequency=st.floats(0.1, 10.0),
        cycles=st.floats(1.01, 5.0),
        phase=st.floats(-180.0, 180.0),
        start=st.floats(0.0, 10.0),
    )
)
def test_a_velocity_pulse_is_the_derivative_of_its_published_velocity(pulse: VelocityPulse) -> None:
    # v = A/2 (1 + cos(2 pi f s / gamma)) cos(2 pi f s + nu): the acceleration integrates to it, has its peak, and the ground stops.
    time = np.linspace(pulse.start, pulse.end, 20_001)
    since = time - 0.5 * (time[0] + time[-1])
    envelope = 0.5 * pulse.peak_velocity * (1 + np.cos(2 * np.pi * pulse.frequency * since / pulse.cycles))
    velocity = envelope * np.cos(2 * np.pi * pulse.frequency * since + np.radians(pulse.phase))
    a = pulse.acceleration(time)
    np.testing.assert_allclose(integral(a, time[1] - time[0]), velocity, atol=1e-5 * pulse.peak_velocity)
    assert np.abs(a).max() == pytest.approx(pulse.amplitude, rel=1e-6)
    assert abs(a[1]) < 1e-2 * pulse.amplitude and abs(a[-2]) < 1e-2 * pulse.amplitude
    assert not pulse.acceleration(np.array([0.0, pulse.start - 1e-6, pulse.end + 1e-6, 1e4]) - 1e-9).any()


def test_a_velocity_pulse_by_hand() -> None:
    # gamma = 2, nu = 0, f = 1: v = A/2 (1 + cos(pi s)) cos(2 pi s) is A in the middle, -A/2 half a second beside it.
    pulse = VelocityPulse(kind="velocity_pulse", amplitude=1.0, frequency=1.0, cycles=2.0, start=1.0)
    time = np.linspace(1.0, 3.0, 20_001)
    velocity = integral(pulse.acceleration(time), time[1] - time[0])
    np.testing.assert_allclose(velocity[[5_000, 10_000, 15_000, 20_000]] / pulse.peak_velocity, [-0.5, 1.0, -0.5, 0.0], atol=1e-6)
    assert pulse.end == 3.0


def test_only_records_shake_vertically() -> None:
    for motion in (PAPER, NoMotion(), VelocityPulse(kind="velocity_pulse", amplitude=1.0, frequency=1.0, start=0.0)):
        assert not vertical_acceleration(motion, np.linspace(0.0, 10.0, 11)).any()
    assert [reference_amplitude(motion) for motion in (PAPER, NoMotion())] == [6.0, 0.0]


# ---------------------------------------------------------------- steps that resolve a motion

PULSES = st.builds(
    VelocityPulse,
    kind=st.just("velocity_pulse"),
    amplitude=st.just(1.0),
    frequency=st.floats(0.1, 10.0),
    cycles=st.floats(1.01, 5.0),
    phase=st.floats(-180.0, 180.0),
    start=st.just(0.0),
)


@given(PULSES | WAVELETS.map(lambda wavelet: wavelet.model_copy(update={"amplitude": 1.0})) | st.just(PAPER), st.floats(0.0, 1.0))
def test_the_fewest_steps_allowed_lose_little_of_a_motion(motion: Ricker | VelocityPulse | TaperedSine, shift: float) -> None:
    step = motion.shortest_period / STEPS_IN_PERIOD
    coarse = motion.start + np.arange(shift, (motion.end - motion.start) / step) * step  # within: there may be kinks at the ends
    fine = np.linspace(coarse[0], coarse[-1], 20 * coarse.size)
    lost = np.abs(np.interp(fine, coarse, motion.acceleration(coarse)) - motion.acceleration(fine)).max()
    assert lost < 1.01 * MISSED * motion.amplitude


UNRESOLVED = [
    ({"kind": "tapered_sine", "frequency": 20.0}, 0.025, "0.05 s, .*20 steps.*0.0025 s"),
    ({"kind": "tapered_sine", "frequency": 20.0}, 5e-3, "0.05 s"),
    ({"kind": "tapered_sine", "ramp": 0.0, "decay_start": 3.0, "end": 3.002}, 1e-3, "0.002 s"),
    ({"kind": "ricker", "amplitude": 1.0, "frequency": 20.0, "peak": 4.0}, 2.5e-3, "0.0408 s"),
    ({"kind": "velocity_pulse", "amplitude": 1.0, "frequency": 10.0, "start": 3.0}, 5e-3, "0.0667 s"),
]


@pytest.mark.parametrize(("motion", "step", "words"), UNRESOLVED)
@pytest.mark.parametrize("numerics", [{}, {"adaptive_step": {}}])
def test_a_motion_that_the_steps_do_not_resolve_is_refused(motion: dict, step: float, words: str, numerics: dict) -> None:
    scene = {"scheme": "paper", "name": "slope", "geometry": {"shape": "slope"}, "numerics": {"time_step": step} | numerics}
    scene |= {"outputs": {"series_interval": 0.025}, "motion": motion}
    with pytest.raises(ValueError, match=f"numerics.time_step: {step:g} s .*{motion['kind']}.*{words}"):
        make_scene(scene)
    make_scene(scene | {"motion": motion | {"amplitude": 0.0}})
    make_scene(scene | {"numerics": numerics | {"time_step": 1e-4}, "outputs": {}})


@pytest.mark.parametrize(
    ("text", "value"),
    [("0.4g", 0.4 * GRAVITY), (" 0.4 G ", 0.4 * GRAVITY), ("3.9 m/s2", 3.9), ("3.9m/s²", 3.9), ("3.9 m/s^2", 3.9), ("1e2 cm/s2", 1.0)]
    + [("390 gal", 3.9), ("3.9", 3.9), (".5e1", 5.0), (2, 2.0)],
)
def test_accelerations_have_units(text: str | float, value: float) -> None:
    for kind in ({"kind": "tapered_sine"}, {"kind": "ricker", "frequency": 1.0, "peak": 5.0}):
        assert make_scene(merge(SLOPE, {"motion": kind | {"amplitude": text}})).motion.amplitude == pytest.approx(value, rel=1e-15)  # type: ignore[union-attr]
    made = make_scene(merge(SLOPE, {"gravity": {"acceleration": text}}))
    assert made.gravity.acceleration == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["0.4 h", "g", "", "m/s2", "1.2.3 g", "0.4g g", "0x3", "20g", "-1g", "1e999", "0.4 kg", "e"])
def test_what_is_no_acceleration_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"scene: motion\.amplitude: "):
        make_scene(merge(SLOPE, {"motion": {"amplitude": text}}))


def test_an_acceleration_is_said_in_both_units() -> None:
    assert in_both(0.4 * GRAVITY) == "0.4 g (3.924 m/s2)" and in_both(1.2 * GRAVITY) == "1.2 g (11.77 m/s2)"
    assert in_both(4.0) == "4 m/s2 (0.408 g)" and in_both(0.412 * GRAVITY) == "4.042 m/s2 (0.412 g)" and in_both(0.0) == "0 m/s2 (0 g)"
    assert in_both(0.4 * GRAVITY, 0.02 * GRAVITY) == "3.92 ± 0.2 m/s2 (0.4 ± 0.02 g)"
    assert beside_g("1.962") == "1.962 (0.2 g)"
    assert (beside_g("0.25", "-"), beside_g("none")) == ("0.25", "none")
    shaking = Dimension("motion.amplitude", "m/s2", "", False)
    assert shaking.said("1.962") == "amplitude of the motion 1.962 m/s² (0.2 g)"
    assert shaking._replace(unit="1/s").said("2") == "amplitude of the motion 2 s⁻¹"
