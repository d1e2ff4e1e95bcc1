"""What a study costs beside its runs: the start of a job, compiling, and the paper's study at its coarsest."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import netCDF4
import pytest
from measuring import ROOT, children

pytest.importorskip("pytest_benchmark", reason='pytest-benchmark is missing; pip install -c constraints.txt -e ".[bench]"')
pytestmark = pytest.mark.long

SCENE = {
    "name": "block",
    "scheme": "paper",
    "duration": 0.01,
    "geometry": {"shape": "block", "width": 4.0, "height": 4.0},
    "gravity": {"ramp": 0.001, "duration": 0.002},
    "motion": {"kind": "none"},
    "numerics": {"spacing": 1.0, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.001},
}
"""A few particles: nearly all of a job's time is beside the run."""
JOB = """
import json, sys
from sph.jobs.ahead import Task
from sph.jobs.simulation import work
from sph.study.planned import planned
work(Task(sys.argv[3], sys.argv[2], None, *planned(json.loads(sys.argv[1])), "end", "simulation", False, True, "cpu", "0"), [], 1)
"""


@pytest.mark.benchmark(timer=children)
@pytest.mark.parametrize("state", ["compiled", "nothing compiled"])
def test_job(benchmark: Any, tmp_path: Path, state: str) -> None:
    """Imports, building, compiling or loading, findings and writing, in processor time; bytecode is kept, as an installation does."""
    if benchmark.disabled:
        pytest.skip("measured by pytest-benchmark alone")
    out = tmp_path / "run.nc"
    command = [sys.executable, "-c", JOB, json.dumps(SCENE), str(tmp_path / "log"), str(out)]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "PYTHONPYCACHEPREFIX": str(tmp_path / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # else every job would compile numba's and scipy's Python anew

    def cache() -> tuple[tuple[str], dict[str, Any]]:
        return (str(tmp_path / "cache") if state == "compiled" else tempfile.mkdtemp(dir=tmp_path),), {}

    def job(cache: str) -> None:
        subprocess.run(command, env=environment | {"SPH_CACHE_DIR": cache}, check=True, capture_output=True)

    benchmark.pedantic(job, setup=cache, rounds=5 if state == "compiled" else 2, warmup_rounds=1)
    with netCDF4.Dataset(out) as run:
        assert len(run.dimensions["particle"]) < 100
    benchmark.extra_info |= {"what": f"a job of a study, solver {state}, its run next to nothing (processor time)"}


@pytest.mark.benchmark(timer=children)
def test_study(benchmark: Any, tmp_path: Path) -> None:
    """The paper's study at ``draft``; tests/workflow runs studies where this is not measured, and ``tools.times`` has the wall time."""
    if benchmark.disabled:
        pytest.skip("measured by pytest-benchmark alone")
    study = ["--snakefile", str(ROOT / "Snakefile"), "--configfile", str(ROOT / "config/config.yaml"), "--config", "fidelity=draft"]
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "--directory", str(tmp_path), *study]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "SPH_CACHE_DIR": str(tmp_path / "cache")}
    benchmark.pedantic(subprocess.run, args=(command,), kwargs={"env": environment, "check": True}, rounds=1)
    assert (tmp_path / "results/paper/draft/report.html").is_file()
    benchmark.extra_info["what"] = "the paper's study at `draft`, nothing compiled (processor time)"
