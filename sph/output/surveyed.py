"""A trajectory in the coordinates of the user's survey: its own begin at the box's lower left corner and have the toe on the left."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from sph.output.run import MARK, Run
from sph.storage.trajectory import BY_NAME

PLACES = {"x0": "initial x in the survey", "y0": "initial elevation", "x": "x in the survey", "y": "elevation"}
"""What is placed in the survey, with its meaning there."""
TURNED = (
    "displacement_x",
    "velocity_x",
    "stress_xy",
    "probe_displacement_x",
    "probe_velocity_x",
    "ground_acceleration",
)
"""What changes its sign with the direction of x: horizontal components of vectors and the shear stress."""


def in_survey(run: xr.Dataset) -> xr.Dataset:
    """A trajectory in the coordinates and the horizontal direction of the scene's survey; that given stays as it is.

    Positions ``x0``, ``y0`` (particle,) and ``x``, ``y`` (frame, particle) are x and elevation of the survey (m), in double precision, as
    an easting of 500 km needs.  Displacements (m), velocities (m/s), the ground acceleration (m/s2) and the shear stress (Pa) count along
    the survey's x: where the slope falls to the right, their horizontal components and ``stress_xy`` have the other sign than in the file,
    and a ground acceleration that drives the soil downslope is negative.  All else is the same.  ``sph.measure`` and ``sph.plot`` take
    the trajectory as it is stored, and draw in the survey's coordinates anyway.  ValueError for one that is in the survey already.
    """
    geometry = Run(run).scene.geometry
    placed = run.assign_attrs({MARK: "survey"})
    for x, y in (("x0", "y0"), ("x", "y")):
        for name, values in zip((x, y), geometry.in_survey(run[x].values.astype("f8"), run[y].values.astype("f8")), strict=True):
            placed[name] = (run[name].dims, values, {"units": BY_NAME[name].units, "long_name": PLACES[name]})
    for name in TURNED if geometry.direction < 0 else ():
        placed[name] = (run[name].dims, -run[name].values, run[name].attrs)
    return placed


def read_run(path: Path | str, survey: bool = False) -> xr.Dataset:
    """Root group of a trajectory with all variables and facts of a run, with ``survey`` as ``in_survey`` gives it.

    ``sph.storage.trajectory.VARIABLES`` has every variable with its dimensions and unit.  ValueError names a file that lacks one, as that
    of a search does.
    """
    run = Run.read(path).trajectory
    return in_survey(run) if survey else run
