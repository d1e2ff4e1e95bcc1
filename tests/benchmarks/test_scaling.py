"""The benchmark over sizes runs on tiny ones and its numbers agree with each other."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.long
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("scaling.py", "--spacing", "5.0", "2.5", "--repeats", "2", "--particle-steps", "2000")
    first, second = found["sizes"]
    assert (first["particles"], second["particles"]) == (163, 472)
    # The turns and one to warm up, each of particle_steps over particles.
    assert (first["steps"], second["steps"]) == (3 * (2000 // 163), 3 * 4)
    for name in ("particle_step", "interaction"):
        assert first[f"{name}_ratio"] == 1.0
        assert second[f"{name}_ratio"] == pytest.approx(second[f"{name}_ns"] / first[f"{name}_ns"])
    assert found["triad_rate"] > 1e8 and f"{found['triad_rate'] / 1e9:.1f} GB/s" in printed
    for size in found["sizes"]:
        # 16 bytes a pair in single precision, and some 30 numbers of the state
        assert 16 * size["neighbours_mean"] + 200 < size["read_bytes"] < 16 * size["neighbours_mean"] + 400
        assert size["read_rate"] == pytest.approx(1e9 * size["read_bytes"] / size["particle_step_ns"])
        assert size["particle_step_ns"] == pytest.approx(size["interaction_ns"] * size["neighbours_mean"])
        assert size["renew_pairs_ns"] > 0 and size["renew_candidates_ns"] > 0
        assert f"{size['particles']:,d}" in printed
    assert first["neighbours_mean"] < second["neighbours_mean"]
    assert found["largest_ratio"] == max(1.0, second["particle_step_ratio"])
