"""What a study will cost before it is run (``sph cost``), from ``sph.study.cost`` and the speed of this machine.

The speed is measured where it can be: on finished jobs of the study, else on a coarse copy of a run here; ``--speed`` gives that of
another machine.  Runs share the gravity stage and continue from it; the shaking up to the first failure is counted with them, and so is
the preflight.  On a graphics card (``--backend cuda``) all runs of a kind advance together; its speed is measured on the card of this
machine, else it is that of an H200.
"""

from __future__ import annotations

import math
import statistics
import time as clock
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from sph.command.status import BESIDE, Stand, State, look_at, speeds, tests_left
from sph.command.study import find_study
from sph.experiments.variants.second_spacing import DECIDING, MOST_DECIDING
from sph.jobs.ahead import AT_ONCE, TOGETHER
from sph.scene.configuration import merge
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.scene.strict_json import to_json
from sph.solver.backends import BACKENDS, ENOUGH, Member
from sph.solver.cuda.ensemble import Ensemble, card, describe_card, memory_of
from sph.solver.run import Progress, Run
from sph.solver.simulation import Simulation
from sph.study.cost import CARD_RATE, CARD_START, CARD_STEP, COMPILE, PROCESS, START, TAKE_UP, Cost, cost, job_cost
from sph.study.machine import duration
from sph.study.plan import Plan
from sph.study.preflight import plan_seconds
from sph.study.runs import SIMULATION, Kind

CALIBRATION, LONGEST, FEWEST = 1.0, 5.0, 400
"""Computing time of the measurement of a machine's speed, s; what ends it, s; and the particles of its scene."""
BLOCKS, COPIES = 10, 64
"""Intervals of the series in which a card's speed is measured, and most runs that then advance together."""
MIB = 2.0**20
TABLES, TABLES_A_RUN = 18.0, 0.1
"""Seconds of computing of tables, claims, figures and page, and of these for each run (measured)."""


class Speed(NamedTuple):
    """A machine's speed over that of the reference machine, and how it is known."""

    value: float
    known_by: str


class CardCost(NamedTuple):
    """What a study needs of a graphics card."""

    left: float  # s, of runs and stages that are not done
    speed: Speed  # particle-steps a second
    together: int  # runs that advance together
    memory: float  # MiB of the card, a run; NaN where what drives a card is not installed


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
    repeats: float  # s on one core, at most, of runs that are repeated at a finer spacing where not all are at another
    searches: float  # s on one core, of static tests and the searches for limits of the slopes
    computing: float  # s on one core, of everything
    left: float  # s on one core, of jobs that are not done
    wall: float  # s on the cores, of what is left, the preflight included
    cores: int
    memory: float  # MiB, of as many jobs at once as there are cores, a search among them; or of the runs together on a card
    disk: float  # MiB
    speed: Speed
    card: CardCost | None


def cost_of_study(
    study: Path, fidelity: str | None, cores: int, speed: float | None, start: float, backend: str | None, as_json: bool
) -> str:
    """The prediction for a study's configuration, in words or for machines."""
    if speed is not None and not 1e-3 <= speed <= 1e3:
        raise ValueError(f"--speed {speed:g}: must be from 0.001 to 1000")
    check_known("--backend", [backend] if backend else (), BACKENDS)
    catalogue = find_study(study)
    plan = catalogue.plan
    if fidelity is not None:
        check_known("--fidelity", [fidelity], plan.study.fidelities)
        plan = plan.at(fidelity)
    needs = study_cost(plan, catalogue.base, cores, speed, start, (backend or plan.study.backend) != "cpu")
    return to_json(record(needs), indent=1) if as_json else "\n".join(lines(needs))


