"""Newmark's sliding block against closed forms, an independent integration, and what must hold for every record."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sph.stability.newmark import _slide, _time_to_rest, sliding_block

G = 9.81
ROUNDING = 1e-12
"""Relative; the integration is exact, so closed forms are met to rounding."""

# ---------------------------------------------------------------- closed forms; a train of sines is V11


def slid_once(impulse: float, centroid: float, rise: float, resistance: float) -> float:
    """Displacement (m) of a block that starts on the first flank, of slope ``rise``, and comes to rest after the pulse is over.

    With the impulse I (m/s) of the pulse and its centroid, less those of the triangle before the start:
    D = integral of (a - N) (stop - t) from start to stop.
    """
    start = resistance / rise
    before = 0.5 * resistance * start
    late = impulse - before
    moment = impulse * centroid - before * 2 / 3 * start
    stop = start + late / resistance
    return late * stop - moment - 0.5 * resistance * (stop - start) ** 2


def rectangle(peak: float, length: float, resistance: float) -> float:
    """Newmark's (1965) displacement under a rectangular pulse, m."""
    return 0.5 * peak * length**2 * (peak / resistance - 1)


def test_rectangular_pulse() -> None:
    """A record that begins and ends with a jump is Newmark's pulse itself; the block comes to rest after it."""
    block = sliding_block([0.0, 0.2], [0.6 * G, 0.6 * G], 0.3 * G)
    assert block.permanent == pytest.approx(rectangle(0.6 * G, 0.2, 0.3 * G), rel=ROUNDING)
    assert block.permanent == pytest.approx(0.1177, abs=5e-5)
    assert block.sliding_time == pytest.approx(0.4, rel=ROUNDING)
    np.testing.assert_allclose(block.displacement, [0, 0.5 * 0.3 * G * 0.2**2], rtol=ROUNDING)
    np.testing.assert_allclose(block.velocity, [0, 0.3 * G * 0.2], rtol=ROUNDING)


def test_trapezoid_approaches_the_rectangular_pulse() -> None:
    peak, length, resistance = 0.6 * G, 0.2, 0.3 * G
    errors = []
    for side in (1e-2, 1e-3, 1e-4, 1e-5):
        hold = length - side  # the impulse is that of the rectangle
        time = np.cumsum([0.0, side, hold, side, 1.0])
        block = sliding_block(time, [0, peak, peak, 0, 0], resistance)
        assert block.permanent == pytest.approx(slid_once(peak * length, side + hold / 2, peak / side, resistance), rel=ROUNDING)
        assert block.velocity[-1] == 0, "at rest within the record"
        errors.append(abs(block.permanent - rectangle(peak, length, resistance)))
    # First order in the width of the sides.
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 10, rtol=0.1)


def test_triangle_with_rest_after_the_pulse() -> None:
    block = sliding_block([0, 0.3, 0.6], [0, 5.0, 0], 2.5)
    assert block.velocity[-1] > 0, "the record ends before the block rests"
    assert block.permanent == pytest.approx(slid_once(1.5, 0.3, 5.0 / 0.3, 2.5), rel=ROUNDING)


def test_triangle_with_rest_on_the_falling_flank() -> None:
    """From the peak the net acceleration is s (d - t), d = w (1 - N / A): at rest (1 + sqrt 2) d after the peak."""
    width, peak, resistance = 0.4, 6.0, 5.0
    d = width * (1 - resistance / peak)
    block = sliding_block([0, width, 2 * width], [0, peak, 0], resistance)
    assert block.permanent == pytest.approx(peak / width * d**3 * (1 + 2 * math.sqrt(2) / 3), rel=ROUNDING)
    assert block.sliding_time == pytest.approx((2 + math.sqrt(2)) * d, rel=ROUNDING)
    assert block.displacement[-1] == block.permanent and block.velocity[-1] == 0


def test_train_of_triangles_without_a_rest_between() -> None:
    """The mean acceleration, 2.5, exceeds the yield acceleration, 1: the block slides on from pulse to pulse."""
    count, width, peak, resistance = 7, 0.3, 5.0, 1.0
    acceleration = [0.0, *[peak, 0.0] * count]
    block = sliding_block(width * np.arange(2 * count + 1), acceleration, resistance)
    assert np.all(block.velocity[1:] > 0)
    assert block.permanent == pytest.approx(slid_once(count * peak * width, count * width, peak / width, resistance), rel=ROUNDING)


