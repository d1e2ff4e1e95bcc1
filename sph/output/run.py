"""A run as it is measured and drawn: its scene, its stored arrays and what follows from both, each read or worked out once.

Displacements are those *since the end of the gravity stage*: the settlement while gravity is brought on belongs to the set-up of the
model and is left out.
"""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.particles import SOIL, strength_at
from sph.storage import trajectory
from sph.storage.netcdf import Group
from sph.storage.trajectory import scene_of

if TYPE_CHECKING:
    import xarray as xr

MARK = "coordinates_of"
"""Attribute of a trajectory in the coordinates of the survey (``sph.output.surveyed``), with the value ``survey``."""


class ProbeHistory(NamedTuple):
    """Motion of one probe since the end of the gravity stage, relative to the box."""

    time: np.ndarray  # (samples,) s; the first is the end of the gravity stage
    displacement_horizontal: np.ndarray  # (samples,) m, positive to the right
    displacement_vertical: np.ndarray  # (samples,) m, positive upwards
    speed: np.ndarray  # (samples,) m/s
    gravity_stage_displacement: float  # length of the displacement in the gravity stage, m

    @property
    def displacement_magnitude(self) -> np.ndarray:
        """Length of the displacement (samples,), m."""
        return np.hypot(self.displacement_horizontal, self.displacement_vertical)


class Run:
    """A run that has been made.  ``run[name]`` is a stored array, by the name that ``sph.storage.trajectory.VARIABLES`` gives it.

    Raises ValueError for a trajectory in the survey's coordinates, which cannot be measured or drawn.
    """

    def __init__(self, stored: Group | xr.Dataset, scene: Scene | None = None, origin: str = "trajectory") -> None:
        """Of a trajectory, or the trials of a search, and their ``scene`` where it is known; else that of the file is built once."""
        if MARK in stored.attrs:
            raise ValueError(
                "the trajectory is in the coordinates of the survey; give it as it is stored, as sph.read_run without survey=True"
            )
        self.stored: Group | xr.Dataset = stored
        self._origin, self._histories = origin, dict[str, ProbeHistory]()
        if scene is not None:
            self.scene = scene

    @classmethod
    def of(cls, run: Run | Group | xr.Dataset) -> Run:
        """The view of a run, or of its trajectory."""
        return run if isinstance(run, Run) else cls(run)

    @classmethod
    def read(cls, path: Path | str, scene: Scene | None = None) -> Run:
        """The run of a file, and its ``scene`` where it is known; ValueError names a file that lacks a variable or fact of a run, as that
        of a search does, or whose scene is refused."""
        run = cls(trajectory.read_run(path), scene, str(path))
        run.scene  # noqa: B018  refused here, by the name of the file
        return run

    @property
    def trajectory(self) -> xr.Dataset:
        """The run as a dataset, which holds it from then on, so that what is changed in it is changed in the run."""
        if isinstance(self.stored, Group):
            self.stored = self.stored.dataset()
        return self.stored

    @functools.cached_property
    def scene(self) -> Scene:
        """The scene of the run; ValueError where what is stored cannot be read or is refused."""
        return scene_of(self.stored, self._origin)

    @property
    def attrs(self) -> dict[str, Any]:
        """The facts of the run: ``sph.storage.trajectory.FACTS`` and others."""
        return self.stored.attrs

    @property
    def status(self) -> str:
        """How it ended (``sph.storage.trajectory.Status``)."""
        return str(self.attrs.get("status"))

    def __contains__(self, name: str) -> bool:
        return name in self.stored

    def __getitem__(self, name: str) -> np.ndarray:
        return self.stored[name].values

    @functools.cached_property
    def soil(self) -> np.ndarray:
        """Which particles (particles,) are soil."""
        return self["kind"] == SOIL

    def soil_at(self, frame: int, *names: str) -> tuple[np.ndarray, ...]:
        """Particle fields of the soil (soil,) in a frame, in double precision, in the order of their names."""
        return tuple(self[name][frame, self.soil].astype(float) for name in names)

    @functools.cached_property
    def strength(self) -> np.ndarray:
        """Peak cohesion (Pa) and friction angle (rad) of every particle (2, particles)."""
        return strength_at(self.scene, self["x0"], self["y0"], self["layer"], int(np.count_nonzero(self.soil)))

    @property
    def time_step_ratio(self) -> float:
        """Largest time step over its limit as measured during the run."""
        return float(np.fmax.reduce(self["time_step"] / self["time_step_limit"]))

    def last_at(self, times: np.ndarray, time: float) -> int:
        """Index of the last of ``times`` (s) not later than ``time`` (s), to half a time step; ValueError if there is none."""
        index = int(np.searchsorted(times, time + 0.5 * self.scene.numerics.time_step, side="right")) - 1
        if index < 0:
            raise ValueError(f"time: {time} s lies before the first stored time ({times[0] if len(times) else 'none'} s)")
        return index

    @functools.cached_property
    def gravity_frame(self) -> int:
        """Index of the last frame not later than the end of the gravity stage."""
        return self.last_at(self["time"], self.scene.gravity.duration)

    def displacement(self, frame: int = -1) -> tuple[np.ndarray, np.ndarray]:
        """Horizontal and vertical displacement of every particle since the end of the gravity stage, each (particles,), m."""
        start = self.gravity_frame
        (x, x_start), (y, y_start) = (self[f"displacement_{axis}"][[frame, start]].astype(float) for axis in "xy")
        return x - x_start, y - y_start

    @property
    def probes(self) -> list[str]:
        """Names of the probes."""
        return [str(name) for name in self["probe"]]

    def history(self, probe: str) -> ProbeHistory:
        """Motion of a probe since the end of the gravity stage; ValueError if there is no such probe."""
        if probe not in self.probes:
            raise ValueError(f"probe: {probe!r} is not among the probes of the trajectory {self.probes}")
        if probe not in self._histories:
            time, at = self["sample_time"], self.probes.index(probe)
            start = self.last_at(time, self.scene.gravity.duration)
            names = "displacement_x", "displacement_y", "velocity_x", "velocity_y"
            ux, uy, vx, vy = (self[f"probe_{name}"][start:, at] for name in names)
            settlement = float(np.hypot(ux[0], uy[0]))
            self._histories[probe] = ProbeHistory(time[start:], ux - ux[0], uy - uy[0], np.hypot(vx, vy), settlement)
        return self._histories[probe]
