"""Running a scene: stages, recording, restart and guard.  Scene in, dataset out.

A run advances in blocks of one series interval.  Between blocks it records, reports progress and
looks after the guard.  It can stop early, at the end of the gravity stage or just before the first
failure, and go on from there: until the shaking starts the motion has no effect, and until the first
particle fails neither S_R nor gamma has one, so that a study does that work once.  A run that goes
on from a restart equals an uninterrupted one bit for bit: the restart holds the neighbour lists'
reference positions, and trunk and branch run the same compiled code.
"""

from __future__ import annotations

import functools
import math
import time as clock
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr

from sph.scene.configuration import differences, one_line
from sph.scene.loading import Loading, make_loading
from sph.scene.schema import MOST_STEPS, Scene
from sph.solver.compiled.jit import cache_folder, compile_lock
from sph.solver.compiled.threads import make_team, together
from sph.solver.early_stop import quiet_from, rest_reason
from sph.solver.guard import likely_cause, trouble
from sph.solver.initial_stress import NO_LOADING, impose_stress
from sph.solver.integration import TERM_NAMES, advance, make_lists, renew_candidates
from sph.solver.particles import Particles, locate_probes, place_particles
from sph.solver.physics.coupling import CHUNK, cauchy_stress, elastic_energy
from sph.solver.state import (
    FAILED,
    FAILURES,
    GRAVITY,
    INTERNAL,
    MASS_DAMPING,
    REPULSION,
    SHAKING,
    VISCOUS,
    WALLS,
    DrivenTerm,
    State,
    Terms,
    initial_state,
    make_terms,
)
from sph.solver.time_step import PresentLimit, check_time_step, mode_of, stiffest_frequency
from sph.storage import trajectory

Until = Literal["end", "gravity", "first_failure"]
FIRST_TURNS, TURNS = 60, 6
"""Turns of the power iteration that measures the limit of the time step, at the start and at every frame."""

BRANCH_KEYS = ("coupling.S_R", "coupling.gamma", "coupling.fluid_tension_limit", "layers.*.S_R", "layers.*.gamma")
"""Keys without effect before the first failure; * stands for a name."""
RESTART_DIMS = {
    "work": ("row",),
    "reaction_x": ("moving_boundary",),
    "reaction_y": ("moving_boundary",),
    "free_field": ("direction", "quantity", "node"),
}
"""Dimensions of the state's arrays in a restart; the others go over the particles."""
FREE_KEYS = ("name", "title", "duration")
"""Keys that a restarted run may change at any time."""


class Progress(NamedTuple):
    """How far a run is."""

    time: float  # simulated, s
    duration: float  # s
    particle_steps: int  # made since this process started
    elapsed: float  # s of this process
    failed_fraction: float


class Result(NamedTuple):
    """A run's trajectory, its restart state and its status (see ``trajectory.STATUSES``)."""

    trajectory: xr.Dataset
    restart: xr.Dataset
    status: str


