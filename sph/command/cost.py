"""What a study will cost before it is run (``sph cost``), from ``sph.study.cost`` and the speed of this machine.

The speed is measured where it can be: on finished jobs of the study, else on a coarse copy of a run here; ``--speed`` gives that of
another machine.  Runs share the gravity stage and continue from it; the shaking up to the first failure is counted with them, and so is
the preflight.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from sph.command.status import Stand, State, look_at
from sph.command.study import find_study
from sph.jobs.ahead import TOGETHER
from sph.jobs.known_errors import CHECKED
from sph.scene.configuration import merge
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.scene.strict_json import to_json
from sph.solver.run import Progress, Run
from sph.study.cost import COMPILE, START, TAKE_UP, Cost, cost, job_cost
from sph.study.machine import duration
from sph.study.plan import Plan
from sph.study.preflight import MAX_SCENES, preflight_searches, preflight_seconds
from sph.study.runs import Kind

CALIBRATION, LONGEST, FEWEST = 1.0, 5.0, 400
"""Computing time of the measurement of a machine's speed, s; what ends it, s; and the particles of its scene."""
TABLES, TABLES_A_RUN = 18.0, 0.1
"""Seconds of computing of tables, claims, figures and page, and of these for each run (measured)."""

PREFLIGHT_FILE = "preflight.csv"
"""What the preflight of a study writes, after ``CHECKED``."""


class Speed(NamedTuple):
    """A machine's speed over that of the reference machine, and how it is known."""

    value: float
    known_by: str


class StudyCost(NamedTuple):
    """What a study needs in total, and for what is left of it."""

    folder: str
    runs: int
    jobs: int
    jobs_left: int
    particles: int  # of the longest run
    steps: int  # of the longest run
    run: float  # s, the longest run from its gravity stage to its end
    shared: float  # s on one core, of the stages that runs share: gravity, and the shaking up to the first failure
    computing: float  # s on one core, of everything
    left: float  # s on one core, of jobs that are not done
    wall: float  # s on the cores, of what is left, the preflight included
    cores: int
    memory: float  # MiB, of as many jobs at once as there are cores, a search among them
    disk: float  # MiB
    speed: Speed


def cost_of_study(study: Path, fidelity: str | None, cores: int, speed: float | None, start: float, as_json: bool) -> str:
    """The prediction for a study's configuration, in words or for machines."""
    if speed is not None and not 1e-3 <= speed <= 1e3:
        raise ValueError(f"--speed {speed:g}: must be from 0.001 to 1000")
    catalogue = find_study(study)
    plan = catalogue.plan
    if fidelity is not None:
        check_known("--fidelity", [fidelity], plan.study.fidelities)
        plan = plan.at(fidelity)
    found = study_cost(plan, catalogue.base, cores, speed, start)
    return to_json(record(found), indent=1) if as_json else "\n".join(lines(found))


def study_cost(plan: Plan, base: Path, cores: int, speed: float | None = None, start: float = START) -> StudyCost:
    """Predict a study on a number of cores; ``speed`` over the reference machine's, measured by default.

    ``start`` is the time of a job besides its computing, s: more on a cluster than on one machine.
    """
    states = look_at(plan.jobs, base)
    known = Speed(speed, "as given") if speed else measured_speed(states)
    found = [(state, job_cost(state.job.run)) for state in states]
    times = [_started(part, state, start) + part.seconds / known.value for state, part in found]
    tests, limits = preflight_seconds(_looked_at(plan), preflight_searches(plan.study.searches, bool(plan.searches)))
    checks = {CHECKED: start + tests / known.value, PREFLIGHT_FILE: start + limits / known.value}
    test_left, limits_left = (0.0 if (base / plan.folder / file).exists() else time for file, time in checks.items())
    waits = [time for time, state in zip(times, states, strict=True) if state.state != Stand.DONE]
    slowest: dict[Kind, float] = {}
    for state, time in zip(states, times, strict=True):
        if state.state != Stand.DONE:
            slowest[state.job.run.kind] = max(time, slowest.get(state.job.run.kind, 0.0))
    search = slowest.pop(Kind.SEARCH, 0.0)
    longest = max((part for state, part in found if state.job.run.kind == Kind.RUN), key=lambda part: part.seconds)
    runs, at_once = sum(state.job.run.kind == Kind.RUN for state in states), min(cores, len(states))
    after = (TABLES + TABLES_A_RUN * runs) / known.value
    left = sum(waits) + limits_left + after * bool(waits)
    return StudyCost(
        plan.folder,
        runs,
        len(states),
        len(waits),
        longest.particles,
        longest.steps,
        longest.seconds / known.value,
        sum(part.seconds for state, part in found if state.job.run.kind not in (Kind.RUN, Kind.SEARCH)) / known.value,
        sum(times) + sum(checks.values()) + after,
        test_left + left,
        # The tests first, alone; then one stage after another, however many cores there are; the searches beside them.
        test_left + max(left / cores, max(sum(slowest.values()), search, limits_left) + after * bool(waits) / min(cores, 8)),
        cores,
        (at_once - 1) * longest.memory + max(part.memory for _, part in found),
        sum(part.disk for _, part in found),
        known,
    )


