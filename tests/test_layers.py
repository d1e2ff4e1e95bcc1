"""Layer order: no folder imports from one above it, the library knows no Snakemake."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import sph

SPH = Path(__file__).resolve().parents[1] / "sph"
SCRIPTS = sorted((SPH.parent / "workflow" / "scripts").rglob("*.py"))
ORDER = (
    ("scene",),
    ("storage",),
    ("solver",),
    ("output",),
    ("measures",),
    ("stability",),
    ("study",),
    ("figures",),
    ("experiments",),
    ("jobs",),
    ("command",),
    ("page",),
)
"""The folders of the package from the lowest to the highest; those of one row do not know each other either."""
KNOW_THE_PAPER = {"page/paper.py"}
"""The modules outside ``sph/experiments/paper`` that import from it: where its page is made."""


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module or ""} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def layer(folder: str) -> int:
    return next(number for number, row in enumerate(ORDER) if folder in row)


def test_every_folder_has_a_layer() -> None:
    folders = {path.name for path in SPH.iterdir() if path.is_dir() and not path.name.startswith("__")}
    assert folders == {folder for row in ORDER for folder in row}
    assert [path.name for path in SPH.glob("*.py")] == ["__init__.py"]
    assert not folders & set(sph.__all__), "a folder of that name would hide the public one once it is imported"


@pytest.mark.parametrize("path", sorted(path for path in SPH.rglob("*.py") if path.parent != SPH), ids=lambda p: str(p.relative_to(SPH)))
def test_no_upward_imports(path: Path) -> None:
    own = path.relative_to(SPH).parts[0]
    known = {name.split(".")[1] for name in imports(path) if name.startswith("sph.") and len(name.split(".")) > 1}
    wrong = {name for name in known - {own} if any(name in row for row in ORDER) and layer(name) >= layer(own)}
    assert not wrong, f"{path.name} must not import {sorted(wrong)}"
    assert not any(name.split(".")[0] in ("snakemake", "tools") for name in imports(path))


def test_walls_know_the_physics_and_not_the_other_way_round() -> None:
    physics = [*(SPH / "solver" / "physics").glob("*.py"), SPH / "solver" / "state.py"]
    assert not {path.name for path in physics if any(name.startswith("sph.solver.boundaries") for name in imports(path))}


def test_what_knows_the_paper() -> None:
    paths = {path.relative_to(SPH).as_posix(): imports(path) for path in SPH.rglob("*.py")}
    knowing = {path for path, names in paths.items() if any(name.startswith("sph.experiments.paper") for name in names)}
    assert {path for path in knowing if not path.startswith("experiments/paper/")} == KNOW_THE_PAPER


def test_the_check_sees_imports() -> None:
    assert "sph.measures.metrics" in imports(SPH / "command" / "cli.py")


def test_jobs_do_not_load_the_command_line() -> None:
    """A change of the command line, and a fault in it, is nothing to a job."""
    code = "import runpy, sys\nfor path in sys.argv[1:]: runpy.run_path(path)\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, *map(str, SCRIPTS)], cwd=SPH.parent, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "sph.jobs.log" in loaded and not loaded & {"sph.command.cli", "typer"}


def test_a_job_loads_of_scipy_what_it_uses() -> None:
    """``scipy.signal`` and ``scipy.stats`` take as long to load as everything else that a simulation needs."""
    script = SPH.parent / "workflow" / "scripts" / "simulate.py"
    code = "import runpy, sys\nrunpy.run_path(sys.argv[1])\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code, str(script)], cwd=SPH.parent, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "sph.solver.run" in loaded and not loaded & {"scipy.signal", "scipy.stats", "scipy.optimize", "matplotlib.pyplot"}


def test_no_two_test_files_have_one_name() -> None:
    names = sorted(path.name for path in Path(__file__).parent.rglob("test_*.py"))
    assert [name for name, following in zip(names, names[1:], strict=False) if name == following] == [], "pytest imports them by name"
