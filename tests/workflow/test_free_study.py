"""Studies over other dimensions than the paper's, from end to end: a grid, a list of cases, a sample; scenes of 163 particles."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from test_workflow import planned_jobs, said, snakemake, sph

from sph.experiments.variants.second_spacing import DECIDING, read_deciding, read_spacing
from sph.measures.metrics import measure
from sph.scene.schema import Scene
from sph.storage import trajectory
from sph.study.plan import load_study
from sph.study.tables import read_study, read_table

pytestmark = pytest.mark.long

BASE: dict[str, Any] = {"scene": "slope.yaml", "fidelity": "draft", "fidelities": {"draft": {}}, "on_error": "go_on"}
GRID = {"study": "grid", "grid": {"soil.cohesion": ["20", "150"], "motion.frequency": ["1.0", "2.0"]}}
CASES = {
    "study": "cases",
    "cases": [{"S_R": "0.10", "coupling.fluid_tension_limit": None}, {"S_R": "0.10", "coupling.fluid_tension_limit": 0}],
    "figures": {"runs": ["case-000002"]},
}
SAMPLE = {
    "study": "sample",
    "searches": "none",
    "sample": {"size": 2, "ranges": {"S_R": [0.1, 0.5], "soil.cohesion": {"bounds": [10, 200], "scale": "log"}}},
}
ONCE = {"all": 1, "check": 1, "preflight": 1, "figure": 1, "study_figure": 1, "measure": 1, "study": 1, "page": 1}


def configured(folder: Path, study: dict[str, Any]) -> tuple[str, str]:
    path = folder / f"{study['study']}.yaml"
    path.write_text(yaml.safe_dump(BASE | study, sort_keys=False))
    return "--configfile", str(path)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder of three finished studies."""
    folder = tmp_path_factory.mktemp("free")
    numerics = {"numerics.spacing": 2.5, "numerics.smoothing_ratio": 1.3}  # the coarsest at which a static test sees a slope fail
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4, **numerics})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    jobs = {
        "grid": {"stage": 6, "search": 2, "simulate": 4},
        "cases": {"stage": 2, "search": 1, "simulate": 2, "study_figure": 1},  # no map where one dimension alone varies
        "sample": {"stage": 4, "simulate": 2},
    }
    for study in (GRID, CASES, SAMPLE):
        config = configured(folder, study)
        assert planned_jobs(folder, *config) == ONCE | jobs[str(study["study"])]
        table = ("--", "results/sample/draft/study.nc") if study is SAMPLE else ()
        result = snakemake(folder, "--cores", "2", *config, *table)
        assert result.returncode == 0, result.stderr
        assert planned_jobs(folder, *config, *table) == {}
    return folder


def of(folder: Path, name: str) -> Path:
    return folder / "results" / name / "draft"


def test_a_grid_has_its_own_dimensions(finished: Path) -> None:
    folder = of(finished, "grid")
    study, table = read_study(folder / "study.nc"), read_table(folder / "study.csv", load_study(BASE | GRID, [finished]).layout)
    assert dict(study.sizes) == {"soil.cohesion": 2, "motion.frequency": 2}
    for row in table.to_dict("records"):
        name = f"soil.cohesion-{row['soil.cohesion']}_motion.frequency-{row['motion.frequency']}"
        run = trajectory.read(folder / "runs" / f"{name}.nc").dataset()
        scene = trajectory.scene_of(run)
        assert (scene.soil.cohesion, scene.motion.frequency) == (float(row["soil.cohesion"]), float(row["motion.frequency"]))
        at = {"soil.cohesion": scene.soil.cohesion, "motion.frequency": scene.motion.frequency}
        assert row["displacement_magnitude"] == study["displacement_magnitude"].sel(at) == measure(run)["displacement_magnitude"]
    assert study["displacement_magnitude"].std() > 0.01
    weak, strong = (searched_value(folder, cohesion) for cohesion in (20.0, 150.0))
    assert weak < strong < 20.0
    np.testing.assert_array_equal(study["yield_acceleration"].transpose("soil.cohesion", ...), [[weak] * 2, [strong] * 2])


def searched_value(folder: Path, cohesion: float) -> float:
    """The yield acceleration that a search found for the slope of a soil, in the file named after it."""
    trials = trajectory.read(folder / "stages" / f"yield_acceleration_soil.cohesion-{cohesion:g}.nc").dataset()
    assert trajectory.scene_of(trials).soil.cohesion == cohesion
    return float(trials.attrs["value"])


