"""``sph compile``: the solver ready for scenes and the static tests of their slopes, before any run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from calling import call

BLOCK = {
    "scheme": "paper",
    "name": "block",
    "duration": 0.1,
    "geometry": {"shape": "block", "width": 4.0, "height": 4.0},
    "gravity": {"duration": 0.05, "ramp": 0.05},
    "motion": {"kind": "none"},
    "outputs": {"frame_interval": 0.1, "series_interval": 0.05},
    "probes": {},
}


@pytest.mark.long
def test_what_is_compiled_for_a_scene_serves_its_runs(tmp_path: Path) -> None:
    scene = tmp_path / "block.yaml"
    scene.write_text(yaml.safe_dump(BLOCK))

    def sph(*arguments: str) -> str:
        command = [sys.executable, "-m", "sph.command.cli", *arguments]
        environment = os.environ | {"SPH_CACHE_DIR": str(tmp_path / "cache")}
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return done.stdout + done.stderr

    first = sph("compile", "block.yaml")
    assert "compiling the solver with" in first and "block.yaml: ready" in first
    assert "compiling" not in sph("compile", "block.yaml")
    assert "compiling" not in sph("run", "block.yaml")


def test_a_file_that_is_no_scene_is_refused_before_anything_is_compiled(tmp_path: Path) -> None:
    good, bad = tmp_path / "block.yaml", tmp_path / "bad.yaml"
    good.write_text(yaml.safe_dump(BLOCK))
    bad.write_text("name: [")
    result = call("compile", good, bad)
    assert result.exit_code == 2 and "bad.yaml" in result.output and "ready" not in result.output
