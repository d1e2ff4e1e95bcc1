"""The benchmark script runs on a tiny setting and its numbers agree with each other; time itself is not judged."""

from __future__ import annotations

import math
from typing import Any

import pytest

TINY = ["--duration", "3.5", "--moments", "2", "--set", "numerics.spacing=5.0", "--set", "numerics.time_step=0.001"]


def agrees(stage: dict[str, Any]) -> None:
    """Parts of a step, its length and the wall time of a stage are one account."""
    split = stage["split_us"]
    assert sum(split.values()) == pytest.approx(stage["step_us"])
    assert stage["step_us"] == pytest.approx(1e6 * stage["wall_time_s"] / stage["steps"])
    assert stage["loops_share"] == pytest.approx((split["velocity_gradients"] + split["stress_accelerations"]) / stage["step_us"])
    # The literal smoothing length: pi 4.6^2 = 66 neighbours inside, fewer at the edges of so small a scene.
    assert 20 < stage["neighbours_mean"] < 66
    assert 0 <= stage["renewals_per_step"] <= 1
    assert all(math.isfinite(value) for value in split.values())
    assert split["velocity_gradients"] > 0 and split["stress_accelerations"] > 0
    assert stage["call_us"] > 0


@pytest.mark.long
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    # The scene's motion would end after the run; that is allowed.
    found, printed = script("speed.py", *TINY)
    stages = found["stages"]
    assert list(stages) == ["elastic", "collapse"]
    for stage in (found, *stages.values()):
        agrees(stage)
    assert found["particles"] == 163
    assert (stages["elastic"]["steps"], stages["collapse"]["steps"]) == (3000, 500)
    assert found["particle_steps"] == 163 * 3500
    for name in ("steps", "moments", "wall_time_s"):
        assert found[name] == pytest.approx(sum(stage[name] for stage in stages.values()))
    assert found["moments"] == 4
    assert all(stage["wall_time_s"] > 0 for stage in stages.values())
    assert found["particle_steps_per_second"] == pytest.approx(found["particle_steps"] / found["wall_time_s"])
    assert found["interactions_per_second"] == pytest.approx(found["neighbours_mean"] * found["particle_steps_per_second"])
    for stage in stages.values():
        assert min(stage["split_us"][name] for name in ("update_stress", "update_pairs")) >= 0
    for name in found["split_us"]:
        assert name in printed
    assert "M/s" in printed
