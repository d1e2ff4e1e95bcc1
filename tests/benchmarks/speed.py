"""Speed of the solver's core: ``python tests/benchmarks/speed.py [--scene FILE] [--duration S] [--json FILE]``.

Runs the paper's scene (2,404 particles, support 4.6 m, about 60 neighbours), or another one, to the end of a full
collapse, S_R 0.10 and gamma 100, and reports particle-steps/s and directed neighbour interactions/s
averaged over the run, start of the gravity stage to arrest.  At a few moments the run is interrupted
and the parts of a time step are timed one by one on its state; this time is taken off again.

Two stages are told apart: the elastic one, while gravity is brought on and nothing fails, and the collapse.  Python needs some
10 us to call a compiled function, which a step inside the solver does not pay: each part is also called for no rows at all, and
that time is subtracted.
"""

from __future__ import annotations

import copy
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measuring import PAPER, command_line, hand_out, medians, scene_of

from sph.scene.schema import Scene
from sph.solver.integration import kick_soil, loads_of
from sph.solver.neighbours import Places, update_pairs
from sph.solver.physics.coupling import update_stress
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.physics.short_range_repulsion import add_repulsion
from sph.solver.renewal import make_lists
from sph.solver.run import Progress, Run
from sph.solver.simulation import Simulation
from sph.solver.terms import State

LOOPS = ("velocity_gradients", "stress_accelerations")
PARTS = (*LOOPS, "update_stress", "kick_soil", "add_repulsion", "update_pairs")
STAGES = ("elastic", "collapse")
PROBED_STEPS = 50


def twin(run: Simulation) -> Simulation:
    """The same moment of a run, which can go on without the run noticing."""
    other = copy.copy(run)
    other.state = State(*(array.copy() for array in run.state))
    other.candidates, other.pairs = make_lists(other.state, run.terms)
    return other


def part_calls(run: Simulation) -> dict[str, Callable[[int], Any]]:
    """Each part of a time step, to be called with the number of rows; those that change the state have a copy of their own."""
    terms, mass, loading, team = run.terms, run.particles.mass, run.loading, run.team[0]
    still, strained, moved, pushed = (twin(run) for _ in range(4))
    pairs, now = still.pairs, min(run.step, loading.time.size - 1)
    loads, state = loads_of(loading, now), still.state
    places = Places(state.x, state.y, state.density)
    return {
        "velocity_gradients": lambda n: velocity_gradients(state, pairs, terms, team.gradient, 0, n),
        "stress_accelerations": lambda n: stress_accelerations(state, pairs, terms, team.strain_rate, 0, min(n, terms.n_soil)),
        "update_stress": lambda n: update_stress(strained.state, pairs, terms, float(loading.time[now]), team, 0, n),
        "kick_soil": lambda n: kick_soil(moved.state, terms, mass, loads, 0, n),
        "add_repulsion": lambda n: add_repulsion(
            terms.short_range_repulsion, terms.periodic, terms.seams, pushed.state, pairs, mass, terms.n_soil, 0, min(n, terms.n_soil)
        ),
        "one_update_pairs": lambda n: update_pairs(pairs, still.candidates, terms, places, 0, n),
    }