def test_the_page_has_the_factors_of_safety_that_were_asked_for(finished: Path, tmp_path: Path) -> None:
    """Those of the study's slopes, and no other file of such a name."""
    place = Path(shutil.copytree(finished, tmp_path / "study"))
    folder, config = of(place, "grid"), configured(place, GRID)
    files = [folder / "stages" / f"factor_of_safety_soil.cohesion-{cohesion}.nc" for cohesion in (20, 150)]
    result = snakemake(place, "--cores", "2", *(str(file.relative_to(place)) for file in files), *config)
    assert result.returncode == 0, result.stderr
    (weak, low), (strong, high) = ([float(trajectory.read(file).attrs[name]) for name in ("value", "error")] for file in files)
    assert 0.5 < weak < 1.0 < strong
    for file in files:
        sph("explain", file, "--configfile", config[1])
    for other in ("factor_of_safety.nc", "factor_of_safety_soil.cohesion-99.nc"):
        shutil.copy(files[0], folder / "stages" / other)
    assert planned_jobs(place, *config) == {"page": 1, "all": 1}
    result = snakemake(place, "--cores", "2", *config)
    assert result.returncode == 0, result.stderr
    assert f"{weak:.2f} ± {low:.2f} to {strong:.2f} ± {high:.2f} of 2 slopes" in (folder / "report.html").read_text(encoding="utf-8")


def test_cases_and_samples_are_lists(finished: Path) -> None:
    for name, keys in (("cases", {"S_R", "coupling.fluid_tension_limit"}), ("sample", {"S_R", "soil.cohesion"})):
        study = read_study(of(finished, name) / "study.nc")
        assert dict(study.sizes) == {"case": 2} and keys <= set(study.coords)
        for case in study["case"].values:
            assert study["status"].sel(case=case) == trajectory.read(of(finished, name) / "runs" / f"{case}.nc").attrs["status"]
    assert read_study(of(finished, "cases") / "study.nc")["coupling.fluid_tension_limit"].values.tolist() == ["null", "0"]


def test_the_page_chooses_by_whatever_there_is(finished: Path) -> None:
    grid, cases = ((of(finished, name) / "report.html").read_text(encoding="utf-8") for name in ("grid", "cases"))
    assert 'name="soil.cohesion" value="150"' in grid and 'id="find"' not in grid
    assert '<option value="case-000002" selected>case-000002: S_R 0.10, fluid tension limit 0 kPa</option>' in cases
    assert 'id="find"' in cases
    for page, pictures in ((grid, 9), (cases, 8)):
        assert page.count("data:image/png") == pictures and "claims" not in page.partition("<main>")[0]


def test_a_run_is_repeated_and_told_of_like_any_other(finished: Path, tmp_path: Path) -> None:
    path = of(finished, "grid") / "runs" / "soil.cohesion-150_motion.frequency-2.0.nc"
    assert f"every variable is identical to that of {path}" in sph("run", path, "--out", tmp_path / "again.nc")
    for study in (GRID, CASES, SAMPLE):
        folder = of(finished, str(study["study"]))
        shown = json.loads(said("status", folder, "--configfile", configured(finished, study)[1], "--json"))
        files = {path.stem for kind in ("runs", "stages") for path in (folder / kind).glob("*.nc")}
        assert {job["job"] for job in shown["jobs"]} == files and all(job["state"] == "done" for job in shown["jobs"])


SEARCH: dict[str, Any] = {
    "cases": {"as it is": {}},
    "intensity": {"lowest": 0.5, "highest": 16.5, "cells": 2},
    "tolerance": 8.0,
    "at": {"soil.cohesion": ["20", "150"]},
}


