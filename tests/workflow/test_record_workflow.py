"""A study under a recorded motion: its amplitude is a dimension, and a run repeats without its file (changed files: test_contents.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from calling import call
from small_scenes import SLOPE
from test_workflow import STUDY, snakemake

from sph.storage import trajectory

TIME = np.arange(100) * 0.01
BURST = np.sin(2 * np.pi * 4.0 * TIME) * np.sin(np.pi * TIME) ** 2
RUNS = [f"results/small/draft/runs/S_R-0.10_gamma-1_amplitude-{amplitude}.nc" for amplitude in ("0.1", "8.0")]
DURATION = 1.5
pytestmark = pytest.mark.long


def write_record(path: Path, factor: float = 1.0) -> None:
    rows = (f"{t:.2f},{factor * a:.6f},{0.3 * factor * a:.6f}" for t, a in zip(TIME, BURST, strict=True))
    path.write_text("time (s),ax (g),ay (g)\n" + "\n".join(rows))


@pytest.fixture(scope="module")
def shaken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of two finished runs whose scene and record lie in a folder below."""
    folder = tmp_path_factory.mktemp("shaken")
    (folder / "scenes").mkdir()
    write_record(folder / "scenes" / "record.csv")
    motion = {"kind": "record", "file": "record.csv", "start": 0.5, "vertical": {}, "baseline": {"degree": 0}}
    changes: dict[str, Any] = {"motion": motion, "duration": DURATION, "gravity": {"ramp": 0.2, "duration": 0.5}}
    (folder / "scenes" / "slope.yaml").write_text(yaml.safe_dump(SLOPE | changes))
    (folder / "study.yaml").write_text(yaml.safe_dump(STUDY | {"scene": "scenes/slope.yaml"}))
    result = snakemake(folder, *RUNS, "--cores", "1", "--configfile", str(folder / "study.yaml"))
    assert result.returncode == 0, result.stderr
    return folder


def test_the_amplitude_scales_both_components(shaken: Path) -> None:
    for name, peak in zip(RUNS, (0.1, 8.0), strict=True):
        ds = trajectory.read_run(shaken / name).dataset()
        ground, vertical = (ds[variable].values for variable in ("ground_acceleration", "ground_acceleration_y"))
        assert np.abs(ground).max() == pytest.approx(peak, rel=1e-6)
        np.testing.assert_allclose(vertical, 0.3 * ground, atol=1e-4 * peak)
        assert trajectory.scene_of(ds).motion.file == "record.csv", "no folder of this machine in a result"


def test_a_run_is_repeated_without_its_record(shaken: Path) -> None:
    (shaken / "scenes" / "record.csv").unlink()
    result = call("run", shaken / RUNS[1], "--out", shaken / "again.nc")
    assert result.exit_code == 0 and "every variable is identical" in result.stderr, result.output
