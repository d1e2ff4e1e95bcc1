"""A probe that a scene lacks is refused when it is planned, not when its runs are measured."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from small_scenes import SLOPE, study_plan

from sph.experiments.registry import EXPERIMENTS, load_study
from sph.experiments.sensitivity.design import load_sensitivity
from sph.experiments.trigger.design import load_trigger
from sph.scene.configuration import read_yaml
from sph.study.plan import Plan

ROOT = Path(__file__).resolve().parents[2]
CONFIG = read_yaml(ROOT / "config" / "config.yaml") | {"fidelity": "draft"}
ASSUMPTIONS = {
    "scene": "slope.yaml",
    "cases": {"one": {}},
    "reference": {"parameter": "spacing", "variant": "as it is"},
    "parameters": {"spacing": {"variants": {"as it is": {}, "other": {"numerics": {"spacing": 4.0}}}}},
}
COST_ACCURACY = {
    "scene": "slope.yaml",
    "cases": {"one": {}},
    "timed_case": "one",
    "reference": {"parameter": "spacing", "variant": "4 m"},
    "parameters": {"spacing": {"about": "Spacing.", "variants": {"4 m": {"numerics": {"spacing": 4.0}}, "5 m": {}}}},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, data in (("slope", SLOPE), ("assumptions", ASSUMPTIONS), ("cost-accuracy", COST_ACCURACY)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    return tmp_path


def unchecked(probe: str) -> Plan:
    return load_study(CONFIG | {"metrics": {"probe": probe}}, [ROOT], check=False)


def load(name: str, folder: Path, probe: str = "A") -> Any:
    return EXPERIMENTS[name].load(f"{name}.yaml", study_plan(probe=probe), [folder], True)


LOADERS: dict[str, Callable[[Path, str], Any]] = {
    "study": lambda folder, probe: load_study(CONFIG | {"metrics": {"probe": probe}}, [ROOT]),
    "trigger": lambda folder, probe: load_trigger("config/trigger.yaml", unchecked(probe), [ROOT]),
    "sensitivity": lambda folder, probe: load_sensitivity("config/sensitivity.yaml", unchecked(probe), [ROOT], check=False),
    "assumptions": lambda folder, probe: load("assumptions", folder, probe),
    "cost-accuracy": lambda folder, probe: load("cost-accuracy", folder, probe),
}


@pytest.mark.parametrize("kind", LOADERS)
def test_a_probe_that_the_scene_lacks_is_refused_by_its_key(folder: Path, kind: str) -> None:
    LOADERS[kind](folder, "A")
    with pytest.raises(ValueError, match=r"metrics\.probe: 'B' .*A"):
        LOADERS[kind](folder, "B")


def test_a_scene_without_a_probe(folder: Path) -> None:
    (folder / "slope.yaml").write_text(yaml.safe_dump(SLOPE | {"probes": {}}))
    with pytest.raises(ValueError, match=r"assumptions\.yaml: .*'as it is'.*'one'.*metrics\.probe: 'A'"):
        load("assumptions", folder)
