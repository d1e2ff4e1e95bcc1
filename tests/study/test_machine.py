"""Costs are told in words."""

from __future__ import annotations

import pytest

from sph.study.machine import duration

TIMES = [
    (0.2, "0 s"),
    (59.4, "59 s"),
    (60.0, "1 min"),
    (697.2, "11 min 37 s"),
    (3599.0, "59 min 59 s"),
    (7200.0, "2 h"),
    (7531.0, "2 h 5 min"),
]


@pytest.mark.parametrize(("seconds", "words"), TIMES)
def test_a_duration_in_words(seconds: float, words: str) -> None:
    assert duration(seconds) == words
