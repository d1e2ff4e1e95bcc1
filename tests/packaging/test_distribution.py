"""What a release is made of: the sdist, the wheel that is built from it, and its use in an environment of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from test_install import ROOT, pip

import sph
from sph.storage import trajectory

pytestmark = pytest.mark.long

SDIST = "import sys; from setuptools.build_meta import build_sdist; print(build_sdist(sys.argv[1]))"
GROUND = "x (m),z (m)\n0,20\n25,20\n35,26\n40,26\n50,32\n75,32\n"
"""A benched slope 12 m high."""


def called(folder: Path, *command: object) -> str:
    """What a command prints that runs in a folder and knows nothing of the repository; it has to succeed."""
    known = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV", "SPH_CACHE_DIR")}
    result = subprocess.run(
        [*map(str, command)], cwd=folder, env=known | {"SPH_CACHE_DIR": str(folder / "cache")}, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, f"{command}: {result.stdout[-2000:]} {result.stderr[-2000:]}"
    return result.stdout


def tracked() -> list[str]:
    return subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True).stdout.split("\0")[:-1]


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Made from what git tracks, so that no leftover of this folder enters it."""
    folder = tmp_path_factory.mktemp("sdist")
    for name in tracked():
        (folder / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "source" / name).write_bytes((ROOT / name).read_bytes())
    return folder / called(folder / "source", sys.executable, "-c", SDIST, folder).split()[-1]


@pytest.fixture(scope="module")
def wheel(sdist: Path) -> Path:
    pip("wheel", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", sdist.parent, sdist)
    return next(sdist.parent.glob("*.whl"))


def test_the_sdist_holds_the_whole_tool_and_builds_what_the_repository_builds(sdist: Path, wheel: Path) -> None:
    name = f"sph_slope-{sph.__version__}"
    with tarfile.open(sdist) as archive:
        held = set(archive.getnames())
    assert sdist.name == f"{name}.tar.gz" and wheel.name.startswith(f"{name}-py3-none-any")
    tool = (
        "sph/",
        "workflow/",
        "config/",
        "tests/",
        "tools/",
        "docs/",
        "Snakefile",
        "LICENSE",
        "README.md",
        "pyproject.toml",
        "constraints.txt",
    )
    assert {f"{name}/{file}" for file in tracked() if file.startswith(tool)} <= held


def test_the_wheel_serves_an_engineer_in_a_clean_environment(wheel: Path, tmp_path: Path) -> None:
    """Its dependencies as pip finds them; a scene from a ground line and a record; a coarse run; the library."""
    called(tmp_path, sys.executable, "-m", "venv", "own")
    place = tmp_path / "own" / "bin"
    called(tmp_path, place / "pip", "install", "--quiet", "--no-compile", "-c", ROOT / "constraints.txt", wheel)
    assert "site-packages" in called(tmp_path, place / "python", "-c", "import sph; print(sph.__file__, sph.load_scene)")
    assert called(tmp_path, place / "sph", "--version") == f"sph {sph.__version__}\n"
    (tmp_path / "ground.csv").write_text(GROUND, encoding="utf-8")
    time = 0.01 * np.arange(400)
    rows = (f"{t:.2f},{a:.5f}" for t, a in zip(time, 2.0 * np.sin(2 * np.pi * 2 * time) * np.sin(np.pi * time / 4.0), strict=True))
    (tmp_path / "record.csv").write_text("time (s),acceleration (m/s2)\n" + "\n".join(rows) + "\n", encoding="utf-8")
    called(tmp_path, place / "sph", "new", "ground.csv", "record.csv", "--out", "slope")
    scene = tmp_path / "slope" / "scene.yaml"
    called(tmp_path, place / "sph", "run", scene, "--set", "numerics.spacing=2", "--out", "first.nc")
    with xr.open_dataset(tmp_path / "first.nc", engine="netcdf4") as stored:
        assert int(stored.attrs["format"]) == trajectory.FORMAT
    run = trajectory.read_run(tmp_path / "first.nc").dataset()
    assert run.attrs["source"] == f"sph {sph.__version__}"
    again = "import sph; print(sph.read_run('first.nc').sizes['particle'])"
    assert int(called(tmp_path, place / "python", "-c", again)) == run.sizes["particle"]
