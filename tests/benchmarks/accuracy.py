"""Time to a wanted accuracy: ``python tests/benchmarks/accuracy.py [--against CHECKOUT] [--json FILE]``.

The slope of the resolution study, S_R 0.25, at ever finer spacing: seconds of one core for a run, and the larger of the
errors of A's displacement and of the run-out, from the mean over two lattices at 0.5 m in the shipped table.  A spacing is within an error
if it and all finer ones are, since one run may come near by chance.  With another checkout of this project both run at each
spacing, one after the other; each run is a process of its own, which compiles or loads everything before it is timed.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from measuring import command_line, hand_out, scene_of

import sph
from sph.experiments.variants.advice import shipped_table
from sph.measures.metrics import MetricSettings, measure
from sph.solver.run import Run

ROOT = Path(sph.__file__).parents[1]
SCENE = Path(__file__).parents[2] / "config" / "scenes" / "slope_on_rock.yaml"
CASE = "S_R 0.25"
ERRORS = (0.10, 0.05, 0.02)
SPACINGS = (25 / 10, 25 / 15, 25 / 20, 25 / 25, 25 / 30, 25 / 40)


def one(spacing: float) -> dict[str, float]:
    """Seconds of a run at a spacing (m), A's displacement and the run-out (m)."""
    scene = scene_of(SCENE, {"numerics.spacing": spacing})
    Run(scene.model_copy(update={"duration": scene.outputs.frame_interval})).go()
    run = Run(scene)
    start = time.perf_counter()
    result = run.go()
    seconds = time.perf_counter() - start
    found = measure(result.trajectory, MetricSettings())
    return {"seconds": seconds} | {name: float(found[name]) for name in ("displacement_magnitude", "runout")}


def reference() -> dict[str, float]:
    """A's displacement and the run-out (m) of the shipped reference."""
    table = shipped_table("resolved")
    assert table is not None
    row = table[(table["reference"] == 1) & (table["case"] == CASE)].iloc[0]
    return {name: float(row[name]) for name in ("displacement_magnitude", "runout")}


def in_process(checkout: Path, spacing: float) -> dict[str, float]:
    """``one`` with the code of a checkout."""
    command = [sys.executable, __file__, "--one", str(spacing)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | {"PYTHONPATH": str(checkout)})
    if done.returncode:
        raise SystemExit(f"{checkout}: {done.stderr}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def within(runs: list[dict[str, float]], error: float) -> float:
    """Seconds of the cheapest run, of ``runs`` from the coarsest on, that is within an error as all finer ones are; infinite for none."""
    seconds = math.inf
    for run in reversed(runs):
        if run["error"] > error:
            break
        seconds = run["seconds"]
    return seconds


def measure_codes(checkouts: dict[str, Path], spacings: list[float]) -> dict[str, Any]:
    """Runs of each code by name, coarsest first, and the seconds to each error."""
    true = reference()
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in checkouts}
    for spacing in spacings:
        for name, checkout in checkouts.items():
            run = in_process(checkout, spacing)
            error = max(abs(run[quantity] / value - 1.0) for quantity, value in true.items())
            runs[name].append(run | {"spacing": spacing, "error": error})
    times = {name: {str(error): within(found, error) for error in ERRORS} for name, found in runs.items()}
    return {"reference": true, "runs": runs, "seconds_within": times}


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = []
    for name, runs in found["runs"].items():
        lines.append(f"{name}:")
        lines += [f"  {run['spacing']:5.2f} m {run['seconds']:8.1f} s   error {run['error']:6.1%}" for run in runs]
        times = found["seconds_within"][name].items()
        lines.append(
            "  " + ", ".join(f"within {float(error):.0%}: {f'{time:.1f} s' if time < math.inf else 'not reached'}" for error, time in times)
        )
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--one", type=float, metavar="SPACING", help="print the numbers of one run and end")
    parser.add_argument("--against", type=Path, metavar="CHECKOUT", help="folder of another checkout of this project")
    parser.add_argument("--spacing", type=float, nargs="+", default=SPACINGS, help="of the particles, m, coarsest first")
    options = parser.parse_args(arguments)
    if options.one:
        print(json.dumps(one(options.one)))
        return
    checkouts = {"this code": ROOT} | ({str(options.against): options.against.resolve()} if options.against else {})
    found = measure_codes(checkouts, sorted(options.spacing, reverse=True))
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
