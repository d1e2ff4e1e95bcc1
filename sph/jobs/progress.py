"""Progress of a run: a bar on a terminal; in a log lines, in that of a job records, at every tenth and at least every half minute."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TextIO

from sph.jobs.log import PROGRESS, JobLog
from sph.scene.schema import Scene
from sph.solver.compiled.jit import before_compiling
from sph.solver.integration import advance
from sph.solver.run import Progress
from sph.solver.terms import wanted_terms


def words(progress: Progress) -> str:
    """How far a run is, how much of its soil has failed, and how fast it is."""
    rate = progress.particle_steps / progress.elapsed if progress.elapsed > 0 else 0.0
    failed = f"{progress.failed_fraction:.0%} failed"
    return f"{progress.time:.2f} of {progress.duration:g} s, {failed}, {rate / 1e6:.2f} M particle-steps/s"


def compiling(variant: str, last: float | None) -> str:
    """What is compiled, and how long that took last time."""
    took = "about 10 s on a free core" if last is None else f"it took {last:.0f} s last time"
    return f"compiling the solver with {variant or 'no optional term'}, once per machine ({took})"


SECONDS = 30.0
"""Longest wall time between lines, s."""


@contextmanager
def reporter(label: str, scene: Scene, stream: TextIO | None = None) -> Iterator[Callable[[Progress], None]]:
    """A function to call with the progress of a run; chooses bar, lines or records by what ``stream`` is.

    Says so there if the solver is compiled for the scene.
    """
    stream = stream or sys.stderr
    variant = ", ".join(name for name, wanted in wanted_terms(scene).items() if wanted)
    if stream.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[note]}"), TimeRemainingColumn())
        with Bar(*columns, console=Console(file=stream)) as bar:
            task = bar.add_task(label, total=None, note="")

            def on_terminal(p: Progress) -> None:
                bar.update(task, completed=p.time, total=p.duration, note=words(p))

            with before_compiling(advance, variant, lambda last: bar.console.print(f"{label}: {compiling(variant, last)}")):
                yield on_terminal
        return
    with before_compiling(advance, variant, lambda last: print(f"{label}: {compiling(variant, last)}", file=stream, flush=True)):
        yield Sparse(partial(record, stream) if isinstance(stream, JobLog) else partial(line, label, stream))


def line(label: str, stream: TextIO, progress: Progress, left: float) -> None:
    """Write a line for people, with the wall time left, s."""
    print(f"{label}: {words(progress)}{'' if math.isnan(left) else f', {left:.0f} s left'}", file=stream, flush=True)


def record(log: JobLog, progress: Progress, left: float) -> None:
    """Write a record into the log of a job, with the wall time left, s."""
    log.record(PROGRESS, **progress._asdict(), left=left)


class Sparse:
    """Passes on progress at every tenth of the run and at least every ``SECONDS``."""

    def __init__(self, tell: Callable[[Progress, float], None]) -> None:
        self.tell = tell
        self.first_time: float | None = None
        self.printed, self.printed_at = -1, 0.0

    def __call__(self, p: Progress) -> None:
        """Pass on, with the wall time left (s; NaN at the first), if another tenth, or half a minute, has passed."""
        if self.first_time is None:
            self.first_time = p.time
        tenth = int(10 * p.time / p.duration)
        if tenth == self.printed and p.elapsed - self.printed_at < SECONDS:
            return
        self.printed, self.printed_at = tenth, p.elapsed
        gained = p.time - self.first_time
        self.tell(p, (p.duration - p.time) / gained * p.elapsed if gained > 0 else math.nan)
