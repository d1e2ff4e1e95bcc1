"""Progress of a study, for a second terminal (``sph status``): nothing is written, locked or started.

Snakemake counts its steps in its own terminal; what a run has simulated, what failed and why, and the time left stand here.

A job is *done* when its file is there and holds the scene of the configuration; *outdated*, and to be made again, when it holds another.
Without a file it is *running* while the process in its log runs (on another machine: while its log is fresh), *failed* when its log ends
with a reason, *stopped* when it was killed (it continues from its checkpoint), else *waiting*.  Whether edited sources ask for a
rerun is for ``snakemake -n`` to say.  What goes on beside the simulations, as tests of the slopes, figures and page, is named while its
process runs and where it has failed.  Targets beside the study count once they have been started (``sph.jobs.catalogue``).

The time left is what running jobs say themselves, or what finished ones of the kind took by their benchmarks (runs: those that share their
shaking up to the first failure), or what ``sph.study.cost`` predicts at the speed of those that are done, over the number at work.  Static
tests and searches for limits of the slopes count.
"""

from __future__ import annotations

import csv
import functools
import itertools
import math
import statistics
import sys
import time as clock
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4

from sph.command.study import find_study
from sph.jobs.ahead import finished
from sph.jobs.log import Log, read_log
from sph.scene.schema import Scene
from sph.scene.strict_json import to_json
from sph.storage.files import beside
from sph.study.cost import TRIALS, cost, job_cost
from sph.study.machine import duration
from sph.study.plan import Plan
from sph.study.planned import differing
from sph.study.preflight import plan_seconds
from sph.study.runs import Kind, PlannedRun

REFRESH = 2.0
"""Wall time between looks of ``--watch``, s."""
LISTED = 10
"""Most jobs of a state that are named."""
CLEAR = "\x1b[H\x1b[J"
"""Empties a terminal."""
LOCKS = ".snakemake/locks"
"""What Snakemake keeps in a working folder while it is at work there, and leaves when it is killed."""
LOCKED = (
    "Snakemake is starting or was killed, which leaves this folder locked; if none is at work here: your snakemake command once with "
    "--unlock added, then without it and with --rerun-incomplete"
)
TITLES = {
    Kind.GRAVITY: "gravity stage",
    Kind.PRE_FAILURE: "shaking to the first failure",
    Kind.RUN: "runs",
    Kind.SEARCH: "yield acceleration",
}
"""The kinds in words."""
BESIDE = {"check": "static tests of the slopes", "preflight": "searches for limits of the slopes"}
"""Jobs of computing beside the simulations, by their logs, and what they do."""
MADE = {"check": "checked.csv", "preflight": "preflight.csv"}
"""What they write into the folder of results."""
SAMPLED = 20
"""Most finished runs by which the speed of the machine is known here."""


class Stand(StrEnum):
    """How a job stands; see above."""

    DONE = "done"
    RUNNING = "running"
    FAILED = "failed"
    STOPPED = "stopped"
    OUTDATED = "outdated"
    WAITING = "waiting"


class Job(NamedTuple):
    """A run of the catalogue with its scene built."""

    run: PlannedRun
    scene: Scene

    @property
    def is_run(self) -> bool:
        """Whether it runs to the end of its scene, unlike a stage or a search."""
        return self.run.kind == Kind.RUN

    @property
    def title(self) -> str:
        """What it is, in words: its row of the overview."""
        return TITLES[self.run.kind] + self.of_target

    @property
    def of_target(self) -> str:
        """What it belongs to where that is not the study at its own fidelity, in words."""
        return f" of {self.run.target}" if self.run.target else ""


class State(NamedTuple):
    """How a job stands."""

    job: Job
    state: Stand
    note: str = ""  # the run's own status, or why it failed
    time: float = 0.0  # simulated, s
    left: float = math.nan  # wall time by its own account, s
    since: float = math.nan  # wall time since it began, of a job that is running, s
    took: float = math.nan  # wall time by its benchmark, s
    computed: float = math.nan  # computing time of a core by its file, without compiling, reading and writing, s


