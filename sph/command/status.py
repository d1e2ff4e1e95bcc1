"""Progress of a study, for a second terminal (``sph status``): nothing is written, locked or started.

A job is *done* when its file is there and holds the scene of the configuration; *outdated*, and to be made again, when it holds another.
Without a file it is *running* while the process in its log runs (on another machine: while its log is fresh), *failed* when its log ends
with a reason, *stopped* when it was killed (it continues from its checkpoint), else *waiting*.  Whether edited sources ask for a
rerun is for ``snakemake -n`` to say.  Targets beside the study count once they have been started (``sph.jobs.catalogue``).

The time left is that which finished jobs of the kind took by their benchmarks (runs: those that share their shaking up to the first
failure, else all, else the gravity stage's time a simulated second), and what running ones say themselves, over the number at work.
"""

from __future__ import annotations

import csv
import functools
import math
import statistics
import time as clock
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
from rich.console import Console
from rich.live import Live
from rich.text import Text

import sph
from sph.experiments.registry import load_study
from sph.jobs.catalogue import Catalogue
from sph.jobs.log import read_log
from sph.scene.configuration import merge, read_yaml, without_files
from sph.scene.schema import Scene, make_scene, stored_scene
from sph.scene.strict_json import parse_json
from sph.storage.files import beside
from sph.study.machine import duration
from sph.study.plan import Plan
from sph.study.runs import Kind, Run
from sph.study.sampling import chosen_study

REFRESH = 2.0
"""Wall time between looks of ``--watch``, s."""
LISTED = 10
"""Most jobs of a state that are named."""


TITLES = {
    Kind.GRAVITY: "gravity stage",
    Kind.PRE_FAILURE: "shaking to the first failure",
    Kind.RUN: "runs",
    Kind.SEARCH: "yield acceleration",
}
"""The kinds in words."""


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

    run: Run
    scene: Scene

    @property
    def is_run(self) -> bool:
        """Whether it runs to the end of its scene, unlike a stage or a search."""
        return self.run.kind == Kind.RUN

    @property
    def title(self) -> str:
        """What it is, in words: its row of the overview."""
        return f"{TITLES[self.run.kind]} of {self.run.target}" if self.run.target else TITLES[self.run.kind]


class State(NamedTuple):
    """How a job stands."""

    job: Job
    state: Stand
    note: str = ""  # the run's own status, or why it failed
    time: float = 0.0  # simulated, s
    left: float = math.nan  # wall time by its own account, s
    took: float = math.nan  # wall time by its benchmark, s
    computed: float = math.nan  # computing time by its file, without compiling, reading and writing, s


def located(folder: Path | None, configfile: Path | None) -> Catalogue:
    """The catalogue of a study; by default that of ``config/config.yaml`` in the working folder, as for ``snakemake``.

    ``folder`` is ``.../results/<study>/<fidelity>`` and decides the fidelity; the configuration of another study than that of
    ``config/config.yaml``, which need not be there then, is found by its name.  ValueError names what does not fit.
    """
    place = folder.resolve() if folder else None
    if place and place.parent.parent.name != "results":
        raise ValueError(f"{folder}: not the folder of a study's results, results/<study>/<fidelity>")
    base = place.parents[2] if place else Path.cwd()
    shipped = base / "config" / "config.yaml"
    if configfile is None and place is None and not shipped.is_file():
        raise ValueError(f"{shipped}: no such file; go to the folder the study was started in, or give its results folder or --configfile")
    data: Mapping[str, Any] = read_yaml(shipped) if shipped.is_file() else {}
    if place and configfile is None and data.get("study") != place.parent.name:
        configfile = _configuration_of(place.parent.name, base)
    if configfile:
        given = read_yaml(configfile)
        data = chosen_study(merge(data, given), given)
    if place:
        if data.get("study") != place.parent.name:
            other = f"the configuration's study is {data['study']!r}" if "study" in data else f"no configuration of it is found in {base}"
            raise ValueError(f"{folder}: {other}; give the configuration of this one with --configfile")
        data = {**data, "fidelity": place.name}
    folders = [base, Path(sph.__file__).parents[1]]
    return Catalogue(load_study(data, folders), folders, base, check=False)


def _configuration_of(study: str, base: Path) -> Path | None:
    """The only file at most two folders below where a study was started that names the study; None where there is none, or more."""
    found = []
    for path in (path for depth in ("", "*/", "*/*/") for path in base.glob(f"{depth}*.y*ml")):
        with suppress(ValueError):
            if read_yaml(path).get("study") == study:
                found.append(path)
    return found[0] if len(found) == 1 else None


def look_at(runs: Sequence[Run], base: Path, known: dict[str, Job] | None = None) -> list[State]:
    """How runs stand, by what lies below the working folder; scenes that are ``known``, by file, are not built again."""
    built = {} if known is None else known
    for run in runs:
        if run.file not in built or built[run.file].run is not run:
            built[run.file] = Job(run, make_scene(run.scene, run.file))
    return [look(built[run.file], base) for run in runs]


def look(job: Job, base: Path) -> State:
    """How a job stands, by what lies below the working folder."""
    path = base / job.run.file
    try:
        scene, note, computed = _facts(path, path.stat().st_mtime_ns)
    except OSError as error:
        if not isinstance(error, FileNotFoundError):
            return State(job, Stand.OUTDATED, f"cannot be read: {error.strerror or error}")
    else:
        same = scene == job.scene.stored() or _content(_scene(scene)) == _content(job.scene)
        return State(
            job,
            Stand.DONE if same else Stand.OUTDATED,
            note if same else "of another scene",
            took=_benchmark(base / job.run.benchmark),
            computed=computed,
        )
    log = read_log(base / job.run.log)
    if log is not None:
        time = log.time or 0.0
        left = math.nan if log.left is None else max(log.left - log.age, 0.0)
        if log.reason is not None:
            return State(job, Stand.FAILED, log.reason, time)
        if log.process is not None and log.process.alive(log.age):
            begun = "" if log.time is not None else "compiling or reading"
            return State(job, Stand.RUNNING, f"{_trials(path)} trials so far" if job.run.kind == Kind.SEARCH else begun, time, left)
        if any(beside(path, role).exists() for role in ("run", "checkpoint")):
            return State(job, Stand.STOPPED, time=time)
    return State(job, Stand.WAITING)


