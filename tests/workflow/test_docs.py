"""The documentation, built as a user builds it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from test_workflow import ROOT, snakemake

import sph

GALLERY = [path for path in (ROOT / "docs" / "gallery").glob("*.md") if path.stem != "index"]
QUICKEST = "rod-column"


@pytest.mark.long
def test_the_documentation_builds_without_a_warning(tmp_path: Path) -> None:
    """With the quickest page of the gallery; to run all of them takes half an hour, and is what the target ``gallery`` does."""
    (tmp_path / "config").symlink_to(ROOT / "config")
    for target in (f"results/gallery/{QUICKEST}", "docs"):
        result = snakemake(tmp_path, "--cores", "2", "--", target)
        assert result.returncode == 0, result.stderr
    docs = tmp_path / "results" / "docs"
    start = (docs / "api" / "sph.html").read_text(encoding="utf-8")
    assert not [name for name in sph.__all__ if f'id="{name}"' not in start]
    modules = {path.relative_to(ROOT).with_suffix("") for path in (ROOT / "sph").rglob("*.py") if path.name != "__init__.py"}
    assert not [module for module in modules if not (docs / "api" / module).with_suffix(".html").exists()]
    assert "simulated time" in start and "Wendland" in (docs / "api" / "sph" / "solver" / "physics" / "kernels.html").read_text(
        encoding="utf-8"
    )
    pages = {path.relative_to(ROOT / "docs").with_suffix(".html") for path in (ROOT / "docs").rglob("*.md")}
    assert not [page for page in pages if not (docs / page).exists()]
    html = (docs / "gallery" / f"{QUICKEST}.html").read_text(encoding="utf-8")
    pictures = re.findall(r'<img [^>]*src="([^"]+)"', html)
    assert pictures and not [picture for picture in pictures if not (docs / "gallery" / picture).is_file()]
    others = [(docs / "gallery" / page.stem).with_suffix(".html").read_text(encoding="utf-8") for page in GALLERY if page.stem != QUICKEST]
    assert all("has not been run here" in other for other in others) and "has not been run here" not in html
    fetched = re.compile(r"<(?:script|img|link)\b[^>]*\b(?:src|href)=\"https?://[^\"]*")
    assert not [page for page in pages if fetched.search((docs / page).read_text(encoding="utf-8"))], "a page needs the network"


def test_a_broken_link_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    checks = settings[settings.index("validation:") : settings.index("nav:")]
    (tmp_path / "mkdocs.yml").write_text(f"site_name: broken\nstrict: true\n{checks}", encoding="utf-8")
    for text in ("[a](other.md)", "[a](#nowhere)", "[a](/index.md)", "[a](sub)"):
        (tmp_path / "docs" / "index.md").write_text(text, encoding="utf-8")
        built = subprocess.run([sys.executable, "-m", "mkdocs", "build"], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert built.returncode == 1 and "strict mode" in built.stdout + built.stderr, text