def study_cost(plan: Plan, base: Path, cores: int, speed: float | None = None, start: float = START, on_card: bool = False) -> StudyCost:
    """Predict a study on a number of cores; ``speed`` over the reference machine's, measured by default.

    ``start`` is the time of a job besides its computing, s: more on a cluster than on one machine.  With ``on_card`` a graphics card makes
    runs and stages, and the cores the rest.
    """
    states = look_at(plan.jobs, base)
    known = Speed(speed, "as given") if speed else measured_speed(states)
    costs = [(state, job_cost(state.job.run)) for state in states]
    of_card = _card_cost(costs, start) if on_card else None
    times = [
        TAKE_UP if of_card and state.job.run.by == SIMULATION else _started(part, state, start) + part.seconds / known.value
        for state, part in costs
    ]
    tests = dict(zip(BESIDE, plan_seconds(plan), strict=True))
    checks = {job: start + seconds / known.value for job, seconds in tests.items()}
    checks_left = sum(checks[job] for job in tests_left(plan, base))
    waits = [time for time, state in zip(times, states, strict=True) if state.state != Stand.DONE]
    slowest: dict[Kind, float] = {}
    for state, time in zip(states, times, strict=True):
        if state.state != Stand.DONE:
            slowest[state.job.run.kind] = max(time, slowest.get(state.job.run.kind, 0.0))
    search = slowest.pop(Kind.SEARCH, 0.0)
    longest = max((part for state, part in costs if state.job.run.kind == Kind.RUN), key=lambda part: part.seconds)
    runs, at_once = sum(state.job.run.kind == Kind.RUN for state in states), min(cores, len(states))
    repeats = 0.0
    if plan.second and not plan.repeats_all:
        repeats = MOST_DECIDING * max(start + job_cost(run).seconds / known.value for run in plan.second.shared.runs.values())
    repeats_left = repeats * (not (base / plan.folder / DECIDING).is_file())
    after = (TABLES + TABLES_A_RUN * runs) / known.value
    left = sum(waits) + checks_left + repeats_left + after * bool(waits)
    # One stage after another, however many cores there are; the searches beside them.
    stages = of_card.left if of_card else sum(slowest.values())
    memory = (at_once - 1) * longest.memory + max(part.memory for _, part in costs)
    if of_card:
        memory = PROCESS + of_card.together * (longest.memory - PROCESS)
    return StudyCost(
        plan.folder,
        runs,
        len(states),
        len(waits),
        longest.particles,
        longest.steps,
        longest.seconds / known.value,
        sum(part.seconds for state, part in costs if state.job.run.kind not in (Kind.RUN, Kind.SEARCH)) / known.value,
        repeats,
        (sum(part.seconds for state, part in costs if state.job.run.kind == Kind.SEARCH) + sum(tests.values())) / known.value,
        sum(times) + sum(checks.values()) + repeats + after,
        left,
        max(left / cores, max(stages, search, checks_left) + after * bool(waits) / min(cores, 8)),
        cores,
        memory,
        sum(part.disk for _, part in costs),
        known,
        of_card,
    )


