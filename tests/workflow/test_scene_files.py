"""A file that a scene names is an input of its simulations, and its content stays with their results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from test_workflow import STUDY, planned_jobs, snakemake

from sph.scene.schema import load_scene
from sph.storage import trajectory

SCENE: dict[str, Any] = {
    "scheme": "paper",
    "name": "own",
    "duration": 3.0,
    "geometry": {"shape": "ground_line", "file": "ground.csv", "base": 430.0},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "start": 1.0, "ramp": 0.5, "decay_start": 2.0, "end": 2.5},
    "numerics": {"spacing": 5.0, "time_step": 1e-3},
    "outputs": {"frame_interval": 0.25, "series_interval": 0.01},
}
GRAVITY = "results/small/draft/stages/gravity.nc"


@pytest.mark.long
def test_a_change_of_the_file_runs_the_simulations_again(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "config").mkdir()
    ground = tmp_path / "scenes" / "ground.csv"
    ground.write_text("100,440\n150,440\n165,465\n200,465\n")
    (tmp_path / "scenes" / "own.yaml").write_text(yaml.safe_dump(SCENE))
    (tmp_path / "config" / "config.yaml").write_text(yaml.safe_dump(STUDY | {"scene": "scenes/own.yaml"}))
    configured = ("--configfile", "config/config.yaml", "--cores", "1", GRAVITY)
    done = snakemake(tmp_path, *configured)
    assert done.returncode == 0, done.stderr
    made = trajectory.scene_of(trajectory.read(tmp_path / GRAVITY))
    assert made.geometry == load_scene(tmp_path / "scenes" / "own.yaml").geometry.model_copy(update={"file": "scenes/ground.csv"})
    assert planned_jobs(tmp_path, *configured) == {}
    ground.write_text("100,440\n150,440\n165,460\n200,460\n")
    assert planned_jobs(tmp_path, *configured) == {"stage": 1}
    ground.write_text("100,440\n150,440\n140,460\n200,460\n")
    refused = snakemake(tmp_path, "--dry-run", *configured)
    assert refused.returncode != 0 and "the line may not overhang" in refused.stdout + refused.stderr
