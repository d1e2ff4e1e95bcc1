"""The documentation, built from the docstrings as a user builds it."""

from __future__ import annotations

from pathlib import Path

from test_workflow import ROOT, snakemake

import sph


def test_the_documentation_builds_without_a_warning(tmp_path: Path) -> None:
    (tmp_path / "config").symlink_to(ROOT / "config")
    result = snakemake(tmp_path, "--cores", "1", "--", "docs")
    assert result.returncode == 0, result.stderr
    docs = tmp_path / "results" / "docs"
    start = (docs / "sph.html").read_text(encoding="utf-8")
    assert not [name for name in sph.__all__ if f'id="{name}"' not in start]
    modules = {path.relative_to(ROOT).with_suffix("") for path in (ROOT / "sph").rglob("*.py") if path.name != "__init__.py"}
    assert not [module for module in modules if not (docs / module).with_suffix(".html").exists()]
    assert "simulated time" in start and "Wendland" in (docs / "sph" / "kernels.html").read_text(encoding="utf-8")
