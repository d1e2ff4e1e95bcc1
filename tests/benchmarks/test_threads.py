"""The benchmark of threads runs on a tiny scene; several threads give the bits of one."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.long
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("threads.py", "--spacing", "1.4", "--threads", "2", "--steps", "5", "--repeats", "2")
    assert found["particles"] > 4 * 256
    assert found["threads"] == 2
    assert found["steps"] == 3 * 5
    assert found["same_bits"] and "the same bits" in printed
    assert found["one_ms"] > 0
    assert found["speedup"] == pytest.approx(found["one_ms"] / found["several_ms"])
