"""Synthetic motions: the statistics that they are made for, over many seeds, and rest at the end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import read_scene
from sph.scene.ground_motion.measures import arias_share, measure
from sph.scene.ground_motion.processing import integral
from sph.scene.ground_motion.stochastic import INTERVAL, Stochastic, synthesised
from sph.scene.schema import make_scene

TARGET: dict[str, Any] = {
    "arias_intensity": 0.5, "duration": 8.0, "time_mid": 4.0, "frequency_mid": 5.0, "frequency_rate": -0.1, "damping": 0.3,
    "high_pass": 0.2,
}  # fmt: skip
SEEDS = 200
ERRORS = 4.0
"""Standard errors of a mean over the seeds that it may be off: one in 16,000 by chance."""


def motion(seed: int = 1, **changes: Any) -> np.ndarray:
    return synthesised(Stochastic(**{**TARGET, **changes, "seed": seed}))


@pytest.fixture(scope="module")
def motions() -> np.ndarray:
    return np.array([motion(seed) for seed in range(SEEDS)])


def near(found: np.ndarray, target: float, bias: float) -> bool:
    """Whether a mean is within its sampling error and a bias of the target."""
    return abs(float(found.mean()) - target) <= ERRORS * float(found.std(ddof=1)) / np.sqrt(found.size) + bias


@pytest.mark.long
def test_the_target_statistics_are_met(motions: np.ndarray) -> None:
    # Biases allowed: 2 % of the intensity, which the high-pass filter takes and the end cuts off; of the times one interval and 2 %,
    # since the filter of a motion of some 40 cycles spreads it by a part of a period.
    found = [measure(each, INTERVAL) for each in motions]
    assert near(np.array([each.arias_intensity for each in found]), TARGET["arias_intensity"], 0.02 * TARGET["arias_intensity"])
    mean_share = arias_share(np.sqrt((motions**2).mean(axis=0)))
    start, middle, end = np.interp([0.05, 0.45, 0.95], mean_share, INTERVAL * np.arange(mean_share.size))
    durations = np.array([each.duration_5_95 for each in found])
    middles = np.array([np.interp(0.45, arias_share(each), INTERVAL * np.arange(each.size)) for each in motions])
    for name, value, spread in (("duration", end - start, durations), ("time_mid", middle, middles)):
        assert abs(value - TARGET[name]) <= ERRORS * spread.std(ddof=1) / np.sqrt(SEEDS) + INTERVAL + 0.02 * TARGET[name], name


@pytest.mark.long
def test_the_rate_of_zero_crossings_is_the_frequency_of_the_filter(motions: np.ndarray) -> None:
    # Up-crossings in 2 s about the time of the middle; 3 % for what the sampling and the high-pass filter change.
    middle = slice(*(round((TARGET["time_mid"] + side) / INTERVAL) for side in (-1.0, 1.0)))
    part = motions[:, middle]
    rates = ((part[:, :-1] < 0) & (part[:, 1:] >= 0)).sum(axis=1) / (INTERVAL * (part.shape[1] - 1))
    assert near(rates, TARGET["frequency_mid"], 0.03 * TARGET["frequency_mid"])


@pytest.mark.long
def test_the_ground_comes_to_rest(motions: np.ndarray) -> None:
    # (1 + 12) exp(-12) = 8e-5 of the swing is left; ten times that for a swing larger than the peak at the samples.
    for each in motions:
        velocity = integral(each, INTERVAL)
        displacement = integral(velocity, INTERVAL)
        assert abs(velocity[-1]) < 1e-3 * np.abs(velocity).max()
        assert abs(displacement[-1]) < 1e-3 * np.abs(displacement).max()


def test_a_seed_gives_the_same_bits_and_another_gives_others() -> None:
    np.testing.assert_array_equal(motion(7), motion(7))
    assert not np.array_equal(motion(7), motion(8))


def test_every_key_is_required() -> None:
    for name in TARGET:
        with pytest.raises(ValueError, match=name):
            Stochastic(**{key: value for key, value in TARGET.items() if key != name}, seed=1)
    with pytest.raises(ValueError, match="seed"):
        Stochastic(**TARGET)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"duration": 40.0}, "D5-95 between .* s for this time_mid"),
        ({"frequency_rate": -2.0}, "must stay above high_pass"),
        ({"frequency_rate": 8.0}, "at most 25 Hz"),
    ],
)
def test_what_the_model_does_not_bear_is_refused(changes: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        motion(**changes)


def scene(**motion: Any) -> Any:
    return make_scene({**read_scene("config/scenes/paper.yaml"), "motion": {"kind": "record", "start": 3.0, **motion}})


def test_it_stands_in_place_of_a_file_and_is_scaled_as_a_record() -> None:
    made = scene(stochastic={**TARGET, "seed": 3}, amplitude="0.3g").motion
    assert made.peak == pytest.approx(0.3 * 9.81)
    with pytest.raises(ValueError, match="stochastic: .*data"):
        scene(stochastic={**TARGET, "seed": 3}, data={"interval": 0.01, "x": [0.0, 1.0]})
    with pytest.raises(ValueError, match="vertical"):
        scene(stochastic={**TARGET, "seed": 3}, vertical={})
