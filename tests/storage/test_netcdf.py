"""Groups of netCDF files: written and read as xarray does both."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sph.storage.netcdf import Array, Group, read_attributes, read_group, write_group


@pytest.fixture
def root() -> Group:
    """Every type that trajectories and tables have, along dimensions of their own, shared ones and none."""
    generator = np.random.default_rng(4)
    numbers = generator.normal(size=(3, 5))
    numbers[1, 2] = np.nan
    arrays = {
        "time": Array(("frame",), np.array([0.0, 0.5, 1.0]), {"units": "s", "long_name": "time of the frame"}),
        "x": Array(("frame", "particle"), numbers.astype("f4"), {"units": "m"}),
        "mass": Array(("particle",), numbers[0], {"units": "kg m-1"}),
        "kind": Array(("particle",), np.arange(5, dtype="i1")),
        "phase": Array(("particle",), np.arange(5, dtype="u1")),
        "layer": Array(("frame",), np.arange(3, dtype="i8")),
        "word": Array(("frame",), np.array(["", "front", "Böschung"])),
        "spacing": Array(("spacing",), np.array([1.0, 0.5])),
        "probe": Array(("probe",), np.array(["A", "B"])),
        "depth": Array((), np.array(2.5)),
    }
    attrs = {"title": "Böschung", "empty": "", "wall_time_s": 1.5, "particle_steps": 12, "step": np.int64(3)}
    return Group(arrays, attrs, ("time", "spacing", "probe"))


@pytest.fixture
def state() -> Group:
    """A group with a dimension of the root's, one of its own length and one of its own."""
    arrays = {
        "x": Array(("particle",), np.arange(5.0)),
        "work": Array(("row",), np.arange(7.0)),
        "lost": Array(("frame", "particle"), np.full((2, 5), np.nan)),
    }
    return Group(arrays, {"step": 7, "substeps": 1})


def by_xarray(path: Path, written: Group, **where: Any) -> None:
    """Write a group as xarray does, its numbers compressed."""
    numbers = [name for name, array in written.variables.items() if array.values.dtype.kind in "fiu" and array.dims]
    encoding = {name: {"zlib": True, "complevel": 4, "shuffle": True} for name in numbers}
    written.dataset().to_netcdf(path, engine="netcdf4", encoding=encoding, **where)


def contents(place: Any) -> dict[str, Any]:
    """All that a file says of a group: dimensions, attributes with their types, and of every variable how it is stored and its bytes."""

    def attributes(of: Any) -> dict[str, tuple[type, str]]:
        return {name: (type(of.getncattr(name)), repr(of.getncattr(name))) for name in of.ncattrs()}

    stored = {
        name: (data.dtype, data.dimensions, data.filters(), data.chunking(), data.endian(), attributes(data), np.asarray(data[...]))
        for name, data in place.variables.items()
    }
    return {
        "dimensions": {name: (dim.size, dim.isunlimited()) for name, dim in place.dimensions.items()},
        "attributes": attributes(place),
        "variables": {
            name: (*facts, values.tolist() if facts[0] is str else values.tobytes()) for name, (*facts, values) in stored.items()
        },
        "groups": {name: contents(group) for name, group in place.groups.items()},
    }


def contents_of(path: Path) -> dict[str, Any]:
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        return contents(file)


def test_a_file_is_that_which_xarray_writes(tmp_path: Path, root: Group, state: Group) -> None:
    by_xarray(tmp_path / "xarray.nc", root)
    by_xarray(tmp_path / "xarray.nc", state, mode="a", group="restart")
    wanted = contents_of(tmp_path / "xarray.nc")
    assert wanted["variables"]["x"][5]["coordinates"][1] == "'time'" and wanted["groups"]["restart"]["dimensions"].keys() == {
        "row",
        "frame",
    }
    write_group(tmp_path / "own.nc", root)
    write_group(tmp_path / "own.nc", state, "restart")
    assert contents_of(tmp_path / "own.nc") == wanted
    write_group(tmp_path / "dataset.nc", root.dataset())
    write_group(tmp_path / "dataset.nc", state.dataset(), "restart")
    assert contents_of(tmp_path / "dataset.nc") == wanted, "a dataset in a group's place"


@pytest.mark.parametrize("name", [None, "restart"])
def test_a_file_is_read_as_xarray_reads_it(tmp_path: Path, root: Group, state: Group, name: str | None) -> None:
    write_group(tmp_path / "run.nc", root)
    write_group(tmp_path / "run.nc", state, "restart")
    with xr.open_dataset(tmp_path / "run.nc", group=name, engine="netcdf4") as opened:
        wanted = opened.load()
    found = read_group(tmp_path / "run.nc", name)
    xr.testing.assert_identical(found.dataset(), wanted)
    assert {name: array.values.dtype for name, array in found.variables.items()} == {
        str(key): value.dtype for key, value in wanted.variables.items()
    }
    assert {name: type(value) for name, value in found.attrs.items()} == {name: type(value) for name, value in wanted.attrs.items()}
    assert found.sizes == dict(wanted.sizes) and set(found.coords) == set(wanted.coords)
    if name is None:
        assert read_attributes(tmp_path / "run.nc") == found.attrs


def test_an_array_that_netcdf_has_no_type_for_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TypeError):
        write_group(tmp_path / "a.nc", Group({"failed": Array(("particle",), np.array([True, False]))}))


def test_more_attributes_leave_the_group_as_it_was(root: Group) -> None:
    more = root.assign_attrs(status="paused")
    assert more.attrs["status"] == "paused" and "status" not in root.attrs and more["x"].values is root["x"].values
