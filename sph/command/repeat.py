"""A trajectory as the scene of a command: ``sph run FILE.nc`` repeats the run that wrote it.

A run that continued from a stage, as those of a study do, is repeated from the start: what may differ between a stage and the run that
continues it (see ``sph.solver.run.check_restart``) has no effect before the stage ends, so that both give the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sph.scene.configuration import merge, scene_files
from sph.scene.schema import Scene, make_scene, written_scene
from sph.scene.strict_json import parse_json
from sph.solver.run import Until
from sph.storage import trajectory
from sph.study.planned import differing

SIGNATURES = (b"\x89HDF", b"CDF")
"""What netCDF files begin with."""


def earlier_run(path: Path) -> xr.Dataset | None:
    """The trajectory in a file, None for a scene file; ValueError for another netCDF file, and for the trials of a search."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        if not file.read(4).startswith(SIGNATURES):
            return None
    ds = trajectory.read(path)
    if "by" in ds.attrs:
        raise ValueError(
            f"{path}: holds the trials of a search ({ds.attrs['by']}), not a run; repeat it with sph fos or sph yield-acceleration"
        )
    return ds


def given_scene(path: Path, overrides: Mapping[str, Any], earlier: xr.Dataset | None = None) -> Scene:
    """The scene in a file, YAML or a trajectory (``earlier``, where it has been read); ValueError with file, key and value."""
    return read_given(path, overrides, earlier)[0]


def read_given(path: Path, overrides: Mapping[str, Any], earlier: xr.Dataset | None = None) -> tuple[Scene, list[str]]:
    """The scene as ``given_scene``, and the files that it was read from: its own, which may be a pipe, records and ground lines."""
    earlier = earlier_run(path) if earlier is None else earlier
    if earlier is None:
        kept = written_scene(path)
    else:
        kept = parse_json(trajectory.scene_of(earlier, str(path)).stored())
        _check_layers(kept, overrides, path)
        motion, vertical = _at(overrides, "motion"), _at(overrides, "motion", "vertical")
        third = isinstance(vertical, Mapping) and ("file" in vertical or _at(kept, "motion", "data", "y") is None)
        if isinstance(motion, Mapping) and (third or not motion.keys().isdisjoint(("file", "unit", "component"))):
            kept["motion"].pop("data", None)  # the samples are to be read again
    data = merge(kept, overrides)
    return make_scene(data, str(path)), [str(path), *scene_files(data)]


def _check_layers(kept: Mapping[str, Any], overrides: Mapping[str, Any], path: Path) -> None:
    """Refuse a key of the soil where a layer holds the same value among all keys: an earlier version stored so what it did not name."""
    soil = _at(overrides, "soil")
    for name, layer in kept["layers"].items():
        for key in soil if isinstance(soil, Mapping) and layer["soil"].keys() >= kept["soil"].keys() else ():
            if _at(layer, "soil", key) == _at(kept, "soil", key) and _at(overrides, "layers", name, "soil", key) is None:
                raise ValueError(
                    f"{path}: soil.{key}: layer {name} has the same {key}, and the file may have been written by an earlier version, which "
                    f"did not record which keys are a layer's own; set layers.{name}.soil.{key} as well, or name the scene's file"
                )


def _at(data: Any, *names: str) -> Any:
    """Value below names, None where there is none."""
    for name in names:
        data = data.get(name) if isinstance(data, Mapping) else None
    return data


def check_of_scene(path: Path, scene: Scene) -> None:
    """ValueError where a file holds the run of another scene, with the first key that differs; one that cannot be read may be replaced."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as ds:
            differ = differing(ds.attrs, scene, path) if "scene" in ds.attrs else []
    except (OSError, RuntimeError, ValueError):
        return
    if differ:
        more = f" and {len(differ) - 1} more" if len(differ) > 1 else ""
        raise ValueError(
            f"--out {path}: holds the run of another scene ({differ[0]}{more}); name another file, or replace it with --overwrite"
        )


def stopped_at(earlier: xr.Dataset | None) -> Until:
    """The stage up to which a trajectory was to be simulated; ``end`` for a new scene.

    A paused run whose last sample is that at the end of the gravity stage has the same bits whichever stage it was told to stop at.
    """
    if earlier is None or earlier.attrs.get("status") != trajectory.Status.PAUSED:
        return "end"
    scene = trajectory.scene_of(earlier)
    at_gravity = scene.steps(float(earlier["sample_time"][-1])) == scene.steps(scene.gravity.duration)
    return "gravity" if at_gravity else "first_failure"


def compare(earlier: xr.Dataset, again: xr.Dataset, path: Path) -> str:
    """Whether a repeated run has the bits of the earlier one, in words; if not, what was not the same."""
    names = [row.name for row in trajectory.VARIABLES]
    differ = [name for name in names if name not in earlier or not _same(earlier[name].values, again[name].values)]
    if not differ:
        return f"every variable is identical to that of {path}, bit for bit"
    old, new = (parse_json(ds.attrs.get("versions", "{}")) | {"machine": ds.attrs.get("machine")} for ds in (earlier, again))
    other = ", ".join(f"{name} {old.get(name)} there and {new[name]} here" for name in new if old.get(name) != new[name])
    return f"differs from {path} in {', '.join(differ)}: {other or 'made by other sources or on another processor'}"


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
