"""What the jobs of a workflow do that simulate: runs and stages, several short ones in a job, and searches for limits of slopes."""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Sequence
from contextlib import redirect_stderr, suppress
from pathlib import Path
from typing import TextIO, cast

from sph.checks.finding import codes
from sph.checks.messages import line
from sph.checks.scene import findings
from sph.jobs.ahead import Task, keep_log, take_up
from sph.jobs.log import job_log
from sph.jobs.progress import reporter
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Until
from sph.stability.record import search_to_file
from sph.storage.files import alone
from sph.study.planned import Planned
from sph.study.runs import SIMULATION


def work(own: Task, others: Sequence[Task], threads: int) -> None:
    """Make the result of a job and then, ahead of their jobs, those of others; what another job has made or makes is left to it.

    An error ends the job, and with one of the others that alone: its own job will tell it.
    """
    before = [_written(other) for other in others]
    with alone(Path(own.file), "job"):
        make(own, threads)
    for other, then in zip(others, before, strict=True):
        with suppress(_AtWorkError, OSError, SystemExit), redirect_stderr(io.StringIO()), alone(Path(other.file), "job", _leave):
            if _written(other) == then:  # else its own job has been at it
                make(other, threads)
    take_up(own)


def _written(task: Task) -> float | None:
    path = Path(task.file)
    return path.stat().st_mtime if path.exists() else None


class _AtWorkError(Exception):
    """Another job works on this run."""


def _leave() -> None:
    raise _AtWorkError


def make(task: Task, threads: int) -> None:
    """Make a result where its own job will take it up; of a search, which is never made ahead, in its place."""
    if task.made.exists():
        return
    planned, finished = Planned(task.scene, task.contents), task.made.with_name(".finished.nc")
    with job_log(task.log) as log:
        if task.by != SIMULATION:
            # From the trials of a search that was killed; at two spacings if it extrapolates.
            search_to_file(planned.build(), task.by, task.file, lambda trial: print(*trial, file=log, flush=True), task.extrapolates)
            return
        keep_log(task)
        try:
            simulate(planned, task, finished, log, threads)
        except Exception:
            shutil.rmtree(finished.parent)
            raise
    os.replace(finished, task.made)


def simulate(planned: Planned, task: Task, finished: Path, log: TextIO, threads: int) -> None:
    """Run a scene, from its checkpoint or a restart if there is one, and write its trajectory; a run that diverges is a result."""

    def say(text: str) -> None:
        print(text, file=log)

    built = planned.build()
    found = findings(built)
    with reporter(task.file, built, log) as report:
        for each in found:
            if each.counts:
                say(line(each))
        result = run_to_file(
            built,
            task.file,
            cast(Until, task.until),
            task.restart,
            report,
            threads,
            say=say,
            enforce_limit=task.enforce_limit,
            attrs={"findings": codes(found)},
            to=finished,
        )
    print(f"{task.file}: {result.status} {result.stored.attrs['status_reason']}", file=log)
