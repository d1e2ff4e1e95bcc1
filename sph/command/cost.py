"""What a study will cost before it is run (``sph cost``), by ``sph.analysis.cost`` and the speed of the machine at hand.

The speed is measured where it can be: on finished jobs of the study, else by a second of its gravity stage here; ``--speed`` gives that of
another machine.  Runs share the gravity stage and go on from it; the shaking up to the first failure is counted with them.
"""

from __future__ import annotations

import statistics
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from sph.analysis.cost import COMPILE, START, Cost, cost, search_cost
from sph.analysis.study import Plan
from sph.command.status import RUNS, SEARCH, State, duration, jobs, look
from sph.scene import Scene
from sph.solver import Run

CALIBRATION = 1.0
"""Computing time of the measurement of a machine's speed, s."""
TABLES, TABLES_A_RUN = 30.0, 0.3
"""Seconds of computing of tables, claims, figures and page, and of these for each run (measured)."""


class Speed(NamedTuple):
    """A machine's speed over that of the reference machine, and how it is known."""

    value: float
    known_by: str


class StudyCost(NamedTuple):
    """What a study asks for, all of it and what of it is left."""

    folder: str
    runs: int
    jobs: int
    jobs_left: int
    particles: int  # of the largest scene
    steps: int  # of the longest run
    run: float  # s, the longest run from its gravity stage to its end
    computing: float  # s on one core, of everything
    left: float  # s on one core, of jobs that are not done
    wall: float  # s on the cores, of what is left
    cores: int
    memory: float  # MiB, of as many jobs at once as there are cores
    disk: float  # MiB
    speed: Speed


def study_cost(plan: Plan, folder: Path, cores: int, speed: float | None = None) -> StudyCost:
    """Predict a study on a number of cores of one machine; ``speed`` over the reference machine's, measured by default."""
    states = [look(job, folder) for job in jobs(plan)]
    known = Speed(speed, "as given") if speed else measured_speed(states)
    found = [(state, _part(state)) for state in states]
    times = [START + part.seconds / known.value for _, part in found]
    waits = [time for time, state in zip(times, states, strict=True) if state.state != "done"]
    kinds: dict[str, float] = {}
    for (state, _), time in zip(found, times, strict=True):
        if state.state != "done" and state.job.kind != SEARCH:
            kinds[state.job.kind] = max(time, kinds.get(state.job.kind, 0.0))
    longest = max((part for state, part in found if state.job.kind == RUNS), key=lambda part: part.seconds)
    runs = sum(state.job.kind == RUNS for state in states)
    after = (TABLES + TABLES_A_RUN * runs) / known.value
    left = sum(waits) + after * bool(waits)
    return StudyCost(
        plan.folder,
        runs,
        len(states),
        len(waits),
        max(part.particles for _, part in found),
        longest.steps,
        longest.seconds / known.value,
        sum(times) + after,
        left,
        # One stage after another however many cores there are; the figures need one another least of all.
        max(left / cores, sum(kinds.values()) + after * bool(waits) / min(cores, 8)),
        cores,
        min(cores, len(states)) * max(part.memory for _, part in found),
        sum(part.disk for _, part in found),
        known,
    )


def _part(state: State) -> Cost:
    """The part of its scene that a job computes."""
    scene, settled = state.job.scene, state.job.scene.gravity.duration
    if state.job.kind == SEARCH:
        return search_cost(scene)
    if state.job.kind == RUNS:
        return cost(scene, since=settled)
    return cost(scene, *((0.0, settled) if state.job.group == "gravity" else (settled, settled + scene.outputs.series_interval)))


def measured_speed(states: Sequence[State]) -> Speed:
    """Speed on the finished runs of a study, else here."""
    ratios = [
        cost(state.job.scene).seconds / state.computed
        for state in states
        if state.state == "done" and state.job.kind == RUNS and state.computed > 0
    ]
    if ratios:
        return Speed(statistics.median(ratios), f"by {len(ratios)} finished run{'s' if len(ratios) > 1 else ''}")
    return Speed(speed_here(states[0].job.scene), f"measured here for {CALIBRATION:g} s")


def speed_here(scene: Scene) -> float:
    """Speed of this machine, from the first second or so of computing a scene; compiles if nobody has yet."""
    run, block = Run(scene), scene.steps(scene.outputs.series_interval)
    run.prepare()
    run.advance_steps(block)  # the first steps are slower
    started, first = clock.perf_counter(), run.step
    last = scene.steps(scene.gravity.duration)
    while run.step + block <= last and clock.perf_counter() - started < CALIBRATION:
        run.advance_steps(block)
    elapsed, done = clock.perf_counter() - started, run.step - first
    if not done:
        return 1.0
    stage = cost(scene, until=scene.gravity.duration)
    return stage.seconds / stage.steps * (run.steps_made - first) / elapsed


def lines(found: StudyCost) -> list[str]:
    """The prediction in words."""
    done = found.jobs - found.jobs_left
    rows = [
        ("study", f"{found.folder}: {found.runs:,} runs, {found.jobs:,} simulations" + (f", {done:,} done" if done else "")),
        ("a run", f"{_time(found.run)} of one core: {found.particles:,} particles, {found.steps:,} steps after the gravity stage"),
        ("computing", f"{found.computing / 3600:.3g} core-hours" + (f", {found.left / 3600:.3g} of them left" if done else "")),
        ("wall time", f"{_time(found.wall)} on {found.cores} cores of one machine"),
        ("memory", f"{found.memory / 1024:.1f} GiB for {found.cores} runs at once"),
        ("disk", f"{found.disk / 1024:.2f} GiB of trajectories"),
        ("speed", f"{found.speed.value:.2f} of the reference machine's, {found.speed.known_by}"),
        ("on top", f"about {COMPILE:.0f} s the first time a machine compiles a kind of scene, twice with the yield acceleration's"),
    ]
    return [f"{label:<10} {text}" for label, text in rows]


def _time(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds < 10 else duration(seconds)


def record(found: StudyCost) -> dict[str, Any]:
    """The prediction for machines: times in s, memory and disk in MiB."""
    return found._asdict() | {"speed": found.speed.value, "known_by": found.speed.known_by}
