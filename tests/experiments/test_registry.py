"""What the registry promises the rules and the reference of every experiment in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from small_scenes import study_plan

from sph.experiments.registry import CONFIGURED, EXPERIMENTS
from sph.scene.configuration import read_yaml, validated
from sph.study.planned import digest

ROOT = Path(__file__).resolve().parents[2]
ALONE = [name for name, each in EXPERIMENTS.items() if each.alone]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_an_experiment_is_what_its_name_says(name: str) -> None:
    each = EXPERIMENTS[name]
    assert each.name == name and each.folder == f"results/{name}"
    assert each.keys is None or validated(each.keys, read_yaml(ROOT / study_plan().study.file_of(name)), name)


@pytest.mark.long
def test_what_a_measuring_job_is_given_has_the_same_digest_each_time() -> None:
    # Snakemake compares it: an address in memory would make every table anew.
    for name in ("assumptions", "robustness", "cost-accuracy"):
        one, other = (EXPERIMENTS[name].plan(f"config/{name}.yaml", study_plan(), [ROOT], check=False) for _ in range(2))
        assert digest(one.parameters) == digest(other.parameters) and " at 0x" not in repr(one.parameters)
        assert list(one.runs) == list(other.runs)


def test_every_configuration_is_found_by_its_name() -> None:
    assert all((ROOT / study_plan().study.file_of(name)).is_file() for name in CONFIGURED)
