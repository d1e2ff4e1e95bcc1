"""The sensitivity analysis from end to end, as a user runs it, with scenes of a few hundred particles."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import xarray as xr
import yaml
from test_workflow import drawn, made, planned_jobs, snakemake, write_config

from sph.experiments.sensitivity.elementary_effects import MORRIS
from sph.experiments.sensitivity.surrogate import SOBOL
from sph.measures.metrics import measure
from sph.scene.configuration import merge
from sph.scene.schema import Scene
from sph.storage import trajectory
from sph.study.tables import read_csv

pytestmark = pytest.mark.long

FOLDER = Path("results/small/draft/sensitivity")
SENSITIVITY: dict[str, Any] = {
    "overrides": {"outputs": {"frame_interval": 0.5}},
    "factors": {
        "S_R": {"keys": {"coupling.S_R": 1}, "bounds": [0.1, 0.5]},
        "amplitude": {"keys": {"motion.amplitude": 1}, "bounds": [4.0, 9.0]},
    },
    "metrics": {"displacement_magnitude": {"log_offset": 0.01}},
    "morris": {"trajectories": 2},
    "sobol": {"samples": 8, "folds": 2, "draws": 50, "points": 64},
    "confirm": {"fidelity": "coarse", "points": 1},
}
FIDELITIES = {"draft": {}, "coarse": {"numerics": {"spacing": 6.0}}}
ONCE = {"sensitivity": 1, "sensitivity_morris": 1, "sensitivity_factors": 1, "sensitivity_tornado": 1, "sensitivity_sobol": 1,
        "sensitivity_sample": 1, "sensitivity_confirm": 1, "sensitivity_measure": 4}  # fmt: skip
ONCE |= {f"sensitivity_figure_{name}": 1 for name in ("morris", "tornado", "sobol", "cross_validation")}


def written(folder: Path, changes: dict[str, Any] | None = None) -> tuple[str, str]:
    (folder / "sensitivity.yaml").write_text(yaml.safe_dump(merge(SENSITIVITY, changes or {}), sort_keys=False))
    return write_config(folder, experiments={"sensitivity": "sensitivity.yaml"}, fidelities=FIDELITIES)


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder of a finished small analysis."""
    folder = tmp_path_factory.mktemp("sensitivity")
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    config = written(folder)
    assert planned_jobs(folder, *config, "--", "sensitivity") == ONCE | {"simulate": 11}, "before the screening is known"
    made(folder, *config, "--", "sensitivity")
    return folder


def test_tables_and_figures(analysed: Path) -> None:
    folder = analysed / FOLDER
    sample = pd.read_csv(folder / "sample.csv")
    designs = sample["run"].str.partition("/")[0].value_counts().to_dict()
    assert designs == {"morris": 6, "tornado": 5, "sobol": 8, "confirm": 1}
    assert all((folder / "runs" / f"{run}.nc").exists() for run in sample["run"])
    with xr.open_dataset(folder / "sample.nc") as ds:
        assert ds["displacement_magnitude"].attrs["units"] == "m" and ds["amplitude"].attrs["units"] == "m/s2"
    morris, sobol = read_csv(folder / "morris.csv", MORRIS, "it"), read_csv(folder / "sobol.csv", SOBOL, "it")
    assert list(morris["factor"]) == ["S_R", "amplitude"] and (morris["diverged"] == 0).all()
    assert list(sobol["factor"]) == json.loads((folder / "factors.json").read_text())
    tornado = pd.read_csv(folder / "tornado.csv").set_index("factor")
    assert tornado.loc["S_R", "at_low"] > tornado.loc["S_R", "at_base"] > tornado.loc["S_R", "at_high"] > 0
    assert len(pd.read_csv(folder / "confirm.csv")) == 1
    drawn(folder / "figures", "morris", "tornado", "sobol", "cross_validation")


def test_a_run_holds_the_factors_of_its_row(analysed: Path) -> None:
    sample = pd.read_csv(analysed / FOLDER / "samples" / "sobol.csv").iloc[3]
    scene = trajectory.scene_of(trajectory.read(analysed / FOLDER / "runs" / f"{sample['run']}.nc"))
    assert (scene.coupling.S_R, scene.motion.amplitude) == (sample["S_R"], sample["amplitude"])
    confirmed = trajectory.scene_of(trajectory.read(analysed / FOLDER / "runs" / "confirm" / "0000.nc"))
    assert confirmed.numerics.spacing == 6.0


