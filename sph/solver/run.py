"""Running a scene: stages, recording and guard.  Scene in, trajectory out.

A run advances in blocks of one series interval.  Between blocks it records, reports progress and checks that the run is sound.
It can stop early, at the end of the gravity stage or just before the first
failure, and go on from there: until the shaking starts the motion has no effect, and until the first
particle fails neither S_R nor gamma has one, so that a study does that work once (``sph.solver.restart``).
"""

from __future__ import annotations

import functools
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

import numpy as np

from sph.scene.gravity import MOVED, UNSHAKEN
from sph.scene.motion import NoMotion
from sph.scene.schema import Scene
from sph.scene.units import in_both
from sph.solver.early_stop import rest_reason
from sph.solver.guard import likely_cause, trouble
from sph.solver.recording import Recording
from sph.solver.restart import restart_of, take_over
from sph.solver.simulation import POWER_ITERATIONS, Simulation
from sph.solver.state import FAILED
from sph.storage import trajectory
from sph.storage.netcdf import Group
from sph.storage.trajectory import Status

if TYPE_CHECKING:
    import xarray as xr

Until = Literal["end", "gravity", "first_failure"]


class Backend(Protocol):
    """What advances scenes elsewhere than on the processor."""

    name: str

    def simulation(self, scene: Scene, enforce_limit: bool) -> Simulation:
        """A scene's simulation."""


class Progress(NamedTuple):
    """How far a run is."""

    time: float  # simulated, s
    duration: float  # s
    particle_steps: int  # made since this process started
    elapsed: float  # s of this process
    failed_fraction: float


@dataclass(frozen=True)
class Result:
    """A run's trajectory, its restart state and its status (see ``sph.storage.trajectory.Status``)."""

    stored: Group  # the trajectory as it is written
    stored_restart: Group
    status: str

    @functools.cached_property
    def trajectory(self) -> xr.Dataset:
        """The trajectory, with the variables of ``sph.storage.trajectory.VARIABLES``."""
        return self.stored.dataset()

    @functools.cached_property
    def restart(self) -> xr.Dataset:
        """The state from which a run goes on bit for bit."""
        return self.stored_restart.dataset()


