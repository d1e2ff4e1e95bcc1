"""The log of a workflow's job, which begins with its process and ends with the reason if the job fails."""

from __future__ import annotations

import os
import platform
import re
import sys
import time as clock
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TextIO

import psutil

from sph.jobs.exit_codes import REFUSED

FRESH = 120.0
"""A job on another machine is taken for running while its log is younger than this, s; a run writes a line every 30 s."""


class Job(Protocol):
    """What the workflow gives to the script of a job, in which it stands under the name ``snakemake``."""

    input: Any
    output: Any
    params: Any
    wildcards: Any
    log: list[str]
    threads: int


class Process(NamedTuple):
    """The process of a job, as the first line of its log has it."""

    machine: str
    number: int
    started: float  # s since 1970

    def line(self) -> str:
        """The line."""
        return f"process {self.number} on {self.machine}, started at {self.started:.2f} s since 1970"

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
    lines: list[str]  # after the first
    reason: str  # why it failed, or empty
    age: float  # since its last line, s


def read_log(path: Path) -> Log | None:
    """The log of a job; None if there is none."""
    try:
        text, age = path.read_text(encoding="utf-8", errors="replace"), clock.time() - path.stat().st_mtime
    except OSError:
        return None
    lines = text.splitlines()
    first = re.fullmatch(r"process (\d+) on (.*), started at ([\d.]+) s since 1970", lines[0]) if lines else None
    process = Process(first[2], int(first[1]), float(first[3])) if first else None
    own = [line.removeprefix(f"{path.stem}: ") for line in lines if line.startswith(f"{path.stem}: ")]
    reason = own[0] if own else lines[-1] if "Traceback (most recent call last):" in lines else ""
    return Log(process, lines[1 if first else 0 :], reason, age)


@contextmanager
def job_log(path: Path | str) -> Iterator[TextIO]:
    """The log to write to.  An error ends the job with a line, in the log and on stderr, where the workflow shows it.

    What the user can mend (exit code 2) is that line alone; anything else leaves its traceback in the log.  A log that cannot be
    written stops nobody.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        log: TextIO = open(path, "w", encoding="utf-8", errors="backslashreplace", buffering=1)  # noqa: SIM115
        print(Process(platform.node(), os.getpid(), clock.time()).line(), file=log)
    except OSError as error:
        print(f"{path}: no log: {error.strerror}", file=sys.stderr)
        log = sys.stderr
    try:
        yield log
    except Exception as error:
        mendable = isinstance(error, (ValueError, OSError))
        line = f"{path.stem}: {error if mendable else repr(error)}"
        with suppress(OSError):
            print(line if mendable else traceback.format_exc().rstrip(), file=log)
        print(line, file=sys.stderr, flush=True)
        raise SystemExit(REFUSED if mendable else 1) from error
    finally:
        if log is not sys.stderr:
            with suppress(OSError):
                log.close()
