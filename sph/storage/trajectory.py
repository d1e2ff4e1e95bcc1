"""The trajectory file: one table of variables used by writer, reader, tests and documentation.

A trajectory is a netCDF-4 file (CF-1.10 attributes, compressed).  The root group holds frames of
the particle fields and dense series; the group ``restart`` holds the complete state in double
precision from which the run goes on bit for bit.  Files are written under a temporary name and
renamed, so a file that exists is whole.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from collections.abc import Mapping
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph import __version__
from sph.scene.configuration import in_order, without_files
from sph.scene.schema import Scene, stored_scene
from sph.scene.strict_json import parse_json, to_json
from sph.storage.files import whole
from sph.storage.netcdf import Array, Group, read_group, write_group

if TYPE_CHECKING:
    import xarray as xr


class Variable(NamedTuple):
    """One stored variable: name, dimensions, type, unit and meaning."""

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    text: str


FRAME = ("frame", "particle")
SERIES = ("sample",)
PROBE = ("sample", "probe")

VARIABLES: tuple[Variable, ...] = (
    Variable("time", ("frame",), "f8", "s", "time of the frame"),
    Variable("time_step", ("frame",), "f8", "s", "time step up to the frame; at the first frame the one that follows"),
    Variable(
        "time_step_limit",
        ("frame",),
        "f8",
        "s",
        "stability limit of the time step for the present particle positions, measured at every outputs.frame_interval",
    ),
    Variable("x0", ("particle",), "f8", "m", "initial horizontal position"),
    Variable("y0", ("particle",), "f8", "m", "initial height"),
    Variable("kind", ("particle",), "i1", "1", "0 soil, 1 base of the box, 2 side wall, 3 lid"),
    Variable("mass", ("particle",), "f8", "kg m-1", "mass for a metre of thickness"),
    Variable("layer", ("particle",), "i2", "1", "0 the scene's own soil, k its k-th layer"),
    Variable("t_f", ("particle",), "f8", "s", "time of first failure; NaN where the particle has not failed"),
    Variable("x", FRAME, "f4", "m", "horizontal position in the frame of the box"),
    Variable("y", FRAME, "f4", "m", "height in the frame of the box"),
    Variable("displacement_x", FRAME, "f4", "m", "horizontal displacement relative to the box"),
    Variable("displacement_y", FRAME, "f4", "m", "vertical displacement relative to the box"),
    Variable("velocity_x", FRAME, "f4", "m s-1", "horizontal velocity relative to the box"),
    Variable("velocity_y", FRAME, "f4", "m s-1", "vertical velocity relative to the box"),
    Variable("stress_xx", FRAME, "f4", "Pa", "stress, tension positive"),
    Variable("stress_yy", FRAME, "f4", "Pa", "stress, tension positive"),
    Variable("stress_zz", FRAME, "f4", "Pa", "out-of-plane stress, tension positive"),
    Variable("stress_xy", FRAME, "f4", "Pa", "shear stress"),
    Variable("density", FRAME, "f4", "kg m-3", "density"),
    Variable("beta", FRAME, "f4", "1", "weight of the solid state, Eq. 9"),
    Variable("failed", FRAME, "i1", "1", "1 once the stress has reached the failure surface"),
    Variable("sample_time", SERIES, "f8", "s", "time of the sample"),
    Variable("probe_particle", ("probe",), "i4", "1", "index of the probe's particle"),
    Variable("probe_displacement_x", PROBE, "f8", "m", "horizontal displacement of the probe relative to the box"),
    Variable("probe_displacement_y", PROBE, "f8", "m", "vertical displacement of the probe relative to the box"),
    Variable("probe_velocity_x", PROBE, "f8", "m s-1", "horizontal velocity of the probe relative to the box"),
    Variable("probe_velocity_y", PROBE, "f8", "m s-1", "vertical velocity of the probe relative to the box"),
    Variable("ground_acceleration", SERIES, "f8", "m s-2", "horizontal acceleration of the box"),
    Variable("ground_acceleration_y", SERIES, "f8", "m s-2", "vertical acceleration of the box, positive upwards"),
    Variable("kinetic_energy", SERIES, "f8", "J m-1", "kinetic energy relative to the box"),
    Variable("elastic_energy", SERIES, "f8", "J m-1", "stored energy of stress and repulsion"),
    Variable("potential_energy", SERIES, "f8", "J m-1", "energy of position minus its initial value; work done by the gravity ramp"),
    Variable(
        "dissipated_energy",
        SERIES,
        "f8",
        "J m-1",
        "energy dissipated by yielding, damping, friction, artificial viscosity and stress",
    ),
    Variable("viscous_energy", SERIES, "f8", "J m-1", "part of dissipated_energy due to artificial viscosity and stress"),
    Variable("shaking_work", SERIES, "f8", "J m-1", "work of the inertial force of the shaking, or of a prescribed motion"),
    Variable("failed_fraction", SERIES, "f8", "1", "failed soil particles over all soil particles"),
    Variable("maximum_speed", SERIES, "f8", "m s-1", "largest speed of a soil particle relative to the box"),
)
OPTIONAL: tuple[Variable, ...] = (
    Variable("pore_pressure_ratio", FRAME, "f4", "1", "excess pore pressure over the initial vertical effective stress"),
)
"""Stored where the scene has the term that makes them: ``water.excess_pressure``."""
BY_NAME = {variable.name: variable for variable in (*VARIABLES, *OPTIONAL)}


class Status(StrEnum):
    """How a run ended, as its attribute ``status`` and the tables have it."""

    COMPLETE = "complete"
    """reached its duration, or rest where ``early_stop`` ends it"""
    UNFAILED = "unfailed"
    """the same without one particle failing"""
    FAILED_UNSHAKEN = "failed_unshaken"
    """the same, but so much soil failed before the shaking that it is not the cause (``sph.scene.schema.Scene.fails_unshaken``)"""
    PAUSED = "paused"
    """stopped before its duration so that it can go on"""
    DIVERGED = "diverged"
    """stopped by the guard"""


FACTS = ("scene", "status", "status_reason", "wall_time_s", "particle_steps", "particle_steps_per_second")
"""Attributes of every run."""

FORMAT = 1
"""Version of what the netCDF files hold, their attribute ``format``: to be raised where an earlier reader would take them for something
else.  Files of version 0 lack it, and are read like those of version 1."""

PACKAGES = ("numpy", "numba", "llvmlite", "xarray", "netCDF4", "pydantic")


def assembled(arrays: Mapping[str, np.ndarray], probes: list[str], attrs: Mapping[str, Any]) -> Group:
    """A trajectory of the variables in ``VARIABLES``, every one of which ``arrays`` must hold, and those in ``OPTIONAL`` that it holds."""
    found = {
        name: Array(dims, np.asarray(arrays[name]).astype(dtype, copy=False), {"units": units, "long_name": text})
        for name, dims, dtype, units, text in (*VARIABLES, *(variable for variable in OPTIONAL if variable.name in arrays))
    }
    return Group(found | {"probe": Array(("probe",), np.array(probes))}, attrs, ("time", "sample_time", "probe"))


def run_attributes(scene: Scene) -> dict[str, Any]:
    """Attributes that let a reader repeat the run: the whole scene and the versions."""
    return {
        "Conventions": "CF-1.10",
        "title": scene.title or scene.name,
        "source": f"sph {__version__}",
        "scene": scene.stored(),
        "scene_digest": scene_digest(scene),
        "versions": to_json({"sph": __version__, "python": platform.python_version()} | {p: _version(p) for p in PACKAGES}),
        "machine": f"{platform.system()} {platform.machine()}",
    }


def scene_digest(scene: Scene) -> str:
    """Digest of all that a scene says, wherever its files lie: their content is part of it, their names are not."""
    return text_digest(without_files(scene.model_dump(mode="json")))


def text_digest(data: Any) -> str:
    """Digest of plain data, whatever the order of its keys where it does not count."""
    return hashlib.sha256(to_json(in_order(data), sort_keys=True).encode()).hexdigest()[:16]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def write(path: Path | str, run: Group | xr.Dataset, restart: Group | xr.Dataset | None = None) -> None:
    """Write a trajectory, whole or not at all (see ``sph.storage.files.whole``); ``restart`` goes into its own group."""
    check_name(path)
    with whole(path) as temporary:
        write_group(temporary, run.assign_attrs(format=FORMAT))
        if restart is not None:
            write_group(temporary, restart.assign_attrs(format=FORMAT), "restart")


def read(path: Path | str) -> Group:
    """Root group of a trajectory, or of the trials of a search, in memory; ValueError names a file that is none, and the remedy."""
    loaded = _read(path, None, "a trajectory")
    if "scene" not in loaded.attrs:
        raise ValueError(f"{path}: not a trajectory of this program (it has no attribute 'scene'); name another file")
    return loaded


def read_run(path: Path | str) -> Group:
    """Root group of a trajectory with all variables and facts of a run; ValueError names a file that lacks one, as a search's does."""
    run = read(path)
    missing = [row.name for row in VARIABLES if row.name not in run or run[row.name].dims != row.dims]
    missing += [name for name in FACTS if name not in run.attrs]
    if missing:
        raise ValueError(f"{path}: not a trajectory of this version, it lacks {', '.join(missing)}; run its scene again")
    if not run["time"].values.size or not run["sample_time"].values.size:
        raise ValueError(f"{path}: a trajectory without a frame or a sample")
    return run


