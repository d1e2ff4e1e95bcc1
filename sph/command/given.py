"""The scene that a command is given: a file of one, or a trajectory, which holds its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sph.scene.configuration import merge, scene_files
from sph.scene.schema import Scene, check_unit, make_scene, written_amplitude, written_scene
from sph.scene.strict_json import parse_json
from sph.storage import trajectory
from sph.storage.netcdf import Group

SIGNATURES = (b"\x89HDF", b"CDF")
"""What netCDF files begin with."""


def earlier_run(path: Path) -> Group | None:
    """The trajectory in a file, None for a scene file; ValueError for another netCDF file, and for the trials of a search."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        if not file.read(4).startswith(SIGNATURES):
            return None
    run = trajectory.read(path)
    if "by" in run.attrs:
        raise ValueError(
            f"{path}: holds the trials of a search ({run.attrs['by']}), not a run; repeat it with sph fos or sph yield-acceleration"
        )
    return run


def read_given(path: Path, overrides: Mapping[str, Any], earlier: Group | None = None) -> tuple[Scene, list[str]]:
    """The scene in a file, YAML or a trajectory (``earlier``, where it has been read), and the files that it was read from: its own, which
    may be a pipe, records and ground lines.  ValueError with file, key and value."""
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
            kept["motion"].pop("name", None)  # of the record that they were from
    data = merge(kept, overrides)
    scene = make_scene(data, str(path))
    check_unit(written_amplitude(data if earlier is None else overrides), scene, f"{path}: motion.amplitude")
    return scene, [str(path), *scene_files(data)]


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
