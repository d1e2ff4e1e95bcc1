"""The reference cases and the assumptions from end to end, as a user runs them, on a few small cases."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from test_workflow import ROOT, planned_jobs, snakemake, write_config

from cases import CASES
from cases.suite import read_validation, write_suite
from sph.experiments.variants.assumptions import read_assumptions
from sph.scene.schema import Scene
from sph.storage import trajectory

ASSUMPTIONS: dict[str, Any] = {
    "scene": "slope.yaml",
    "cases": {"S_R 0.10": {"coupling": {"S_R": 0.1}}},
    "reference": {"parameter": "box", "variant": "as it is"},
    "parameters": {"box": {"variants": {"as it is": {}, "longer": {"geometry": {"apron_length": 80.0}}}}},
}
TRIED = ("V11", "V13", "V14")
"""Cases that take seconds."""


@pytest.fixture(scope="module")
def validated(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    """Folder in which three cases, a search of a fourth, and a change have been run."""
    folder = tmp_path_factory.mktemp("validation")
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    (folder / "mine.yaml").write_text(yaml.safe_dump(ASSUMPTIONS, sort_keys=False))
    config = write_config(folder, experiments={"assumptions": "mine.yaml"})
    files = [f"results/validation/cases/{case}.csv" for case in TRIED] + ["results/validation/runs/V9/run/1-m.nc"]
    assert planned_jobs(folder, *config, "--", *files) == {"validation_run": 10, "validation_case": 3}
    assert planned_jobs(folder, *config, "--", "assumptions") == {"assumptions": 1, "simulate": 2, "assumptions_table": 1}
    result = snakemake(folder, "--cores", "2", *config, "--", *files, "assumptions")
    assert result.returncode == 0, result.stderr
    return folder / "results"


@pytest.mark.long
def test_all_cases_are_planned() -> None:
    jobs = planned_jobs(ROOT, "--forceall", "--", "validation", "assumptions")
    assert jobs["validation_case"] == len(CASES) and jobs["validation_run"] > 200 and "stage" not in jobs


@pytest.mark.long
def test_without_the_tests_the_cases_are_refused(tmp_path: Path) -> None:
    """As where the library beside the workflow is that of the wheel."""
    for name in ("sph", "config", "workflow"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"), symlinks=True)
    shutil.copy(ROOT / "Snakefile", tmp_path)
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--", "validation"]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    result = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode != 0
    assert "validation: the reference cases are no part of the installed package" in result.stdout + result.stderr


@pytest.mark.long
def test_the_table_holds_every_case(validated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the book a page a case, behind that of what is missed."""
    for name in CASES.keys() - set(TRIED):
        monkeypatch.delitem(CASES, name)
    folder = validated / "validation"
    tables, pictures = ([folder / made.format(case) for case in TRIED] for made in ("cases/{}.csv", "figures/{}.png"))
    runs = [folder / f"runs/V13/{run}/{level.replace(' ', '-')}.nc" for level in CASES["V13"].levels for run in CASES["V13"].runs]
    write_suite(tables, pictures, runs, *(tmp_path / f"all.{ending}" for ending in ("csv", "md", "pdf")))
    table = read_validation(tmp_path / "all.csv")
    assert list(dict.fromkeys(table["case"])) == list(TRIED)
    by_quantity = table.set_index("quantity")
    assert by_quantity.loc["pulse", "verdict"] == "holds" and by_quantity.loc["pulse", "cost"] == 0.0
    assert 0.9 < by_quantity.loc["strength_after", "order"] < 2.0, "t_f is known to a step"
    text = (tmp_path / "all.md").read_text(encoding="utf-8")
    assert [line[3:].split(":")[0] for line in text.splitlines() if line.startswith("## ")] == list(TRIED)
    assert "steps, " in text and (tmp_path / "all.pdf").read_bytes().count(b"/Type /Page ") == 4


@pytest.mark.long
def test_the_table_of_the_release_comes_again(validated: Path) -> None:
    """For an element, whose stress one particle's rounding does not move."""
    made = pd.concat(read_validation(validated / "validation" / "cases" / f"{case}.csv") for case in TRIED)
    shipped = read_validation(ROOT / "sph" / "experiments" / "measured" / "validation.csv")
    shipped = shipped[shipped["case"].isin(TRIED)]
    assert made["computed"].to_numpy() == pytest.approx(shipped["computed"].to_numpy(), rel=1e-6, abs=1e-3)


@pytest.mark.long
def test_a_search_leaves_its_trials(validated: Path) -> None:
    trials = trajectory.read(validated / "validation" / "runs" / "V9" / "run" / "1-m.nc").dataset()
    assert trials.attrs["by"] == "factor_of_safety" and trials.attrs["stood"] < trials.attrs["failed"]
    assert set(trials["value"].values[trials["stands"].values == 1]) & {trials.attrs["stood"]}
    assert trajectory.scene_of(trials).numerics.spacing == 1.0


@pytest.mark.long
def test_a_figure_a_case(validated: Path) -> None:
    for case in TRIED:
        assert (validated / "validation" / "figures" / f"{case}.png").read_bytes().startswith(b"\x89PNG")
        assert (validated / "validation" / "figures" / f"{case}.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.long
def test_assumptions_compare_with_the_reference(validated: Path) -> None:
    table = read_assumptions(validated / "assumptions" / "assumptions.csv")
    assert list(table["change"]) == ["as it is", "longer"] and table["displacement_magnitude_change"].iloc[0] == 0.0
    first, second = table["displacement_magnitude"]
    assert table["displacement_magnitude_change"].iloc[1] == pytest.approx(second / first - 1.0)


@pytest.mark.long
def test_bad_suites_are_refused_before_any_job(validated: Path, tmp_path: Path) -> None:
    (tmp_path / "slope.yaml").write_text((validated.parent / "slope.yaml").read_text())
    bad = ASSUMPTIONS | {"parameters": {"box": {"variants": {"as it is": {}, "odd": {"soil": {"cohesin": 1.0}}}}}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(bad))
    result = snakemake(tmp_path, "--cores", "1", *write_config(tmp_path, experiments={"assumptions": "mine.yaml"}), "--", "assumptions")
    assert result.returncode != 0 and "variant 'odd', case 'S_R 0.10': soil.cohesin" in result.stdout + result.stderr
