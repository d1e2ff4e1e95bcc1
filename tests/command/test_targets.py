"""Targets beside the study in ``sph status``: listed once they have been started, by the points that they ask for."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import netCDF4
import pytest
import yaml
from calling import call

from sph.command.status import Job, State, look_at
from sph.command.study import find_study
from sph.jobs.catalogue import Catalogue
from sph.scene.schema import Scene, make_scene
from sph.study.runs import BaseScene

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
def study(tmp_path: Path) -> Path:
    """Folder of the results of a study, in a working folder with its configuration."""
    (tmp_path / "config").mkdir()
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8")) | {"experiments": {"trigger": "mine.yaml"}}
    (tmp_path / "config" / "config.yaml").write_text(yaml.safe_dump(config, sort_keys=False))
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(TRIGGER, sort_keys=False))
    return tmp_path / "results" / "paper" / "draft"


def states_of(catalogue: Catalogue) -> list[State]:
    return look_at(catalogue.started, catalogue.base)


def wants(folder: Path, table: str, *points: str) -> None:
    place = folder / "trigger" / "rounds"
    place.mkdir(parents=True, exist_ok=True)
    (place / f"{table}-wanted.csv").write_text(HEAD + "".join(f"{point},0\n" for point in points))


def finish(base: Path, job: Job) -> None:
    path = base / job.run.file
    path.parent.mkdir(parents=True, exist_ok=True)
    with netCDF4.Dataset(path, "w") as ds:
        ds.setncatts({"scene": job.scene.model_dump_json(), "status": "complete", "wall_time_s": 1.0})


def test_nothing_is_listed_before_it_is_started(study: Path) -> None:
    assert find_study(study, None).started == []


def test_a_search_is_listed_round_by_round_without_the_study_s_own_runs(study: Path) -> None:
    catalogue = find_study(study, None)
    wants(study, "trigger-0", "as it is,0.10,100,6.0", "as it is,0.10,100,8", "slip: sides,0.10,100,8")
    jobs = [state.job for state in states_of(catalogue)]
    # The first point is one of the study's grid, and its run is listed there.
    folders = [(job.title, job.run.folder) for job in jobs]
    assert folders == [("runs of trigger", "results/paper/draft"), ("runs of trigger", "results/paper/draft/trigger/slip-sides")]
    assert jobs[1].scene.walls.sides == "free_slip" and jobs[1].scene.motion.amplitude == 8.0  # type: ignore[union-attr]
    finish(catalogue.base, jobs[1])
    assert [state.state for state in states_of(catalogue)] == ["waiting", "done"]
    wants(study, "trigger-1", "slip: sides,0.10,100,8", "slip: sides,0.10,100,6")
    wants(study, "confirm", "slip: sides,0.10,100,6")
    jobs = [state.job for state in states_of(catalogue)]
    assert Counter(job.title for job in jobs) == {"runs of trigger": 3, "runs of confirm": 1}
    assert jobs[-1].run.folder == "results/paper/standard/trigger/slip-sides" and jobs[-1].scene.numerics.smoothing_ratio == 2.3


def test_points_of_an_earlier_configuration_are_none(study: Path) -> None:
    wants(study, "trigger-0", "as it is,0.10,100,8", "no more,0.10,100,8")
    assert [run.id for run in find_study(study, None).started] == ["S_R-0.10_gamma-100_amplitude-8"]
    (study / "trigger" / "rounds" / "trigger-0-wanted.csv").write_text("case,motion.frequency,amplitude,round\nas it is,2,8,0\n")
    assert find_study(study, None).started == []


def test_sensitivity_is_listed_with_its_indices_once_the_factors_are_known(study: Path) -> None:
    place = study / "sensitivity"
    place.mkdir(parents=True)
    catalogue = find_study(study, None)
    designs = {run.group for run in catalogue.started}
    assert designs == {"sensitivity morris", "sensitivity tornado"}
    (place / "factors.json").write_text('["S_R", "height"]')
    assert {run.group for run in catalogue.started} == designs | {"sensitivity sobol", "sensitivity confirm"}
    (place / "factors.json").write_text('["a factor of an earlier configuration"]')
    assert {run.group for run in catalogue.started} == designs
    (first, *_) = states_of(catalogue)
    finish(catalogue.base, first.job)
    assert states_of(catalogue)[0].state == "done"
    shown = call("status", study, "--json")
    assert shown.exit_code == 0 and sum(job["state"] == "done" for job in json.loads(shown.stdout)["jobs"]) == 1


def test_files_that_a_search_has_asked_for_are_known_by_its_tables(study: Path) -> None:
    catalogue = find_study(study, None)
    case = "results/paper/draft/trigger/slip-sides"
    run = f"{case}/runs/S_R-0.10_gamma-100_amplitude-8.0.nc"

    def scene(file: str) -> Scene:
        return make_scene(catalogue.row(file).scene)

    with pytest.raises(ValueError, match="no such run"):
        scene(run)
    assert scene(f"{case}/stages/yield_acceleration.nc").walls.sides == "free_slip", "which the table needs, whatever is asked for"
    wants(study, "trigger-0", "slip: sides,0.10,100,8.0", "as it is,0.10,100,7")
    for file in (run, f"{case}/stages/pre_failure_amplitude-8.0.nc", f"{case}/stages/gravity.nc", f"{case}/stages/factor_of_safety.nc"):
        assert scene(file).walls.sides == "free_slip"
    assert scene(run).motion.amplitude == 8.0  # type: ignore[union-attr]
    for file in ("runs/S_R-0.10_gamma-100_amplitude-7.nc", "stages/pre_failure_amplitude-7.nc"):
        assert scene(f"results/paper/draft/{file}").motion.amplitude == 7.0  # type: ignore[union-attr]
    assert scene("results/paper/draft/runs/S_R-0.10_gamma-100_amplitude-6.0.nc").coupling.S_R == 0.1
    assert scene("results/paper/draft/sensitivity/runs/tornado/base.nc").name == "paper"


def test_the_plan_is_written_beside_the_results(study: Path) -> None:
    catalogue = find_study(study, None)
    wants(study, "trigger-0", "slip: sides,0.10,100,8")
    catalogue.row("results/paper/draft/stages/gravity.nc")
    catalogue.row("results/assumptions/runs/assumption/as-it-is/S_R-0.10_1.nc")
    catalogue.row("results/paper/draft/trigger/slip-sides/stages/gravity.nc")
    catalogue.write()
    told = json.loads((study / "plan.json").read_text(encoding="utf-8"))
    runs = {run["file"]: run for run in told["runs"]}
    assert {run.file for run in (*catalogue.plan.jobs, *catalogue.started)} <= set(runs)
    for file, run in runs.items():
        planned = catalogue.row(file)
        assert BaseScene(told["scenes"][run["scene"]]).built(run["point"], "plan.json") == make_scene(planned.scene)
        assert [run[name] for name in ("id", "parent", "until", "by")] == [planned.id, planned.parent, planned.until, planned.by]
        assert run["parent"] is None or run["parent"] in runs
    alone = json.loads((catalogue.base / "results" / "assumptions" / "plan.json").read_text(encoding="utf-8"))
    assert {run["target"] for run in alone["runs"]} == {"assumptions"} and len(alone["runs"]) > 50
    assert not (catalogue.base / "results" / "cost-accuracy").exists(), "what nobody asked for is not read"
