"""What describes the package is said once, or agrees: version, dependencies, licence, catalog."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import yaml
from jinja2 import StrictUndefined, Template
from setuptools import find_packages

import sph

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
EXACT = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines() if "==" in line)


def differences(conda: list[str]) -> set[str]:
    """Dependencies with their bounds that are in one of environment.yml and pyproject.toml, the workflow's extras included."""
    extras = PROJECT["optional-dependencies"]
    named = re.findall(r"\w+", next(name for name in extras["workflow"] if name.startswith(PROJECT["name"])).partition("[")[2])
    wanted = [*PROJECT["dependencies"], *extras["workflow"], *(name for extra in named for name in extras[extra])]
    needed = {requirement.lower() for requirement in wanted if not requirement.startswith(PROJECT["name"])}
    return (needed | {f"python{PROJECT['requires-python']}", "pip"}) ^ set(conda)


def test_conda_and_pip_want_the_same() -> None:
    *packages, own = CONDA["dependencies"]
    assert not differences(packages) and own == {"pip": ["-e ."]}
    assert differences([name.replace("numba>=0.62", "numba>=0.63") for name in packages]) == {"numba>=0.62,<0.69", "numba>=0.63,<0.69"}
    assert len(differences(packages[:-2])) == 2


def test_exact_versions_are_given_for_every_dependency() -> None:
    extras = [requirement for extra in PROJECT["optional-dependencies"].values() for requirement in extra]
    names = {re.split(r"[<>=\[]", requirement)[0] for requirement in PROJECT["dependencies"] + extras}
    spelled = {name.lower().replace("_", "-") for name in EXACT}
    assert {name.lower() for name in names} - {PROJECT["name"]} <= spelled


def faults(text: str) -> set[str]:
    """Requirements with digests that are not those of constraints.txt, or have none, and lines of anything else."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    named = dict.fromkeys(line.split(" ")[0] for line in lines)
    bare = {line for line in lines if not re.fullmatch(r"\S+==\S+( --hash=sha256:[0-9a-f]{64})+", line)}
    return bare | (set(named) ^ {f"{name}=={version}" for name, version in EXACT.items()})


def test_the_exact_set_has_digests() -> None:
    """After a change of constraints.txt: tests/packaging/write_hashes.py."""
    text = (ROOT / "requirements-hashed.txt").read_text(encoding="utf-8")
    assert not faults(text) and "://" not in text
    first = next(line for line in text.splitlines() if "==" in line)
    assert faults(text.replace(first, first.split(" ")[0])) == {first.split(" ")[0]}
    assert faults(text.replace(first + "\n", "")) == {first.split(" ")[0]}
    assert faults(text.replace("--hash=sha256:", "--hash=sha256:0", 1)) and faults(text + "--index-url elsewhere\n")
    assert len(faults(text.replace("numpy==", "numpy==1."))) == 2


def test_the_version_is_one() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == sph.__version__ and citation["license"] == PROJECT["license"]
    assert f"\n## {sph.__version__} ({citation['date-released']})\n" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert citation["keywords"] == PROJECT["keywords"]


def recipe(text: str) -> dict[str, Any]:
    """The conda recipe as conda-build reads it: rendered by Jinja, then YAML."""
    return yaml.safe_load(Template(text, undefined=StrictUndefined).render(PYTHON="python"))


def test_the_conda_recipe_wants_what_pip_wants() -> None:
    text = (ROOT / "recipe" / "meta.yaml").read_text(encoding="utf-8")
    found = recipe(text)
    wanted = {f"python{PROJECT['requires-python']}", *(name.lower() for name in PROJECT["dependencies"])}
    assert {name.replace(" ", "") for name in found["requirements"]["run"]} == wanted
    assert found["package"] == {"name": PROJECT["name"], "version": sph.__version__}
    assert found["build"]["entry_points"] == [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]
    assert found["about"]["license"] == PROJECT["license"] and found["about"]["summary"] == PROJECT["description"]
    assert (ROOT / "recipe" / found["source"]["path"] / "pyproject.toml").is_file()
    (backend,) = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    assert backend in {name.replace(" ", "") for name in found["requirements"]["host"]}


def test_what_only_a_release_needs_is_no_part_of_the_package() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]["find"]
    assert (ROOT / "tools" / "__init__.py").is_file() and "tools" in find_packages(str(ROOT))
    assert {name.partition(".")[0] for name in find_packages(str(ROOT), **settings)} == {"sph"}


def test_the_paper_is_cited() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    (paper,) = citation["references"]
    assert paper["title"].lower() in " ".join((ROOT / "README.md").read_text(encoding="utf-8").split()).lower()


def test_the_catalog_finds_what_it_asks_for() -> None:
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text(encoding="utf-8"))["usage"]
    assert set(usage) == {"mandatory-flags", "software-stack-deployment", "report"} and usage["report"] is True
    assert set(usage["mandatory-flags"]) == {"desc", "flags"}
    assert {name for name, offered in usage["software-stack-deployment"].items() if offered} == {"report"}
    assert not any("conda:" in path.read_text(encoding="utf-8") for path in (ROOT / "workflow" / "rules").glob("*.smk")), "then offer conda"
    assert (ROOT / "workflow" / "Snakefile").is_file() and (ROOT / "config" / "README.md").is_file()


def test_the_hooks_before_a_commit_download_nothing() -> None:
    repos = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    assert [repo["repo"] for repo in repos] == ["local"]
    assert all(hook["entry"].startswith(".venv/bin/") and hook["language"] == "system" for hook in repos[0]["hooks"])
    programs = {hook["entry"].split()[0].removeprefix(".venv/bin/") for hook in repos[0]["hooks"]}
    installed = {script.name for script in entry_points(group="console_scripts") if script.dist and script.dist.name in EXACT}
    assert programs - installed <= {"ruff"}, "ruff is a program and no entry point"
