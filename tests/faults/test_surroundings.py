"""Places without a home, a user or a folder that can be written: only a simulation needs one for compiled code, and says so."""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from small_scenes import SLOPE

import sph

PACKAGE = Path(sph.__file__).parent
NOBODY = 54321
"""Number of a user whom the system does not know."""
RIGHT = "+dac_read_search"
"""Whoever has this alone may read everything, as the tests' own Python, and write nothing."""

USED = """
import json, sys
from typer.testing import CliRunner
import sph
sph.run
from sph.command.cli import app

record, scene = sys.argv[1:]
commands = {
    "help": ["--help"], "motion": ["motion", record], "newmark": ["newmark", scene, "--ay", "1m/s2"], "check": ["check", scene],
    "info": ["info", scene], "run": ["run", scene], "fos": ["fos", scene, "--single"],
    "yield-acceleration": ["yield-acceleration", scene, "--single"],
}
found = {name: CliRunner().invoke(app, arguments) for name, arguments in commands.items()}
print(json.dumps({name: [done.exit_code, done.stderr, repr(done.exception)] for name, done in found.items()}))
"""


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """A folder that everybody may read and write; those of pytest are its user's alone."""
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o777)
        yield Path(folder)


@functools.cache
def as_nobody() -> tuple[str, ...]:
    """What begins a command of that user; skips where this user may not become it."""
    identity = [f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    rights = [f"--inh-caps=-all,{RIGHT}", f"--ambient-caps={RIGHT}", f"--bounding-set=-all,{RIGHT}"]
    command = ["setpriv", *identity, *rights]
    try:
        subprocess.run([*command, sys.executable, "-c", ""], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"this user may not become another: {error}")
    return tuple(command)


@pytest.mark.long
@pytest.mark.parametrize("home", ["none", "absent", "read-only cache", "a file"])
def test_only_a_simulation_needs_a_cache(open_folder: Path, tmp_path: Path, home: str) -> None:
    """With a file in the cache's place for any user; else as a user whom nobody knows, for whom the package is read-only, too."""
    scene, record, file = (open_folder / name for name in ("slope.yaml", "record.csv", "file"))
    scene.write_text(yaml.safe_dump(SLOPE | {"numerics": {"spacing": 25.0 / 12, "smoothing_ratio": 1.3, "time_step": 1e-3}}))
    record.write_text("t (s),a (m/s2)\n0,0\n0.1,1\n0.2,-1\n")
    file.touch()
    chosen, reason = {
        "none": ({}, "this user has no home folder"),
        "absent": ({"HOME": "/absent"}, "/absent/.cache/sph"),
        "read-only cache": ({"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}, f"{tmp_path}/sph/"),
        "a file": ({"SPH_CACHE_DIR": str(file)}, f"{file}/"),
    }[home]
    kept = {name: value for name, value in os.environ.items() if name not in ("HOME", "SPH_CACHE_DIR", "XDG_CACHE_HOME")}
    command = [*(as_nobody() if home != "a file" else ()), sys.executable, "-c", USED, str(record), str(scene)]
    before = set(PACKAGE.rglob("*.nb?"))
    done = subprocess.run(
        command, env=kept | {"PYTHONPATH": str(PACKAGE.parent)} | chosen, cwd=open_folder, capture_output=True, text=True, check=True
    )
    assert set(PACKAGE.rglob("*.nb?")) == before, "numba chose another place"
    for name, (code, said, error) in json.loads(done.stdout.splitlines()[-1]).items():
        if name in ("run", "fos", "yield-acceleration"):
            assert code == 2 and said.startswith("sph: ") and len(said.splitlines()) == 1, (name, said, error)
            assert reason in said and "compiled code cannot be kept" in said and "set SPH_CACHE_DIR to a folder" in said
        else:
            assert code == 0 and "Traceback" not in said, (name, said, error)
