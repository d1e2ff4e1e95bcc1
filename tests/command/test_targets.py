"""Targets beside the study in ``sph status``: listed once they have been started, by the points that they ask for."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import netCDF4
import pytest
import yaml
from typer.testing import CliRunner

from sph.command.cli import app
from sph.command.explain import Project
from sph.command.status import Job, located_plan, look
from sph.command.targets import target_jobs
from sph.study.plan import Plan

ROOT = Path(__file__).resolve().parents[2]
TRIGGER: dict[str, Any] = {
    "cases": {"as it is": {}, "slip: sides": {"walls": {"sides": "free_slip", "layers": 4}}},
    "intensity": {"lowest": 0.0, "highest": 8.0, "cells": 2},
    "tolerance": 0.5,
    "at": {"S_R": ["0.10"], "gamma": ["100"]},
    "confirm": {"fidelity": "standard"},
}
HEAD = "case,S_R,gamma,amplitude,round\n"


@pytest.fixture
def study(tmp_path: Path) -> tuple[Plan, Path]:
    (tmp_path / "config").mkdir()
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8")) | {"experiments": {"trigger": "mine.yaml"}}
    (tmp_path / "config" / "config.yaml").write_text(yaml.safe_dump(config, sort_keys=False))
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(TRIGGER, sort_keys=False))
    return located_plan(tmp_path / "results" / "paper" / "draft", None)


def wants(folder: Path, table: str, *points: str) -> None:
    place = folder / "trigger" / "rounds"
    place.mkdir(parents=True, exist_ok=True)
    (place / f"{table}-wanted.csv").write_text(HEAD + "".join(f"{point},0\n" for point in points))


def finish(folder: Path, job: Job) -> None:
    path = folder / job.place / job.file
    path.parent.mkdir(parents=True, exist_ok=True)
    with netCDF4.Dataset(path, "w") as ds:
        ds.setncatts({"scene": job.scene.model_dump_json(), "status": "complete", "wall_time_s": 1.0})


def test_nothing_is_listed_before_it_is_started(study: tuple[Plan, Path]) -> None:
    assert target_jobs(*study) == []


def test_a_search_is_listed_round_by_round_without_the_study_s_own_runs(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    wants(folder, "trigger-0", "as it is,0.10,100,6.0", "as it is,0.10,100,8", "slip: sides,0.10,100,8")
    jobs = target_jobs(plan, folder)
    # The first point is one of the study's grid, and its run is listed there.
    assert [(job.title, job.place) for job in jobs] == [("runs of trigger", "."), ("runs of trigger", "trigger/slip-sides")]
    assert jobs[1].scene.walls.sides == "free_slip" and jobs[1].scene.motion.amplitude == 8.0  # type: ignore[union-attr]
    finish(folder, jobs[1])
    assert [look(job, folder).state for job in jobs] == ["waiting", "done"]
    wants(folder, "trigger-1", "slip: sides,0.10,100,8", "slip: sides,0.10,100,6")
    wants(folder, "confirm", "slip: sides,0.10,100,6")
    jobs = target_jobs(plan, folder)
    assert Counter(job.title for job in jobs) == {"runs of trigger": 3, "runs of confirm": 1}
    assert jobs[-1].place == "../standard/trigger/slip-sides" and jobs[-1].scene.numerics.smoothing_ratio == 2.3


def test_sensitivity_is_listed_with_its_indices_once_the_factors_are_known(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    place = folder / "sensitivity"
    place.mkdir(parents=True)
    designs = {job.group for job in target_jobs(plan, folder)}
    assert designs == {"sensitivity morris", "sensitivity tornado"}
    (place / "factors.json").write_text('["S_R", "height"]')
    jobs = target_jobs(plan, folder)
    assert {job.group for job in jobs} == designs | {"sensitivity sobol", "sensitivity confirm"}
    finish(folder, jobs[0])
    assert look(jobs[0], folder).state == "done"
    shown = CliRunner().invoke(app, ["status", str(folder), "--json"])
    assert shown.exit_code == 0 and sum(job["state"] == "done" for job in json.loads(shown.stdout)["jobs"]) == 1


def test_files_that_a_search_has_asked_for_are_known_by_its_tables(study: tuple[Plan, Path]) -> None:
    plan, folder = study
    project = Project(folder.parents[2], None, folder)
    case = "results/paper/draft/trigger/slip-sides"
    run = f"{case}/runs/S_R-0.10_gamma-100_amplitude-8.nc"
    with pytest.raises(ValueError, match="no such run is planned now"):
        project.scene(run)
    wants(folder, "trigger-0", "slip: sides,0.10,100,8", "as it is,0.10,100,7")
    project = Project(folder.parents[2], None, folder)
    for file in (run, f"{case}/stages/pre_failure_amplitude-8.nc", f"{case}/stages/gravity.nc", f"{case}/stages/yield_acceleration.nc"):
        assert project.scene(file).walls.sides == "free_slip"
    assert project.scene(run).motion.amplitude == 8.0  # type: ignore[union-attr]
    for file in ("runs/S_R-0.10_gamma-100_amplitude-7.nc", "stages/pre_failure_amplitude-7.nc"):
        assert project.scene(f"results/paper/draft/{file}").motion.amplitude == 7.0  # type: ignore[union-attr]
    assert project.scene("results/paper/draft/runs/S_R-0.10_gamma-100_amplitude-6.0.nc").coupling.S_R == 0.1
    assert project.scene("results/paper/draft/sensitivity/runs/tornado/base.nc").name == "paper"