def test_the_shaking_is_searched_over_other_dimensions(finished: Path) -> None:
    (finished / "search.yaml").write_text(yaml.safe_dump(SEARCH, sort_keys=False))
    config = configured(finished, GRID | {"experiments": {"trigger": "search.yaml"}})
    result = snakemake(finished, "--cores", "2", *config, "--", "trigger")
    assert result.returncode == 0, result.stderr
    folder = of(finished, "grid") / "trigger"
    table, points = pd.read_csv(folder / "trigger.csv"), pd.read_csv(folder / "points.csv")
    assert table["soil.cohesion"].tolist() == [20, 150] and sorted(set(points["amplitude"])) == [0.5, 8.5, 16.5]
    of_soils = [searched_value(of(finished, "grid"), cohesion) for cohesion in (20.0, 150.0)]  # which the study has searched already
    assert not list(folder.rglob("yield_acceleration*.nc"))
    np.testing.assert_array_equal(table["yield_acceleration"], of_soils)
    run = trajectory.read(folder / "as-it-is" / "runs" / "amplitude-8.5_soil.cohesion-20.nc").dataset()
    scene = trajectory.scene_of(run)
    assert (scene.motion.amplitude, scene.soil.cohesion) == (8.5, 20.0)
    row = points[(points["amplitude"] == 8.5) & (points["soil.cohesion"] == 20)].iloc[0]
    assert row["displacement_magnitude"] == measure(run)["displacement_magnitude"]
    assert not (folder / "claim.csv").exists() and (folder / "figures" / "trigger.png").exists()
    assert planned_jobs(finished, *config, "--", "trigger") == {}
    sph("explain", folder / "as-it-is" / "runs" / "amplitude-8.5_soil.cohesion-20.nc", "--configfile", config[1])
    assert planned_jobs(finished, *config) == {"page": 1, "all": 1}, "which shows what was found"
    assert snakemake(finished, "--cores", "2", *config).returncode == 0
    page = (of(finished, "grid") / "report.html").read_text(encoding="utf-8")
    assert "Critical intensities of the shaking" in page and page.count("data:image/png") == 10


def test_a_larger_study_runs_what_is_new(finished: Path) -> None:
    larger = SAMPLE | {"sample": SAMPLE["sample"] | {"size": 3}}  # type: ignore[operator]
    jobs = planned_jobs(finished, *configured(finished, larger))
    assert (jobs["stage"], jobs["simulate"], jobs["measure"]) == (2, 1, 1)
    wider = GRID | {"grid": GRID["grid"] | {"motion.frequency": ["1.0", "2.0", "3.0"]}}  # type: ignore[operator]
    jobs = planned_jobs(finished, *configured(finished, wider))
    assert (jobs["stage"], jobs["simulate"]) == (2, 2)


@pytest.mark.parametrize("target", ["results/grid/draft/claims.csv", "results/grid/draft/figures/fig4.png"])
def test_what_needs_the_papers_dimensions_is_refused_with_the_reason(finished: Path, target: str) -> None:
    result = snakemake(finished, "--cores", "1", *configured(finished, GRID), "--", target)
    assert result.returncode != 0
    assert "need a grid over exactly S_R, gamma, amplitude; study 'grid' varies" in result.stdout + result.stderr


def test_the_draft_repeats_the_runs_that_decide_with_finer_particles(finished: Path, tmp_path: Path) -> None:
    """Which these are is known when its table is there; the whole study later has them already."""
    shutil.copy(finished / "slope.yaml", tmp_path)
    fidelities = {"draft": {}, "fine": {"numerics": {"spacing": 2.0}}}
    grid = {"amplitude": ["0.5", "6.0", "9.0"], "soil.cohesion": ["150"]}
    levels = {"study": "levels", "searches": "none", "grid": grid, "second_fidelity": "draft", "fidelities": fidelities}
    config = configured(tmp_path, levels)
    result = snakemake(tmp_path, "--cores", "2", *config)
    assert result.returncode == 0, result.stderr
    assert planned_jobs(tmp_path, *config) == {}
    folder = of(tmp_path, "levels")
    table = read_table(folder / "study.csv", load_study(BASE | levels, [tmp_path]).layout)
    failing = table.loc[table["collapse_class"] != "stable", "amplitude"].tolist()
    assert 0 < len(failing) < 3, "some stand, some fail"
    deciding = sorted(float(name.split("_")[0].removeprefix("amplitude-")) for name in read_deciding(folder / DECIDING))
    assert deciding == sorted(map(float, [*failing[:2], *table.loc[table["collapse_class"] == "stable", "amplitude"].tolist()[-1:]]))
    spacing = read_spacing(folder / "spacing.csv")
    assert set(spacing["second_spacing"]) == {2.0} and set(spacing["run"]) == set(read_deciding(folder / DECIDING))
    made = {path.stem for path in (folder.parent / "fine" / "runs").glob("*.nc")}
    assert made == set(spacing["run"])
    assert "runs of fidelity fine" in said("status", folder, "--configfile", config[1])
    page = (folder / "report.html").read_text(encoding="utf-8")
    agree = (spacing["collapse_class"] == "stable") == (spacing["second_class"] == "stable")
    assert ("with particles of 2.5 m and of 2 m" if agree.all() else "it depends on the spacing: A moves") in page
    whole = planned_jobs(tmp_path, *config, "--config", "fidelity=fine")
    assert whole.get("simulate", 0) + whole.get("draft", 0) == 3 - len(made), "the draft's runs are done, too"