def status(given: Path | None, configfile: Path | None, watching: bool, as_json: bool) -> str | None:
    """How the jobs of a study stand, in words or for machines; None where that was shown until all were done."""
    catalogue = find_study(given, configfile, started=True)

    def look_again() -> list[State]:
        return look_at([*catalogue.plan.jobs, *catalogue.started], catalogue.base)

    if watching and not as_json:
        watch(catalogue.plan, look_again, catalogue.base)
        return None
    states = look_again()
    others = look_beside(catalogue.plan, catalogue.base)
    if as_json:
        return to_json(record(catalogue.plan, states, others), indent=1)
    idle = Stand.RUNNING not in [*(each.state for each in states), *(each.state for each in others)]
    locked = idle and any((catalogue.base / LOCKS).glob("*.lock"))
    return "\n".join([*lines(catalogue.plan, states, others), *[_locked(catalogue.base)] * locked])


def _locked(base: Path) -> str:
    """Why a working folder is locked in which nothing of a study is at work, in words."""
    folders = dict.fromkeys(path.parents[1] for path in (base / "results").glob("**/logs/*.log") if _at_work(read_log(path)))
    others = ", ".join(folder.relative_to(base).as_posix() for folder in folders)
    return f"at work in this folder, which locks it: {others}; sph status FOLDER shows it" if others else LOCKED


def _at_work(log: Log | None) -> bool:
    return log is not None and log.reason is None and log.process is not None and log.process.alive(log.age)


def look_at(runs: Sequence[PlannedRun], base: Path) -> list[State]:
    """How runs stand, by what lies below the working folder."""
    return [look(Job(run, run.built), base) for run in runs]


def look(job: Job, base: Path) -> State:
    """How a job stands, by what lies below the working folder."""
    path = finished(base / job.run.file)
    try:
        facts = _facts(path, path.stat().st_mtime_ns)
        differs = differing(facts, job.scene, path)
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        return State(job, Stand.OUTDATED, f"cannot be read: {getattr(error, 'strerror', None) or error}")
    else:
        stand, note = (Stand.OUTDATED, "of another scene") if differs else (Stand.DONE, str(facts.get("status", "")))
        took, computed = _benchmark(base / job.run.benchmark), math.nan if "backend" in facts else float(facts.get("wall_time_s", math.nan))
        return State(job, stand, note, took=took, computed=computed)
    log = read_log(base / job.run.log)
    if log is not None:
        time = log.time or 0.0
        left = math.nan if log.left is None else max(log.left - log.age, 0.0)
        if log.reason is not None:
            return State(job, Stand.FAILED, log.reason, time)
        if log.process is not None and log.process.alive(log.age):
            begun = "" if log.time is not None else "compiling or reading"
            note = f"{_trials(path)} trials so far" if job.run.kind == Kind.SEARCH else begun
            return State(job, Stand.RUNNING, note, time, left, clock.time() - log.process.started)
        if any(beside(path, role).exists() for role in ("run", "checkpoint")):
            return State(job, Stand.STOPPED, time=time)
    return State(job, Stand.WAITING)


class Beside(NamedTuple):
    """A job beside the simulations that is at work or has failed, or of ``BESIDE`` and to come."""

    job: str
    state: Stand
    note: str  # what it does, where its name does not say that, or why it failed
    since: float = math.nan  # wall time since it began, of a job that is running, s


def look_beside(plan: Plan, base: Path) -> list[Beside]:
    """The jobs of a study beside its simulations that are at work or have failed, by their logs, and those of ``BESIDE`` to come."""
    own, jobs, folder = {base / run.log for run in plan.jobs}, list[Beside](), base / plan.folder
    for path in sorted((folder / "logs").glob("*.log")):
        log = read_log(path) if path not in own else None
        if log and log.reason is not None:
            jobs.append(Beside(path.stem, Stand.FAILED, log.reason))
        elif log and log.process and log.process.alive(log.age):
            jobs.append(Beside(path.stem, Stand.RUNNING, BESIDE.get(path.stem, ""), clock.time() - log.process.started))
    told = [other.job for other in jobs]
    return jobs + [Beside(job, Stand.WAITING, BESIDE[job]) for job in tests_left(plan, base) if job not in told]


def tests_left(plan: Plan, base: Path) -> list[str]:
    """The jobs of ``BESIDE`` whose tables are not there."""
    return [job for job, table in MADE.items() if not (base / plan.folder / table).exists()]


def _trials(path: Path) -> int:
    """How many trials a search under way has made, by its checkpoint."""
    try:
        with netCDF4.Dataset(beside(path, "checkpoint")) as ds:
            return len(ds.dimensions["trial"])
    except (OSError, KeyError):
        return 0


