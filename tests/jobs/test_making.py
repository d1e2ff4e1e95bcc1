"""Steps of experiments: what each is given fits its function, what it makes fits its files, and its caption holds for any dimensions."""

from __future__ import annotations

import functools
import inspect
import json
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure

from sph.experiments.sensitivity.design import load_sensitivity
from sph.experiments.trigger.design import load_trigger
from sph.jobs.tables.making import READERS, Step, make, steps
from sph.paper.study import load_study, paper_study
from sph.scene.configuration import read_yaml

ROOT = Path(__file__).resolve().parents[2]
BACK: dict[str, Any] = {"back_analysis": {"observed": {"runout": {"value": 20.0, "error": 1.0}}}}


@functools.cache
def designs(folder: Path) -> dict[str, Any]:
    """The shipped experiments, with all that they may ask for."""
    study = load_study(read_yaml(ROOT / "config" / "config.yaml") | {"fidelity": "draft"}, [ROOT], check=False)
    searched = read_yaml(ROOT / "config" / "trigger.yaml") | {"hazard": "site.csv"}
    (folder / "site.csv").write_text("amplitude (m/s2),annual frequency\n0.1,0.01\n20,0.0001\n")
    (folder / "trigger.yaml").write_text(yaml.safe_dump(searched, sort_keys=False))
    sampled = read_yaml(ROOT / "config" / "sensitivity.yaml") | BACK
    (folder / "sensitivity.yaml").write_text(yaml.safe_dump(sampled, sort_keys=False))
    return {
        "trigger": load_trigger("trigger.yaml", study, [folder, ROOT]),
        "sensitivity": load_sensitivity("sensitivity.yaml", study, [folder, ROOT], check=False),
        "paper": paper_study(study.study, "the claims"),
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("experiments")


LISTED = [(experiment, step) for experiment in ("trigger", "sensitivity", "paper") for step in steps(experiment).values() if step.writes]


@pytest.mark.parametrize(("experiment", "step"), LISTED, ids=lambda each: each.name if isinstance(each, Step) else each)
def test_a_step_is_given_what_its_function_takes(experiment: str, step: Step, folder: Path) -> None:
    design = designs(folder)[experiment]
    assert set(step.reads) <= set(READERS)
    read = {*step.reads, *(name for name in step.needs(design) if name in READERS)}
    inspect.signature(step.make).bind(**dict.fromkeys(read), **step.given(design))


@pytest.mark.parametrize(("experiment", "step"), LISTED, ids=lambda each: each.name if isinstance(each, Step) else each)
def test_a_caption_holds_for_any_dimensions(experiment: str, step: Step) -> None:
    assert len(step.about) > 20 and step.about.endswith(".")
    told = step.about.replace("Every column is defined", "")
    assert experiment == "paper" or not any(word in told for word in ("S_R", "γ", "gamma", "amplitude"))


def test_no_two_rules_have_one_name() -> None:
    names = [step.name for experiment in ("trigger", "sensitivity", "paper") for step in steps(experiment).values()]
    assert len(names) == len(set(names))


def test_tables_and_figures_are_read_and_written_in_order(tmp_path: Path) -> None:
    (tmp_path / "factors.json").write_text('["S_R", "height"]')

    def made(factors: list[str], first: str) -> tuple[pd.DataFrame, Figure, list[str]]:
        return pd.DataFrame({"factor": factors}), Figure(), [first, *factors]

    step = Step("all", made, writes={"table.csv": "", "figures/one": "figure", "names.json": ""})
    assert step.draws and not step._replace(writes={"table.csv": ""}).draws
    paths = [str(tmp_path / name) for name in ("table.csv", "one.png", "one.pdf", "names.json")]
    make(step, {"factors": str(tmp_path / "factors.json"), "elsewhere": "unread.csv"}, {"first": "gamma"}, [], paths)
    assert pd.read_csv(paths[0])["factor"].tolist() == ["S_R", "height"]
    assert Path(paths[1]).read_bytes().startswith(b"\x89PNG") and Path(paths[2]).read_bytes().startswith(b"%PDF")
    assert json.loads(Path(paths[3]).read_text()) == ["gamma", "S_R", "height"]
