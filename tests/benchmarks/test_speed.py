"""The benchmark script runs on a tiny setting and its numbers agree with each other; time itself is not judged."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

import sph

SCRIPT = Path(__file__).with_name("speed.py")
TINY = ["--duration", "3.5", "--moments", "3", "--set", "numerics.spacing=5.0", "--set", "numerics.time_step=0.001"]


def test_the_numbers_agree_with_each_other(tmp_path: Path) -> None:
    path = tmp_path / "speed.json"
    # The scene's motion would end after the run; that is allowed.
    command = [sys.executable, str(SCRIPT), *TINY, "--json", str(path)]
    environment = os.environ | {"PYTHONPATH": str(Path(sph.__file__).parents[1])}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(path.read_text())
    assert found["particles"] == 163
    assert found["steps"] == 3500
    assert found["particle_steps"] == 163 * 3500
    assert found["moments"] == 3
    assert found["wall_time_s"] > 0
    assert found["particle_steps_per_second"] == pytest.approx(found["particle_steps"] / found["wall_time_s"])
    assert found["interactions_per_second"] == pytest.approx(found["neighbours_mean"] * found["particle_steps_per_second"])
    # The literal smoothing length: pi 4.6^2 = 66 neighbours inside, fewer at the edges of so small a scene.
    assert 20 < found["neighbours_mean"] < 66
    assert 0 <= found["renewals_per_step"] <= 1
    split = found["split_us"]
    assert sum(split.values()) == pytest.approx(found["step_us"])
    assert found["step_us"] == pytest.approx(1e6 * found["wall_time_s"] / found["steps"])
    for name in ("velocity_gradients", "stress_accelerations", "update_stress", "kick_and_drift"):
        assert split[name] > 0 and math.isfinite(split[name])
        assert name in done.stdout
    assert split["update_pairs"] == pytest.approx(found["renewals_per_step"] * found["one_update_pairs_us"])
    assert "M/s" in done.stdout