@functools.lru_cache(maxsize=20_000)
def _facts(path: Path, changed: int) -> dict[str, Any]:
    """The attributes of a file, which is not read again until it changes."""
    with netCDF4.Dataset(path) as ds:
        return {name: ds.getncattr(name) for name in ds.ncattrs()}


def _benchmark(path: Path) -> float:
    """Wall time of a finished job, s; NaN if Snakemake has not (yet) written it."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            return float(next(csv.DictReader(file, delimiter="\t"))["s"])
    except (OSError, ValueError, KeyError, TypeError, StopIteration, csv.Error):
        return math.nan


class Estimate(NamedTuple):
    """The work left."""

    work: float  # s of computing
    time: float  # s of wall time with the jobs now at work; NaN with none
    unknown: int  # jobs left of which nothing is known, not counted in these
    searches: float  # s of the work, of static tests and searches for limits


def estimate(plan: Plan, states: Sequence[State], beside: Sequence[Beside]) -> Estimate:
    """What the jobs left will take; see above."""
    speed, groups = _speed(states), dict[str, list[State]]()
    for state in states:
        groups.setdefault(state.job.run.group, []).append(state)
    costs = {group: _time_of_one(of) for group, of in groups.items() if any(state.state != Stand.DONE for state in of)}
    costs = {group: job_cost(groups[group][0].job.run).seconds / speed if math.isnan(time) else time for group, time in costs.items()}
    left, searching = list[tuple[Stand, float]](), list[float]()
    for state in states:
        if state.state != Stand.DONE:
            search, time = state.job.run.kind == Kind.SEARCH, costs[state.job.run.group]
            left.append((state.state, _rest(time, state.since if search else math.nan) if math.isnan(state.left) else state.left))
            searching += [left[-1][1]] * search
    for job in (other for other in beside if other.job in BESIDE):
        left.append((job.state, _rest(plan_seconds(plan)[list(BESIDE).index(job.job)] / speed, job.since)))
        searching.append(left[-1][1])
    known, at_work = ([time for _, time in left if not math.isnan(time)], [time for state, time in left if state == Stand.RUNNING])
    work, lasting = math.fsum(known), [time for time in at_work if not math.isnan(time)]
    searches = math.fsum(time for time in searching if not math.isnan(time))
    return Estimate(work, max(work / len(at_work), *lasting, 0.0) if at_work else math.nan, len(left) - len(known), searches)


def _rest(time: float, since: float) -> float:
    """What is left of a search that takes a ``time`` (s) and has run for some: one of its trials at least."""
    return time if math.isnan(since) else max(time - since, time / TRIALS)


def _speed(states: Sequence[State]) -> float:
    """Speed of this machine over that of the reference machine, on finished runs, else on gravity stages; NaN without these."""
    if runs := list(itertools.islice(speeds(states), SAMPLED)):
        return statistics.median(runs)
    done = [state for state in states if state.state == Stand.DONE and state.job.run.kind == Kind.GRAVITY and state.computed > 0.0]
    stages = [cost(state.job.scene, until=state.job.scene.gravity.duration).seconds / state.computed for state in done[:SAMPLED]]
    return statistics.median(stages) if stages else math.nan


def speeds(states: Sequence[State]) -> Iterator[float]:
    """Speed over that of the reference machine on each finished run."""
    for state in states:
        if state.state == Stand.DONE and state.job.is_run and state.computed > 0:  # NaN where a card made it
            yield cost(state.job.scene).seconds / state.computed


def _time_of_one(states: Sequence[State]) -> float:
    """Mean time of a job, s; NaN if none is measured.  Made ahead by another job, a run is done before its own has a benchmark."""
    known = [state.took for state in states if not math.isnan(state.took)]
    made = sum(state.state == Stand.DONE or not math.isnan(state.took) for state in states)
    return math.fsum(known) / made if known else math.nan


def lines(plan: Plan, states: Sequence[State], beside: Sequence[Beside]) -> list[str]:
    """The overview in words."""
    titles = dict.fromkeys(state.job.title for state in states)
    width = max(map(len, titles))
    text = [f"{plan.folder}: study {plan.study.study} at fidelity {plan.study.fidelity}"]
    for title in titles:
        of_kind = [state for state in states if state.job.title == title]
        count = Counter(state.state for state in of_kind)
        ended = Counter(state.note for state in of_kind if state.state == Stand.DONE and state.note)
        done = f" ({', '.join(f'{number} {status}' for status, number in ended.items())})" if of_kind[0].job.is_run and ended else ""
        others = "".join(f", {count[name]} {name}" for name in list(Stand)[1:] if count[name])
        text.append(f"  {title:<{width}}  {count[Stand.DONE]} of {len(of_kind)} done{done}{others}")
    for name in list(Stand)[1:5]:
        told = [_line(state) for state in states if state.state == name]
        text += told[:LISTED] + [f"  and {len(told) - LISTED} more {name}"] * (len(told) > LISTED)
    text += [f"  {other.state}: {other.job}{': ' if other.note else ''}{other.note}" for other in beside]
    return [*text, sentence(plan, states, beside)]


def _line(state: State) -> str:
    told = [state.note] if state.note else []
    if not math.isnan(state.left):
        told.insert(0, f"{duration(state.left)} left")
    if state.time and state.state in (Stand.RUNNING, Stand.STOPPED):
        until = state.job.scene.duration
        told.insert(0, f"{state.time / until:.0%}, {state.time:.2f} of {until:g} s" if state.job.is_run else f"at {state.time:.2f} s")
    return f"  {state.state}: {state.job.run.id}{state.job.of_target}{': ' if told else ''}{', '.join(told)}"


def sentence(plan: Plan, states: Sequence[State], beside: Sequence[Beside] = ()) -> str:
    """What is left, in a sentence."""
    left = sum(state.state != Stand.DONE for state in states) + sum(other.job in BESIDE for other in beside)
    if not left:
        return "all simulations are done; snakemake -n says whether tables, claims and figures are up to date"
    needed, measured = estimate(plan, states, beside), sum(not math.isnan(state.took) for state in states)
    at_work = [other.job for other in beside if other.state == Stand.RUNNING]
    running = sum(state.state == Stand.RUNNING for state in states) + sum(job in BESIDE for job in at_work)
    nothing = f"no{' simulation' if at_work else 'thing'} is running; "
    if needed.unknown == left:
        return f"{'' if running else nothing}time left: unknown until the first job is done"
    basis = f"from {_number(measured, 'benchmark')}" if measured else "from the progress of the running jobs"
    share = f"; {duration(needed.searches)} of {duration(needed.work)} of computing are static tests and searches"
    searches = share * (needed.searches >= 1.0)
    uncounted = f"; {_number(needed.unknown, 'job')} of unknown time not counted" if needed.unknown else ""
    if math.isnan(needed.time):
        return f"{nothing}{'at least ' * bool(needed.unknown)}{duration(needed.work)} of computing remaining, {basis}{searches}{uncounted}"
    more, bound = "; tables and figures need more time", "at least" if needed.unknown else "about"
    return f"time left: {bound} {duration(needed.time)} with the {running} running now, {basis}{searches}{uncounted}{more}"


def _number(count: int, what: str) -> str:
    return f"{count} {what}{'s' if count > 1 else ''}"


def record(plan: Plan, states: Sequence[State], beside: Sequence[Beside]) -> dict[str, Any]:
    """The overview for machines; numbers that are not known are null."""
    needed = estimate(plan, states, beside)
    rows = [state._asdict() | {"job": state.job.run.id, "kind": state.job.title, "duration": state.job.scene.duration} for state in states]
    return {
        "study": plan.study.study,
        "fidelity": plan.study.fidelity,
        "folder": plan.folder,
        "work_left": needed.work,
        "time_left": needed.time,
        "searches_left": needed.searches,
        "not_measured": needed.unknown,
        "jobs": rows,
        "beside": [other._asdict() for other in beside],
    }


def watch(plan: Plan, look_again: Callable[[], list[State]], base: Path) -> None:
    """Show the overview until all simulations are done: in place on a terminal, elsewhere whenever it has changed."""
    shown = ""
    while True:
        states = look_again()
        text = "\n".join(lines(plan, states, look_beside(plan, base)))
        if sys.stdout.isatty():
            print(f"{CLEAR}{text}", flush=True)
        elif text != shown:
            print(text, flush=True)
        shown = text
        if all(state.state == Stand.DONE for state in states) and not tests_left(plan, base):
            return
        clock.sleep(REFRESH)
