"""Groups of netCDF-4 files in memory, written and read by netCDF4 alone: xarray takes half as long to load as all that a job needs.

A file is the same as ``xarray.Dataset.to_netcdf`` would write it, and a dataset may be given in a group's place.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import netCDF4
import numpy as np

if TYPE_CHECKING:
    import xarray as xr


class Array(NamedTuple):
    """Values along dimensions, with attributes."""

    dims: tuple[str, ...]
    values: np.ndarray
    attrs: Mapping[str, Any] = {}


class Group:
    """Arrays by name, with attributes; ``coords`` names those that say where the others lie."""

    def __init__(self, variables: Mapping[str, Array], attrs: Mapping[str, Any] | None = None, coords: Iterable[str] = ()) -> None:
        self.variables, self.attrs, self.coords = dict(variables), dict(attrs or {}), frozenset(coords)

    def __getitem__(self, name: str) -> Array:
        return self.variables[name]

    def __contains__(self, name: str) -> bool:
        return name in self.variables

    @property
    def sizes(self) -> dict[str, int]:
        """Length of each dimension."""
        return {dim: size for array in self.variables.values() for dim, size in zip(array.dims, array.values.shape, strict=True)}

    def assign_attrs(self, **attrs: Any) -> Group:
        """The same arrays with more attributes."""
        return Group(self.variables, self.attrs | attrs, self.coords)

    def dataset(self) -> xr.Dataset:
        """The same arrays, not copied, as a dataset."""
        import xarray as xr  # here, since a run does without it

        return xr.Dataset({name: tuple(array) for name, array in self.variables.items()}, attrs=self.attrs).set_coords(self.coords)


def write_group(path: Path | str, group: Group | xr.Dataset, name: str | None = None) -> None:
    """Write a file, or add a group of a name to one: numbers compressed, NaN as the fill value of those in floating point."""
    arrays: Mapping[Any, Any] = group.variables
    sizes: Mapping[Any, int] = group.sizes
    along = _coordinates(arrays, sorted({str(name) for name in group.coords} - sizes.keys()))
    with netCDF4.Dataset(os.fspath(path), "a" if name else "w") as file:
        file.set_auto_maskandscale(False)
        place = file.createGroup(name) if name else file
        place.setncatts(group.attrs)
        for dim, size in sizes.items():
            if name is None or dim not in file.dimensions or len(file.dimensions[dim]) != size:
                place.createDimension(dim, size)
        for variable, array in arrays.items():
            values, how = array.values, dict[str, Any]()
            if values.dtype.kind in "fiu" and array.dims:
                how = {"compression": "zlib", "complevel": 4, "shuffle": True}
            if values.dtype.kind == "f":
                how["fill_value"] = np.nan
            words = values.dtype.kind in "OUT"
            made = place.createVariable(variable, str if words else values.dtype, array.dims, **how)
            made.setncatts({**array.attrs, **along.get(variable, {})})
            made[...] = values.astype(object) if words else values


def _coordinates(arrays: Mapping[str, Any], coords: Sequence[str]) -> dict[str, dict[str, str]]:
    """Attribute ``coordinates`` of the arrays along whose dimensions some of ``coords`` lie, those that are no dimension."""
    found = {}
    for name in arrays.keys() - coords:
        along = [coord for coord in coords if set(arrays[coord].dims) <= set(arrays[name].dims)]
        if along and name not in arrays[name].dims:
            found[name] = {"coordinates": " ".join(along)}
    return found


def read_group(path: Path | str, name: str | None = None) -> Group:
    """The root group of a file, or the group of a name; FileNotFoundError, OSError or IndexError where there is none."""
    with netCDF4.Dataset(os.path.expanduser(path)) as file:
        file.set_auto_mask(False)
        place = file[name] if name else file
        arrays, coords = dict[str, Array](), set[str]()
        for variable, stored in place.variables.items():
            attrs = {key: stored.getncattr(key) for key in stored.ncattrs() if key != "_FillValue"}
            coords.update(attrs.pop("coordinates", "").split())
            values = np.asarray(stored[...])
            arrays[variable] = Array(stored.dimensions, values.astype(str) if values.dtype.kind == "O" else values, attrs)
        coords = (coords & arrays.keys()) | {variable for variable, array in arrays.items() if variable in array.dims}
        return Group(arrays, {key: place.getncattr(key) for key in place.ncattrs()}, coords)


def read_attributes(path: Path | str) -> dict[str, Any]:
    """Attributes of the root group of a file; OSError where there is none."""
    with netCDF4.Dataset(os.path.expanduser(path)) as file:
        return {key: file.getncattr(key) for key in file.ncattrs()}
