"""The benchmark of a job's start gives times in order; how long it takes is not judged."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.long
def test_the_times_are_those_of_a_job(script: Any) -> None:
    found, printed = script("starting.py", "--repeats", "1")
    assert found["here"]["wall"] > found["here"]["run"] > 0 and found["here"]["processor"] > 0
    assert "here" in printed
