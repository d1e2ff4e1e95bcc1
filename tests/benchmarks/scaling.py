"""Cost of a particle-step from 2,400 to some 300,000 particles: ``python tests/benchmarks/scaling.py [--json FILE]``.

The paper's slope at ever finer spacing, while gravity is brought on: the same physics everywhere, with pairs that stay.
What renewing the lists costs, once, is reported beside it.  Sizes take turns, so that a busy machine slows all alike.

Is memory the limit?  A step has to read the pairs and the state of every particle at least once (``bytes_of_step``); their rate stands
beside the bandwidth of one core, by the triad of STREAM (McCalpin 1995).  A rate near it means that no faster arithmetic would help.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from measuring import at_rest, command_line, hand_out, medians, processor

from sph.solver.compiled.jit import jit, rows
from sph.solver.renewal import renew_candidates, renew_pairs
from sph.solver.simulation import Simulation

SPACINGS = (1.0, 0.5, 0.25, 0.15, 0.083)
PARTICLE_STEPS = 400_000
"""Particle-steps in a turn, or 4 steps where that is more."""
TRIAD = 2**24
"""Numbers in each of the three arrays of the triad: 128 MiB, more than any cache."""


@jit
def triad(a, b, c):  # type: ignore[no-untyped-def]
    """a = b + 3 c."""
    for k in rows(0, a.size):
        a[k] = b[k] + 3.0 * c[k]


def bandwidth(size: int = TRIAD, repeats: int = 5) -> float:
    """Bytes a second that one core reads and writes in the triad, three numbers a turn as STREAM counts them; the best of some turns."""
    a, b, c = np.zeros(size), np.ones(size), np.ones(size)
    triad(a, b, c)
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        triad(a, b, c)
        best = min(best, time.perf_counter() - start)
    assert a[0] == a[-1] == 4.0
    return 3 * a.nbytes / best


def bytes_of_step(run: Simulation) -> int:
    """Bytes that a step reads at least: of each pair neighbour, gradient and norm once, and the state of the particles once.

    What is written, and the pairs read again by the second loop, which finds them in the cache, are not counted.
    """
    pairs = run.pairs
    directed = int((pairs.end.astype(np.int64) - pairs.start).sum())
    of_pair = sum(each.itemsize for each in (pairs.neighbour, pairs.gx, pairs.gy, pairs.inverse_norm))
    return directed * of_pair + sum(each.nbytes for each in run.state if each.shape == run.state.x.shape)


def measure(spacings: list[float], repeats: int, particle_steps: int) -> list[dict[str, Any]]:
    """Nanoseconds of a particle-step, an interaction and a renewal of pairs and of candidates, by spacing."""
    runs = [at_rest(spacing) for spacing in spacings]
    sizes = [run.state.x.size for run in runs]
    steps = [max(4, particle_steps // n) for n in sizes]
    advanced = [0 for _ in runs]

    def advance(k: int) -> None:
        failed, done = runs[k].advance_steps(steps[k])
        assert (failed, done) == (0, steps[k])
        advanced[k] += done

    found = medians({str(k): (lambda k=k: advance(k)) for k in range(len(runs))}, repeats)
    return [
        {
            "spacing_m": spacing,
            "particles": n,
            "neighbours_mean": (neighbours := float((run.pairs.end - run.pairs.start).mean())),
            "steps": advanced[k],
            "particle_step_ns": (cost := 1e9 * found[str(k)] / steps[k] / n),
            "interaction_ns": cost / neighbours,
            "read_bytes": (read := bytes_of_step(run) / n),
            "read_rate": 1e9 * read / cost,
            **{f"{name}_ns": 1e9 * seconds / n for name, seconds in renewals(run).items()},
        }
        for k, (spacing, run, n) in enumerate(zip(spacings, runs, sizes, strict=True))
    ]


def renewals(run: Simulation) -> dict[str, float]:
    """Seconds of one renewal of the pairs and of the candidates."""
    return medians(
        {
            "renew_pairs": lambda: renew_pairs(run.state, run.candidates, run.pairs, run.terms, run.team[0]),
            "renew_candidates": lambda: renew_candidates(run.state, run.terms, run.pairs),
        },
        repeats=3,
    )


def with_ratios(sizes: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The same with the cost over that of the first size."""
    first = sizes[0]
    return [
        size | {f"{name}_ratio": size[f"{name}_ns"] / first[f"{name}_ns"] for name in ("particle_step", "interaction")} for size in sizes
    ]


def table(sizes: list[dict[str, Any]], triad_rate: float) -> str:
    """The numbers as text; ``triad_rate`` in bytes/s."""
    lines = [f"{'particles':>10s}{'neighbours':>12s}{'particle-step, ns':>20s}{'ratio':>7s}{'interaction, ns':>17s}{'ratio':>7s}"
             f"{'pairs, ns':>12s}{'candidates, ns':>16s}{'reads, bytes':>14s}{'GB/s':>7s}"]  # fmt: skip
    for size in sizes:
        lines.append(
            f"{size['particles']:10,d}{size['neighbours_mean']:12.1f}{size['particle_step_ns']:20.1f}{size['particle_step_ratio']:7.2f}"
            f"{size['interaction_ns']:17.3f}{size['interaction_ratio']:7.2f}{size['renew_pairs_ns']:12.0f}{size['renew_candidates_ns']:16.0f}"
            f"{size['read_bytes']:14,.0f}{size['read_rate'] / 1e9:7.1f}"
        )
    lines.append("pairs, candidates: a renewal, for each particle; reads: of a step, for each particle")
    return "\n".join([*lines, f"{processor()}: one core moves {triad_rate / 1e9:.1f} GB/s in the triad of STREAM"])


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--spacing", type=float, nargs="+", default=SPACINGS, help="of the particles, m, coarsest first")
    parser.add_argument("--repeats", type=int, default=9, help="turns of which the median is taken")
    parser.add_argument("--particle-steps", type=int, default=PARTICLE_STEPS, help="in a turn, or 4 steps")
    options = parser.parse_args(arguments)
    sizes = with_ratios(measure(list(options.spacing), options.repeats, options.particle_steps))
    found = {"processor": processor(), "triad_rate": bandwidth(), "largest_ratio": max(size["particle_step_ratio"] for size in sizes)}
    hand_out({"sizes": sizes, **found}, table(sizes, found["triad_rate"]), options.json)


if __name__ == "__main__":
    main()
