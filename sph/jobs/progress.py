"""Progress of a run: a bar on a terminal, plain lines at every tenth, and at least every half minute, in a log file."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from sph.solver.run import Progress


def rate_text(progress: Progress) -> str:
    """Particle-steps per second, in words."""
    rate = progress.particle_steps / progress.elapsed if progress.elapsed > 0 else 0.0
    return f"{rate / 1e6:.2f} M particle-steps/s"


SECONDS = 30.0
"""Longest wall time between lines; ``sph status`` reads them."""
LINE = re.compile(r".*: ([\d.]+) of (\S+) s, \d+% failed, .* particle-steps/s(?:, (\d+) s left)?")
"""A line: simulated time, duration and, but in the first, the wall time left, s."""


@contextmanager
def reporter(label: str, stream: TextIO | None = None) -> Iterator[Callable[[Progress], None]]:
    """A function to call with the progress of a run; chooses bar or lines by what ``stream`` is."""
    stream = stream or sys.stderr
    if stream.isatty():
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[note]}"), TimeRemainingColumn())
        with Bar(*columns, console=Console(file=stream)) as bar:
            task = bar.add_task(label, total=None, note="")

            def on_terminal(p: Progress) -> None:
                note = f"{p.time:.2f} of {p.duration:g} s, {p.failed_fraction:.0%} failed, {rate_text(p)}"
                bar.update(task, completed=p.time, total=p.duration, note=note)

            yield on_terminal
        return
    yield Lines(label, stream)


class Lines:
    """Plain progress lines, one at every tenth of the run and at least every ``SECONDS``."""

    def __init__(self, label: str, stream: TextIO) -> None:
        self.label, self.stream = label, stream
        self.first_time: float | None = None
        self.printed, self.printed_at = -1, 0.0

    def __call__(self, p: Progress) -> None:
        """Print if another tenth, or half a minute, has passed."""
        if self.first_time is None:
            self.first_time = p.time
        tenth = int(10 * p.time / p.duration)
        if tenth == self.printed and p.elapsed - self.printed_at < SECONDS:
            return
        self.printed, self.printed_at = tenth, p.elapsed
        gained = p.time - self.first_time
        left = f", {(p.duration - p.time) / gained * p.elapsed:.0f} s left" if gained > 0 else ""
        note = f"{p.time:.2f} of {p.duration:g} s, {p.failed_fraction:.0%} failed, {rate_text(p)}{left}"
        print(f"{self.label}: {note}", file=self.stream, flush=True)
