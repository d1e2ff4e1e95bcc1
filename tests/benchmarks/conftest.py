"""Runs a benchmark as a user would."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import sph

Script = Callable[..., tuple[dict[str, Any], str]]


@pytest.fixture
def script(tmp_path: Path) -> Script:
    """Call of a benchmark by name with arguments; its numbers and what it printed."""

    def call(name: str, *arguments: str) -> tuple[dict[str, Any], str]:
        path = tmp_path / "numbers.json"
        command = [sys.executable, str(Path(__file__).with_name(name)), *arguments, "--json", str(path)]
        environment = os.environ | {"PYTHONPATH": str(Path(sph.__file__).parents[1])}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(path.read_text()), done.stdout

    return call
