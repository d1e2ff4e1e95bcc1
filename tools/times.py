"""Times of the README's commands: ``python -m tools.times [--tasks study tests ...] [--keep FOLDER]``.

Each command is run as the README has it, in a fresh clone of this repository's last commit, with nothing installed or compiled; the study
is then run at the other fidelities, with the packages installed and nothing compiled.  The times go into the table ``times`` of the
release (``sph/experiments/measured/times.csv``), with the machine and its load at the start.  The clone is deleted unless it is to be kept,
for instance to adopt its results by ``python -m tools.release``.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from sph.solver.compiled.jit import solver_digest
from sph.study.machine import duration, machine_class
from tools.release import STUDY_AT, write_time
from tools.shipped import note

ROOT = Path(__file__).resolve().parents[1]
STUDY, TESTS, FIRST = re.findall(r"^python3 -m venv .*$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
FRESH = "from a fresh clone: packages installed, solver compiled"
INSTALLED = "packages installed, nothing compiled"
TASKS = {
    "first picture": (FIRST, FRESH),
    "study": (STUDY, FRESH),
    "tests": (TESTS, FRESH),
    **{
        STUDY_AT + fidelity: (f".venv/bin/snakemake --cores 2 --forceall --config fidelity={fidelity}", INSTALLED)
        for fidelity in ("draft", "standard")
    },
}
"""Command and conditions of every task."""


def timed(command: str, folder: Path) -> float:
    """Seconds that a command takes in a folder, with nothing compiled; CalledProcessError where it fails."""
    with tempfile.TemporaryDirectory() as cache:
        start = time.perf_counter()
        subprocess.run(command, shell=True, cwd=folder, env=os.environ | {"SPH_CACHE_DIR": cache}, check=True)
        return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("--tasks", nargs="+", choices=TASKS, default=list(TASKS), help="what is timed, in this order")
    parser.add_argument("--keep", type=Path, help="folder of the clone, which then stays")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        clone = options.keep or Path(temporary, "clone")
        subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
        for task in options.tasks:
            command, conditions = TASKS[task]
            if conditions == INSTALLED and not (clone / ".venv").exists():
                subprocess.run(STUDY.rpartition(" && ")[0], shell=True, cwd=clone, check=True)
            load = f"; load average {os.getloadavg()[0]:.1f} at the start"
            if conditions == FRESH:
                shutil.rmtree(clone / ".venv", ignore_errors=True)
            seconds = timed(command, clone)
            write_time(task, seconds, conditions + load, machine_class())
            print(f"{task}: {duration(seconds)}")
    if set(options.tasks) == set(TASKS):  # times of several versions have no one origin
        note("times", solver_digest())


if __name__ == "__main__":
    main()
