"""What a stored measurement records of the code and the machine, and a call of ``gpu.py`` as a user would make it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

import sph
from sph.solver.compiled.jit import solver_digest
from sph.study.machine import processor

Script = Callable[..., tuple[dict[str, Any], str]]
SOLVER = solver_digest()
"""As the session begins: sources may be edited while it measures."""


@pytest.hookimpl(optionalhook=True, tryfirst=True)
def pytest_benchmark_generate_machine_info() -> dict[str, Any]:
    """In place of what pytest-benchmark tells of a machine, its name among it."""
    packages = {name: version(name) for name in ("numba", "numpy", "snakemake")}
    return {"processor": processor(), "cores": os.cpu_count(), "python": sys.version.split()[0], **packages}


@pytest.hookimpl(optionalhook=True)
def pytest_benchmark_update_commit_info(commit_info: dict[str, Any]) -> None:
    """The commit by its id alone, whether the tree has been changed since, the solver and the version."""
    kept = {name: commit_info.get(name) for name in ("id", "dirty")}
    commit_info.clear()
    commit_info.update(kept | {"solver": SOLVER, "version": sph.__version__})


@pytest.fixture(autouse=True)
def _load(request: pytest.FixtureRequest) -> None:
    """Keep with a measurement the load average at its start."""
    if "benchmark" in request.fixturenames:
        request.getfixturevalue("benchmark").extra_info["load"] = round(os.getloadavg()[0], 1)


@pytest.fixture
def script(tmp_path: Path) -> Script:
    """Call of a benchmark by name with arguments; its numbers and what it printed."""

    def call(name: str, *arguments: str) -> tuple[dict[str, Any], str]:
        path = tmp_path / "numbers.json"
        command = [sys.executable, str(Path(__file__).with_name(name)), *arguments, "--json", str(path)]
        environment = os.environ | {"PYTHONPATH": str(Path(sph.__file__).parents[1])}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(path.read_text()), done.stdout

    return call
