"""What tests of killed processes share: processes that can be killed with their children, and what is then compared."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CHECKPOINT = "0.1"
"""Seconds between checkpoints: short, so that many kills hit the writing of one."""
TIMINGS = {"wall_time", "particle_steps_per_second"}
"""Metrics that tell how long a run took."""


def start(arguments: list[str], folder: Path) -> subprocess.Popen[bytes]:
    """A process that leads its group, so that it can be killed with its children."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"PYTHONPATH": path, "SPH_CHECKPOINT": CHECKPOINT}
    with open(folder / "output.log", "ab") as log:
        return subprocess.Popen(arguments, cwd=folder, env=environment, stdout=log, stderr=log, start_new_session=True)


def killed(process: subprocess.Popen[bytes], after: float) -> bool:
    """Kill a process and its children after some seconds; False if it ended before."""
    try:
        process.wait(after)
        return False
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return True
