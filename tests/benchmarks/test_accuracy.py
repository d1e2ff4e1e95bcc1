"""The benchmark of accuracy runs on coarse spacings, against itself."""

from __future__ import annotations

import math
from typing import Any

import accuracy
import pytest


def test_a_spacing_counts_if_all_finer_ones_do() -> None:
    runs = [{"seconds": seconds, "error": error} for seconds, error in ((1.0, 0.01), (2.0, 0.3), (4.0, 0.08), (8.0, 0.04))]
    assert [accuracy.within(runs, error) for error in (0.5, 0.1, 0.05, 0.02)] == [1.0, 4.0, 8.0, math.inf]


@pytest.mark.long
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("accuracy.py", "--spacing", "4", "5", "--against", str(accuracy.ROOT))
    here, there = found["runs"].values()
    assert [run["spacing"] for run in here] == [5.0, 4.0]
    for own, other in zip(here, there, strict=True):
        assert own["seconds"] > 0 and {**own, "seconds": 0} == {**other, "seconds": 0}, "the same code gives the same bits"
        for name, true in found["reference"].items():
            assert abs(own[name] / true - 1.0) <= own["error"]
        assert f"{own['error']:.1%}" in printed
