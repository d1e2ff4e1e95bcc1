"""The README's way from a surveyed line and a record to a study works as it is written."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULES = {"sph": ["sph.command.cli"], "snakemake": ["snakemake", "--snakefile", str(ROOT / "Snakefile")]}
SHORT = {"run": ["--set", "duration=3.5"], "snakemake": ["--dry-run"]}
"""What is added, so that a test does not take minutes: half a second of the shaking, and what would be run."""


def commands() -> list[list[str]]:
    """The commands of the first block of the README's section, without comments."""
    section = (ROOT / "README.md").read_text(encoding="utf-8").split("## Your own slope\n")[1]
    block = re.search(r"```sh\n(.*?)```", section, re.DOTALL)
    assert block
    return [shlex.split(line, comments=True) for line in block[1].splitlines()]


@pytest.mark.long
def test_the_readme_s_commands(tmp_path: Path) -> None:
    (tmp_path / "config").symlink_to(ROOT / "config")
    written = commands()
    assert [command[1] for command in written[:-1]] == ["motion", "check", "run", "plot", "cost"]
    for program, *arguments in written:
        name = Path(program).name
        command = [sys.executable, "-m", *MODULES[name], *arguments, *SHORT.get(arguments[0], []), *SHORT.get(name, [])]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
        told = done.stdout + done.stderr
        if "check" in arguments:
            assert all(word in told for word in ("clay", "till", "progressive-failure"))
        if name == "snakemake":
            assert re.search(r"simulate\s+24\b", told), "12 runs at two spacings"
    assert {"motion.png", "scene.png", "first.nc", "first.png"} <= {path.name for path in tmp_path.iterdir()}