def _card_cost(costs: Sequence[tuple[State, Cost]], start: float) -> CardCost:
    """What runs and stages need of a card: those of a kind advance together, one kind after another."""
    runs = [(state, part) for state, part in costs if state.job.run.kind == Kind.RUN]
    state, part = max(runs, key=lambda run: run[1].seconds)
    together, memory = max(1, min(len(runs), AT_ONCE, ENOUGH // part.particles)), math.nan
    if find_spec("numba_cuda") is not None:
        memory = sum(pack.size for pack in memory_of(Simulation(state.job.scene, enforce_limit=False))) / MIB
    try:
        card()
    except ValueError:
        rate = min(CARD_RATE, together * part.particles / CARD_STEP)
        speed = Speed(rate, "as measured on an H200; there is no card here")
    else:
        speed = card_speed_here(state.job.scene, min(together, COPIES))
    waiting = [(state.job.run.kind, part) for state, part in costs if state.job.run.by == SIMULATION and state.state != Stand.DONE]
    left = math.ceil(len(waiting) / AT_ONCE) * (start + CARD_START)
    for kind in {kind for kind, _ in waiting}:
        parts = [part for own, part in waiting if own == kind]
        left += max(sum(part.particles * part.steps for part in parts) / speed.value, CARD_STEP * max(part.steps for part in parts))
    return CardCost(left, speed, together, memory)


def card_speed_here(scene: Scene, copies: int) -> Speed:
    """Speed of the card of this machine, on copies of a scene that advance together at its start."""
    on = Ensemble(copies)
    times: list[list[float]] = [[] for _ in range(copies)]

    def call(number: int) -> None:
        def look(_: Progress) -> None:
            times[number].append(clock.perf_counter())
            if len(times[number]) > BLOCKS:
                raise _Enough

        with suppress(_Enough):
            Run(scene, backend=Member(on), enforce_limit=False).go(report=look)

    for result in on.carry([partial(call, number) for number in range(copies)]):
        if isinstance(result, BaseException):
            raise result
    # The first interval compiles.
    seconds = max(seen[-1] for seen in times) - max(seen[0] for seen in times)
    steps = (min(map(len, times)) - 1) * scene.steps(scene.outputs.series_interval)
    return Speed(copies * steps * cost(scene).particles / seconds, f"measured here on {copies} runs together, {describe_card()}")


def _started(part: Cost, state: State, start: float) -> float:
    """The time of a job besides its computing, s: short runs share it (``sph.jobs.ahead``)."""
    return start if state.job.run.kind == Kind.SEARCH else min(TAKE_UP + start * part.seconds / TOGETHER, start)


def measured_speed(states: Sequence[State]) -> Speed:
    """Speed on the finished runs of a study, else here."""
    ratios = list(speeds(states))
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


def lines(needs: StudyCost) -> list[str]:
    """The prediction in words."""
    done, on_card = needs.jobs - needs.jobs_left, needs.card
    size = f"{needs.particles:,} particles, {needs.steps:,} steps after the gravity stage"
    at_once = f"{on_card.together} runs" if on_card else f"{min(needs.cores, needs.jobs)} jobs"
    stages = "gravity and the shaking up to the first failure, once for all runs that share them"
    rows = [
        ("study", f"{needs.folder}: {needs.runs:,} runs, {needs.jobs:,} simulations" + (f", {done:,} done" if done else "")),
        ("a run", size if on_card else f"{_time(needs.run)} of one core: {size}"),
        ("stages", stages if on_card else f"{_time(needs.shared)} of one core: {stages}"),
        ("computing", f"{needs.computing / 3600:.3g} core-hours" + (f", {needs.left / 3600:.3g} of them still to do" if done else "")),
        ("wall time", f"{_time(needs.wall)} on {needs.cores} core{'s' if needs.cores > 1 else ''}" + " and a card" * (on_card is not None)),
        ("memory", f"{_size(needs.memory)} for {at_once} at once"),
        ("disk", f"{_size(needs.disk)} of trajectories"),
        ("speed", f"{needs.speed.value:.2f} of the reference machine's, {needs.speed.known_by}"),
        (
            "compiling",
            f"about {COMPILE:.0f} s the first time a machine compiles a kind of scene, twice that with the yield-acceleration search",
        ),
    ]
    if needs.repeats:
        what = f"of at most {MOST_DECIDING} runs with finer particles, which decide in what shaking the slope fails"
        rows.insert(3, ("repeats", f"{_time(needs.repeats)} of one core: {what}"))
    if needs.searches:
        what = "static tests, factors of safety, yield accelerations; less of these with searches: quick or none in the study"
        rows.insert(
            3, ("searches", f"{_time(needs.searches)} of one core, {needs.searches / needs.computing:.0%} of the computing: {what}")
        )
    if on_card:
        each = "unknown without numba-cuda" if math.isnan(on_card.memory) else f"{_size(on_card.memory)} of its memory a run"
        rows.insert(-5, ("card", f"{_time(on_card.left)}, {on_card.together} runs together, {each}"))
        rows.insert(-5, ("its speed", f"{on_card.speed.value / 1e6:,.0f} M particle-steps/s, {on_card.speed.known_by}"))
    return [f"{label:<10} {text}" for label, text in rows]


def _time(seconds: float) -> str:
    return f"{seconds:.2g} s" if seconds < 10 else duration(seconds)


def _size(mebibytes: float) -> str:
    return f"{mebibytes:.3g} MiB" if mebibytes < 1000 else f"{mebibytes / 1024:.3g} GiB"


def record(needs: StudyCost) -> dict[str, Any]:
    """The prediction for machines: times in s, memory and disk in MiB."""
    return _plain(needs) | {"card": needs.card and _plain(needs.card)}


def _plain(needs: StudyCost | CardCost) -> dict[str, Any]:
    return needs._asdict() | {"speed": needs.speed.value, "known_by": needs.speed.known_by}