class Run:
    """One run under way: its simulation, by a backend or else on the processor, and what has been recorded of it."""

    def __init__(self, scene: Scene, threads: int = 1, enforce_limit: bool = True, backend: Backend | None = None) -> None:
        self.simulation = Simulation(scene, threads, enforce_limit) if backend is None else backend.simulation(scene, enforce_limit)
        self.recording = Recording(self.simulation)
        self.ended = ("", "")
        self.backends = self.simulation.backend
        self.earlier_wall_time = 0.0
        self.earlier_particle_steps = 0

    def resume(self, path: Path | str) -> None:
        """Take over state and history of a paused run; ValueError if it belongs to another scene.

        A run that diverged stays diverged: it is taken over as it is and not run on.
        """
        old = trajectory.read_run(path)
        take_over(self.simulation, old, trajectory.read_restart(path), path)
        self.recording.take_over(old)
        if old.attrs["status"] == "diverged":
            self.ended = (Status.DIVERGED, str(old.attrs["status_reason"]))
        self.backends = " ".join(dict.fromkeys([*str(old.attrs.get("backend", "cpu")).split(), self.simulation.backend]))
        self.earlier_wall_time = float(old.attrs["wall_time_s"])
        self.earlier_particle_steps = int(old.attrs["particle_steps"])

    def go(
        self,
        until: Until = "end",
        report: Callable[[Progress], None] | None = None,
        checkpoint: Callable[[Callable[[], Result]], None] | None = None,
    ) -> Result:
        """Run to the wanted point; the status says how it ended.

        Between blocks ``checkpoint`` is offered the run so far, as a function that makes its result; its time is not counted.
        """
        scene, simulation, recording = self.simulation.scene, self.simulation, self.recording
        block = scene.steps(scene.outputs.series_interval)
        last = scene.steps(scene.gravity.duration if until == "gravity" else scene.duration)
        simulation.prepare()
        started = clock.perf_counter()
        first_steps_made = simulation.steps_made
        status, reason = self.ended
        if simulation.step == 0 and not recording.series["sample_time"]:
            if scene.gravity.initial_stress != "none":
                simulation.balance()
            self._adapt()
            self._record()
            status, reason = self.ended
        while simulation.step < last and not status and not self._rest():
            saved = simulation.saved() if until == "first_failure" else None
            failed, done = simulation.advance_steps(block)
            if saved is not None and failed:
                simulation.go_back(saved)
                status, reason = Status.PAUSED, "before the first failure"
                break
            if done == block:
                self._record()
                status, reason = self.ended
            wrong = trouble(scene, simulation.particles, simulation.state, recording.series, jumped=done < block)
            if wrong:
                status, reason = (
                    Status.DIVERGED,
                    f"{wrong}, at {simulation.time:.4f} s; {likely_cause(scene, recording.largest_ratio(), wrong)}",
                )
                break
            if report is not None:
                steps = (simulation.steps_made - first_steps_made) * simulation.state.x.size
                report(
                    Progress(
                        simulation.time,
                        last * scene.numerics.time_step,
                        steps,
                        clock.perf_counter() - started,
                        recording.series["failed_fraction"][-1],
                    )
                )
            if checkpoint is not None and not status:
                paused = clock.perf_counter()
                steps = (simulation.steps_made - first_steps_made) * simulation.state.x.size
                elapsed = paused - started - simulation.waited
                checkpoint(functools.partial(self._result, Status.PAUSED, "checkpoint", elapsed, steps))
                started += clock.perf_counter() - paused
        if not status:
            rest = self._rest()
            done_all = bool(rest) or simulation.step >= scene.steps(scene.duration)
            if done_all:
                status, reason = self._finished(rest)
            else:
                status, reason = Status.PAUSED, "at the end of the gravity stage"
            if rest and recording.frames["time"][-1] < simulation.time:
                recording.add_frame()
        elapsed = clock.perf_counter() - started - simulation.waited
        return self._result(status, reason, elapsed, (simulation.steps_made - first_steps_made) * simulation.state.x.size)

    def _finished(self, rest: str) -> tuple[str, str]:
        """Status and reason of a run that has reached its duration or came to ``rest``."""
        simulation = self.simulation
        scene, n_soil, t_f = simulation.scene, simulation.particles.n_soil, simulation.state.t_f[: simulation.particles.n_soil]
        particles, soil = simulation.particles, slice(0, n_soil)
        unshaken, layer = scene.unshaken(t_f, scene.held(particles.x[soil], particles.y[soil])), particles.layer[soil]
        parts = [f"{np.mean(unshaken[layer == k]):.2%} of {name}" for k, name in enumerate(scene.layers, 1) if unshaken[layer == k].any()]
        share = f"{np.mean(unshaken):.2%} of the soil yields under gravity alone" if unshaken.any() else ""
        share += f" ({', '.join(parts)})" if parts else ""
        later = t_f[unshaken & ~scene.gravity.failed(t_f)]
        if not isinstance(scene.motion, NoMotion) and np.any(later >= scene.motion.start):
            share += f", while the ground is shaken by less than {in_both(UNSHAKEN * scene.gravity.acceleration)}"
        reason = "; ".join(filter(None, (share, rest)))
        moved = self.recording.moved_since(scene.gravity.duration) > MOVED * (scene.geometry.crest[1] - scene.geometry.toe[1])
        if scene.fails_unshaken(*map(int, map(np.count_nonzero, (unshaken, moved, moved & unshaken)))):
            return Status.FAILED_UNSHAKEN, reason
        return Status.COMPLETE if np.any(simulation.state.phase == FAILED) else Status.UNFAILED, reason

    def _rest(self) -> str:
        """Why the run may end here, or empty."""
        simulation = self.simulation
        soil_mass = float(simulation.particles.mass[: simulation.particles.n_soil].sum())
        return rest_reason(simulation.scene, simulation.step, self.recording.series, simulation.state, soil_mass)

    def _record(self) -> None:
        """Record the present step; at every interval of frames measure the limit of the time step before, and adapt to it after."""
        simulation, recording = self.simulation, self.recording
        regular = recording.is_regular()
        if regular and simulation.step:
            simulation.measure_limit(POWER_ITERATIONS)
        if recording.has_frame(simulation.step):
            recording.add_frame()
        if regular:
            self._adapt()
        recording.add_sample()

    def _adapt(self) -> None:
        reason = self.simulation.adapt()
        if reason:
            self.ended = (Status.DIVERGED, reason)

    def _result(self, status: str, reason: str, elapsed: float, particle_steps: int) -> Result:
        simulation = self.simulation
        wall_time = self.earlier_wall_time + elapsed
        total = self.earlier_particle_steps + particle_steps
        attrs = {
            "status": str(status),
            "status_reason": reason,
            "wall_time_s": wall_time,
            "particle_steps": total,
            "particle_steps_per_second": total / wall_time if wall_time > 0 else 0.0,
            "neighbours_mean": simulation.mean_neighbours(),
            "active_terms": " ".join(name for name, on in simulation.wanted.items() if on),
        }
        if self.backends != "cpu":
            attrs["backend"] = self.backends
        return Result(self.recording.trajectory(attrs), restart_of(simulation), str(status))


def run(
    scene: Scene,
    until: Until = "end",
    restart: Path | str | None = None,
    report: Callable[[Progress], None] | None = None,
    threads: int = 1,
    enforce_limit: bool = True,
    backend: Backend | None = None,
) -> Result:
    """Simulate a scene, from the start or from a paused run's file; the number of threads does not change a bit of the result.

    ValueError for a fixed time step above its limit, unless that is what is to be seen (``enforce_limit``).
    """
    simulation = Run(scene, threads, enforce_limit, backend)
    if restart is not None:
        simulation.resume(restart)
    return simulation.go(until, report)
