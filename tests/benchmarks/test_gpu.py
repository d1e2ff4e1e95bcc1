"""The benchmark of a graphics card runs in numba's simulator of one, on a tiny scene."""

from __future__ import annotations

from typing import Any

import pytest

from sph.solver.cuda import ensemble


@pytest.mark.long
@pytest.mark.skipif(ensemble.find_spec("numba_cuda") is None, reason=f"numba-cuda is missing ({ensemble.INSTALL})")
def test_the_numbers_agree_with_each_other(script: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_ENABLE_CUDASIM", "1")
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    found, printed = script("gpu.py", "--runs", "1", "--steps", "1", "--finest", "0.5", "--coarsen", "12", "--threads", "4")
    mixed, double = found["cases"]
    assert mixed["runs"] == double["runs"] == 1 and mixed["particles"] == double["particles"] < 100
    assert mixed["speed"] > 0 and mixed["over_a_core"] > 0
    assert mixed["bytes_a_second"] < mixed["speed"] * double["bytes_a_second"] / double["speed"]
    assert "over a core" in printed
