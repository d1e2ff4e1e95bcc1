"""Critical amplitudes and maps from end to end, as a user runs them, with scenes of 163 particles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import xarray as xr
import yaml
from test_workflow import STUDY, drawn, made, planned_jobs, snakemake, write_config

from sph.experiments.trigger.annual import annual_columns
from sph.experiments.trigger.critical import BRACKETED, confirm_columns, critical_columns, read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.efficiency import ARIAS, MEASURE_COLUMNS, PGA, PGV
from sph.experiments.trigger.exceedance import exceedance_columns
from sph.experiments.trigger.maps import read_shares
from sph.experiments.trigger.points import names, read_points
from sph.scene.configuration import merge
from sph.scene.schema import Scene
from sph.storage import trajectory
from sph.study.dimensions import Dimension
from sph.study.tables import read_csv

pytestmark = pytest.mark.long

TRIGGER: dict[str, Any] = {
    "cases": {"as it is": {}, "fixed sides": {"walls": {"sides": "fixed"}}},
    "intensity": {"lowest": 0.0, "highest": 16.0, "cells": 2},
    "tolerance": 4.0,
    "periods": [0.5],
    "hazard": "site.csv",
    "at": {"S_R": ["0.1"], "gamma": ["100"]},
    "confirm": {"at": {"S_R": ["0.1"]}, "cases": ["as it is"]},
    "maps": {
        "cases": ["as it is"],
        "over": {
            "S_R": {"lowest": 0.1, "highest": 0.5, "cells": 1},
            "gamma": {"lowest": 1, "highest": 100, "cells": 1, "scale": "logarithmic"},
        },
        "levels": 0,
    },
}
CHANGES: dict[str, Any] = {
    "experiments": {"trigger": "trigger.yaml"},
    "fidelities": {"draft": {}, "standard": {"numerics": {"time_step": 5e-4}}},
    "metrics": {"stable_limit": 0.001, "minor_limit": 0.004, "damaged_limit": 0.02},
}
"""Limits within which the coarse slope moves in three seconds."""
FOLDER = "results/small/draft/trigger"
SEARCHED = Searched(
    (Dimension("S_R", "-", "", False), Dimension("gamma", "1/s", "", False), Dimension("amplitude", "m/s2", "", False)), "amplitude"
)
TARGETS = ("trigger", "confirm", "maps", "fragility")


def write(folder: Path, **changes: Any) -> tuple[str, ...]:
    (folder / "trigger.yaml").write_text(yaml.safe_dump(merge(TRIGGER, changes), sort_keys=False))
    (folder / "site.csv").write_text("amplitude (m/s2),annual frequency\n1,0.01\n20,0.0001\n")
    return (*write_config(folder, **CHANGES), "--")


def runs(folder: Path) -> dict[Path, int]:
    """Every stage and run, and when it was written."""
    return {path: path.stat().st_mtime_ns for name in ("runs", "stages") for path in folder.rglob(f"{name}/*.nc")}


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder of a small study of which the trigger has been searched, confirmed and mapped."""
    folder = tmp_path_factory.mktemp("trigger")
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    made(folder, *write(folder), *TARGETS)
    return folder


def test_every_search_ends_in_a_bracket_within_the_tolerance(searched: Path) -> None:
    table, points = read_critical(searched / FOLDER / "trigger.csv"), read_points(searched / FOLDER / "points.csv")
    assert table["case"].tolist() == list(TRIGGER["cases"]) and table["outcome"].tolist() == [BRACKETED] * 2
    assert (table["upper"] - table["lower"] == 4.0).all() and (table["runs"] == 4).all() and len(points) == 8
    assert set(points["round"]) == {0, 1} and set(points["amplitude"]) >= {"0", "8.0", "16"}, "8.0 as in the study's grid"
    trials = trajectory.read(searched / "results/small/draft/stages/yield_acceleration.nc").dataset()
    assert "too coarse to see a slope" in trials.attrs["reason"], "an estimate that there is not is no number"
    assert table["yield_acceleration"].isna().all() and table["newmark_intensity"].isna().all()
    with xr.open_dataset(searched / FOLDER / "trigger.nc") as ds:
        assert list(ds.data_vars) == names(critical_columns(SEARCHED)) and ds.attrs["fidelity"] == "draft"
        assert ds["critical_intensity"].values.tolist() == table["critical_intensity"].tolist()
    claim = pd.read_csv(searched / FOLDER / "claim.csv")
    assert claim["verdict"].tolist() == ["not covered"] * 2 and claim["measured"].str.contains("S_R 0.10: ").all()