def test_other_ranges_and_another_scene_run_everything_again(analysed: Path, tmp_path: Path) -> None:
    """Runs keep their names: measured as they are, they would pass for those of the new values."""
    folder = Path(shutil.copytree(analysed, tmp_path / "other"))
    name, factor = next(iter(SENSITIVITY["factors"].items()))
    bounds = [value * 1.01 for value in factor["bounds"]]
    jobs = planned_jobs(folder, *written(folder, {"factors": {name: {"bounds": bounds}}}), "--", "sensitivity")
    assert jobs["simulate"] >= 8 and jobs["sensitivity_measure"] >= 2
    path = folder / "slope.yaml"
    path.write_text(yaml.safe_dump(yaml.safe_load(path.read_text()) | {"duration": 2.9}))
    os.utime(path, (1e9, 1e9))
    assert planned_jobs(folder, *written(folder), "--", "sensitivity")["simulate"] >= 11


def test_a_finished_analysis_has_nothing_to_do(analysed: Path) -> None:
    assert planned_jobs(analysed, *written(analysed), "--", "sensitivity") == {}


def test_a_larger_analysis_runs_only_what_is_new(analysed: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(analysed, tmp_path / "larger"))
    samples = written(folder, {"sobol": {"samples": 10}})
    jobs = planned_jobs(folder, *samples, "--", "sensitivity")
    assert jobs["simulate"] == 2 and "sensitivity_morris" not in jobs
    config = written(folder, {"morris": {"trajectories": 3}, "sobol": {"samples": 10}})
    before = {path: path.stat().st_mtime_ns for path in folder.glob(f"{FOLDER}/runs/**/*.nc")}
    made(folder, *config, "--", "sensitivity")
    after = {path: path.stat().st_mtime_ns for path in folder.glob(f"{FOLDER}/runs/**/*.nc")}
    assert len(after) == len(before) + 3 + 2 and before.items() <= after.items()
    assert len(pd.read_csv(folder / FOLDER / "samples" / "sobol.csv")) == 10


def test_a_back_analysis_adds_its_own_runs_to_the_sample(analysed: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(analysed, tmp_path / "back"))
    result = snakemake(folder, "--dry-run", *written(folder), "--", "back_analysis")
    text = result.stdout + result.stderr
    assert result.returncode != 0 and "sensitivity.yaml: back_analysis: null: write what was observed" in text
    seen = pd.read_csv(folder / FOLDER / "samples" / "sobol.csv")["displacement_magnitude"].median()
    back = {"back_analysis": {"observed": {"displacement_magnitude": {"value": float(seen), "error": 0.2}}, "over": ["S_R"]}}
    config = written(folder, back)
    made(folder, *config, "--", "back_analysis")
    place = folder / FOLDER
    table, confirmed = pd.read_csv(place / "back_analysis.csv"), pd.read_csv(place / "back_confirmed.csv")
    assert table["factor"].tolist() == ["S_R"] and 0.1 <= table["best"][0] <= 0.5
    with xr.open_dataset(place / "back_analysis.nc") as ds:
        assert ds["median"].values == pytest.approx(table["median"]) and "interval" in ds["lower"].attrs["long_name"]
    assert len(list((place / "runs" / "back").rglob("*.nc"))) == len(confirmed) == (1 if table["median"].isna()[0] else 3)
    for row in confirmed.to_dict("records"):
        run = trajectory.read(place / "runs" / "back" / f"{row['run']}.nc").dataset()
        scene = trajectory.scene_of(run)
        assert (scene.coupling.S_R, scene.motion.amplitude) == (pytest.approx(row["S_R"]), row["amplitude"])
        assert measure(run)["displacement_magnitude"] == pytest.approx(row["measured"])
    drawn(place / "figures", "back_analysis")
    assert planned_jobs(folder, *config, "--", "back_analysis") == {}


def test_ranges_that_cannot_be_built_are_refused_before_any_job(analysed: Path) -> None:
    angle = {"slope_angle": {"keys": {"geometry.slope_angle": 1}, "bounds": [50.0, 95.0]}}
    result = snakemake(analysed, "--cores", "1", *written(analysed, {"factors": angle}), "--", "sensitivity")
    text = result.stdout + result.stderr
    assert result.returncode != 0 and "sensitivity.yaml: at " in text and "slope_angle" in text and "less than or equal to 90" in text
