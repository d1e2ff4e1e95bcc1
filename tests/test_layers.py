"""Layer order: the solver knows neither analysis nor command, the library knows no Snakemake."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SPH = Path(__file__).resolve().parents[1] / "sph"
SOLVER = ("sph.analysis", "sph.stability", "sph.command", "sph.page", "snakemake")
FORBIDDEN = {
    "__init__.py": ("snakemake",),  # it names the public interface, and imports a part when it is used
    "": SOLVER,
    "ground_motion": SOLVER,
    "stability": ("sph.analysis", "sph.command", "sph.page", "snakemake"),
    "analysis": ("sph.validation", "sph.command", "sph.page", "snakemake"),
    "validation": ("sph.command", "sph.page", "snakemake"),
    "command": ("sph.page", "snakemake"),
    "page": ("snakemake",),
}


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {node.module or ""} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


@pytest.mark.parametrize("path", sorted(SPH.rglob("*.py")), ids=lambda p: str(p.relative_to(SPH)))
def test_no_upward_imports(path: Path) -> None:
    first = path.relative_to(SPH).parts[0]
    layer = first if first in FORBIDDEN else ""
    wrong = [name for name in imports(path) if name.startswith(FORBIDDEN[layer])]
    assert not wrong, f"{path.name} must not import {wrong}"


def test_the_check_sees_imports() -> None:
    assert "sph.analysis.metrics" in imports(SPH / "command" / "cli.py")
