"""The wheel holds the package and nothing else, and what is installed from it works without the repository."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import yaml
from small_scenes import SLOPE

pytestmark = pytest.mark.long

ROOT = Path(__file__).resolve().parents[2]
CACHES = shutil.ignore_patterns("__pycache__", "*.nb?")


def pip(*arguments: object) -> None:
    result = subprocess.run([sys.executable, "-m", "pip", "--quiet", *map(str, arguments)], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of a clean copy."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    shutil.copytree(ROOT / "sph", source / "sph", ignore=CACHES)
    for name in ("README.md", "LICENSE", "pyproject.toml"):
        shutil.copy(ROOT / name, source)
    pip("wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", folder, source)
    return next(folder.glob("*.whl"))


def packed(wheel: Path) -> set[str]:
    """Files of the wheel, but for its own records."""
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if ".dist-info/" not in name}


def wanted() -> set[str]:
    """Files of the package in the repository, but for caches and what documents them for a reader of the repository."""
    paths = (path for path in (ROOT / "sph").rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    return {path.relative_to(ROOT).as_posix() for path in paths if path.name != "README.md"}


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Path:
    """Folder that holds the installed package; its dependencies are those of this process."""
    folder = tmp_path_factory.mktemp("installed")
    pip("install", "--no-deps", "--no-index", "--target", folder, wheel)
    return folder


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """A working folder with a scene in it and nothing else."""
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(SLOPE), encoding="utf-8")
    return tmp_path


def call(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    assert packed(wheel) == wanted()


def test_it_is_the_installed_package_that_is_tested(installed: Path, elsewhere: Path) -> None:
    place = call(installed, elsewhere, "-c", "import sph; print(sph.__file__)").stdout
    assert Path(place.strip()) == installed / "sph" / "__init__.py"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("--help", "yield-acceleration"),
        ("info slope.yaml", "particles"),
        ("schema scene", '"geometry"'),
        ("advise --error 50%", "command line"),
        ("newmark slope.yaml --ay 0.1g", "m"),
    ],
)
def test_commands_need_no_repository(installed: Path, elsewhere: Path, arguments: str, told: str) -> None:
    result = call(installed, elsewhere, str(installed / "bin" / "sph"), *arguments.split())
    assert result.returncode == 0 and told in result.stdout, result.stderr


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ("status", "config/config.yaml: no such file; go to the folder the study was started in"),
        ("info config/scenes/paper.yaml", "paper.yaml"),
    ],
)
def test_what_needs_the_repository_says_so(installed: Path, elsewhere: Path, arguments: str, told: str) -> None:
    result = call(installed, elsewhere, str(installed / "bin" / "sph"), *arguments.split())
    assert result.returncode == 2 and told in result.stderr and "Traceback" not in result.stderr
