"""What imports what: the contracts in pyproject.toml, and what must not be loaded until it is used."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import sph

ROOT = Path(__file__).resolve().parents[1]
SCRIPTS = sorted((ROOT / "workflow" / "scripts").rglob("*.py"))


def test_the_contracts_are_kept(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    cli = pytest.importorskip("importlinter.cli", reason="import-linter is not installed")
    monkeypatch.chdir(ROOT)
    assert cli.lint_imports(no_cache=True, no_logo=True) == 0, capfd.readouterr().out


def test_a_folder_does_not_hide_a_public_name() -> None:
    folders = {path.name for path in (ROOT / "sph").iterdir() if path.is_dir() and not path.name.startswith("__")}
    assert not folders & set(sph.__all__), "once the folder is imported"
    assert [path.name for path in (ROOT / "sph").glob("*.py")] == ["__init__.py"]


def loaded_by(code: str, *arguments: Path) -> set[str]:
    """Modules in a Python that has run some code."""
    command = [sys.executable, "-c", f"import runpy, sys\n{code}\nprint(*sys.modules)", *map(str, arguments)]
    return set(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split())


def test_jobs_do_not_load_the_command_line() -> None:
    """A change of the command line, and a fault in it, is nothing to a job."""
    loaded = loaded_by("for path in sys.argv[1:]: runpy.run_path(path)", *SCRIPTS)
    assert "sph.jobs.log" in loaded and not loaded & {"sph.command.cli", "typer"}


UNUSED = {"xarray", "pandas", "matplotlib.pyplot", "rich.progress"}
UNUSED |= {f"scipy.{name}" for name in ("optimize", "signal", "spatial", "stats")}
"""What a simulation does without: together these took as long to load as all that it needs."""
SCENE = """
name: block
scheme: paper
duration: 0.01
geometry: {shape: block, width: 4.0, height: 4.0}
gravity: {ramp: 0.001, duration: 0.002}
motion: {kind: none}
numerics: {spacing: 1.0, time_step: 1.0e-4}
outputs: {frame_interval: 0.01, series_interval: 0.001}
"""
JOBS = """
from pathlib import Path
from sph.jobs.ahead import Task
from sph.jobs.simulation import work
from sph.scene.configuration import read_yaml
from sph.study.planned import planned
scene, folder = planned(read_yaml(Path(sys.argv[1]))), Path(sys.argv[1]).parent
for name, restart, until in (("gravity", None, "gravity"), ("run", "gravity", "end")):
    file, restart = str(folder / f"{name}.nc"), restart and str(folder / f"{restart}.nc")
    work(Task(file, str(folder / f"{name}.log"), restart, *scene, until, "simulation", False, True, "cpu", "0"), [], 1)
"""


def test_jobs_that_simulate_load_what_they_use(tmp_path: Path) -> None:
    """One up to a stage and one that goes on from its file, both with all that they read and write."""
    (tmp_path / "scene.yaml").write_text(SCENE)
    loaded = loaded_by(JOBS, tmp_path / "scene.yaml")
    assert (tmp_path / "run.nc").is_file() and "sph.solver.run" in loaded and not loaded & {*UNUSED, "typer"}


def test_no_two_test_files_have_one_name() -> None:
    names = sorted(path.name for path in Path(__file__).parent.rglob("test_*.py"))
    assert [name for name, following in zip(names, names[1:], strict=False) if name == following] == [], "pytest imports them by name"
