"""Safety: names and labels stay in their folders, nothing of a configuration is evaluated, unpickled or given to a shell."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from small_scenes import study_plan

from sph.experiments.base import file_name
from sph.experiments.paper.design import AnyStudy
from sph.experiments.registry import EXPERIMENTS, load_study
from sph.scene.configuration import found_file, merge, validated
from sph.study.sampling import MAX_RUNS

ROOT = Path(__file__).resolve().parents[2]
STUDY: dict[str, Any] = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
PAPER = "config/scenes/paper.yaml"
NAMES = [
    *("..", "../x", "/etc", "a/b", "a\\b", "a\0b", "a\nb", "a\n", "\n", "", " ", ".hidden", "-rf", "~", "$(id)", "`id`"),
    *("x" * 65, "é", "\uff41", "\u202e"),
]
LABELS = [
    *(
        "..",
        ".",
        "...",
        "../x",
        "../../x",
        "/etc",
        "a/b",
        ".hidden",
        "..é..",
        "\0",
        "a\0b",
        "x" * 60,
        "é",
        "\u202ea",
        "{run}",
        "*",
        "~",
        "; id",
    ),
]
"""Labels may hold anything, since they are words in tables; the files that are named after them may not."""


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("key", ["study", "fidelity", "name"])
def test_a_name_is_a_plain_word(key: str, name: str) -> None:
    changes = {
        "study": {"study": name},
        "fidelity": {"fidelity": name, "fidelities": {name: {}}},
        "name": {"fidelities": {"paper": {"name": name}}},
    }
    with pytest.raises(ValueError, match={"study": "study", "fidelity": "fidelities", "name": "name"}[key]):
        load_study(merge(STUDY, changes[key]), [ROOT])


@pytest.mark.parametrize("label", LABELS)
def test_a_label_cannot_lead_out_of_its_folder(label: str) -> None:
    name = file_name(label)
    assert re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*", name)
    assert os.path.normpath(f"runs/{name}/{name}.nc") == f"runs/{name}/{name}.nc"


def written(path: Path, data: Any) -> str:
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path.name


def parameters(*variants: str) -> dict[str, Any]:
    """A cost-accuracy study whose variants have these labels."""
    return {
        "scene": PAPER,
        "cases": {"one": {}},
        "timed_case": "one",
        "reference": {"parameter": "k", "variant": variants[0]},
        "convergence": "k",
        "parameters": {"k": {"about": "a", "variants": {label: {"numerics": {"spacing": 2.0 + at}} for at, label in enumerate(variants)}}},
    }


def load(name: str, file: str, folder: Path) -> Any:
    return EXPERIMENTS[name].load(file, study_plan(), [folder, ROOT], True)


def changes(variants: dict[str, Any]) -> dict[str, Any]:
    """Keys of assumptions."""
    return {"reference": {"parameter": "change", "variant": "as it is"}, "parameters": {"change": {"variants": variants}}}


def paths_of(tmp_path: Path, kind: str, *labels: str) -> Iterator[str]:
    """Paths of the runs of a configuration with these labels."""
    each = {label: {"numerics": {"spacing": 2.0 + at}} for at, label in enumerate(labels)}
    if kind == "variants":
        yield from load("cost-accuracy", written(tmp_path / "c.yaml", parameters(*labels)), tmp_path).runs
    elif kind == "cases":
        yield from load(
            "cost-accuracy", written(tmp_path / "c.yaml", parameters("r") | {"cases": each, "timed_case": labels[0]}), tmp_path
        ).runs
    elif kind == "changes":
        data = {"scene": PAPER, "cases": {"one": {}}} | changes({"as it is": {}} | each)
        yield from load("assumptions", written(tmp_path / "c.yaml", data), tmp_path).runs
    else:
        data = {"scene": PAPER, "cases": each} | changes({"as it is": {}, "other": {"numerics": {"spacing": 5.0}}})
        yield from load("assumptions", written(tmp_path / "c.yaml", data), tmp_path).runs


KINDS = ("variants", "cases", "changes", "points")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("label", ["..", "../..", ".", "é", "a/../.."])
def test_runs_named_after_labels_stay_in_their_folder(tmp_path: Path, kind: str, label: str) -> None:
    for path in paths_of(tmp_path, kind, label, "plain"):
        assert os.path.normpath(path) == path and not path.startswith(("/", ".")) and path.isascii()


@pytest.mark.parametrize("kind", KINDS)
def test_labels_with_one_file_name_are_refused(tmp_path: Path, kind: str) -> None:
    # Otherwise one run would be taken for the other without a word.
    with pytest.raises(ValueError, match="'é' and 'ü'.*'-'"):
        list(paths_of(tmp_path, kind, "é", "ü"))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("label", ["$x$", "two\nlines", "", " ", "x" * 61, "\x1b"])
def test_a_label_is_one_line_without_a_formula(tmp_path: Path, kind: str, label: str) -> None:
    with pytest.raises(ValueError, match=r"c\.yaml"):
        list(paths_of(tmp_path, kind, label, "plain"))


def test_a_grid_has_an_end() -> None:
    axis = [str(number) for number in range(1, 101)]
    with pytest.raises(ValueError, match=f"grid .*1,000,000.*{MAX_RUNS:,}"):
        validated(AnyStudy, merge(STUDY, {"grid": {"S_R": axis, "gamma": axis, "amplitude": axis}}), "config")
    with pytest.raises(ValueError, match=r"grid\.gamma\.0: .*100"):
        validated(AnyStudy, merge(STUDY, {"grid": {"gamma": ["0" * 300]}}), "config")


@pytest.mark.parametrize("name", ["absent.yaml", "n" * 300, "a\0b", "..", ""])
def test_a_file_that_is_not_found_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="config: scene: no file"):
        found_file([tmp_path], name, "config: scene")


# ---------------------------------------------------------------- nothing is run

SOURCES = [*sorted((ROOT / "sph").rglob("*.py")), *sorted((ROOT / "workflow" / "scripts").rglob("*.py"))]
RULES = [ROOT / "Snakefile", *sorted((ROOT / "workflow" / "rules").rglob("*.smk"))]
CALLS = ("eval", "exec", "compile", "__import__", "os.system", "os.popen", "yaml.load", "yaml.unsafe_load", "pd.read_pickle", "pd.eval")
ALLOWED = {
    "sph/study/machine.py": ["subprocess"],  # a fixed command that asks macOS for the name of its processor
    "sph/figures/film.py": ["subprocess"],  # the error of ffmpeg, which matplotlib starts
    "sph/__init__.py": ["importlib"],  # the public names, from a fixed table
    "sph/experiments/base.py": ["importlib"],  # a module of an experiment, whose names are a fixed table
    "sph/experiments/registry.py": ["importlib"],  # likewise
    "sph/solver/cuda/kernel.py": ["exec"],  # an argument for each array of the records, whose names are those of the source
    "sph/solver/cuda/ensemble.py": ["importlib", "importlib.util"],  # numba's backend for graphics cards
    "sph/command/cost.py": ["importlib.util"],  # whether that is installed
    "sph/scene/extras.py": ["importlib"],  # a module of a fixed name
    "workflow/scripts/docs/run_page.py": ["subprocess"],  # the blocks of the pages of the repository
    "workflow/scripts/docs/write_docs.py": ["subprocess", "importlib", "importlib.util"],  # mkdocs; all modules for pdoc
}
MODULES = ("pickle", "cPickle", "dill", "joblib", "marshal", "shelve", "subprocess", "pty", "ctypes", "importlib")


def test_the_sources_evaluate_nothing() -> None:
    for path in SOURCES:
        allowed = ALLOWED.get(str(path.relative_to(ROOT)), [])
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                assert called not in CALLS or called in allowed, f"{path}, line {node.lineno} calls {called}"
                assert not any(word.arg in ("shell", "allow_pickle") for word in node.keywords), f"{path}, line {node.lineno}"
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            wrong = [name for name in modules if name.split(".")[0] in MODULES and name != "importlib.metadata"]
            assert set(wrong) <= set(allowed), f"{path} imports {wrong}"


@pytest.mark.parametrize("path", RULES, ids=lambda p: p.name)
def test_the_rules_have_no_shell(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"\b(shell|run|eval|exec|os\.system|subprocess)\s*[:(]", text)


def test_every_wildcard_is_constrained() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in RULES)
    used = set(re.findall(r"wildcards\.(\w+)\b(?!\()", text)) | set(re.findall(r"(?<!\{)\{\{(\w+)\}\}(?!\})", text))
    blocks = re.findall(r"^( *)wildcard_constraints:\n((?:\1 +.*\n)+)", text, re.MULTILINE)
    constrained = {name for _, lines in blocks for name in re.findall(r"^\s+(\w+)=\S", lines, re.MULTILINE)}
    assert used and used <= constrained, f"without a constraint: {used - constrained}"
