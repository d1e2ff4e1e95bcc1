"""A run to a file that may be killed at any instant: the same command goes on from its checkpoint.

A checkpoint is the trajectory so far with its restart state, in a hidden file beside the one to be written: Snakemake, which
deletes the unfinished outputs of a job that failed, does not know of it.  It is taken up only by the run that wrote it: the
same scene, stage, restart file and solver, told by a digest.  One process at a time works on a file.
"""

from __future__ import annotations

import hashlib
import os
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from sph.scene.schema import Scene
from sph.solver.compiled.jit import solver_digest
from sph.solver.run import Backend, Progress, Result, Run, Until
from sph.storage import trajectory
from sph.storage.files import alone, beside, tidy

SECONDS = 300.0
"""Wall time between checkpoints, what a kill costs at most; writing one takes 0.1 s to 0.4 s for the paper's slope, with its history.
No key of scene or study, since it changes no result and a changed key would rerun them: ``$SPH_CHECKPOINT`` sets it."""

Say = Callable[[str], None]


def run_to_file(
    scene: Scene,
    path: Path | str,
    until: Until = "end",
    restart: Path | str | None = None,
    report: Callable[[Progress], None] | None = None,
    threads: int = 1,
    seconds: float | None = None,
    say: Say = print,
    enforce_limit: bool = True,
    attrs: Mapping[str, Any] | None = None,
    backend: Backend | None = None,
    to: Path | None = None,
) -> Result:
    """Simulate a scene (see ``sph.solver.run.run``) and write its trajectory, going on from the checkpoint of the same run if there is one.

    ``seconds`` of wall time lie between checkpoints (0: there are none; by default see ``checkpoint_seconds``); ``say`` is told in a
    line what becomes of them; Ctrl-C leaves one, too.  ``attrs`` go into the file beside those of the run and have no effect on it.  Waits
    for another process at work on the file; what that has finished, or one that was killed, is taken over.  With ``to`` the trajectory is
    written there, and whoever asked for it puts it in its place.
    """
    path = Path(path)
    trajectory.check_name(path)
    seconds = checkpoint_seconds() if seconds is None else seconds
    earlier = {} if restart is None else trajectory.read_run(restart).attrs
    digest, solver = run_digest(scene, until, earlier, "cpu" if backend is None else backend.name), solvers(earlier)
    with alone(path, "run", lambda: say(f"{path}: another process is writing it, waiting for its end")) as followed:
        checkpoint = Checkpoint(path, digest, seconds, say)
        if followed and (finished := _of_this_run(path, digest)):
            tidy(path)
            checkpoint.discard()
            return finished
        begin = partial(Run, scene, threads, enforce_limit, backend)
        started = checkpoint.resumed(begin)
        if started is None:
            started = begin()
            if restart is not None:
                started.resume(restart)
        with checkpoint.on_interrupt():
            result = started.go(until, report, checkpoint.offer)
        result.stored.attrs |= {**(attrs or {}), "run_digest": digest, "solver_digest": solver}
        trajectory.write(to or path, result.stored, result.stored_restart)
        checkpoint.discard()
    return result


def checkpoint_seconds() -> float:
    """``$SPH_CHECKPOINT``, or ``SECONDS``; ValueError for what is no time."""
    text = os.environ.get("SPH_CHECKPOINT", str(SECONDS))
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not seconds >= 0:
        raise ValueError(f"SPH_CHECKPOINT={text}: must be seconds of wall time, 0 for no checkpoints")
    return seconds


def run_digest(scene: Scene, until: Until, earlier: Mapping[str, Any], backend: str = "cpu") -> str:
    """Digest of all that decides the bits of a run: solver, scene, stage, the run gone on from, by its attributes, and the backend."""
    before = earlier.get("run_digest", earlier.get("scene"))
    return hashlib.sha256(
        f"{solver_digest()} {until} {scene.model_dump_json()} {before}{'' if backend == 'cpu' else backend}".encode()
    ).hexdigest()[:16]


def solvers(earlier: Mapping[str, Any]) -> str:
    """Digests of the solvers that made a run: of the run gone on from, by its attributes, and of this one where it is another."""
    before = str(earlier.get("solver_digest", "unknown")) if earlier else ""
    return " ".join(dict.fromkeys([*before.split(), solver_digest()]))


class Checkpoint:
    """The checkpoint of one run."""

    def __init__(self, path: Path, digest: str, seconds: float, say: Say) -> None:
        self.path, self.digest, self.seconds, self.say = beside(path, "checkpoint"), digest, seconds, say
        self.last = clock.monotonic()
        self.offered = self.interrupted = False

    @contextmanager
    def on_interrupt(self) -> Iterator[None]:
        """Have Ctrl-C end the run where it next offers its state, with a checkpoint; a second one, or one before any offer, at once.

        Elsewhere than in the main thread, or where the program does something else at Ctrl-C, nothing changes.
        """
        mine = threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if mine and self.seconds:
            signal.signal(signal.SIGINT, self._interrupt)
        try:
            yield
        finally:
            if mine:
                signal.signal(signal.SIGINT, signal.default_int_handler)

    def _interrupt(self, *_: Any) -> None:
        if self.interrupted or not self.offered:
            raise KeyboardInterrupt
        self.interrupted = True

    def resumed(self, begin: Callable[[], Run]) -> Run | None:
        """A run as the checkpoint has it, from what makes one at its start; None, and a line why, if there is none of this run."""
        if not self.path.exists():
            return None
        started = begin()
        try:
            if trajectory.read(self.path).attrs.get("run_digest") != self.digest:
                raise ValueError(f"{self.path}: of another scene, stage, restart file or solver")
            started.resume(self.path)
        except ValueError as error:
            self.say(f"{error}: this checkpoint is ignored, the run starts anew")
            return None
        self.say(f"{self.path}: goes on from this checkpoint, at {started.simulation.time:g} s")
        return started

    def offer(self, result: Callable[[], Result]) -> None:
        """Write a checkpoint if it is time; a run that cannot keep one goes on without.  KeyboardInterrupt after Ctrl-C."""
        self.offered = True
        if not self.interrupted and (not self.seconds or clock.monotonic() - self.last < self.seconds):
            return
        state = result()
        state.stored.attrs["run_digest"] = self.digest
        try:
            trajectory.write(self.path, state.stored, state.stored_restart)
            if self.interrupted:
                at = float(state.stored["sample_time"].values[-1])
                self.say(f"interrupted at {at:g} s; the same command goes on from there")
        except OSError as error:
            self.say(f"{error}; the run {'ends' if self.interrupted else 'goes on'} without this checkpoint")
        if self.interrupted:
            raise KeyboardInterrupt
        self.last = clock.monotonic()

    def discard(self) -> None:
        """Delete the checkpoint of a finished run, and one that a kill left half written."""
        self.path.unlink(missing_ok=True)
        tidy(self.path)


def _of_this_run(path: Path, digest: str) -> Result | None:
    try:
        run = trajectory.read(path)
        return Result(run, trajectory.read_restart(path), run.attrs["status"]) if run.attrs.get("run_digest") == digest else None
    except ValueError:
        return None