def _trials(path: Path) -> int:
    """How many trials a search under way has made, by its checkpoint."""
    try:
        with netCDF4.Dataset(beside(path, "checkpoint")) as ds:
            return len(ds.dimensions["trial"])
    except (OSError, KeyError):
        return 0


@functools.lru_cache(maxsize=20_000)
def _facts(path: Path, changed: int) -> tuple[str, str, float]:
    """Scene, status and computing time (s) in a file, which is not read again until it changes."""
    with netCDF4.Dataset(path) as ds:
        return str(getattr(ds, "scene", "")), str(getattr(ds, "status", "")), float(getattr(ds, "wall_time_s", math.nan))


@functools.lru_cache(maxsize=20_000)
def _scene(text: str) -> Scene | None:
    """A scene as an earlier version wrote it, without the keys added since; None for what this version refuses."""
    try:
        return stored_scene(parse_json(text))
    except ValueError:
        return None


def _content(scene: Scene | None) -> Any:
    """What decides a run, wherever its files lie."""
    return None if scene is None else without_files(scene.model_dump())


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
    unknown: int  # jobs left of which nothing is measured, not counted in these


def estimate(states: Sequence[State]) -> Estimate:
    """What the jobs left will take; see above."""
    groups = {state.job.run.group for state in states}
    costs = {group: _mean(state.took for state in states if state.job.run.group == group) for group in groups}
    any_run = _mean(state.took for state in states if state.job.is_run)
    scene = states[0].job.scene
    by_gravity = states[0].computed * (scene.duration / scene.gravity.duration - 1.0)
    lefts, work, unknown = [], 0.0, 0
    for state in states:
        if state.state == Stand.DONE:
            continue
        known = (state.left, costs[state.job.run.group], *((any_run, by_gravity) if state.job.is_run else ()))
        left = next((value for value in known if not math.isnan(value)), math.nan)
        if math.isnan(left):
            unknown += 1
            continue
        work += left
        if state.state == Stand.RUNNING:
            lefts.append(left)
    running = sum(state.state == Stand.RUNNING for state in states)
    return Estimate(work, max(work / running, *lefts, 0.0) if running else math.nan, unknown)


def _mean(values: Iterator[float]) -> float:
    known = [value for value in values if not math.isnan(value)]
    return statistics.fmean(known) if known else math.nan


def lines(plan: Plan, states: Sequence[State]) -> list[str]:
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
    return [*text, sentence(states)]


def _line(state: State) -> str:
    told = [state.note] if state.note else []
    if not math.isnan(state.left):
        told.insert(0, f"{duration(state.left)} left")
    if state.time and state.state in (Stand.RUNNING, Stand.STOPPED):
        until = state.job.scene.duration
        told.insert(0, f"{state.time / until:.0%}, {state.time:.2f} of {until:g} s" if state.job.is_run else f"at {state.time:.2f} s")
    return f"  {state.state}: {state.job.run.id}{': ' if told else ''}{', '.join(told)}"


def sentence(states: Sequence[State]) -> str:
    """What is left, in a sentence."""
    left = sum(state.state != Stand.DONE for state in states)
    if not left:
        return "all simulations are done; snakemake -n says whether tables, claims and figures are up to date"
    found, measured = estimate(states), sum(not math.isnan(state.took) for state in states)
    running = sum(state.state == Stand.RUNNING for state in states)
    if found.unknown == left:
        return f"{'' if running else 'nothing is running; '}time left: unknown until the first job is done"
    basis = f"from {_number(measured, 'benchmark')}" if measured else "from the progress of the running jobs"
    at_least = f"; {_number(found.unknown, 'job')} of unknown time not counted" if found.unknown else ""
    if math.isnan(found.time):
        return f"nothing is running; {duration(found.work)} of computing remaining, {basis}{at_least}"
    return f"time left: about {duration(found.time)} with the {running} running now, {basis}{at_least}; tables and figures need more time"


def _number(count: int, what: str) -> str:
    return f"{count} {what}{'s' if count > 1 else ''}"


def record(plan: Plan, states: Sequence[State]) -> dict[str, Any]:
    """The overview for machines; numbers that are not known are null."""
    found = estimate(states)
    rows = [state._asdict() | {"job": state.job.run.id, "kind": state.job.title, "duration": state.job.scene.duration} for state in states]
    return {
        "study": plan.study.study,
        "fidelity": plan.study.fidelity,
        "folder": plan.folder,
        "work_left": found.work,
        "time_left": found.time,
        "not_measured": found.unknown,
        "jobs": rows,
    }


def watch(plan: Plan, look_again: Callable[[], list[State]]) -> None:
    """Show the overview until all simulations are done: in place on a terminal, elsewhere whenever it has changed."""
    shown = [""]
    console = Console()
    with Live(console=console, auto_refresh=False, transient=False) as live:
        while True:
            states = look_again()
            new = lines(plan, states)
            if console.is_terminal:
                live.update(Text("\n".join(new)), refresh=True)
            elif new != shown:
                print("\n".join(new), flush=True)
            shown = new
            if all(state.state == Stand.DONE for state in states):
                return
            clock.sleep(REFRESH)
