"""A job's time beside its run: ``python tests/benchmarks/starting.py [--against FOLDER] [--repeats N] [--json FILE]``.

A job of the workflow simulates a scene of a few particles, so that nearly all of its time is beside the run: imports, building, findings
and writing.  What is told is its time less that of the run, the least of some repeats, after one that compiles the solver and keeps the
bytecode of what is imported, as an installation does.  Processor time depends less on other work on the machine than wall time; to
compare two versions give the folder of the other, and both are timed in turn.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from measuring import command_line, hand_out

ROOT = Path(__file__).resolve().parents[2]
SCENE = {
    "name": "block",
    "scheme": "paper",
    "duration": 0.01,
    "geometry": {"shape": "block", "width": 4.0, "height": 4.0},
    "gravity": {"ramp": 0.001, "duration": 0.002},
    "motion": {"kind": "none"},
    "numerics": {"spacing": 1.0, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.001},
}
JOB = """
import json, sys
from sph.jobs.ahead import Task
from sph.jobs.simulation import work
from sph.study.planned import planned
work(Task(sys.argv[3], sys.argv[2], None, *planned(json.loads(sys.argv[1])), "end", "simulation", False, True, "0"), [], 1)
"""
WALL_TIME = "import sys, netCDF4; print(netCDF4.Dataset(sys.argv[1]).wall_time_s)"


def beside(root: Path, folder: Path) -> dict[str, float]:
    """Wall and processor time (s) of a job with the sources in a folder, less the wall time of its run, which is on one core."""
    environment = os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1", "PYTHONPYCACHEPREFIX": str(folder / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # else every job would compile numba's and scipy's Python anew
    out = folder / "run.nc"
    command = [sys.executable, "-c", JOB, json.dumps(SCENE), str(folder / "log"), str(out)]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=root, check=False)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(done.stderr)
    run = float(subprocess.run([sys.executable, "-c", WALL_TIME, str(out)], capture_output=True, text=True, check=True).stdout)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"wall": wall - run, "processor": processor - run, "run": run}


def measure(roots: dict[str, Path], repeats: int) -> dict[str, Any]:
    """The least of the repeats, in turn for each version."""
    found: dict[str, list[dict[str, float]]] = {name: [] for name in roots}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(1 + repeats):
            for name, root in roots.items():
                found[name].append(beside(root, Path(folder)))
    return {name: {what: min(times[what] for times in each[1:]) for what in each[0]} for name, each in found.items()}


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [f"{'':12s}{'wall':>10s}{'processor':>12s}{'run':>10s}   (s; wall and processor beside the run)"]
    return "\n".join(
        lines + [f"{name:12s}{each['wall']:10.2f}{each['processor']:12.2f}{each['run']:10.3f}" for name, each in found.items()]
    )


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="another version of the sources, timed in turn")
    parser.add_argument("--repeats", type=int, default=5, help="jobs after the first (default: 5)")
    options = parser.parse_args(arguments)
    roots = {"here": ROOT} | ({"other": options.against.resolve()} if options.against else {})
    found = measure(roots, options.repeats)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
