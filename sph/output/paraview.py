"""A trajectory as files for ParaView (``sph export``): a VTU file a frame and a PVD collection with their times.

Points are the particles, in every number as the trajectory stores it.  What the table of variables declares for particles becomes
data of the points, under its name and unit: what ends in ``_x`` and ``_y`` a vector (in the plane, z = 0), anything else a scalar.
"""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr
from pyevtk.hl import pointsToVTK
from pyevtk.vtk import VtkGroup

from sph.storage.files import unwritable
from sph.storage.trajectory import BY_NAME, FRAME, Variable

PARTICLE_ID = "particle"
"""Name of the index of a particle, the same in every frame."""


def data_name(variable: Variable) -> str:
    """Name of a variable in the files, which ParaView writes at colour bars: with its unit, a vector's without the axis."""
    name = variable.name.removesuffix("_x")
    return name if variable.units == "1" else f"{name} ({variable.units})"


def point_data(trajectory: xr.Dataset, frame: int) -> dict[str, np.ndarray | tuple[np.ndarray, ...]]:
    """All data of the particles in a frame by name: arrays (particles,), vectors as three of them; places excepted."""
    stored = [variable for name, variable in BY_NAME.items() if name in trajectory and name not in ("x", "y")]
    values = {variable.name: _of(trajectory, variable, frame) for variable in stored if variable.dims in (FRAME, ("particle",))}
    data: dict[str, np.ndarray | tuple[np.ndarray, ...]] = {PARTICLE_ID: np.arange(trajectory.sizes["particle"], dtype="i4")}
    for variable in stored:
        x, y = variable.name, f"{variable.name.removesuffix('_x')}_y"
        if x in values and x.endswith("_x") and y in values:
            data[data_name(variable)] = (values.pop(x), values[y], np.zeros_like(values.pop(y)))
        elif x in values:
            data[data_name(variable)] = values[x]
    return data


def export_paraview(trajectory: xr.Dataset, folder: Path, name: str) -> Path:
    """Write ``NAME_0000.vtu`` ... and, once all are there, ``NAME.pvd``, which ParaView opens; returns the path of the latter.

    Earlier files of these names are replaced.  OSError names the folder, cause and remedy; the earlier files are then as they were.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=folder, prefix=f".{name}.") as temporary:
            stem = str(Path(temporary, name).resolve())
            group, zeros = VtkGroup(stem), np.zeros(trajectory.sizes["particle"], trajectory["x"].dtype)
            for frame, time in enumerate(trajectory["time"].values):
                x, y = (_of(trajectory, BY_NAME[axis], frame) for axis in ("x", "y"))
                written = pointsToVTK(f"{stem}_{frame:04d}", x, y, zeros, point_data(trajectory, frame))
                group.addFile(written, float(time))
            group.save()
            for path in sorted(Path(temporary).iterdir(), key=lambda path: path.suffix == ".pvd"):
                os.replace(path, folder / path.name)
    except OSError as error:
        raise unwritable(folder / f"{name}.pvd", error) from error
    return folder / f"{name}.pvd"


def _of(trajectory: xr.Dataset, variable: Variable, frame: int) -> np.ndarray:
    values = trajectory[variable.name].values
    return np.ascontiguousarray(values[frame] if variable.dims == FRAME else values)
