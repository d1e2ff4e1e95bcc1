"""What describes the package is said once, or agrees: version, dependencies, licence, catalog."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import yaml

import sph

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
EXACT = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines() if "==" in line)


def differences(conda: list[str]) -> set[str]:
    """Dependencies with their bounds that are in one of environment.yml and pyproject.toml, the workflow's extras included."""
    extras = PROJECT["optional-dependencies"]
    wanted = [*PROJECT["dependencies"], *extras["workflow"], *extras["records"], *extras["sensitivity"]]
    needed = {requirement.lower() for requirement in wanted if not requirement.startswith(PROJECT["name"])}
    return (needed | {f"python{PROJECT['requires-python']}", "pip"}) ^ set(conda)


def test_conda_and_pip_want_the_same() -> None:
    *packages, own = CONDA["dependencies"]
    assert not differences(packages) and own == {"pip": ["-e ."]}
    assert differences([name.replace("numba>=0.60", "numba>=0.61") for name in packages]) == {"numba>=0.60", "numba>=0.61"}
    assert len(differences(packages[:-2])) == 2


def test_exact_versions_are_given_for_every_dependency() -> None:
    extras = [requirement for extra in PROJECT["optional-dependencies"].values() for requirement in extra]
    names = {re.split(r"[<>=\[]", requirement)[0] for requirement in PROJECT["dependencies"] + extras}
    spelled = {name.lower().replace("_", "-") for name in EXACT}
    assert {name.lower() for name in names} - {PROJECT["name"]} <= spelled


def test_the_version_is_one() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == sph.__version__ and citation["license"] == PROJECT["license"]
    assert re.search(rf"^## {re.escape(sph.__version__)}\b", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)


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
    hooks = {hook["entry"].split()[0].removeprefix(".venv/bin/"): hook["language"] for hook in repos[0]["hooks"]}
    assert set(hooks) <= set(EXACT) and set(hooks.values()) == {"system"}
