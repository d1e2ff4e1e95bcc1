"""Several threads against one on a large scene: ``python tests/benchmarks/threads.py [--threads N] [--json FILE]``.

Two runs of the same slope of 108,000 particles, one with one thread and one with more, take turns and must have
the same bits in the end.
"""

from __future__ import annotations

from typing import Any

from measuring import at_rest, command_line, hand_out, medians

from sph.solver.simulation import Simulation


def bits(run: Simulation) -> bytes:
    """The whole state of a run."""
    return b"".join(array.tobytes() for array in run.state)


def measure(spacing: float, threads: int, steps: int, repeats: int) -> dict[str, Any]:
    """Milliseconds a time step with one thread and with several, and whether the state is the same."""
    runs = {"one": at_rest(spacing), "several": at_rest(spacing, threads)}

    def advance(name: str) -> None:
        assert runs[name].advance_steps(steps) == (0, steps)

    found = medians({name: (lambda name=name: advance(name)) for name in runs}, repeats)
    return {
        "particles": runs["one"].state.x.size,
        "neighbours_mean": float((runs["one"].pairs.end - runs["one"].pairs.start).mean()),
        "threads": threads,
        "steps": runs["several"].step,
        "same_bits": bits(runs["one"]) == bits(runs["several"]),
        "one_ms": 1e3 * found["one"] / steps,
        "several_ms": 1e3 * found["several"] / steps,
        "speedup": found["one"] / found["several"],
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    return (
        f"{found['particles']:,} particles, {found['steps']} steps: one thread {found['one_ms']:.2f} ms a step, "
        f"{found['threads']} threads {found['several_ms']:.2f} ms, {found['speedup']:.2f} times as fast; "
        f"{'the same' if found['same_bits'] else 'OTHER'} bits"
    )


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a line and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--spacing", type=float, default=0.14, help="of the particles, m")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--steps", type=int, default=20, help="in a turn")
    parser.add_argument("--repeats", type=int, default=9, help="turns of which the median is taken")
    options = parser.parse_args(arguments)
    found = measure(options.spacing, options.threads, options.steps, options.repeats)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