class Run:
    """One simulation under way: state, lists, and what has been recorded."""

    def __init__(self, scene: Scene, threads: int = 1, enforce_limit: bool = True) -> None:
        self.scene = scene
        self.enforce_limit = enforce_limit
        self.particles: Particles = place_particles(scene)
        self.terms: Terms = make_terms(scene, self.particles)
        self.loading: Loading = make_loading(scene)
        self.state: State = initial_state(self.particles, scene)
        impose_stress(self.state, scene, self.particles, self.terms.n_stressed)
        self.probes = locate_probes(scene, self.particles)
        self.landmarks = landmarks(scene)
        self.wanted = wanted_terms(scene)
        self.team = make_team(threads, self.particles.x.size, FAILURES + 1, CHUNK)
        self.ended = ("", "")
        self.step = 0
        self.substeps = 1
        self.limit = math.inf
        self.steps_made = 0
        self.earlier_wall_time = 0.0
        self.earlier_particle_steps = 0
        self._frames: dict[str, list[np.ndarray]] = {v.name: [] for v in trajectory.VARIABLES if v.dims[0] == "frame"}
        self._series: dict[str, list[Any]] = {v.name: [] for v in trajectory.VARIABLES if v.dims[0] == "sample"}

    # ------------------------------------------------------------ stepping

    def prepare(self) -> None:
        """Check the time step, compile or load the variant this scene needs, and make the neighbour lists."""
        with compile_lock():
            if self.enforce_limit:
                check_time_step(self.scene)
            self.present_limit = PresentLimit(self.scene)
            self.candidates, self.pairs = make_lists(self.state, self.terms)
            self.advance_steps(0)
            self.measure_limit(FIRST_TURNS if self.step == 0 else 0)
            # At the places of the last candidates: those of a run that diverged need not be numbers.
            spare = State(*(a.copy() for a in self.state))
            renew_candidates(spare._replace(x=spare.x_candidates, y=spare.y_candidates), self.terms)
            elastic_energy(self.state, self.terms)
            cauchy_stress(self.state, self.terms, np.empty((self.state.x.size, 4)))
        if self.enforce_limit and self.step == 0 and self.scene.numerics.adaptive_step is None and self.terms.dt >= self.limit:
            raise ValueError(
                f"numerics.time_step: {self.terms.dt:g} s exceeds the limit measured on the particles at the start, {self.limit:.3g} s; "
                "choose a smaller step"
            )

    def advance_steps(self, n_steps: int) -> tuple[int, int]:
        """Advance by a number of the scene's time steps; how many particles failed, and how many steps were made."""
        failed = 0
        first, last = self.step * self.substeps, (self.step + n_steps) * self.substeps
        step, kicked = first, False
        while True:
            new, done, spent, compiled = together(
                advance, self.team, self.state, self.candidates, self.pairs, self.terms, self.particles.mass,
                self.loading, step, last - step, kicked,
            )[0]  # fmt: skip
            if tuple(compiled) != self.wanted:
                raise RuntimeError(
                    f"the compiled solver holds the terms {dict(zip(TERM_NAMES, compiled, strict=True))}, the scene wants "
                    f"{dict(zip(TERM_NAMES, self.wanted, strict=True))}; delete the cache folder {cache_folder()} and run again"
                )
            failed, step = failed + new, step + done
            if not spent:
                break
            self.candidates, self.pairs = renew_candidates(self.state, self.terms)
            kicked = True
        self.steps_made += step - first
        made = (step - first) // self.substeps
        self.step += made
        return failed, made

    def measure_limit(self, turns: int) -> None:
        """Measure the limit of the time step as the particles lie."""
        frequency = stiffest_frequency(mode_of(self.state), self.pairs, self.terms, self.team[0].gradient, turns)
        if turns:
            self.limit = self.present_limit.seconds(frequency)

    def _adapt(self) -> None:
        """Divide the time step so that it keeps to the limit, if the scene wants that."""
        adaptive = self.scene.numerics.adaptive_step
        if adaptive is not None:
            longest, most = adaptive.courant * self.limit, MOST_STEPS // self.scene.steps(self.scene.duration)
            if most * longest < self.scene.numerics.time_step:
                self.ended = ("diverged", f"the limit of the time step fell to {self.limit:.3g} s at {self.time:.4f} s")
            else:
                self._divide(max(1, math.ceil(self.scene.numerics.time_step / longest)))

    def _divide(self, substeps: int) -> None:
        if substeps != self.substeps:
            self.substeps = substeps
            self.terms = make_terms(self.scene, self.particles, substeps)
            self.loading = make_loading(self.scene, substeps)

    def balance(self) -> None:
        """Make the initial stress act from the first kick on: a step without loads, before the first, in which nothing moves.

        It returns the stress to the yield surface and computes the accelerations.  The energy stored so far counts as work done.
        """
        loading, terms, velocity = self.loading, self.terms, (self.state.vx.copy(), self.state.vy.copy())
        still = None if terms.driven is None else DrivenTerm(0.0, 0.0, 0.0, 0.0)
        self.loading, self.terms = NO_LOADING, terms._replace(driven=still)
        self.state.vx[:] = self.state.vy[:] = 0.0
        self.step = -1
        self.advance_steps(1)
        self.step, self.loading, self.terms = 0, loading, terms
        self.state.vx[:], self.state.vy[:] = velocity
        self.state.work[INTERNAL] = elastic_energy(self.state, self.terms)

    def go(
        self,
        until: Until = "end",
        report: Callable[[Progress], None] | None = None,
        checkpoint: Callable[[Callable[[], Result]], None] | None = None,
    ) -> Result:
        """Run to the wanted point; the status says how it ended.

        Between blocks ``checkpoint`` is offered the run so far, as a function that makes its result; its time is not counted.
        """
        scene = self.scene
        block = scene.steps(scene.outputs.series_interval)
        last = scene.steps(scene.gravity.duration if until == "gravity" else scene.duration)
        self.prepare()
        started = clock.perf_counter()
        first_steps_made = self.steps_made
        status, reason = self.ended
        if self.step == 0 and not self._series["sample_time"]:
            if scene.gravity.initial_stress != "none":
                self.balance()
            self._adapt()
            self._record()
            status, reason = self.ended
        while self.step < last and not status and not self._rest():
            saved = self._copy() if until == "first_failure" else None
            failed, done = self.advance_steps(block)
            if saved is not None and failed:
                self._restore(saved)
                status, reason = "paused", "before the first failure"
                break
            if done == block:
                self._record()
                status, reason = self.ended
            wrong = trouble(scene, self.particles, self.state, self._series, jumped=done < block)
            if wrong:
                status, reason = "diverged", f"{wrong}, at {self.time:.4f} s; {likely_cause(scene, self._largest_ratio(), wrong)}"
                break
            if report is not None:
                steps = (self.steps_made - first_steps_made) * self.state.x.size
                report(
                    Progress(
                        self.time,
                        last * scene.numerics.time_step,
                        steps,
                        clock.perf_counter() - started,
                        self._series["failed_fraction"][-1],
                    )
                )
            if checkpoint is not None and not status:
                paused = clock.perf_counter()
                steps = (self.steps_made - first_steps_made) * self.state.x.size
                checkpoint(functools.partial(self._result, "paused", "checkpoint", paused - started, steps))
                started += clock.perf_counter() - paused
        if not status:
            rest = self._rest()
            done_all = bool(rest) or self.step >= scene.steps(scene.duration)
            if done_all:
                status, reason = self._finished(rest)
            else:
                status, reason = "paused", "at the end of the gravity stage"
            if rest and self._frames["time"][-1] < self.time:
                self._record_frame()
        elapsed = clock.perf_counter() - started
        return self._result(status, reason, elapsed, (self.steps_made - first_steps_made) * self.state.x.size)

    def _finished(self, rest: str) -> tuple[str, str]:
        """Status and reason of a run that has reached its duration or came to ``rest``."""
        unshaken = float(np.mean(self.scene.gravity.failed(self.state.t_f[: self.particles.n_soil])))
        if unshaken > 0.0:
            return "failed_unshaken", "; ".join(filter(None, (f"{unshaken:.2%} of the soil yields under gravity alone", rest)))
        return "complete" if np.any(self.state.phase == FAILED) else "unfailed", rest

    def _largest_ratio(self) -> float:
        """Largest time step over its measured limit, over the frames."""
        return float(np.max(np.array(self._frames["time_step"]) / np.array(self._frames["time_step_limit"]), initial=0.0))

    def _rest(self) -> str:
        return rest_reason(self.scene, self.step, self._series, self.state, float(self.particles.mass[: self.particles.n_soil].sum()))

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.step * self.scene.numerics.time_step

    def _copy(self) -> tuple[Any, ...]:
        return State(*(a.copy() for a in self.state)), self.candidates, self.step

    def _restore(self, saved: tuple[Any, ...]) -> None:
        self.state, self.candidates, self.step = saved

    # ------------------------------------------------------------ recording

    def _record(self) -> None:
        scene, state, n_soil = self.scene, self.state, self.particles.n_soil
        regular = self.step % scene.steps(scene.outputs.frame_interval) == 0
        if regular and self.step:
            self.measure_limit(TURNS)
        if self._has_frame(self.step):
            self._record_frame()
        if regular:
            self._adapt()
        soil, moving = slice(0, n_soil), slice(0, self.terms.n_moving)
        speed_square = state.vx[moving] ** 2 + state.vy[moving] ** 2
        work = state.work
        elastic = elastic_energy(state, self.terms)
        at = np.array(list(self.probes.values()), dtype=int)
        sample = {
            "sample_time": self.time,
            "probe_displacement_x": state.x[at] - self.particles.x[at],
            "probe_displacement_y": state.y[at] - self.particles.y[at],
            "probe_velocity_x": state.vx[at],
            "probe_velocity_y": state.vy[at],
            "ground_acceleration": self.loading.ground[self.step * self.substeps],
            "ground_acceleration_y": self.loading.vertical[self.step * self.substeps],
            "kinetic_energy": 0.5 * float(self.particles.mass[moving] @ speed_square),
            "elastic_energy": elastic + work[REPULSION],
            "potential_energy": -work[GRAVITY],
            "dissipated_energy": work[INTERNAL] - elastic + work[MASS_DAMPING] + work[VISCOUS] + work[WALLS],
            "shaking_work": work[SHAKING],
            "failed_fraction": float(np.mean(state.phase[soil] == FAILED)),
            "maximum_speed": float(np.sqrt(speed_square[soil].max())),
        }
        for name, values in self._series.items():
            values.append(sample[name])

    def _has_frame(self, step: int) -> bool:
        """Whether the fields are stored at a step: at every interval, and at the ends of the gravity stage, the shaking and the run."""
        return step % self.scene.steps(self.scene.outputs.frame_interval) == 0 or step in self.landmarks

    def _record_frame(self) -> None:
        state = self.state
        stress = np.empty((state.x.size, 4))
        cauchy_stress(state, self.terms, stress)
        frame = {
            "time": self.time,
            "time_step": self.terms.dt,
            "time_step_limit": self.limit,
            "x": state.x,
            "y": state.y,
            "displacement_x": state.x - self.particles.x,
            "displacement_y": state.y - self.particles.y,
            "velocity_x": state.vx,
            "velocity_y": state.vy,
            "stress_xx": stress[:, 0],
            "stress_yy": stress[:, 1],
            "stress_zz": stress[:, 2],
            "stress_xy": stress[:, 3],
            "density": state.density * (self.particles.mass / self.terms.cell_mass),
            "beta": state.beta,
            "failed": state.phase == FAILED,
        }
        for name, values in self._frames.items():
            values.append(np.array(frame[name], dtype=trajectory.BY_NAME[name].dtype))

    def _result(self, status: str, reason: str, elapsed: float, particle_steps: int) -> Result:
        wall_time = self.earlier_wall_time + elapsed
        total = self.earlier_particle_steps + particle_steps
        arrays: dict[str, np.ndarray] = {
            "x0": self.particles.x,
            "y0": self.particles.y,
            "kind": self.particles.kind,
            "mass": self.particles.mass,
            "layer": self.particles.layer,
            "t_f": self.state.t_f,
            "probe_particle": np.array(list(self.probes.values()), dtype=int),
        }
        for name, values in (self._frames | self._series).items():
            variable = trajectory.BY_NAME[name]
            shape = (len(values), *(self._size(dim) for dim in variable.dims[1:]))
            arrays[name] = np.array(values, dtype=variable.dtype).reshape(shape)
        attrs = trajectory.run_attributes(self.scene) | {
            "status": status,
            "status_reason": reason,
            "wall_time_s": wall_time,
            "particle_steps": total,
            "particle_steps_per_second": total / wall_time if wall_time > 0 else 0.0,
            "neighbours_mean": float((self.pairs.end - self.pairs.start).mean()),
            "active_terms": " ".join(n for n, on in zip(TERM_NAMES, self.wanted, strict=True) if on),
        }
        ds = trajectory.dataset(arrays, list(self.probes), attrs)
        restart = xr.Dataset({name: (RESTART_DIMS.get(name, ("particle",)), a) for name, a in self._kept().items()})
        restart.attrs |= {"step": self.step, "substeps": self.substeps}
        return Result(ds, restart, status)

    def _kept(self) -> dict[str, np.ndarray]:
        """The arrays of the state by name, but those of terms that the scene does not have."""
        return {name: array for name, array in self.state._asdict().items() if array.size}

    def _size(self, dim: str) -> int:
        return {"particle": self.particles.x.size, "probe": len(self.probes)}[dim]

    # ------------------------------------------------------------ restart

    def resume(self, path: Path | str) -> None:
        """Take over state and history of a paused run; ValueError if it belongs to another scene.

        A run that diverged stays diverged: it is taken over as it is and not run on.
        """
        old, restart = trajectory.read_run(path), trajectory.read_restart(path)
        missing = [name for name in self._kept() if name not in restart] + ["step"] * ("step" not in restart.attrs)
        if missing:
            raise ValueError(f"{path}: its restart state lacks {', '.join(missing)}; it was written by another version, run it again")
        failed = bool((restart["phase"] == FAILED).any())
        time = float(old["sample_time"][-1])
        check_restart(trajectory.scene_of(old, str(path)), self.scene, time, failed, path)
        self.step = int(restart.attrs["step"])
        wrong = [name for name, array in self._kept().items() if restart[name].shape != array.shape]
        if wrong or self.step != self.scene.steps(time):
            raise ValueError(f"{path}: its restart state does not belong to its trajectory ({', '.join(wrong) or f'step {self.step}'})")
        for name, array in self._kept().items():
            array[...] = restart[name].values
        substeps = int(restart.attrs.get("substeps", 1))
        most = 1 if self.scene.numerics.adaptive_step is None else MOST_STEPS // self.scene.steps(self.scene.duration)
        if substeps > most:
            raise ValueError(f"{path}: its restart state divides the time step by {substeps}, at most by {most}; run it again")
        self._divide(substeps)
        self.limit = float(old["time_step_limit"][-1])
        # The end of a shorter run is no frame of a longer one.
        frames = [number for number, at in enumerate(old["time"].values) if self._has_frame(self.scene.steps(float(at)))]
        for name in self._frames:
            self._frames[name] = list(old[name].values[frames])
        for name in self._series:
            self._series[name] = list(old[name].values)
        # The last sample's kick is still to come, under this scene's motion, which may not be that of the gravity stage.
        self._series["ground_acceleration"][-1] = self.loading.ground[self.step * self.substeps]
        self._series["ground_acceleration_y"][-1] = self.loading.vertical[self.step * self.substeps]
        if old.attrs["status"] == "diverged":
            self.ended = ("diverged", str(old.attrs["status_reason"]))
        self.earlier_wall_time = float(old.attrs["wall_time_s"])
        self.earlier_particle_steps = int(old.attrs["particle_steps"])


