"""Runs at once on a graphics card against one core of the same machine: ``python tests/benchmarks/gpu.py [--json FILE]``.

The paper's slope, with 2,404 particles in 1, 8, 64 and 256 runs of different strengths, and as one run of 30,000 to 1 M particles.  Times
are those of ``advance_steps``, with the state's way to the card and back, after one call that compiles.  The share of the bandwidth is
that of what a step must read and write (lists of pairs twice, fields once) in what a copy within the card makes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from measuring import command_line, hand_out

from sph.scene.schema import Scene, load_scene
from sph.solver.cuda import ensemble
from sph.solver.simulation import Simulation

PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"
CASES = [(1, 1.0), (8, 1.0), (64, 1.0), (256, 1.0), (1, 0.268), (1, 0.0835), (1, 0.0456)]
"""Numbers of runs, and spacings over that of the paper's scene."""
FIELDS = 60
"""Numbers that a step reads or writes of a particle, beside its pairs."""


def scene_of(number: int, ratio: float, precision: str) -> Scene:
    """The paper's slope with a strength of its own, at a multiple of its spacing."""
    own = load_scene(PAPER).numerics
    parts = math.ceil(1.0 / min(ratio, 1.0))
    numerics = {"spacing": own.spacing * ratio, "time_step": own.time_step / parts, "precision": precision}
    return load_scene(PAPER, {"numerics": numerics, "coupling": {"S_R": 0.05 + 0.9 * (number % 64) / 64}})


def bandwidth(cuda: Any) -> float:
    """Bytes a second that a copy within the card reads and writes."""
    one, other = (cuda.device_array(2**27, np.float64) for _ in range(2))
    other.copy_to_device(one)
    cuda.synchronize()
    began = time.perf_counter()
    for _ in range(10):
        other.copy_to_device(one)
    cuda.synchronize()
    return 10 * 2 * one.nbytes / (time.perf_counter() - began)


def on_card(runs: int, ratio: float, precision: str, steps: int, threads: int) -> dict[str, Any]:
    """Particle-steps a second of so many runs, with so many threads in a block."""
    on = ensemble.Ensemble(runs, threads)
    times = []

    def call(number: int) -> Simulation:
        simulation: Simulation = on.simulation(scene_of(number, ratio, precision), enforce_limit=False)
        simulation.prepare()
        simulation.advance_steps(2)
        for _ in range(3):
            times.append(time.perf_counter())
            simulation.advance_steps(steps)
        times.append(time.perf_counter())
        return simulation

    made = on.carry([lambda number=number: call(number) for number in range(runs)])
    for simulation in made:
        if isinstance(simulation, BaseException):
            raise simulation
    n, neighbours = made[0].state.x.size, made[0].mean_neighbours()
    speed = 3 * steps * n * runs / (max(times) - min(times))
    pair = 2 * 4 + 5 * (4 if precision == "mixed" else 8)
    return {"runs": runs, "particles": n, "neighbours": neighbours, "precision": precision, "speed": speed,
            "bytes_a_second": speed * (neighbours * pair + 8 * FIELDS)}  # fmt: skip


def on_core(precision: str, steps: int, ratio: float) -> float:
    """Particle-steps a second of one core, the paper's slope at a multiple of its spacing."""
    simulation = Simulation(scene_of(0, ratio, precision), enforce_limit=False)
    simulation.prepare()
    simulation.advance_steps(steps)
    began = time.perf_counter()
    simulation.advance_steps(steps)
    return steps * simulation.state.x.size / (time.perf_counter() - began)


def measure(most_runs: int, steps: int, finest: float, coarsened: float, threads: int, precisions: Sequence[str]) -> dict[str, Any]:
    """All cases up to a number of runs and down to a spacing, with spacings ``coarsened`` times as large."""
    cuda = ensemble.card()
    copy = float("nan") if ensemble.simulated() else bandwidth(cuda)
    cases = []
    for precision in precisions:
        core = on_core(precision, steps, coarsened)
        for runs, ratio in CASES:
            if runs <= most_runs and ratio >= finest:
                found = on_card(runs, coarsened * ratio, precision, steps, threads)
                cases.append(found | {"over_a_core": found["speed"] / core, "share_of_copy": found["bytes_a_second"] / copy})
    return {"card": ensemble.describe_card(), "copy_bytes_a_second": copy, "cases": cases}


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [f"{found['card']}; a copy makes {found['copy_bytes_a_second'] / 1e9:.0f} GB/s",
             "runs  particles  precision  M particle-steps/s  over a core  of a copy's bandwidth"]  # fmt: skip
    for case in found["cases"]:
        lines.append(f"{case['runs']:4d} {case['particles']:10,d}  {case['precision']:9s} {case['speed'] / 1e6:19.1f} "
                     f"{case['over_a_core']:12.1f} {case['share_of_copy']:15.0%}")  # fmt: skip
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--runs", type=int, default=256, help="most runs at once")
    parser.add_argument("--steps", type=int, default=1000, help="of a call, of which three are timed")
    parser.add_argument("--finest", type=float, default=0.04, help="smallest spacing over that of the paper")
    parser.add_argument("--precision", nargs="+", default=["mixed", "double"], help="of gradients")
    parser.add_argument("--coarsen", type=float, default=1.0, help="factor on all spacings, for a trial of this script")
    parser.add_argument("--threads", type=int, default=ensemble.THREADS, help="of a block")
    options = parser.parse_args(arguments)
    found = measure(options.runs, options.steps, options.finest, options.coarsen, options.threads, options.precision)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
