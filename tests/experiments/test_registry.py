"""What the registry promises the rules, the figures and the reference of every experiment in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_scenes import study_plan

from sph.experiments.registry import EXPERIMENTS, NAMES
from sph.figures import experiment_figures
from sph.scene.configuration import read_yaml, validated
from sph.study.tables import read_csv

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_an_experiment_is_what_its_name_says(name: str) -> None:
    each = EXPERIMENTS[name]
    assert each.name == name and each.folder == f"results/{name}"
    assert validated(each.keys, read_yaml(ROOT / study_plan().study.file_of(name)), name)
    assert f"{name}.csv" in each.tables and {Path(file).suffix for file in each.tables} <= {".csv", ".nc"}
    shipped = ROOT / "sph" / "experiments" / "measured" / f"{name}.csv"
    assert not shipped.is_file() or len(read_csv(shipped, each.tables[shipped.name].columns, name))


def test_the_parameters_of_a_measuring_job_are_the_same_each_time() -> None:
    # Snakemake compares how they are written: an address in memory among them would make every table anew.
    for name in ("limits", "extremes", "trade"):
        one, other = (EXPERIMENTS[name].load(f"config/{name}.yaml", study_plan(), [ROOT]) for _ in range(2))
        assert repr(one.parameters) == repr(other.parameters) and " at 0x" not in repr(one.parameters)
        assert list(one.runs) == list(other.runs)


def test_figures_are_those_of_the_module_of_that_name() -> None:
    assert {name: list(experiment_figures(name)) for name in EXPERIMENTS if experiment_figures(name)} == {
        "trade": ["tradeoff", "convergence"],
        "resolution": ["tradeoff", "convergence"],
        "extremes": ["extremes"],
    }


def test_every_configuration_is_found_by_its_name() -> None:
    assert all((ROOT / study_plan().study.file_of(name)).is_file() for name in NAMES)
