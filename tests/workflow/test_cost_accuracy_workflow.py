"""The cost-accuracy study from end to end, as a user runs it, with scenes of a few hundred particles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from calling import call
from test_workflow import drawn, made, planned_jobs, snakemake, write_config

from sph.experiments.variants.table import COLUMNS, read_cost_accuracy
from sph.scene.schema import Scene
from sph.storage import trajectory

pytestmark = pytest.mark.long

CONFIG: dict[str, Any] = {
    "scene": "slope.yaml",
    "cases": {"S_R 0.10": {"coupling": {"S_R": 0.1}}, "S_R 0.50": {"coupling": {"S_R": 0.5}}},
    "timed_case": "S_R 0.10",
    "repeats": 2,
    "reference": {"parameter": "spacing", "variant": "3 m"},
    "baseline": "draft",
    "parameters": {
        "spacing": {
            "about": "Particle spacing.",
            "variants": {
                "5 m": {"numerics": {"spacing": 5.0}},
                "4 m": {"numerics": {"spacing": 4.0}},
                "3 m": {"numerics": {"spacing": 3.0}},
            },
            "exceptions": {"4 m": {"repeats": 1}, "3 m": {"repeats": 1}},
        },
    },
}
"""Three spacings; the fidelity 'draft' is the coarsest."""

MADE = {
    "cost-accuracy": 1,
    "cost_accuracy_table": 1,
    "cost_accuracy_figure_tradeoff": 1,
    "cost_accuracy_figure_convergence": 1,
}
"""Jobs beside the runs."""


@pytest.fixture(scope="module")
def climbed(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder of a finished small cost-accuracy study."""
    folder = tmp_path_factory.mktemp("study")
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    (folder / "mine.yaml").write_text(yaml.safe_dump(CONFIG, sort_keys=False))
    config = write_config(folder, experiments={"cost-accuracy": "mine.yaml"})
    assert planned_jobs(folder, *config, "--", "cost-accuracy") == MADE | {"simulate": 7}
    made(folder, *config, "--", "cost-accuracy")
    return folder


def test_the_tables_hold_every_variant_and_case(climbed: Path) -> None:
    table = read_cost_accuracy(climbed / "results" / "cost-accuracy" / "cost-accuracy.csv")
    assert len(table) == 8 and set(table["status"]) <= {"complete", "unfailed"}
    twice = table[(table["variant"].isin(["draft", "5 m"])) & (table["case"] == "S_R 0.10")]
    assert twice["repeats"].tolist() == [2, 2] and twice["reproducible"].tolist() == [1.0, 1.0]
    assert twice["displacement_magnitude"].nunique() == 1
    reference = table[table["reference"] == 1]
    assert (reference["displacement_deviation"] == 0).all() and len(reference) == 2
    assert (table["steps"] == 3000).all() and (table["wall_time"] > 0).all()
    with xr.open_dataset(climbed / "results" / "cost-accuracy" / "cost-accuracy.nc") as ds:
        assert list(ds.data_vars) == COLUMNS
        assert {"machine", "timing", "versions", "scene", "baseline"} <= set(ds.attrs)
        np.testing.assert_array_equal(ds["runout"].values, table["runout"].to_numpy())


def test_runs_are_whole_and_share_no_stage(climbed: Path) -> None:
    folder = climbed / "results" / "cost-accuracy"
    run = trajectory.read(folder / "runs" / "fidelity" / "draft" / "S_R-0.10_2.nc")
    assert run.attrs["particle_steps"] == 3000 * run.sizes["particle"]
    assert not (folder / "stages").exists()


def test_convergence_has_a_verdict_a_quantity_and_case(climbed: Path) -> None:
    found = pd.read_csv(climbed / "results" / "cost-accuracy" / "convergence.csv")
    assert len(found) == 6 and found["verdict"].str.len().min() > 10


def test_figures_are_drawn(climbed: Path) -> None:
    drawn(climbed / "results" / "cost-accuracy" / "figures", "tradeoff", "convergence")


def test_the_table_answers_the_command(climbed: Path) -> None:
    asked = ["advise", "--error", "1000%", "--table", str(climbed / "results" / "cost-accuracy" / "cost-accuracy.csv")]
    result = call(*asked)
    assert result.exit_code in (0, 2) and "s per run on one core" in result.stdout


def test_a_finished_study_has_nothing_to_do_and_a_new_variant_runs_alone(climbed: Path) -> None:
    config = write_config(climbed, experiments={"cost-accuracy": "mine.yaml"})
    assert planned_jobs(climbed, *config, "--", "cost-accuracy") == {}
    skin = {"about": "Skin.", "repeats": 1, "variants": {"0.6": {"numerics": {"neighbour_skin": 0.6}}}}
    more = CONFIG | {"parameters": CONFIG["parameters"] | {"skin": skin}}
    (climbed / "more.yaml").write_text(yaml.safe_dump(more, sort_keys=False))
    jobs = planned_jobs(climbed, *write_config(climbed, experiments={"cost-accuracy": "more.yaml"}), "--", "cost-accuracy")
    assert jobs == MADE | {"simulate": 2}


def test_a_bad_study_is_refused_before_any_job(climbed: Path) -> None:
    bad = CONFIG | {"reference": {"parameter": "spacing", "variant": "1 m"}}
    (climbed / "bad.yaml").write_text(yaml.safe_dump(bad, sort_keys=False))
    result = snakemake(climbed, "--cores", "1", *write_config(climbed, experiments={"cost-accuracy": "bad.yaml"}), "--", "cost-accuracy")
    assert result.returncode != 0 and "bad.yaml: reference: parameter 'spacing', variant '1 m'" in result.stdout + result.stderr
