"""Jobs of experiments: what a rule gives fits its function, what that makes fits its files, and its caption holds for any dimensions."""

from __future__ import annotations

import importlib.util
import inspect
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure
from snakemake.api import ConfigSettings, OutputSettings, ResourceSettings, SnakemakeApi
from snakemake.iocontainers import Wildcards

from sph.experiments.variants.design import EARLIER
from sph.experiments.variants.design import EXPERIMENTS as VARIANTS
from sph.scene.configuration import read_yaml

ROOT = Path(__file__).resolve().parents[2]
MORE: dict[str, Any] = {
    "trigger": {"hazard": "site.csv"},
    "sensitivity": {"back_analysis": {"observed": {"runout": {"value": 20.0, "error": 1.0}}}},
}
"""What experiments may be asked for, over their shipped configurations."""
AT = {
    "folder": "results/paper/draft", "name": "own", "search": "maps", "round": "1", "design": "tornado",
    "table": "maps", "quantity": "class",
}  # fmt: skip
"""A value of every wildcard."""


@pytest.fixture(scope="module")
def workflow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The workflow with a study for which everything is asked; scenes of experiments are not built."""
    folder = tmp_path_factory.mktemp("experiments")
    (folder / "site.csv").write_text("amplitude (m/s2),annual frequency\n0.1,0.01\n20,0.0001\n")
    for name, keys in MORE.items():
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(read_yaml(ROOT / "config" / f"{name}.yaml") | keys, sort_keys=False))
    asked = {"fidelity": "draft", "second_fidelity": "standard", "experiments": {name: f"{name}.yaml" for name in MORE}}
    (folder / "study.yaml").write_text(yaml.safe_dump(read_yaml(ROOT / "config" / "config.yaml") | asked, sort_keys=False))
    with pytest.MonkeyPatch.context() as patched, SnakemakeApi(OutputSettings()) as api:
        patched.chdir(folder)
        settings = ConfigSettings(configfiles=[folder / "study.yaml"])
        made: Any = api.workflow(resource_settings=ResourceSettings(cores=1), config_settings=settings, snakefile=ROOT / "Snakefile")
        made._workflow.globals["CATALOGUE"]._check = False
        yield made._workflow


def jobs(workflow: Any) -> list[tuple[Any, Any, Any, Any]]:
    """Every rule of a step, its function, and what gives its values and its runs."""
    found = []
    for rule in workflow.rules:
        if str(rule.script).endswith("/make.py"):
            told = inspect.getclosurevars(dict(rule.params.items())["given"]).nonlocals
            of = inspect.getclosurevars(told["of"]).nonlocals
            found.append((rule, told["function"], of["given"], of["runs"]))
    return found


def test_a_job_is_given_what_its_function_takes(workflow: Any) -> None:
    for rule, function, given, runs in jobs(workflow):
        named = {name for name, _ in rule.input.items()}
        assert ("runs" in named) == (runs is not None), rule.name
        inspect.signature(function).bind(**dict.fromkeys(named), **given(Wildcards(fromdict=AT)))


def test_a_job_that_draws_depends_on_the_drawing(workflow: Any) -> None:
    drawing = workflow.globals["DRAWING"]
    assert all(dict(rule.params.items())["sources"].startswith(drawing) == any(map(_is_figure, rule.output)) for rule, *_ in jobs(workflow))


def _is_figure(file: str) -> bool:
    return str(file).endswith((".png", ".pdf"))


def test_every_file_of_a_target_is_made_by_a_rule(workflow: Any) -> None:
    names = [each.name for each in VARIANTS] + list(EARLIER)
    for name in [*names, "trigger", "fragility", "confirm", "maps", "sensitivity", "back_analysis"]:
        (rule,) = (each for each in workflow.rules if each.name == name)
        files: list[str] = []
        for each in rule.input:
            found = each(Wildcards()) if callable(each) else each
            files += [found] if isinstance(found, str) else list(map(str, found))
        assert files and all(any(each.is_producer(file) for each in workflow.rules) for file in files), name


def test_a_caption_holds_for_any_dimensions(workflow: Any) -> None:
    for rule, function, *_ in jobs(workflow):
        about = dict(rule.params.items())["about"]
        assert len(about) > 20 and about.endswith("."), rule.name
        told = about.replace("Every column is defined", "")
        assert ".paper." in function.__module__ or not any(word in told for word in ("S_R", "γ", "gamma", "amplitude"))


def test_what_an_experiment_imports_from_others_is_told() -> None:
    """Else an edit there would not make its tables anew; what lies beside the experiments counts for every table."""
    experiments = ROOT / "sph" / "experiments"
    for name in ("trigger", "sensitivity", "paper"):
        text = "".join(path.read_text(encoding="utf-8") for path in (experiments / name).glob("*.py"))
        rules = (ROOT / "workflow" / "rules" / f"{name}.smk").read_text(encoding="utf-8")
        imported = set(re.findall(r"^from sph\.experiments\.(\w+)[. ]", text, re.M)) - {name}
        assert {other for other in imported if (experiments / other).is_dir()} == set(re.findall(r'uses="(\w+)"', rules))


def script() -> ModuleType:
    found = importlib.util.spec_from_file_location("make", ROOT / "workflow" / "scripts" / "make.py")
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_tables_and_figures_are_written_in_order(tmp_path: Path) -> None:
    def made(factors: str, first: str) -> tuple[pd.DataFrame, Figure, list[str]]:
        return pd.DataFrame({"file": [factors]}), Figure(), [first, factors]

    paths = [str(tmp_path / name) for name in ("table.csv", "one.png", "one.pdf", "names.json")]
    script().make(made, {"factors": "factors.json", "earlier": []}, {"first": "gamma"}, None, paths)
    assert pd.read_csv(paths[0])["file"].tolist() == ["factors.json"]
    assert Path(paths[1]).read_bytes().startswith(b"\x89PNG") and Path(paths[2]).read_bytes().startswith(b"%PDF")
    assert json.loads(Path(paths[3]).read_text()) == ["gamma", "factors.json"]


def test_runs_are_read_when_they_are_asked_for() -> None:
    class Scene:
        def read(self, path: str) -> str:
            return f"run of {path}"

    runs = script().Runs(["a.nc", "b.nc"], {"one": Scene(), "two": Scene()})
    assert list(runs) == ["one", "two"] and len(runs) == 2
    assert runs["two"] == "run of b.nc" and list(runs.values()) == ["run of a.nc", "run of b.nc"]
    with pytest.raises(ValueError, match="zip"):
        script().Runs(["a.nc"], {"one": Scene(), "two": Scene()})
