"""Speed of the solver's core: ``python tests/benchmarks/speed.py [--duration S] [--json FILE]``.

Runs the paper's scene (2,404 particles, support 4.6 m, about 60 neighbours) to the end of a full
collapse, S_R 0.10 and gamma 100, and reports particle-steps/s and directed neighbour interactions/s
averaged over the run, start of the gravity stage to arrest.  At a few moments the run is interrupted
and the parts of a time step are timed one by one on its state; this time is taken off again.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from sph.configuration import dotted
from sph.coupling import update_stress
from sph.integration import advance, kick_and_drift, make_lists
from sph.momentum import stress_accelerations, velocity_gradients
from sph.neighbours import update_pairs
from sph.scene import Scene, load_scene
from sph.solver import Progress, Run
from sph.state import State

PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"
PARTS = ("velocity_gradients", "stress_accelerations", "update_stress", "kick_and_drift", "update_pairs")
REPEATS = 20
PROBED_STEPS = 50


def copy(state: State) -> State:
    return State(*(array.copy() for array in state))


def seconds(call: Callable[[], Any]) -> float:
    """Seconds of a call: the median of ``REPEATS``, after one to warm up."""
    call()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def time_parts(run: Run) -> dict[str, float]:
    """Seconds a time step of each part, on copies of the run's state; and how often the pairs are renewed."""
    terms, mass, loading = run.terms, run.particles.mass, run.loading
    state = copy(run.state)
    candidates, pairs = make_lists(state, terms, mass)
    gradient = np.empty((state.x.size, 4))
    ground, gravity, extra = (float(history[min(run.step, history.size - 1)]) for history in loading)
    velocity_gradients(state, pairs, terms.viscosity, gradient)
    found = {
        "velocity_gradients": seconds(lambda: velocity_gradients(state, pairs, terms.viscosity, gradient)),
        "stress_accelerations": seconds(lambda: stress_accelerations(state, pairs, terms.correction, 0, terms.n_soil)),
    }
    # These three change the state: each has a copy of its own.
    strained, moved = copy(run.state), copy(run.state)
    found["update_stress"] = seconds(lambda: update_stress(strained, pairs, terms, mass, gradient, run.step))
    found["kick_and_drift"] = seconds(lambda: kick_and_drift(moved, terms, mass, ground, gravity, extra))
    one_update = seconds(
        lambda: update_pairs(pairs, candidates, terms.kernel, state.x, state.y, mass, state.density, terms.close_range, terms.correction)
    )
    renewals = 0
    steps = min(PROBED_STEPS, loading.ground.size - 1 - run.step)
    probe = copy(run.state)
    candidates, pairs = make_lists(probe, terms, mass)
    for step in range(run.step, run.step + steps):
        before = probe.x_pairs.copy(), probe.y_pairs.copy()
        candidates, pairs, *_ = advance(probe, candidates, pairs, terms, mass, loading, step, 1)
        renewals += not (np.array_equal(before[0], probe.x_pairs) and np.array_equal(before[1], probe.y_pairs))
    found["renewals_per_step"] = renewals / steps if steps else 0.0
    found["update_pairs"] = one_update * found["renewals_per_step"]
    found["one_update_pairs"] = one_update
    found["neighbours"] = float((run.pairs.end - run.pairs.start[:-1]).mean())
    return found


def measure(scene: Scene, moments: int = 12) -> dict[str, Any]:
    """Run a scene and return its speed; every number is named with its unit."""
    # Compiles or loads everything, so that the run below does not.
    Run(scene.model_copy(update={"duration": scene.outputs.series_interval})).go()

    run = Run(scene)
    samples: list[dict[str, float]] = []
    away = [0.0]
    next_time = [scene.duration / (2 * moments)]

    def look(progress: Progress) -> None:
        if progress.time < next_time[0] or len(samples) == moments:
            return
        start = time.perf_counter()
        samples.append(time_parts(run))
        next_time[0] += scene.duration / moments
        away[0] += time.perf_counter() - start

    result = run.go(report=look)
    attrs = result.trajectory.attrs
    wall = float(attrs["wall_time_s"]) - away[0]
    particle_steps = int(attrs["particle_steps"])
    particles = result.trajectory.sizes["particle"]
    steps = particle_steps // particles
    mean = {name: float(np.mean([sample[name] for sample in samples])) for name in samples[0]}
    step_seconds = wall / steps
    split = {name: mean[name] for name in PARTS}
    split["rest"] = step_seconds - sum(split.values())
    return {
        "scene": scene.name,
        "status": result.status,
        "machine": platform.machine(),
        "active_terms": attrs["active_terms"],
        "particles": particles,
        "steps": steps,
        "particle_steps": particle_steps,
        "wall_time_s": wall,
        "failed_fraction": float(result.trajectory["failed_fraction"][-1]),
        "probe_displacement_y_m": float(result.trajectory["probe_displacement_y"][-1, 0]),
        "neighbours_mean": mean["neighbours"],
        "particle_steps_per_second": particle_steps / wall,
        "interactions_per_second": mean["neighbours"] * particle_steps / wall,
        "renewals_per_step": mean["renewals_per_step"],
        "one_update_pairs_us": 1e6 * mean["one_update_pairs"],
        "step_us": 1e6 * step_seconds,
        "split_us": {name: 1e6 * value for name, value in split.items()},
        "moments": len(samples),
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [
        f"{found['scene']}: {found['particles']:,} particles, {found['steps']:,} steps, {found['status']}, "
        f"{found['failed_fraction']:.0%} failed, A {found['probe_displacement_y_m']:.2f} m",
        f"active terms: {found['active_terms']}",
        f"wall time               {found['wall_time_s']:10.2f} s",
        f"particle-steps          {found['particle_steps_per_second'] / 1e6:10.3f} M/s",
        f"neighbours              {found['neighbours_mean']:10.1f} (directed, mean over {found['moments']} moments)",
        f"interactions            {found['interactions_per_second'] / 1e6:10.1f} M/s (a directed pair in a time step)",
        f"time step               {found['step_us']:10.1f} us, of which",
    ]
    for name, value in found["split_us"].items():
        lines.append(f"  {name:22s}{value:10.1f} us  {value / found['step_us']:6.1%}")
    lines.append(f"pairs are renewed {found['renewals_per_step']:.2f} times a step, {found['one_update_pairs_us']:.0f} us each")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> dict[str, Any]:
    """Parse the command line, measure, print a table and write JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, help="simulated time, s (default: the scene's)")
    parser.add_argument("--moments", type=int, default=12, help="how often the parts are timed")
    parser.add_argument("--json", type=Path, help="file for the numbers")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another value for a key of the scene")
    options = parser.parse_args(arguments)
    overrides: dict[str, Any] = {"coupling.S_R": 0.10, "coupling.gamma": 100.0}
    if options.duration is not None:
        overrides["duration"] = options.duration
    overrides |= dict(setting.split("=", 1) for setting in options.set)
    found = measure(load_scene(PAPER, dotted(overrides)), options.moments)
    print(table(found))
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    return found


if __name__ == "__main__":
    main()
