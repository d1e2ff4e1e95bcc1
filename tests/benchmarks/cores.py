"""What more cores would give one large scene: ``python tests/benchmarks/cores.py [--bandwidth GB/S] [--json FILE]``.

A prediction for nodes of up to 64 cores, from what is measured here with one and two threads:

* the time of a step with one thread, and the bytes of pairs that it reads (``BYTES_OF_PAIR``), which give the bandwidth a core asks for;
* the time in which two threads meet, taken to grow as the number of threads, as their additions to one number do;
* the part of a collapse that one thread does alone: renewing candidates, recording and guarding.

A step on p cores takes serial + parallel * max(1 / p, asked / bandwidth) + meetings * p / 2, with the bandwidth of the whole node, which
cannot be measured here and is given (by default 200 GB/s, as of eight channels of DDR4-3200).  The measured speed of two threads stands
beside the predicted one.  A study has a thread a run; ``sph cost STUDY --cores N`` predicts it.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from measuring import command_line, hand_out, paper
from threads import measure as measure_threads

from sph.solver import simulation
from sph.solver.compiled.jit import jit
from sph.solver.compiled.threads import make_team, together, wait
from sph.solver.run import Run

CORES = (1, 2, 4, 8, 16, 32, 64)
BYTES_OF_PAIR = 16
"""Read from memory in a step: neighbour, gradient and norm, by the first loop over pairs; the second finds them in the cache."""
MEETINGS = 4
"""Of the threads in a step in which no pairs are renewed."""
ROUNDS = 20_000


@jit
def meet(rounds, team):  # type: ignore[no-untyped-def]
    """Meet so many times."""
    for _ in range(rounds):
        wait(team)


def meeting_seconds() -> float:
    """Seconds in which two threads meet, of many meetings."""
    team = make_team(2, 1, 1)
    together(meet, team, 1)
    start = time.perf_counter()
    together(meet, team, ROUNDS)
    return (time.perf_counter() - start) / ROUNDS


def serial_share(spacing: float) -> float:
    """Share of a collapse of the paper's slope, S_R 0.10, that is not in what threads share."""
    scene = paper({"coupling.S_R": 0.10, "numerics.spacing": spacing, "numerics.smoothing_ratio": 1.3, "numerics.gradient_tolerance": 0.02})
    Run(scene.model_copy(update={"duration": scene.outputs.series_interval})).go()
    shared, kept = 0.0, simulation.together

    def timed(*arguments: Any) -> Any:
        nonlocal shared
        start = time.perf_counter()
        result = kept(*arguments)
        shared += time.perf_counter() - start
        return result

    simulation.together = timed
    try:
        run = Run(scene)
        start = time.perf_counter()
        run.go()
        return 1.0 - shared / (time.perf_counter() - start)
    finally:
        simulation.together = kept


def predict(step: float, asked: float, meeting: float, serial: float, bandwidth: float, cores: int) -> float:
    """Times as fast as with one thread: step and meeting in s, asked and bandwidth in bytes/s, ``serial`` the share of one thread alone.

    The step is measured without its serial share, which comes on top.
    """
    alone = step * serial / (1.0 - serial)
    others = MEETINGS * meeting * cores / 2 if cores > 1 else 0.0
    return (step + alone) / (step * max(1.0 / cores, asked / bandwidth) + alone + others)


def measure(spacing: float, serial_spacing: float, steps: int, repeats: int, bandwidth: float) -> dict[str, Any]:
    """The constants, and the prediction for each number of cores; seconds, bytes and shares."""
    found = measure_threads(spacing, 2, steps, repeats)
    step, meeting, serial = 1e-3 * found["one_ms"], meeting_seconds(), serial_share(serial_spacing)
    asked = BYTES_OF_PAIR * found["neighbours_mean"] * found["particles"] / step
    block = np.zeros(2**25)
    start = time.perf_counter()
    total = sum(float(block.sum()) for _ in range(4))
    read = 4 * block.nbytes / (time.perf_counter() - start)
    assert total == 0.0
    numbers = {"step": step, "asked": asked, "meeting": meeting, "bandwidth": bandwidth}
    return {
        "particles": found["particles"],
        **numbers,
        "one_core_reads": read,
        "serial": serial,
        "measured_two": found["speedup"],
        "times_as_fast_still": {str(p): predict(**numbers, serial=0.0, cores=p) for p in CORES},
        "times_as_fast": {str(p): predict(**numbers, serial=serial, cores=p) for p in CORES},
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [
        f"{found['particles']:,} particles: a step {1e3 * found['step']:.2f} ms with one thread, which reads pairs at "
        f"{found['asked'] / 1e9:.1f} GB/s (one core reads {found['one_core_reads'] / 1e9:.1f}), a meeting of two threads "
        f"{1e6 * found['meeting']:.2f} us,",
        f"one thread alone {found['serial']:.1%} of a collapse; two threads were measured {found['measured_two']:.2f} times as fast as one",
        f"predicted for a node that reads {found['bandwidth'] / 1e9:.0f} GB/s:",
        "cores                     " + "".join(f"{p:8d}" for p in CORES),
    ]
    for name, text in (("times_as_fast_still", "while nothing moves"), ("times_as_fast", "a collapse")):
        lines.append(f"{text:26s}" + "".join(f"{found[name][str(p)]:8.1f}" for p in CORES))
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--spacing", type=float, default=0.14, help="of the particles of the scene, m")
    parser.add_argument("--serial-spacing", type=float, default=0.5, help="of those of the collapse, m")
    parser.add_argument("--steps", type=int, default=20, help="in a turn")
    parser.add_argument("--repeats", type=int, default=9, help="turns of which the median is taken")
    parser.add_argument("--bandwidth", type=float, default=200.0, help="at which the node reads memory, GB/s")
    options = parser.parse_args(arguments)
    found = measure(options.spacing, options.serial_spacing, options.steps, options.repeats, 1e9 * options.bandwidth)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
