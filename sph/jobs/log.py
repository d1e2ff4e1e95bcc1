"""The log of a workflow's job: lines for people and records for programs, which are lines of JSON.

The first line is a record of the job's process; a run adds one of its progress at least every half minute, and a job that fails one of the
reason as its last line.
"""

from __future__ import annotations

import os
import platform
import sys
import time as clock
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TextIO

import psutil

from sph.jobs.exit_codes import REFUSED
from sph.scene.strict_json import parse_json, to_json

FRESH = 120.0
"""A job on another machine is taken for running while its log is younger than this, s; a run writes a line every 30 s."""
RECORD = "record"
"""Key of every record that holds its kind: one of the following."""
PROCESS, PROGRESS, FAILED = "process", "progress", "failed"


class JobLog(TextIOWrapper):
    """A log that takes records beside lines."""

    def record(self, kind: str, **facts: Any) -> None:
        """Write a record."""
        print(line_of(kind, **facts), file=self)


def line_of(kind: str, **facts: Any) -> str:
    """The line of a record; a number that is not finite is null."""
    return to_json({RECORD: kind, **facts})


class Job(Protocol):
    """What the workflow gives to the script of a job, in which it stands under the name ``snakemake``."""

    input: Any
    output: Any
    params: Any
    wildcards: Any
    config: dict[str, Any]
    log: list[str]
    threads: int


class Process(NamedTuple):
    """The process of a job."""

    machine: str
    number: int
    started: float  # s since 1970

    def alive(self, age: float) -> bool:
        """Whether it runs; ``age`` (s) of its log decides for another machine.  A number is given again, after a reboot for instance."""
        if self.machine != platform.node():
            return age < FRESH
        try:
            return psutil.Process(self.number).create_time() < self.started + 1.0
        except psutil.Error:
            return False


class Log(NamedTuple):
    """What the log of a job says."""

    process: Process | None
    time: float | None  # simulated, s; None before the first progress
    left: float | None  # wall time left at its last line, s; None where that is not known
    reason: str | None  # why it failed, None while it has not
    age: float  # since its last line, s
    of: str  # digest of what the job was given; nothing where its log does not tell


def read_log(path: Path) -> Log | None:
    """The log of a job; None if there is none."""
    try:
        text, age = path.read_text(encoding="utf-8", errors="replace"), clock.time() - path.stat().st_mtime
    except OSError:
        return None
    last = {record[RECORD]: record for record in map(_record, text.splitlines()) if record}
    process, progress, failed = (last.get(kind, {}) for kind in (PROCESS, PROGRESS, FAILED))
    started = Process(process["machine"], process["number"], process["started"]) if process else None
    return Log(started, progress.get("time"), progress.get("left"), failed.get("reason"), age, process.get("of", ""))


def _record(line: str) -> dict[str, Any] | None:
    """The record in a line; None in a line for people."""
    try:
        record = parse_json(line)
    except ValueError:
        return None
    return record if isinstance(record, dict) and RECORD in record else None


@contextmanager
def job_log(path: Path | str, shown: TextIO | None = None, of: str = "") -> Iterator[TextIO]:
    """The log to write to, of a job that is given what has the digest ``of``.

    An error ends the job with a line, in the log and where the workflow shows it (``shown``; by default stderr).  One that the user can
    correct (exit code 2) leaves that line alone, any other its traceback in the log.  A log that cannot be written does not stop the job.
    """
    path, shown = Path(path), shown or sys.stderr
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        log: TextIO
        log = own = JobLog(path.open("wb"), encoding="utf-8", errors="backslashreplace", line_buffering=True)
        own.record(PROCESS, **Process(platform.node(), os.getpid(), clock.time())._asdict(), of=of)
    except OSError as error:
        print(f"{path}: no log: {error.strerror}", file=shown)
        log = shown
    try:
        yield log
    except Exception as error:
        correctable = isinstance(error, (ValueError, OSError))
        line = f"{path.stem}: {error if correctable else repr(error)}"
        with suppress(OSError):
            print(line if correctable else traceback.format_exc().rstrip(), file=log)
            if isinstance(log, JobLog):
                log.record(FAILED, reason=next(iter(str(error).splitlines()), "") if correctable else repr(error))
        print(line, file=shown, flush=True)
        raise SystemExit(REFUSED if correctable else 1) from error
    finally:
        if log is not shown:
            with suppress(OSError):
                log.close()
