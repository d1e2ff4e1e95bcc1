"""Snakemake and ``sph`` take the same from a configuration, or refuse it: numbers that are not decimal, and keys given twice."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from calling import call
from test_workflow import ROOT, STUDY, planned_jobs, snakemake

from sph.experiments.registry import CONFIGURED, load_study
from sph.jobs.catalogue import Catalogue
from sph.scene.schema import Scene, make_scene

OTHER = """
configfile: "{file}"

module slope:
    snakefile: "{snakefile}"
    config: {config}

use rule * from slope
"""


@pytest.fixture
def folder(tmp_path: Path, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    (tmp_path / "good.yaml").write_text(yaml.safe_dump(STUDY))
    return tmp_path


@pytest.mark.parametrize(
    ("written", "instead", "wanted"),
    [
        ("gamma:\n  - '1'", "gamma:\n  - 0100", "grid.gamma.0: 0100 is not one number"),
        pytest.param(
            "study: small", "study: small\nstudy: other", "the section at line 1 has the key 'study' twice", marks=pytest.mark.long
        ),
    ],
)
def test_a_configuration_that_two_readers_take_differently_is_refused_by_both(
    folder: Path, written: str, instead: str, wanted: str
) -> None:
    text = (folder / "good.yaml").read_text()
    assert written in text
    (folder / "bad.yaml").write_text(text.replace(written, instead))
    (folder / "Snakefile").write_text(OTHER.format(file="bad.yaml", snakefile=ROOT / "workflow" / "Snakefile", config="config"))
    for own in (("--configfile", "bad.yaml"), ("--snakefile", "Snakefile")):
        result = snakemake(folder, "--dry-run", *own)
        assert result.returncode != 0
        assert f"bad.yaml: cannot be read as YAML: {wanted}" in result.stdout + result.stderr
    told = call("cost", folder / "bad.yaml")
    assert told.exit_code == 2 and wanted in told.stderr


def test_what_another_workflow_keeps_beside_the_study_is_its_own(folder: Path) -> None:
    (folder / "whole.yaml").write_text(yaml.safe_dump({"slope": STUDY}) + "begun: 2024-01-01\n")
    (folder / "Snakefile").write_text(OTHER.format(file="whole.yaml", snakefile=ROOT / "Snakefile", config='config["slope"]'))
    assert planned_jobs(folder, "--snakefile", "Snakefile")["simulate"] == 8


def test_numbers_in_a_list_on_snakemakes_command_line_are_text(folder: Path) -> None:
    grid = "grid={S_R: ['0.10', '0.50'], gamma: [1, 0100], amplitude: [0.1, 8.0]}"
    result = snakemake(folder, "--dry-run", "--configfile", "good.yaml", "--config", grid, "--", "results/small/draft/study.csv")
    assert result.returncode == 0, result.stdout + result.stderr
    made = load_study(STUDY | {"grid": {"S_R": ["0.10"], "gamma": ["0100"], "amplitude": ["8.0"]}}, [folder], check=False)
    name = "S_R-0.10_gamma-0100_amplitude-8.0"
    assert f"runs/{name}.nc" in result.stdout and make_scene(made.shared.runs[name].scene).coupling.gamma == 100.0


@pytest.mark.parametrize(
    ("name", "told"),
    [
        (
            "asumptions",
            f"'asumptions' is not one of {', '.join(CONFIGURED)}; did you mean assumptions?",
        ),
        ("limits", "limits: is called assumptions now"),
    ],
)
def test_an_experiment_that_there_is_not_is_refused_by_name(folder: Path, name: str, told: str) -> None:
    """By the catalogue that the workflow begins with."""
    plan = load_study(STUDY | {"experiments": {name: "mine.yaml"}}, [folder])
    with pytest.raises(ValueError, match=rf"config: experiments[.:] ?{re.escape(told)}"):
        Catalogue(plan, [folder])


def test_an_earlier_name_of_a_target_makes_the_target(folder: Path) -> None:
    (folder / "study.yaml").write_text(yaml.safe_dump(STUDY))
    result = snakemake(folder, "--dry-run", "--configfile", "study.yaml", "--", "limits")
    assert result.returncode == 0 and "assumptions_table" in result.stdout
    assert "limits is called assumptions now: snakemake --cores 2 assumptions" in result.stdout + result.stderr
