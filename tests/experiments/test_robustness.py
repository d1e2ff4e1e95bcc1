"""Robustness: rows, fixed steps around the limit, and what is measured of a run."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from small_scenes import study_plan
from synthetic import synthetic, translation

from sph.experiments.base import file_name
from sph.experiments.variants.design import fixed_step, load_variants
from sph.experiments.variants.figures_robustness import REFUSED, figure_robustness
from sph.experiments.variants.robustness import ROBUSTNESS, asymmetry, measure_robustness, penetration, read_robustness
from sph.experiments.variants.schema import TIME_STEP, Robustness
from sph.measures.metrics import MetricSettings
from sph.scene.schema import make_scene
from sph.solver.time_step import limits
from sph.study.tables import write_csv

ROOT = Path(__file__).resolve().parents[2]
load = functools.partial(load_variants, "robustness", Robustness)
SCENE: dict[str, Any] = {
    "scheme": "paper",
    "name": "slope",
    "geometry": {"shape": "slope"},
    "motion": {"kind": "tapered_sine"},
    "duration": 15.0,
}
CONFIG: dict[str, Any] = {
    "scene": "scene.yaml",
    "overrides": {"numerics": {"spacing": 2.5, "time_step": 5e-4}},
    "cases": {"weak": {"coupling": {"S_R": 0.1}}},
    "repeats": 2,
    "parameters": {"nu": {"scene_key": "soil.poisson_ratio", "values": [0.3, 0.6]}},
    "time_steps": {"factors": [0.5, 2.0], "schemes": {"plain": {}}},
}


def write(folder: Path, **changes: Any) -> str:
    (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE))
    (folder / "robustness.yaml").write_text(yaml.safe_dump(CONFIG | changes, sort_keys=False))
    return str(folder / "robustness.yaml")


def test_a_value_that_the_schema_refuses_is_a_row_without_runs(tmp_path: Path) -> None:
    made = load(write(tmp_path), study_plan(), [tmp_path])
    first, second, *steps = made.rows
    assert first.runs == ("nu/0.3/weak_1", "nu/0.3/weak_2") and first.refused == ""
    assert second.runs == () and "soil.poisson_ratio" in second.refused
    assert [row.runs for row in steps] == [(f"{file_name(TIME_STEP)}/0.5/plain_1",), (f"{file_name(TIME_STEP)}/2/plain_1",)]
    assert made.runs["nu/0.3/weak_1"].scene["soil"]["poisson_ratio"] == 0.3
    assert [name for name, run in made.runs.items() if not run.enforce_limit] == [row.runs[0] for row in steps]


def test_variants_are_named_by_their_labels(tmp_path: Path) -> None:
    variants = {label: {"numerics": {"artificial_viscosity": value}} for label, value in (("none", None), ("strong", {"alpha": 0.3}))}
    made = load(write(tmp_path, parameters={"alpha": {"variants": variants}}), study_plan(), [tmp_path])
    assert [(row.variant, row.runs[0]) for row in made.rows[:2]] == [("none", "alpha/none/weak_1"), ("strong", "alpha/strong/weak_1")]
    assert made.runs["alpha/none/weak_1"].scene["numerics"]["artificial_viscosity"] is None
    assert made.runs["alpha/strong/weak_1"].scene["numerics"]["artificial_viscosity"] == {"alpha": 0.3}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parameters": {"nu": {"scene_key": "soil.poisson_ratio", "values": [0.3], "cases": ["odd"]}}}, ["parameters.nu", "cases", "odd"]),
        ({"parameters": {"nu": {"scene_key": "soil.poisson_ratio", "values": []}}}, ["parameters.nu", "scene_key and its values"]),
        ({"parameters": {"nu": {"scene_key": "soil.poisson_ratio"}}}, ["parameters.nu", "scene_key and its values"]),
        ({"parameters": {"nu": {"variants": {"a b": {}, "a/b": {}}}}}, ["parameters.nu", "variants", "a b", "a/b", "file name"]),
        ({"cases": {"weak": {"coupling": {"S_R": 7.0}}}}, ["parameter 'nu'", "coupling.S_R"]),
    ],
)
def test_errors_name_the_key(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        load(write(tmp_path, **changes), study_plan(), [tmp_path])
    assert all(word in str(raised.value) for word in words)


@pytest.mark.parametrize("factor", [0.25, 0.95, 4.0])
def test_a_fixed_step_is_a_factor_of_the_limit(factor: float) -> None:
    scene = make_scene(fixed_step(SCENE, factor))
    limit = min(limit.seconds for limit in limits(scene))
    assert scene.numerics.time_step == pytest.approx(factor * limit) and scene.numerics.adaptive_step is None
    assert scene.duration == pytest.approx(15.0, rel=0.02) and scene.gravity.duration == pytest.approx(3.0, rel=0.05)


def test_the_shipped_configuration_is_valid() -> None:
    made = load("config/robustness.yaml", study_plan(), [ROOT])
    assert len(made.rows) > 200 and len(made.runs) > 200
    assert {row.parameter for row in made.rows if row.parameter == TIME_STEP}


def test_penetration_and_asymmetry() -> None:
    # All soil above the toe moved by 56.5 m to the left: the leftmost of it, at x = 55.5 m, is 1 m behind the front wall's face.
    run = synthetic(translation(-56.5))
    assert penetration(run) == pytest.approx(1.0 / 1.0, abs=1e-5)
    still = synthetic(translation(0.0))
    assert penetration(still) == 0.0
    assert penetration(synthetic(translation(0.0, -12.0))) == pytest.approx(1.5, abs=1e-5)
    block = {"geometry": {"shape": "block", "width": 10.0, "height": 10.0}}
    moved = synthetic(lambda scene, x, y: (np.where(y > 5, 0.2, 0.0), np.zeros_like(y)), overrides=block)
    assert asymmetry(moved) == pytest.approx(0.4, abs=1e-5)


def test_table_and_figure(tmp_path: Path) -> None:
    made = load(write(tmp_path), study_plan(), [tmp_path])
    runs = {name: synthetic(translation(-3.0 if "nu" in name else -5.0)) for name in made.runs}
    runs["nu/0.3/weak_2"] = synthetic(translation(-3.1))

    table = measure_robustness(made.parameters, runs, MetricSettings())
    assert list(table.columns) == [column.name for column in ROBUSTNESS]
    assert table["status"].tolist() == ["complete", REFUSED, "complete", "complete"]
    assert table["displacement"].iloc[0] == pytest.approx(3.0) and table["reproducible"].iloc[0] == 0.0
    write_csv(table, tmp_path / "robustness.csv")
    pd.testing.assert_frame_equal(read_robustness(tmp_path / "robustness.csv"), table)
    axes = figure_robustness(table).axes
    assert len(axes) == 5 and "R" in {text.get_text() for text in axes[0].texts}, "four panels and a colour bar"
    with pytest.raises(ValueError, match="no row"):
        figure_robustness(table.iloc[:0])
