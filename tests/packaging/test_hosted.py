"""The hosted workflows: they call what .ci/run and the README call, hold no secret, and pin what they take from elsewhere."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / ".github" / "workflows"
WORKFLOWS = {path.stem: yaml.safe_load(path.read_text(encoding="utf-8")) for path in sorted(FOLDER.glob("*.yml"))}
ENVIRONMENT = "python3 -m venv .venv && .venv/bin/pip install --no-compile "
OWN = {
    "nightly": {
        ".venv/bin/pip install --no-compile --upgrade numba llvmlite snakemake && .venv/bin/pip freeze",
        ".venv/bin/pytest",
        ".venv/bin/pytest --cov=sph --cov-report=html --cov-report=term --cov-fail-under=87",
        ".venv/bin/snakemake --cores all --keep-going --config fidelity=draft -- ${{ matrix.target }}",
    },
    "tests": {".venv/bin/snakemake --cores 2 docs"},
    "release": {
        """test "$GITHUB_REF_NAME" = "v$(.venv/bin/python -c 'import sph; print(sph.__version__)')\"""",
        ".venv/bin/pytest -m long tests/packaging",
        ".venv/bin/python -m build",
    },
}
"""What a workflow calls beside the files of .ci, the README's test command and the installation of the tests' environment."""


def steps(workflow: dict[str, Any]) -> list[dict[str, Any]]:
    return [step for job in workflow["jobs"].values() for step in job["steps"]]


def readme_test_command() -> str:
    commands = re.findall(r"^python3 -m venv .*pytest$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(commands) == 1
    return commands[0]


def test_they_call_what_is_called_here() -> None:
    assert set(WORKFLOWS) == {"tests", "nightly", "release"}
    for name, workflow in WORKFLOWS.items():
        for step in steps(workflow):
            command = step.get("run", "").split(" #")[0].strip()
            local = re.fullmatch(r"(sudo )?\.ci/(\w+)( \d+)?", command)
            if local:
                assert os.access(ROOT / ".ci" / local[2], os.X_OK), command
            elif command and command != readme_test_command() and command not in OWN[name]:
                assert re.fullmatch(re.escape(ENVIRONMENT) + r'(-c constraints\.txt )?-e "\.\[test\]"( build| pytest-cov)?', command), (
                    name,
                    command,
                )
    called = {step.get("run") for step in steps(WORKFLOWS["tests"])}
    assert {readme_test_command(), ".ci/lint"} <= called
    assert ".ci/long 500" in {step.get("run") for step in steps(WORKFLOWS["nightly"])}


def test_coverage_has_one_floor() -> None:
    floors = [
        re.findall(r"pytest --cov=sph .*--cov-fail-under=(\d+)", path.read_text(encoding="utf-8"))
        for path in (FOLDER / "nightly.yml", ROOT / "CONTRIBUTING.md")
    ]
    assert len(floors[0]) == 1 and floors[0] == floors[1]


def test_ci_calls_the_command_of_the_readme() -> None:
    here = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert readme_test_command().replace("--no-compile", "-q --no-compile") in here.splitlines()
    assert all(f".ci/{name}" in here.splitlines() for name in ("system", "lint", "long"))


def test_what_is_taken_from_elsewhere_is_pinned_and_may_write_nothing_by_default() -> None:
    for name, workflow in WORKFLOWS.items():
        text = (FOLDER / f"{name}.yml").read_text(encoding="utf-8")
        assert workflow["permissions"] == {"contents": "read"} and "secrets." not in text
        assert all("timeout-minutes" in job for job in workflow["jobs"].values())
        for line in text.splitlines():
            if "uses:" in line:
                assert re.search(r"uses: [\w.-]+/[\w./-]+@[0-9a-f]{40} # v\d+(\.\d+)+$", line), line
        checked_out = [step for step in steps(workflow) if step.get("uses", "").startswith("actions/checkout@")]
        assert all(step["with"]["persist-credentials"] is False for step in checked_out)


def test_every_python_that_is_allowed_is_tried() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    tried = WORKFLOWS["tests"]["jobs"]["tests"]["strategy"]["matrix"]["python"]
    assert project["requires-python"] == f">={tried[0]}"
    classified = [name.rpartition(" ")[2] for name in project["classifiers"] if re.search(r":: Python :: 3\.\d+$", name)]
    assert classified == tried
    assert [version.split(".") for version in tried] == [["3", str(minor)] for minor in range(int(tried[0][2:]), int(tried[-1][2:]) + 1)]