def test_reversal_without_a_rest() -> None:
    """On a ramp from A to -A the block stops at 2 N - A, beyond the upslope yield: it slides back at once, into the tail."""
    peak, down, up, slope = 6.0, 1.5, 2.0, 4.0
    net = peak - down
    turn = 2 * net / slope
    left = 2 * peak / slope - turn
    back = peak - 2 * down - up  # net upslope acceleration at the turn
    speed = back * left + slope * left**2 / 2
    there = 2 / 3 * net**3 / slope**2
    forth = back * left**2 / 2 + slope * left**3 / 6 + speed**2 / (2 * up)
    block = sliding_block([0, 2 * peak / slope], [peak, -peak], down, up)
    assert block.velocity[-1] == pytest.approx(-speed, rel=ROUNDING)
    assert block.permanent == pytest.approx(there - forth, rel=ROUNDING)
    assert block.sliding_time == pytest.approx(turn + left + speed / up, rel=ROUNDING)
    assert sliding_block([0, 2 * peak / slope], [peak, -peak], down).permanent == pytest.approx(there, rel=ROUNDING)


@pytest.mark.parametrize("resistance", [6.0, 6.1, 100.0])
def test_no_motion_up_to_the_yield_acceleration(resistance: float) -> None:
    time = np.linspace(0, 5, 501)
    block = sliding_block(time, 6.0 * np.sin(2 * np.pi * time), resistance, resistance)
    assert not block.displacement.any() and not block.velocity.any()
    assert block.permanent == 0 and block.sliding_time == 0


def test_a_ramp_that_begins_at_the_yield_acceleration() -> None:
    """From rest at a = N the falling ramp passes the band between the two yields first: then it slides upslope from its crossing."""
    down, up, slope = 1.5, 2.0, 7.5
    length = 1 - (down + up) / slope
    block = sliding_block([0, 1], [down, down - slope], down, up)
    assert block.velocity[-1] == pytest.approx(-slope * length**2 / 2, rel=ROUNDING)
    assert block.displacement[-1] == pytest.approx(-slope * length**3 / 6, rel=ROUNDING)


def test_rounding_leaves_no_speed_against_the_direction_of_sliding() -> None:
    """An interval that ends one rounding before the standstill: the sum for its end gives -2.8e-17 m/s, which no one-way block has."""
    speed, net, rise = 0.2, 2.0 - 6.4, 1.3
    length = math.nextafter(_time_to_rest(speed, net, rise), 0.0)
    assert speed + length * (net + length * rise / 2) < 0
    _, velocity, _ = _slide(speed, 2.0, rise, length, 6.4, math.inf)
    assert velocity == 0


# ---------------------------------------------------------------- an independent integration


def stepped(time: np.ndarray, acceleration: np.ndarray, down: float, up: float, steps: int) -> float:
    """Final displacement (m) by small steps in which friction takes speed away but never reverses it (Moreau's scheme)."""
    dt = (time[-1] - time[0]) / steps
    v = x = 0.0
    for a in np.interp(time[0] + dt * (np.arange(steps) + 0.5), time, acceleration).tolist():
        v += a * dt
        v = max(v - down * dt, 0.0) if v > 0 else min(v + up * dt, 0.0)
        x += v * dt
    return x


@pytest.mark.parametrize("up", [math.inf, 3.0, 1.0])
def test_small_steps_approach_the_same_displacement(up: float) -> None:
    random = np.random.default_rng(1965)
    time = np.cumsum(random.uniform(0.02, 0.3, 40))
    acceleration = random.normal(0, 4, 40)
    time, acceleration = np.append(time, time[-1] + np.array([0.1, 10.0])), np.append(acceleration, [0.0, 0.0])
    block = sliding_block(time, acceleration, 1.0, None if math.isinf(up) else up)
    assert block.displacement[-1] == block.permanent, "the record is long enough for rest"
    speed, length = np.abs(block.velocity).max(), time[-1] - time[0]
    for steps in (25_000, 400_000):
        path_of_a_step = speed * length / steps
        assert abs(stepped(time, acceleration, 1.0, up, steps) - block.permanent) < path_of_a_step


