"""Quantities of a frame or of a probe that metrics and figures share.

Displacements are those *since the end of the gravity stage*: the settlement while gravity is brought
on belongs to the set-up of the model and is left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from sph.measures.mobilised import mobilised
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.storage.trajectory import Status, scene_of


def with_end(name: str, trajectory: xr.Dataset) -> str:
    """A name for figures, with the time at which the guard stopped the run, or with the remark that the slope fails without shaking."""
    ends = {Status.DIVERGED: f"diverged at {float(trajectory['sample_time'][-1]):.3g} s", Status.FAILED_UNSHAKEN: "fails without shaking"}
    return ", ".join(filter(None, (name, ends.get(trajectory.attrs["status"]))))


class ProbeHistory(NamedTuple):
    """Motion of one probe since the end of the gravity stage, relative to the box."""

    time: np.ndarray  # (samples,) s; the first is the end of the gravity stage
    horizontal: np.ndarray  # (samples,) m, positive to the right
    vertical: np.ndarray  # (samples,) m, positive upwards
    speed: np.ndarray  # (samples,) m/s
    settlement: float  # length of the displacement in the gravity stage, m

    @property
    def magnitude(self) -> np.ndarray:
        """Length of the displacement, m."""
        return np.hypot(self.horizontal, self.vertical)


class Field(NamedTuple):
    """A particle field that can be plotted: label, unit and how it follows from a frame."""

    label: str
    units: str
    of: Callable[[xr.Dataset, int], np.ndarray]


def last_at(times: np.ndarray, time: float, scene: Scene) -> int:
    """Index of the last of ``times`` (s) not later than ``time`` (s), to half a time step; ValueError if there is none."""
    index = int(np.searchsorted(times, time + 0.5 * scene.numerics.time_step, side="right")) - 1
    if index < 0:
        raise ValueError(f"time: {time} s lies before the first stored time ({times[0] if len(times) else 'none'} s)")
    return index


def gravity_frame(trajectory: xr.Dataset) -> int:
    """Index of the last frame not later than the end of the gravity stage."""
    scene = scene_of(trajectory)
    return last_at(trajectory["time"].values, scene.gravity.duration, scene)


def displacement(trajectory: xr.Dataset, frame: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal and vertical displacement of every particle since the end of the gravity stage, each (particles,), m."""
    start = gravity_frame(trajectory)
    (x, x_start), (y, y_start) = (trajectory[f"displacement_{axis}"].values[[frame, start]].astype(float) for axis in "xy")
    return x - x_start, y - y_start


def probe_history(trajectory: xr.Dataset, probe: str) -> ProbeHistory:
    """Motion of a probe since the end of the gravity stage; ValueError if there is no such probe."""
    names = [str(name) for name in trajectory["probe"].values]
    if probe not in names:
        raise ValueError(f"probe: {probe!r} is not among the probes of the trajectory {names}")
    at, scene = names.index(probe), scene_of(trajectory)
    time = trajectory["sample_time"].values
    start = last_at(time, scene.gravity.duration, scene)
    ux, uy, vx, vy = (
        trajectory[f"probe_{name}"].values[start:, at] for name in ("displacement_x", "displacement_y", "velocity_x", "velocity_y")
    )
    return ProbeHistory(time[start:], ux - ux[0], uy - uy[0], np.hypot(vx, vy), float(np.hypot(ux[0], uy[0])))


def check_probe(probe: str, scene: Scene, where: str) -> None:
    """ValueError beginning with ``where`` for a probe to be measured that a scene lacks."""
    if probe not in scene.probes:
        known = ", ".join(scene.probes) or "none"
        raise ValueError(f"{where}: metrics.probe: {probe!r} is not one of the scene's probes ({known})")


def _initial_height(trajectory: xr.Dataset, frame: int) -> np.ndarray:
    return trajectory["y0"].values + scene_of(trajectory).geometry.origin[1]


def _displacement_magnitude(trajectory: xr.Dataset, frame: int) -> np.ndarray:
    return np.hypot(*displacement(trajectory, frame))


def _speed(trajectory: xr.Dataset, frame: int) -> np.ndarray:
    return np.hypot(trajectory["velocity_x"].values[frame], trajectory["velocity_y"].values[frame])


def _beta(trajectory: xr.Dataset, frame: int) -> np.ndarray:
    return trajectory["beta"].values[frame]


def _mean_pressure(trajectory: xr.Dataset, frame: int) -> np.ndarray:
    return -1e-3 * sum(trajectory[f"stress_{axes}"].values[frame] for axes in ("xx", "yy", "zz")) / 3.0


FIELDS: dict[str, Field] = {
    "initial_height": Field("initial elevation", "m", _initial_height),
    "displacement": Field("displacement since the gravity stage", "m", _displacement_magnitude),
    "speed": Field("speed relative to the box", "m/s", _speed),
    "beta": Field("weight of the solid state β", "-", _beta),
    "pressure": Field("mean pressure", "kPa", _mean_pressure),
    "mobilised": Field("mobilised share of the peak strength", "-", mobilised),
}


def check_field(name: str) -> None:
    """ValueError for a name that ``FIELDS`` lacks."""
    check_known("field", [name], FIELDS)
