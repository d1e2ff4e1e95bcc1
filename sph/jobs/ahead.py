"""Runs share a job: one goes ahead with runs that could start beside it, and the jobs of these take up what it has made.

So a study of short runs starts few processes that load the solver, and one on a graphics card advances all its runs together; each is
planned, counted, recorded and repeated run by run as any other.
What a job makes stays in a hidden folder beside its place until the job of that run ends: what a killed job has finished is taken up again.
Its name there is a digest of all that decides the run, so that a run of other scenes or sources is not taken up.
"""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from sph.storage.files import beside

TOGETHER = 20.0
"""Seconds of predicted work up to which a job goes ahead with other runs."""
AT_ONCE = 256
"""Most runs of a job on a graphics card, of which each has three files open; more make it hardly faster (docs/how-to/gpu.md)."""


class Task(NamedTuple):
    """A run, stage or search as its job is given it: plain data, which is read without the library of scenes."""

    file: str
    log: str
    restart: str | None
    """file of the stage that it goes on from"""
    scene: dict[str, Any]
    contents: dict[str, str]
    """digests of the files that the scene is read from (``sph.study.planned.Planned``)"""
    until: str
    """stage, one of ``sph.solver.run.Until``"""
    by: str
    extrapolates: bool
    enforce_limit: bool
    backend: str
    """one of ``sph.solver.backends.BACKENDS``"""
    digest: str
    """of all that decides its result"""

    @property
    def made(self) -> Path:
        """What its own job takes up, once it is made."""
        return beside(Path(self.file), "made") / f"{self.digest}.nc"


def keep_log(task: Task) -> None:
    """Give the log a second name beside what is made: Snakemake deletes the first when the job of the run begins."""
    kept = task.made.with_suffix(".log")
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.unlink(missing_ok=True)
    with suppress(OSError):  # a disk without hard links, or no log could be written
        os.link(task.log, kept)


def take_up(task: Task) -> bool:
    """Put what is made of a run in its place, with its log; False where nothing is."""
    try:
        os.replace(task.made, task.file)
    except FileNotFoundError:
        return False
    with suppress(OSError):
        os.replace(task.made.with_suffix(".log"), task.log)
    shutil.rmtree(task.made.parent, ignore_errors=True)
    return True


def finished(path: Path) -> Path:
    """The file of a run: in its place, or where it is made and not yet taken up; its place where there is neither."""
    return path if path.exists() else next(beside(path, "made").glob("[!.]*.nc"), path)
