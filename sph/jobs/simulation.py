"""What the jobs of a workflow do that simulate: runs and stages, several in a job, and searches for limits of slopes."""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TextIO, cast

from sph.checks.finding import codes
from sph.checks.layers import own_spacings
from sph.checks.messages import line
from sph.checks.scene import findings
from sph.jobs.ahead import Task, keep_log, take_up
from sph.jobs.log import job_log
from sph.jobs.progress import reporter
from sph.scene.schema import Scene
from sph.solver.backends import backend_of, call_together
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Backend, Until
from sph.stability.record import search_to_file
from sph.storage.files import alone
from sph.study.planned import Planned
from sph.study.runs import SIMULATION


def work(own: Task, others: Sequence[Task], threads: int) -> None:
    """Make the result of a job and, ahead of their jobs, those of others; what another job has made or makes is left to it.

    On the processor its own comes first, on a card all advance together.  An error ends the job, and with one of the others that alone:
    its own job will tell it.
    """
    before = [_written(other) for other in others]
    with ExitStack() as held:
        held.enter_context(alone(Path(own.file), "job"))
        if own.backend == "cpu":
            make(own, threads)
            held.close()
            for other, then in zip(others, before, strict=True):
                with suppress(_AtWorkError, OSError, SystemExit), _left_alone(other, then):
                    make(other, threads, io.StringIO())
        elif not own.made.exists():
            free = []
            for other, then in zip(others, before, strict=True):
                with suppress(_AtWorkError, OSError):
                    held.enter_context(_left_alone(other, then))
                    free.append(other)
            make_together(own, free)
    take_up(own)


@contextmanager
def _left_alone(task: Task, then: float | None) -> Iterator[None]:
    """Hold the place of a run at which no other job works nor, since ``then``, has worked; _AtWorkError where one does."""
    with alone(Path(task.file), "job", _leave):
        if _written(task) != then:
            _leave()
        yield


def _written(task: Task) -> float | None:
    path = Path(task.file)
    return path.stat().st_mtime if path.exists() else None


class _AtWorkError(Exception):
    """Another job works on this run."""


def _leave() -> None:
    raise _AtWorkError


def make_together(own: Task, others: Sequence[Task]) -> None:
    """Make results on the card, each as soon as it is done where its own job will take it up; an error of the own one is raised.

    What goes on from another of them follows when that is done; if that failed, it is left to its own job.
    """
    left = [own, *others]
    made = {task.file: task.made for task in left}
    while left:
        files = {task.file for task in left}
        now, left = [task for task in left if task.restart not in files], [task for task in left if task.restart in files]
        begun = [task for task in now if task.restart not in made or made[task.restart].exists()]
        make_at_once([task._replace(restart=str(made[task.restart])) if task.restart in made else task for task in begun], own)


def make_at_once(tasks: Sequence[Task], own: Task) -> None:
    """Make results that need nothing of each other."""
    built: dict[int, Scene] = {}

    def scene_of(number: int) -> Scene:
        built[number] = Planned(tasks[number].scene, tasks[number].contents).build()
        return built[number]

    def call(number: int, backend: Backend) -> None:
        make(tasks[number], 1, None if tasks[number] is own else io.StringIO(), backend, built.pop(number, None))

    try:
        found = call_together([partial(scene_of, number) for number in range(len(tasks))], call)
    except ValueError:
        with job_log(own.log):
            raise
    for task, result in zip(tasks, found, strict=True):
        if task is own and result is not None:
            raise result


def make(task: Task, threads: int, shown: TextIO | None = None, backend: Backend | None = None, scene: Scene | None = None) -> None:
    """Make a result where its own job will take it up; of a search, which is never made ahead, in its place.

    ``shown`` is where an error is told beside the log, ``backend`` what advances it if not what the task says, ``scene`` is its scene, if
    that is built already.
    """
    if task.made.exists():
        return
    finished = task.made.with_name(".finished.nc")
    with job_log(task.log, shown) as log:
        if task.by != SIMULATION:
            # From the trials of a search that was killed; at two spacings if it extrapolates.
            scene = Planned(task.scene, task.contents).build()
            spacings = own_spacings if task.extrapolates else None
            search_to_file(scene, task.by, task.file, lambda trial: print(*trial, file=log, flush=True), spacings)
            return
        keep_log(task)
        try:
            scene = scene or Planned(task.scene, task.contents).build()
            simulate(scene, task, finished, log, threads, backend or backend_of(task.backend))
        except Exception:
            shutil.rmtree(finished.parent)
            raise
    os.replace(finished, task.made)


def simulate(scene: Scene, task: Task, finished: Path, log: TextIO, threads: int, backend: Backend | None) -> None:
    """Run a scene, from its checkpoint or a restart if there is one, and write its trajectory; a run that diverges is a result."""

    def say(text: str) -> None:
        print(text, file=log)

    found = findings(scene)
    with reporter(task.file, scene, log) as report:
        for each in found:
            if each.counts:
                say(line(each))
        result = run_to_file(
            scene,
            task.file,
            cast(Until, task.until),
            task.restart,
            report,
            threads,
            say=say,
            enforce_limit=task.enforce_limit,
            attrs={"findings": codes(found)},
            backend=backend,
            to=finished,
        )
    print(f"{task.file}: {result.status} {result.stored.attrs['status_reason']}", file=log)
