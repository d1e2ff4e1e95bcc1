"""Measures and response spectrum against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sph.scene.ground_motion.measures import arias_share, measure
from sph.scene.ground_motion.spectrum import pseudo_acceleration

AMPLITUDE, FREQUENCY, INTERVAL = 3.0, 2.0, 0.001
TIME = np.arange(10_001) * INTERVAL
COSINE = AMPLITUDE * np.cos(2 * np.pi * FREQUENCY * TIME)


def test_a_cosine() -> None:
    # From rest: velocity A/w sin(wt), displacement A/w^2 (1 - cos wt); Arias pi/2g A^2 T/2 over whole periods, in even growth.
    found = measure(COSINE, INTERVAL)
    w = 2 * np.pi * FREQUENCY
    assert found.peak_acceleration == pytest.approx(AMPLITUDE)
    assert found.peak_velocity == pytest.approx(AMPLITUDE / w, rel=1e-4)
    assert found.peak_displacement == pytest.approx(2 * AMPLITUDE / w**2, rel=1e-4)
    assert found.arias_intensity == pytest.approx(np.pi / (2 * 9.81) * AMPLITUDE**2 * 10.0 / 2, rel=1e-6)
    # The share wavers about a straight line by 1 / (4 w), at both ends.
    assert found.duration_5_95 == pytest.approx(9.0, abs=2 / (4 * w))
    assert found.duration_5_75 == pytest.approx(7.0, abs=2 / (4 * w))
    assert abs(found.final_velocity) < 1e-12


def test_a_box_has_even_growth() -> None:
    # Constant acceleration for 10 s: the durations are the shares of it, the ground does not stop.
    found = measure(np.full(1001, -2.0), 0.01)
    assert found[:4] == pytest.approx((2.0, 20.0, 100.0, np.pi / (2 * 9.81) * 40.0))
    assert found[4:] == pytest.approx((7.0, 9.0, -20.0))


def test_still_ground() -> None:
    assert measure(np.zeros(5), 0.1) == (0.0,) * 7
    assert not arias_share(np.zeros(5)).any()


@pytest.mark.parametrize("damping", [0.02, 0.05, 0.2])
def test_the_spectrum_at_resonance_and_off_it(damping: float) -> None:
    # Long harmonic load: the steady answer, 1 / sqrt((1 - b^2)^2 + (2 zeta b)^2) of the static one with b = T / T_load, without a
    # transient, since the load swells and fades slowly.
    time = np.arange(0.0, 600.0, 0.01)
    load = np.sin(2 * np.pi * FREQUENCY * time) * np.minimum(time / 300.0, 2.0 - time / 300.0)
    ratios = np.array([0.2, 0.6, 1.0, 1.5])
    wanted = 1.0 / np.sqrt((1 - ratios**2) ** 2 + (2 * damping * ratios) ** 2)
    np.testing.assert_allclose(pseudo_acceleration(load, 0.01, ratios / FREQUENCY, damping), wanted, rtol=0.02)


def test_the_spectrum_of_a_step_that_stays() -> None:
    # x overshoots a constant load by exp(-zeta pi / sqrt(1 - zeta^2)), and stiff oscillators follow the ground.
    # The step is a ramp of 1 ms; the record ends soon after, but the largest answer has come by then.
    load = np.where(np.arange(20_000) > 0, 1.0, 0.0)
    wanted = 1.0 + np.exp(-0.05 * np.pi / np.sqrt(1 - 0.05**2))
    np.testing.assert_allclose(pseudo_acceleration(load, 0.001, np.array([0.5, 1.0, 5.0]), 0.05), wanted, rtol=0.01)


def test_the_swing_after_the_end_counts() -> None:
    # A short push on a slow oscillator: w times the velocity of the push, met a quarter of its period after the end.
    push = np.array([0.0, 1.0, 0.0])
    w = 2 * np.pi / 5.0
    found = pseudo_acceleration(push, 0.01, np.array([5.0]), 0.0)
    assert found[0] == pytest.approx(w * 0.01, rel=0.01)


@pytest.mark.parametrize("period", [0.03, 0.3, 3.0])
def test_the_spectrum_against_an_integrator(period: float) -> None:
    # Noise every 0.02 s, linear between: also for a period of one and a half intervals.
    rng = np.random.default_rng(3)
    load = np.concatenate([[0.0], rng.normal(size=200), [0.0]])
    time = np.arange(load.size) * 0.02
    w = 2 * np.pi / period
    fine = np.linspace(0.0, time[-1] + period, 40_001)
    answer = solve_ivp(
        lambda t, y: [y[1], -2 * 0.05 * w * y[1] - w * w * y[0] - np.interp(t, time, load, right=0.0)],
        (0.0, fine[-1]), [0.0, 0.0], t_eval=fine, rtol=1e-8, atol=1e-10, max_step=0.01,
    )  # fmt: skip
    assert pseudo_acceleration(load, 0.02, np.array([period]))[0] == pytest.approx(w * w * np.abs(answer.y[0]).max(), rel=0.013)
