"""A job computes with the threads it was given: those of the solver, which Snakemake counts, and none of numba's."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from small_scenes import SceneBuilder

from sph.jobs.ahead import Task
from sph.jobs.simulation import make
from sph.solver.run import Run
from sph.study.planned import planned
from sph.study.runs import SIMULATION

ROOT = Path(__file__).resolve().parents[2]
NUMBAS = """
import json, sys
from sph.scene.schema import make_scene
from sph.solver.run import run
run(make_scene(json.loads(sys.argv[1])), until="gravity", threads=2)
from numba.np.ufunc import parallel
print(parallel._is_initialized)
"""


@pytest.mark.long
def test_the_solver_starts_none_of_numbas_threads(small_slope: SceneBuilder) -> None:
    done = subprocess.run(
        [sys.executable, "-c", NUMBAS, small_slope({}).model_dump_json()], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert done.stdout.split() == ["False"]


def test_a_jobs_threads_are_the_solvers(small_slope: SceneBuilder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    teams: list[int] = []
    go = Run.go
    monkeypatch.setattr(Run, "go", lambda self, *arguments: (teams.append(len(self.simulation.team)), go(self, *arguments))[1])
    scene, contents = planned(json.loads(small_slope({}).model_dump_json()))
    file = str(tmp_path / "gravity.nc")
    make(Task(file, str(tmp_path / "log"), None, scene, contents, "gravity", SIMULATION, False, True, "cpu", "0"), 2)
    assert teams == [2]