def test_runs_share_pre_failure_runs_and_those_of_the_study(searched: Path) -> None:
    own, other = searched / "results/small/draft", searched / FOLDER / "fixed-sides"
    for folder, sides in ((own, "free_slip"), (other, "fixed")):
        pre_failure = trajectory.read(folder / "stages/pre_failure_amplitude-8.0.nc").dataset()
        assert trajectory.scene_of(pre_failure).walls.sides == sides
        assert (folder / "runs/S_R-0.10_gamma-100_amplitude-8.0.nc").exists()
    jobs = planned_jobs(searched, *write(searched), "results/small/draft/study.csv")
    assert jobs == {"stage": 1, "simulate": 4, "measure": 1, "study": 1}, "0.1 m/s2 alone is new: the maps ran the four corners at 8 m/s2"
    assert STUDY["grid"]["amplitude"] == ["0.1", "8.0"]


def test_the_ends_are_run_again_at_the_other_fidelity(searched: Path) -> None:
    confirmed = read_csv(searched / FOLDER / "confirm.csv", confirm_columns(SEARCHED), "confirmed brackets")
    assert confirmed["end"].tolist() == ["lower", "upper"] and set(confirmed["verdict"]) <= {"holds", "fails"}
    fine = trajectory.read(next(searched.glob("results/small/standard/runs/*.nc"))).dataset()
    assert trajectory.scene_of(fine).numerics.time_step == 5e-4
    assert (confirmed["confirming_displacement_magnitude"] != confirmed["displacement_magnitude"]).any()


def test_maps_hold_the_corners(searched: Path) -> None:
    points, shares = read_points(searched / FOLDER / "maps.csv"), read_shares(searched / FOLDER / "shares.csv")
    assert len(points) == 2 * 2 * 3 and set(points["gamma"]) == {"1", "100"}
    assert shares["collapse_class"].tolist() == ["minor"] * 2 + ["damaged"] * 2 + ["collapse"] * 2


def test_one_motion_has_no_fragility_but_a_length(searched: Path) -> None:
    measures = read_csv(searched / FOLDER / "fragility_measures.csv", MEASURE_COLUMNS, "measures")
    annual = read_csv(searched / FOLDER / "fragility_annual.csv", annual_columns("1"), "annual frequencies")
    assert set(measures["measure"]) == {PGA, PGV, ARIAS, "spectral acceleration at 0.5 s"} and measures["dispersion"].isna().all()
    assert annual["case"].tolist() == list(TRIGGER["cases"]) and annual["frequency"].isna().all() and set(annual["last"]) == {20.0}
    table = read_csv(searched / FOLDER / "exceedance.csv", exceedance_columns("1"), "the exceedance")
    assert set(table["intensity"]) >= {0.0, 8.0, 16.0} and set(table["motions"]) == {1}


def test_figures_are_drawn(searched: Path) -> None:
    maps = (f"map-{name}" for name in ("class", "displacement", "runout", "failed"))
    drawn(searched / FOLDER / "figures", "trigger", "fragility", "exceedance", "shares", *maps)


def test_a_finished_search_has_nothing_to_do(searched: Path) -> None:
    assert planned_jobs(searched, *write(searched), *TARGETS) == {}


def test_a_bad_search_is_refused_before_any_job(searched: Path) -> None:
    for target in ("trigger", "results/small/draft/stages/gravity.nc"):  # the study names the file, which is read with it
        result = snakemake(searched, "--cores", "1", *write(searched, classes=["collapsed"]), target)
        assert result.returncode != 0 and "trigger.yaml: classes.0" in result.stdout + result.stderr


def test_a_smaller_tolerance_runs_only_the_new_halves(searched: Path) -> None:
    """Last: it goes on with the folder of the others."""
    before = runs(searched)
    result = snakemake(searched, "--cores", "2", *write(searched, tolerance=2.0), "trigger")
    assert result.returncode == 0, result.stderr
    table = read_critical(searched / FOLDER / "trigger.csv")
    assert (table["upper"] - table["lower"] == 2.0).all() and (table["runs"] == 5).all()
    after = runs(searched)
    assert len(after) == len(before) + 4, "a pre-failure run and a run for each of two brackets"
    assert {path: after[path] for path in before} == before, "no finished run is made again"