def _started(part: Cost, state: State, start: float) -> float:
    """The time of a job besides its computing, s: short runs share it (``sph.jobs.ahead``)."""
    return start if state.job.run.kind == Kind.SEARCH else min(TAKE_UP + start * part.seconds / TOGETHER, start)


def _looked_at(plan: Plan) -> dict[str, Scene]:
    """The scenes that the preflight looks at, by run."""
    return {name: plan.built(**plan.study.runs[name]) for name in plan.study.shown_runs(MAX_SCENES)}


def measured_speed(states: Sequence[State]) -> Speed:
    """Speed on the finished runs of a study, else here."""
    ratios = [
        cost(state.job.scene).seconds / state.computed
        for state in states
        if state.state == Stand.DONE and state.job.run.kind == Kind.RUN and state.computed > 0
    ]
    if ratios:
        return Speed(statistics.median(ratios), f"from {len(ratios)} finished run{'s' if len(ratios) > 1 else ''}")
    return Speed(speed_here(states[0].job.scene), "measured here on a coarse copy of a run")


def speed_here(scene: Scene) -> float:
    """Speed of this machine, on a coarse copy of a scene from start to end; compiles if the cache is empty.

    Debris and soil at rest take different times on different machines, so that the beginning of the scene alone is not enough.
    """
    seen: list[Progress] = []

    def look_at(progress: Progress) -> None:
        seen[:] = [progress]
        if progress.elapsed > LONGEST:
            raise _Enough

    copy = coarse(scene)
    with suppress(_Enough):
        Run(copy).go(report=look_at)
    expected, last = cost(copy, until=seen[0].time), seen[0]
    return expected.seconds * last.particle_steps / (expected.particles * expected.steps) / last.elapsed


class _Enough(Exception):
    """Ends a measurement."""


def coarse(scene: Scene) -> Scene:
    """A scene with the longest time step that its motion bears, coarsened until it takes ``CALIBRATION`` or has ``FEWEST`` particles."""
    quick = _quick(scene)
    expected = cost(quick)
    ratio = min(expected.seconds / CALIBRATION, expected.particles / FEWEST)
    return make_scene(merge(quick.model_dump(), {"numerics": {"spacing": scene.numerics.spacing * math.sqrt(max(ratio, 1.0))}}))


def _quick(scene: Scene) -> Scene:
    """A scene with the longest time step between the samples of its series and its own; adaptive steps are at most as long."""
    series = scene.outputs.series_interval
    own = round(series / scene.numerics.time_step)
    for parts in range(1, own):
        if own % parts == 0:
            with suppress(ValueError):  # a step that skips samples of a record, or is too long for a period
                return _stepped(scene, series / parts)
    return _stepped(scene, scene.numerics.time_step)


def _stepped(scene: Scene, step: float) -> Scene:
    return make_scene(merge(scene.model_dump(), {"numerics": {"time_step": step, "adaptive_step": {"courant": 0.8}}}))


def lines(found: StudyCost) -> list[str]:
    """The prediction in words."""
    done = found.jobs - found.jobs_left
    rows = [
        ("study", f"{found.folder}: {found.runs:,} runs, {found.jobs:,} simulations" + (f", {done:,} done" if done else "")),
        ("a run", f"{_time(found.run)} of one core: {found.particles:,} particles, {found.steps:,} steps after the gravity stage"),
        (
            "stages",
            f"{_time(found.shared)} of one core: gravity and the shaking up to the first failure, once for all runs that share them",
        ),
        ("computing", f"{found.computing / 3600:.3g} core-hours" + (f", {found.left / 3600:.3g} of them still to do" if done else "")),
        ("wall time", f"{_time(found.wall)} on {found.cores} core{'s' if found.cores > 1 else ''}"),
        ("memory", f"{_size(found.memory)} for {min(found.cores, found.jobs)} jobs at once"),
        ("disk", f"{_size(found.disk)} of trajectories"),
        ("speed", f"{found.speed.value:.2f} of the reference machine's, {found.speed.known_by}"),
        (
            "compiling",
            f"about {COMPILE:.0f} s the first time a machine compiles a kind of scene, twice that with the yield-acceleration search",
        ),
    ]
    return [f"{label:<10} {text}" for label, text in rows]


def _time(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds < 10 else duration(seconds)


def _size(mebibytes: float) -> str:
    return f"{mebibytes:.3g} MiB" if mebibytes < 1000 else f"{mebibytes / 1024:.3g} GiB"


def record(found: StudyCost) -> dict[str, Any]:
    """The prediction for machines: times in s, memory and disk in MiB."""
    return found._asdict() | {"speed": found.speed.value, "known_by": found.speed.known_by}