def run(
    scene: Scene,
    until: Until = "end",
    restart: Path | str | None = None,
    report: Callable[[Progress], None] | None = None,
    threads: int = 1,
    enforce_limit: bool = True,
) -> Result:
    """Simulate a scene, from the start or from a paused run's file; the number of threads does not change a bit of the result.

    ValueError for a fixed time step above its limit, unless that is what is to be seen (``enforce_limit``).
    """
    simulation = Run(scene, threads, enforce_limit)
    if restart is not None:
        simulation.resume(restart)
    return simulation.go(until, report)


def landmarks(scene: Scene) -> set[int]:
    """Steps with a frame whatever the interval of frames: the end of the gravity stage, the last sample of the shaking, the end."""
    sample = scene.steps(scene.outputs.series_interval)
    shaken = math.floor((quiet_from(scene) / scene.outputs.series_interval) * (1 + 1e-9)) * sample
    return {scene.steps(scene.gravity.duration), shaken, scene.steps(scene.duration)}


def wanted_terms(scene: Scene) -> tuple[bool, ...]:
    """Which optional terms a scene asks for, in the order of ``TERM_NAMES``."""
    numerics = scene.numerics
    return (
        numerics.kernel == "wendland_c2",
        scene.coupling.fluid.law == "capped_viscosity",
        scene.damping is not None,
        numerics.artificial_viscosity is not None,
        numerics.gradient_correction is not None,
        numerics.short_range_repulsion is not None,
        "free_slip" in (scene.walls.base, scene.walls.top, scene.walls.sides),
        scene.walls.hold,
        scene.walls.friction is not None,
        scene.walls.sides == "periodic",
        numerics.artificial_stress is not None,
        scene.prescribed_velocity_gradient is not None,
        bool(scene.layers),
        "absorbing" in (scene.walls.base, scene.walls.sides),
        scene.walls.sides == "absorbing",
    )


def check_restart(old: Scene, new: Scene, time: float, failed: bool, path: Path | str) -> None:
    """Refuse a restart whose past differs from the new scene's; ValueError names the keys."""
    free = FREE_KEYS + (() if failed else BRANCH_KEYS)
    if time <= old.gravity.duration + 0.5 * old.numerics.time_step:
        free += ("motion",)
    if time <= quiet_from(old) + 0.5 * old.numerics.time_step:
        free += ("early_stop",)
    bad = [
        one_line(f"{name}: {past!r} in the file, {future!r} in the scene")
        for name, (past, future) in differences(old.model_dump(), new.model_dump()).items()
        if not is_among(name, free)
    ]
    if bad:
        raise ValueError(f"{path}: cannot go on from this run at {time:g} s, its scene differs in\n  " + "\n  ".join(bad))
    if time > new.duration:
        raise ValueError(f"{path}: the run is already at {time:g} s, later than duration: {new.duration} s")


def is_among(name: str, keys: Iterable[str]) -> bool:
    """Whether a dotted key, or the section that it stands in, is one of these keys."""
    return any(fnmatchcase(part, key) for key in keys for part in (name, name.split(".")[0]))