def renewals(run: Simulation) -> float:
    """How often in a time step pairs are renewed, over the next ``PROBED_STEPS`` of the scene, at most once in each of these."""
    probe = twin(run)
    steps = min(PROBED_STEPS, (run.loading.time.size - 1) // run.substeps - run.step)
    count = 0
    for _ in range(steps):
        before = probe.state.x_pairs.copy(), probe.state.y_pairs.copy()
        probe.advance_steps(1)
        count += not (np.array_equal(before[0], probe.state.x_pairs) and np.array_equal(before[1], probe.state.y_pairs))
    return count / (steps * run.substeps) if steps else 0.0


def time_parts(run: Simulation) -> dict[str, float]:
    """Seconds a time step of each part on copies of the run's state, without the cost of a call; neighbours and renewals."""
    calls = part_calls(run)
    n = run.state.x.size
    timed = {name: (lambda call=call: call(n)) for name, call in calls.items()}
    empty = {f"no {name}": (lambda call=call: call(0)) for name, call in calls.items()}
    found = medians(timed | empty)
    parts = {name: max(found[name] - found[f"no {name}"], 0.0) for name in calls}
    parts["call"] = float(np.median([found[name] for name in empty]))
    parts["renewals_per_step"] = renewals(run)
    parts["update_pairs"] = parts["one_update_pairs"] * parts["renewals_per_step"]
    parts["neighbours"] = float((run.pairs.end - run.pairs.start).mean())
    return parts


class Watch:
    """Interrupts a run at moments spread evenly over each stage, and keeps apart the time that this takes."""

    def __init__(self, run: Simulation, moments: int) -> None:
        end, last = run.scene.gravity.duration, run.scene.duration
        self.run = run
        self.elastic_end = end + 0.5 * run.terms.dt
        self.due = [start + (k + 0.5) * length / moments for start, length in ((0.0, end), (end, last - end)) for k in range(moments)]
        self.samples: dict[str, list[dict[str, float]]] = {stage: [] for stage in STAGES}
        self.away = 0.0
        self.elastic_wall = 0.0
        self.elastic_steps = 0

    def __call__(self, progress: Progress) -> None:
        stage = STAGES[progress.time > self.elastic_end]
        if stage == "elastic":
            self.elastic_wall, self.elastic_steps = progress.elapsed - self.away, self.run.steps_made
        if self.due and progress.time >= self.due[0]:
            start = time.perf_counter()
            self.samples[stage].append(time_parts(self.run))
            self.due.pop(0)
            self.away += time.perf_counter() - start


def split(samples: list[dict[str, float]], steps: int, wall: float) -> dict[str, Any]:
    """A stage's time step in its parts, us, and the share of the two loops over neighbours."""
    mean = {name: float(np.mean([sample[name] for sample in samples])) for name in samples[0]}
    step = wall / steps
    parts = {name: mean[name] for name in PARTS}
    parts["rest"] = step - sum(parts.values())
    return {
        "steps": steps,
        "wall_time_s": wall,
        "moments": len(samples),
        "step_us": 1e6 * step,
        "split_us": {name: 1e6 * value for name, value in parts.items()},
        "loops_share": sum(mean[name] for name in LOOPS) / step,
        "call_us": 1e6 * mean["call"],
        "neighbours_mean": mean["neighbours"],
        "renewals_per_step": mean["renewals_per_step"],
        "one_update_pairs_us": 1e6 * mean["one_update_pairs"],
    }


def joined(stages: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Both stages together: times and counts a step are means over the steps."""
    steps = sum(stage["steps"] for stage in stages.values())

    def mean(value: Callable[[dict[str, Any]], float]) -> float:
        return sum(stage["steps"] * value(stage) for stage in stages.values()) / steps

    parts = {name: mean(lambda stage, name=name: stage["split_us"][name]) for name in (*PARTS, "rest")}  # type: ignore[misc]
    names = ("step_us", "call_us", "neighbours_mean", "renewals_per_step", "one_update_pairs_us")
    whole = {name: mean(lambda stage, name=name: stage[name]) for name in names}  # type: ignore[misc]
    whole |= {"steps": steps, "split_us": parts, "loops_share": sum(parts[name] for name in LOOPS) / whole["step_us"]}
    return whole | {name: sum(stage[name] for stage in stages.values()) for name in ("wall_time_s", "moments")}


def measure(scene: Scene, moments: int) -> dict[str, Any]:
    """Run a scene and return its speed; every number is named with its unit."""
    # Compiles or loads everything, so that the run below does not.
    first = Run(scene.model_copy(update={"duration": scene.outputs.series_interval}))
    first.go()
    time_parts(first.simulation)

    started = Run(scene)
    run = started.simulation
    watch = Watch(run, moments)
    result = started.go(report=watch)
    attrs = result.trajectory.attrs
    particles = result.trajectory.sizes["particle"]
    wall = float(attrs["wall_time_s"]) - watch.away
    stages = {
        "elastic": split(watch.samples["elastic"], watch.elastic_steps, watch.elastic_wall),
        "collapse": split(watch.samples["collapse"], run.steps_made - watch.elastic_steps, wall - watch.elastic_wall),
    }
    whole = joined(stages)
    particle_steps = int(attrs["particle_steps"])
    return {
        "scene": scene.name,
        "status": result.status,
        "machine": platform.machine(),
        "active_terms": attrs["active_terms"],
        "particles": particles,
        "particle_steps": particle_steps,
        "failed_fraction": float(result.trajectory["failed_fraction"][-1]),
        "probe_displacement_y_m": float(result.trajectory["probe_displacement_y"][-1, 0]),
        "particle_steps_per_second": particle_steps / wall,
        "interactions_per_second": whole["neighbours_mean"] * particle_steps / wall,
        **whole,
        "stages": stages,
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    columns = {"whole run": found, **found["stages"]}
    lines = [
        f"{found['scene']}: {found['particles']:,} particles, {found['steps']:,} steps, {found['status']}, "
        f"{found['failed_fraction']:.0%} failed, A {found['probe_displacement_y_m']:.2f} m",
        f"active terms: {found['active_terms']}",
        f"wall time               {found['wall_time_s']:10.2f} s",
        f"particle-steps          {found['particle_steps_per_second'] / 1e6:10.3f} M/s",
        f"neighbours              {found['neighbours_mean']:10.1f} (directed, mean over the run)",
        f"interactions            {found['interactions_per_second'] / 1e6:10.1f} M/s (a directed pair in a time step)",
        f"pairs are renewed {found['renewals_per_step']:.2f} times a step, {found['one_update_pairs_us']:.0f} us each; "
        f"a call from Python of {found['call_us']:.1f} us is not counted",
        " " * 24 + "".join(f"{name:>20s}" for name in columns),
        "time step, us           " + "".join(f"{column['step_us']:20.1f}" for column in columns.values()),
    ]
    for name in found["split_us"]:
        parts = ((column["split_us"][name], column["step_us"]) for column in columns.values())
        lines.append(f"  {name:22s}" + "".join(f"{part:12.1f} {part / step:7.1%}" for part, step in parts))
    lines.append("the two loops           " + "".join(f"{column['loops_share']:20.1%}" for column in columns.values()))
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--scene", type=Path, default=PAPER, help="scene file (default: the paper's)")
    parser.add_argument("--duration", type=float, help="simulated time, s (default: the scene's)")
    parser.add_argument("--moments", type=int, default=6, help="how often the parts are timed in each stage")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another value for a key of the scene")
    options = parser.parse_args(arguments)
    overrides: dict[str, Any] = {"coupling.S_R": 0.10, "coupling.gamma": 100.0}
    if options.duration is not None:
        overrides["duration"] = options.duration
    found = measure(scene_of(options.scene, overrides, options.set), options.moments)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
