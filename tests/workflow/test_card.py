"""A study on a graphics card, which numba's simulator stands for."""

from __future__ import annotations

import importlib.util
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml
from small_scenes import FEW, SLOPE
from test_workflow import ROOT, planned_jobs, snakemake_command

from sph.jobs.log import read_log
from sph.scene.configuration import merge
from sph.storage import trajectory

pytestmark = pytest.mark.skipif(importlib.util.find_spec("numba_cuda") is None, reason='numba-cuda is missing (pip install -e ".[cuda]")')
STUDY: dict[str, Any] = {"study": "small", "scene": "slope.yaml", "grid": {"soil.cohesion": ["10", "20", "30"]}, "searches": "none"}


def test_one_job_takes_all_runs_that_can_start(tmp_path: Path) -> None:
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(merge(SLOPE, FEW)))
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(STUDY))
    stages = [f"results/small/own/stages/gravity_soil.cohesion-{cohesion}.nc" for cohesion in STUDY["grid"]["soil.cohesion"]]
    on_card = ("--configfile", str(tmp_path / "study.yaml"), "--config", "backend=cuda", "--")
    settings = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        snakemake_command(tmp_path, "--cores", "2", *on_card, *stages), env=os.environ | settings, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert all(trajectory.read(tmp_path / file).attrs["backend"] == "cuda" for file in stages)
    logs = [read_log(tmp_path / file.replace("/stages/", "/logs/").replace(".nc", ".log")) for file in stages]
    assert len({log.process for log in logs if log and log.process and log.reason is None}) == 3
    assert len({log.process.number for log in logs if log and log.process}) == 1, "one process made them"
    assert not [path for path in (tmp_path / "results").rglob(".*")]
    # Bits differ, and so what one backend has made is made anew with the other.
    assert planned_jobs(tmp_path, *on_card, *stages) == {}
    assert planned_jobs(tmp_path, *on_card[:2], "--", *stages) == {"stage": 3}
