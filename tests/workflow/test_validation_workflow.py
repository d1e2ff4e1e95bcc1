"""The reference cases and the limits from end to end, as a user runs them, on a few small cases."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from test_workflow import ROOT, planned_jobs, snakemake, write_config

from sph.experiments.limits.measure import read_limits
from sph.experiments.validation.measure import read_validation
from sph.scene.schema import Scene
from sph.storage import trajectory

pytestmark = pytest.mark.long

LIMITS: dict[str, Any] = {
    "scene": "slope.yaml",
    "cases": {"S_R 0.10": {"coupling": {"S_R": 0.1}}},
    "changes": {"as it is": {}, "longer": {"geometry": {"apron_length": 80.0}}},
}


@pytest.fixture(scope="module")
def validated(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder in which three cases (V9 on one level, V11, V13 on two) and a limit have been run."""
    folder = tmp_path_factory.mktemp("validation")
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    cases = yaml.safe_load((ROOT / "config" / "validation.yaml").read_text())["cases"]
    cases = {name: cases[name] for name in ("V9", "V11", "V13")}
    cases["V9"]["levels"] = {"1 m": cases["V9"]["levels"]["1 m"]}
    cases["V9"]["compared"] = "finest"
    del cases["V13"]["levels"]["2.5e-4 s"]
    (folder / "cases.yaml").write_text(yaml.safe_dump({"cases": cases}, sort_keys=False))
    (folder / "limits.yaml").write_text(yaml.safe_dump(LIMITS, sort_keys=False))
    config = write_config(folder, experiments={"validation": "cases.yaml", "limits": "limits.yaml"})
    jobs = {"validation": 1, "simulate": 8, "validation_case": 3, "validation_table": 1, "validation_book": 1}
    assert planned_jobs(folder, *config, "--", "validation") == jobs
    assert planned_jobs(folder, *config, "--", "limits") == {"limits": 1, "simulate": 2, "limits_table": 1}
    result = snakemake(folder, "--cores", "2", *config, "--", "validation", "limits")
    assert result.returncode == 0, result.stderr
    return folder / "results"


def test_the_shipped_suite_and_limits_are_planned() -> None:
    jobs = planned_jobs(ROOT, "--forceall", "--", "validation", "limits")
    cases = yaml.safe_load((ROOT / "config" / "validation.yaml").read_text())["cases"]
    assert jobs["validation_case"] == len(cases) >= 20 and jobs["simulate"] > 60 and "stage" not in jobs


def test_the_table_holds_every_case(validated: Path) -> None:
    table = read_validation(validated / "validation" / "validation.csv")
    assert list(dict.fromkeys(table["case"])) == ["V9", "V11", "V13"]
    by_quantity = table.set_index("quantity")
    assert by_quantity.loc["pulse", "verdict"] == "holds" and by_quantity.loc["pulse", "cost"] == 0.0
    assert 0.9 < by_quantity.loc["strength_after", "order"] < 1.6, "t_f is known to a step"
    assert by_quantity.loc["factor_of_safety", "levels"] == "1 m" and np.isnan(by_quantity.loc["factor_of_safety", "order"])
    assert 1.2 < by_quantity.loc["factor_of_safety", "computed"] < 1.6


def test_a_search_leaves_its_trials(validated: Path) -> None:
    trials = trajectory.read(validated / "validation" / "runs" / "V9" / "run" / "1-m.nc")
    assert trials.attrs["by"] == "factor_of_safety" and trials.attrs["stood"] < trials.attrs["failed"]
    assert set(trials["value"].values[trials["stands"].values == 1]) & {trials.attrs["stood"]}
    assert trajectory.scene_of(trials).numerics.spacing == 1.0


def test_a_book_with_a_page_a_case(validated: Path) -> None:
    text = (validated / "validation" / "book.md").read_text(encoding="utf-8")
    assert [line[3:].split(":")[0] for line in text.splitlines() if line.startswith("## ")] == ["V9", "V11", "V13"]
    assert "steps, " in text and (validated / "validation" / "book.pdf").read_bytes().count(b"/Type /Page ") == 4


def test_a_figure_a_case(validated: Path) -> None:
    for case in ("V9", "V11", "V13"):
        assert (validated / "validation" / "figures" / f"{case}.png").read_bytes().startswith(b"\x89PNG")
        assert (validated / "validation" / "figures" / f"{case}.pdf").read_bytes().startswith(b"%PDF")


def test_limits_compare_with_the_first_change(validated: Path) -> None:
    table = read_limits(validated / "limits" / "limits.csv")
    assert list(table["change"]) == ["as it is", "longer"] and table["displacement_magnitude_change"].iloc[0] == 0.0
    first, second = table["displacement_magnitude"]
    assert table["displacement_magnitude_change"].iloc[1] == pytest.approx(second / first - 1.0)


def test_bad_suites_are_refused_before_any_job(validated: Path, tmp_path: Path) -> None:
    (tmp_path / "slope.yaml").write_text((validated.parent / "slope.yaml").read_text())
    bad = LIMITS | {"changes": {"as it is": {}, "odd": {"soil": {"cohesin": 1.0}}}}
    (tmp_path / "limits.yaml").write_text(yaml.safe_dump(bad))
    result = snakemake(tmp_path, "--cores", "1", *write_config(tmp_path, experiments={"limits": "limits.yaml"}), "--", "limits")
    assert result.returncode != 0 and "change 'odd', case 'S_R 0.10': soil.cohesin" in result.stdout + result.stderr
