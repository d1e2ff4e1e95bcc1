"""The comparison with C++ runs on a tiny setting; it checks itself that both give the same result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import loops
import pytest

TINY = ["--spacing", "5.0", "--times", "3", "--repeats", "2"]


@pytest.mark.long
@pytest.mark.skipif(loops.compiler() is None, reason="there is no C++ compiler (g++, c++ or $CXX) to compare with")
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("loops.py", *TINY)
    cases = found["cases"]
    assert [(case["smoothing_ratio"], case["precision"]) for case in cases] == [
        (ratio, precision) for ratio in (2.3, 1.3) for precision in ("mixed", "double")
    ]
    for case in cases:
        ns, speed = case["ns_per_interaction"], case["numba_over_cpp_speed"]
        assert set(speed) == set(loops.LOOPS)
        for name in loops.LOOPS:
            assert speed[name] == pytest.approx(ns[f"C++ {name}"] / ns[f"numba {name}"])
            assert name in printed
        assert case["difference"] < loops.ROUNDING
        interactions = 3 * case["neighbours_mean"] * case["particles"]
        assert case["shortest_call_us"] == pytest.approx(1e-3 * interactions * min(ns.values()))
    assert cases[0]["neighbours_mean"] == cases[1]["neighbours_mean"] > 2 * cases[2]["neighbours_mean"]
    assert found["lowest_speed_over_cpp"] == min(min(case["numba_over_cpp_speed"].values()) for case in cases)


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(loops, "compiler", lambda: None)
    with pytest.raises(SystemExit, match="no compiler"):
        loops.compiled(str(tmp_path))
