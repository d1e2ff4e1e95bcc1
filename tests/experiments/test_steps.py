"""Steps of experiments: what each is given fits its function, what it makes fits its files, and its caption holds for any dimensions."""

from __future__ import annotations

import functools
import inspect
import json
import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure

from sph.experiments.base import Experiment
from sph.experiments.registry import EXPERIMENTS, load_study
from sph.experiments.steps import Step, make, steps
from sph.scene.configuration import read_yaml

ROOT = Path(__file__).resolve().parents[2]
BACK: dict[str, Any] = {"back_analysis": {"observed": {"runout": {"value": 20.0, "error": 1.0}}}}


@functools.cache
def design(folder: Path, name: str) -> Any:
    """That of a shipped experiment, with all that it may ask for."""
    study = load_study(
        read_yaml(ROOT / "config" / "config.yaml") | {"fidelity": "draft", "second_fidelity": "standard"}, [ROOT], check=False
    )
    experiment = EXPERIMENTS[name]
    more = {"trigger": {"hazard": "site.csv"}, "sensitivity": BACK}.get(name, {})
    (folder / "site.csv").write_text("amplitude (m/s2),annual frequency\n0.1,0.01\n20,0.0001\n")
    file = f"{name}.yaml"
    if experiment.keys:
        (folder / file).write_text(yaml.safe_dump(read_yaml(ROOT / "config" / file) | more, sort_keys=False))
    return experiment.plan(file, study, [folder, ROOT], check=False)


AT = {"search": "maps", "round": "1", "design": "sobol"}
"""A value of every wildcard."""


def given(step: Step, of: Any) -> dict[str, Any]:
    """What a step is given, at values of its wildcards."""
    return dict(step.given(of, **at(step)))


def at(step: Step) -> dict[str, str]:
    return {name: value for name, value in AT.items() if any(f"{{{name}}}" in file for file in step.writes)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("experiments")


LISTED = [(experiment, step) for experiment in EXPERIMENTS.values() for step in steps(experiment).values()]
listed = pytest.mark.parametrize(("experiment", "step"), LISTED, ids=lambda each: each.name)


@listed
def test_a_step_is_given_what_its_function_takes(experiment: Experiment, step: Step, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    of, readers = design(folder, experiment.name), experiment.measuring.READERS
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(type(of), "chosen", lambda self, name: ("S_R",), raising=False)
    assert set(step.reads) <= set(readers)
    read = {*step.reads, *(name for name in step.needs(of, **at(step)) if name in readers)}
    more = given(step, of) | ({"runs": None} if step.runs else {})
    inspect.signature(step.make).bind(**dict.fromkeys(read), **({"settings": {}} if step.measures else {}) | more)


def test_a_target_makes_what_steps_write(folder: Path) -> None:
    for experiment in EXPERIMENTS.values():
        files = {file for step in steps(experiment).values() for file in step.writes}
        for target, made in experiment.targets.items():
            assert set(made(design(folder, experiment.name))) <= files, target


def test_what_an_experiment_imports_from_others_is_told() -> None:
    """Else an edit there would not make its tables anew; those of trade count for every table."""
    for name, experiment in EXPERIMENTS.items():
        text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "sph" / "experiments" / name).glob("*.py"))
        assert set(re.findall(r"^from sph\.experiments\.(\w+)[. ]", text, re.M)) - {name, "base", "steps", "registry"} == {*experiment.uses}


@listed
def test_a_caption_holds_for_any_dimensions(experiment: Experiment, step: Step) -> None:
    assert len(step.about) > 20 and step.about.endswith(".")
    told = step.about.replace("Every column is defined", "")
    assert experiment.name == "paper" or not any(word in told for word in ("S_R", "γ", "gamma", "amplitude"))


def test_no_two_rules_have_one_name() -> None:
    names = [step.name for _, step in LISTED] + [target for each in EXPERIMENTS.values() for target in each.targets if each.keys]
    assert len(names) == len(set(names))


def test_tables_and_figures_are_read_and_written_in_order(tmp_path: Path) -> None:
    (tmp_path / "factors.json").write_text('["S_R", "height"]')

    def made(factors: list[str], first: str) -> tuple[pd.DataFrame, Figure, list[str]]:
        return pd.DataFrame({"factor": factors}), Figure(), [first, *factors]

    step = Step("all", made, writes={"table.csv": "", "figures/one": "figure", "names.json": ""})
    assert step.draws and not step._replace(writes={"table.csv": ""}).draws
    paths = [str(tmp_path / name) for name in ("table.csv", "one.png", "one.pdf", "names.json")]
    inputs = {"factors": str(tmp_path / "factors.json"), "elsewhere": "unread.csv"}
    make(EXPERIMENTS["sensitivity"], step, inputs, {"first": "gamma"}, [], paths)
    assert pd.read_csv(paths[0])["factor"].tolist() == ["S_R", "height"]
    assert Path(paths[1]).read_bytes().startswith(b"\x89PNG") and Path(paths[2]).read_bytes().startswith(b"%PDF")
    assert json.loads(Path(paths[3]).read_text()) == ["gamma", "S_R", "height"]