def read_restart(path: Path | str) -> Group:
    """Group ``restart`` of a trajectory, in memory; ValueError names a file without one."""
    loaded = _read(path, "restart", "a trajectory with a restart state")
    if "step" not in loaded.attrs:
        raise ValueError(f"{path}: its restart state has no attribute 'step'; it was written by another version, run it again")
    for name, least in (("step", 0), ("substeps", 1)):
        value = loaded.attrs.get(name, least)
        if not isinstance(value, (int, np.integer)) or value < least:
            raise ValueError(f"{path}: its restart state has {name} {value}, a whole number from {least} on is needed; run it again")
    return loaded


def check_name(path: Path | str) -> None:
    """Refuse a path that the netCDF library cannot be given: with bytes that are no characters of the system's encoding."""
    encoding = sys.getfilesystemencoding()
    try:
        os.path.abspath(path).encode(encoding)
    except UnicodeEncodeError as error:
        raise ValueError(
            f"{path}: its name, or its folder's, is not {encoding}, as netCDF needs it; rename it, or set LC_ALL=C.UTF-8 if that is not set"
        ) from error


def _read(path: Path | str, group: str | None, what: str) -> Group:
    check_name(path)
    try:
        loaded = read_group(path, group)
    except FileNotFoundError as error:
        raise ValueError(f"{path}: cannot be read as {what}: there is no such file") from error
    except Exception as error:  # damaged data have raised RuntimeError, AttributeError and KeyError, too
        raise ValueError(f"{path}: cannot be read as {what}: {error}; if it was one, delete it and repeat its command") from error
    check_format(loaded, path)
    return loaded


def check_format(found: Group | xr.Dataset, path: Path | str) -> None:
    """Take the version of the format from the attributes; ValueError where it is newer than what is read here."""
    given = found.attrs.pop("format", 0)
    if not isinstance(given, (int, np.integer)) or given > FORMAT:
        raise ValueError(f"{path}: has format {given}, newer than {FORMAT}, the last that sph {__version__} reads; install a newer sph")


def scene_of(run: Group | xr.Dataset, origin: str = "trajectory") -> Scene:
    """The scene a trajectory was run with; ValueError where its attribute ``scene`` cannot be read or is refused."""
    try:
        data = parse_json(run.attrs["scene"])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{origin}: its attribute 'scene' cannot be read: {error}") from error
    return stored_scene(data, origin)
