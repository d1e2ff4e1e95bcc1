"""The README's first picture, and its way from what is known of a slope and a record to a study, work as they are written."""

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
    """The commands of the README's section but those that install, without comments."""
    section = (ROOT / "README.md").read_text(encoding="utf-8").split("## Your own slope\n")[1].split("\n## ")[0]
    lines = "\n".join(re.findall(r"```sh\n(.*?)```", section, re.DOTALL)).splitlines()
    written = [shlex.split(command, comments=True) for line in lines for command in line.split(" && ")]
    return [command for command in written if command and Path(command[0]).name in MODULES]


@pytest.mark.long
def test_the_readme_s_commands(tmp_path: Path) -> None:
    (tmp_path / "config").symlink_to(ROOT / "config")
    written = commands()
    assert [command[1] for command in written] == ["new", "check", "cost", "--cores", "run", "plot"]
    for program, *arguments in written:
        name = Path(program).name
        command = [sys.executable, "-m", *MODULES[name], *arguments, *SHORT.get(arguments[0], []), *SHORT.get(name, [])]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
        told = done.stdout + done.stderr
        if "check" in arguments:
            assert all(word in told for word in ("drained", "berm", "Spencer"))
        if name == "snakemake":
            assert re.search(r"simulate\s+6\b", told), "the slope as it is and both alternatives, in both directions"
    assert {"scene.png", "look.nc", "look.png"} <= {path.name for path in tmp_path.iterdir()}