# ---------------------------------------------------------------- what holds for every record


class Record(NamedTuple):
    """Drawn samples and yield accelerations."""

    time: np.ndarray
    acceleration: np.ndarray
    down: float
    up: float | None


@st.composite
def records(draw: st.DrawFn) -> Record:
    count = draw(st.integers(2, 12))
    gaps = draw(st.lists(st.floats(0.01, 1.0), min_size=count, max_size=count))
    acceleration = draw(st.lists(st.floats(-10, 10), min_size=count, max_size=count))
    yields = st.floats(0.05, 12)
    return Record(np.cumsum(gaps), np.array(acceleration), draw(yields), draw(st.none() | yields))


@given(records(), st.data())
def test_samples_on_the_straight_lines_change_nothing(record: Record, data: st.DataObject) -> None:
    """The time in sliding is left out: a block may hover at no speed, and rounding says whether it slides or stands."""
    time, acceleration, down, up = record
    fractions = np.array(data.draw(st.lists(st.floats(0.01, 0.99), min_size=time.size - 1, max_size=time.size - 1)))
    where = np.arange(1, time.size)
    extra_time = time[:-1] + fractions * np.diff(time)
    extra = acceleration[:-1] + fractions * np.diff(acceleration)
    coarse = sliding_block(time, acceleration, down, up)
    fine = sliding_block(np.insert(time, where, extra_time), np.insert(acceleration, where, extra), down, up)
    np.testing.assert_allclose(fine.displacement[::2], coarse.displacement, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(fine.velocity[::2], coarse.velocity, rtol=1e-9, atol=1e-9)
    assert fine.permanent == pytest.approx(coarse.permanent, rel=1e-9, abs=1e-9)


@given(records(), st.floats(0.05, 12))
def test_a_stronger_block_slides_no_farther(record: Record, other: float) -> None:
    weak, strong = (sliding_block(record.time, record.acceleration, value) for value in sorted((record.down, other)))
    assert np.all(strong.displacement <= weak.displacement * (1 + ROUNDING) + ROUNDING)
    assert strong.permanent <= weak.permanent * (1 + ROUNDING) + ROUNDING


@given(records())
def test_mirrored_ground_mirrors_the_block(record: Record) -> None:
    time, acceleration, down, up = record
    assume(up is not None)
    block, mirrored = sliding_block(time, acceleration, down, up), sliding_block(time, -acceleration, up, down)
    np.testing.assert_array_equal(mirrored.displacement, -block.displacement)
    np.testing.assert_array_equal(mirrored.velocity, -block.velocity)
    assert mirrored.permanent == -block.permanent and mirrored.sliding_time == block.sliding_time


@given(records())
def test_one_way_is_two_way_with_a_strength_never_reached(record: Record) -> None:
    one, two = (sliding_block(record.time, record.acceleration, record.down, up) for up in (None, 11.0))
    np.testing.assert_array_equal(one.displacement, two.displacement)
    assert np.all(np.diff(one.displacement) >= 0) and np.all(one.velocity >= 0)


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("time", "acceleration", "wanted"),
    [
        ([0, 1, 2], [0, 1], ("time", "(3,)", "(2,)", "same n")),
        ([0], [1], ("(1,)", "n >= 2")),
        ([[0, 1]], [[0, 1]], ("(1, 2)",)),
        ([0, 1, 1], [0, 1, 2], ("time[2]", "1.0 s", "greater than")),
        ([0, math.nan, 2], [0, 1, 2], ("time[1]", "nan", "finite")),
        ([0, 1, 2], [0, 1, math.inf], ("acceleration[2]", "inf", "finite")),
    ],
)
def test_bad_records_are_refused(time: list[float], acceleration: list[float], wanted: tuple[str, ...]) -> None:
    with pytest.raises(ValueError) as error:
        sliding_block(time, acceleration, 1.0)
    for text in wanted:
        assert text in str(error.value)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_yield_accelerations_are_positive_and_finite(value: float) -> None:
    with pytest.raises(ValueError, match=rf"^yield_acceleration: {value} m/s2"):
        sliding_block([0, 1], [0, 1], value)
    with pytest.raises(ValueError, match=rf"^upslope_yield_acceleration: {value} m/s2"):
        sliding_block([0, 1], [0, 1], 1.0, value)
