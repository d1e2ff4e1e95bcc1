"""What is timed is what the README has, from an empty cache."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tools.release import read_measured
from tools.times import INSTALLED, STUDY, TASKS, timed


def test_the_release_has_a_time_of_every_task() -> None:
    assert set(read_measured("times")["task"]) == set(TASKS)


def test_the_commands_are_those_of_the_readme() -> None:
    assert STUDY.rpartition(" && ")[::2] == (
        'python3 -m venv .venv && .venv/bin/pip install --no-compile -c constraints.txt -e ".[workflow]"',
        ".venv/bin/snakemake --cores 2",
    )
    assert TASKS["tests"][0].endswith(" && .venv/bin/pytest") and TASKS["study at draft"][1] == INSTALLED


def test_a_command_is_timed_with_an_empty_cache_in_its_folder(tmp_path: Path) -> None:
    assert timed('touch here && test -d "$SPH_CACHE_DIR" && test -z "$(ls "$SPH_CACHE_DIR")" && sleep 0.1', tmp_path) >= 0.1
    assert (tmp_path / "here").exists()
    with pytest.raises(subprocess.CalledProcessError):
        timed("false", tmp_path)
