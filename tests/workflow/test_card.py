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
STUDY: dict[str, Any] = {"study": "small", "scene": "slope.yaml", "grid": {"soil.cohesion": ["10", "20"]}, "searches": "none"}


def test_one_job_takes_all_runs_that_can_start_and_what_goes_on_from_them(tmp_path: Path) -> None:
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(merge(SLOPE, FEW)))
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(STUDY))
    names = [f"soil.cohesion-{cohesion}" for cohesion in STUDY["grid"]["soil.cohesion"]]
    runs, folder = [f"results/small/own/runs/{name}.nc" for name in names], tmp_path / "results" / "small" / "own"
    on_card = ("--configfile", str(tmp_path / "study.yaml"), "--config", "backend=cuda", "--")
    settings = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        snakemake_command(tmp_path, "--cores", "2", *on_card, *runs), env=os.environ | settings, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    files = [*folder.glob("stages/*.nc"), *folder.glob("runs/*.nc")]
    assert len(files) == 6 and all(trajectory.read(file).attrs["backend"] == "cuda" for file in files)
    logs = [read_log(folder / "logs" / f"{file.stem}.log") for file in files]
    assert len({log.process for log in logs if log and log.process and log.reason is None}) == 6
    assert len({log.process.number for log in logs if log and log.process}) == 1, "one process made them"
    assert not list(folder.rglob(".*"))
    # Bits differ, and so what one backend has made is made anew with the other.
    assert planned_jobs(tmp_path, *on_card, *runs) == {}
    assert planned_jobs(tmp_path, *on_card[:2], "--", *runs) == {"stage": 4, "simulate": 2}
