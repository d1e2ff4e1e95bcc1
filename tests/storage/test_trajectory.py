"""Trajectory files: one table of variables, atomic writing, foreign files refused by name."""

from __future__ import annotations

import json
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sph.scene.schema import Scene
from sph.solver.terms import State
from sph.storage import trajectory
from sph.study.tables import read_study

SIZES = {"frame": 3, "particle": 5, "sample": 4, "probe": 2}


@pytest.fixture
def scene(small_slope) -> Scene:
    return small_slope({"title": "for the file's sake"})


@pytest.fixture
def stored(scene: Scene) -> xr.Dataset:
    """A dataset with every variable, filled with numbers."""
    generator = np.random.default_rng(1)
    arrays = {}
    for variable in trajectory.VARIABLES:
        shape = tuple(SIZES[dim] for dim in variable.dims)
        arrays[variable.name] = (100 * generator.normal(size=shape)).astype(variable.dtype)
    arrays["t_f"][0] = np.nan
    arrays["time"] = np.array([0.0, 0.25, 0.5])
    arrays["sample_time"] = np.array([0.0, 0.1, 0.2, 0.3])
    return trajectory.assembled(arrays, ["A", "B"], trajectory.run_attributes(scene) | {"status": "complete"}).dataset()


@pytest.fixture
def restart() -> xr.Dataset:
    state = {name: ("particle", np.random.default_rng(2).normal(size=5)) for name in State._fields if name != "work"}
    ds = xr.Dataset(state | {"work": ("row", np.arange(7.0))})
    ds.attrs["step"] = 1234
    return ds


def unwritable() -> xr.Dataset:
    return xr.Dataset({"x": ("particle", np.zeros(3))}, attrs={"a mapping": {"netCDF": "knows none"}})


def test_round_trip(tmp_path: Path, stored: xr.Dataset, restart: xr.Dataset) -> None:
    path = tmp_path / "new" / "folder" / "run.nc"
    trajectory.write(path, stored, restart)
    read = trajectory.read(path).dataset()
    xr.testing.assert_identical(read, stored)
    for name in stored.variables:
        assert read[name].dtype == stored[name].dtype or name == "probe"
    again = trajectory.read_restart(path).dataset()
    assert again.attrs["step"] == 1234
    for name in restart.variables:
        # The restart is in double precision, bit for bit.
        assert again[name].dtype == np.float64
        np.testing.assert_array_equal(again[name].values, restart[name].values)


def test_scene_of_gives_the_scene_back(tmp_path: Path, stored: xr.Dataset, scene: Scene) -> None:
    path = tmp_path / "run.nc"
    trajectory.write(path, stored)
    assert trajectory.scene_of(trajectory.read(path)) == scene


@pytest.mark.parametrize("variable", trajectory.VARIABLES, ids=lambda v: v.name)
def test_every_row_of_the_table_is_written_as_declared(stored: xr.Dataset, variable: trajectory.Variable) -> None:
    assert variable.units and variable.text
    array = stored[variable.name]
    assert array.dims == variable.dims
    assert array.dtype == np.dtype(variable.dtype)
    assert array.attrs["units"] == variable.units
    assert array.attrs["long_name"] == variable.text


def test_nothing_is_written_that_the_table_lacks(stored: xr.Dataset) -> None:
    assert set(stored.variables) - {"probe"} == {variable.name for variable in trajectory.VARIABLES}
    assert len(trajectory.BY_NAME) == len(trajectory.VARIABLES) + len(trajectory.OPTIONAL), "a name occurs twice"


def test_a_run_fills_every_variable(small_slope) -> None:
    from sph.solver.run import run

    ds = run(small_slope({"duration": 1.0, "motion.start": 1.0, "gravity.duration": 0.5}), until="gravity").trajectory
    for variable in trajectory.VARIABLES:
        assert ds[variable.name].dtype == np.dtype(variable.dtype)
        assert ds[variable.name].dims == variable.dims
        assert ds[variable.name].size > 0
    assert ds.attrs["status"] in list(trajectory.Status)
    for attribute in ("wall_time_s", "particle_steps", "particle_steps_per_second", "neighbours_mean", "active_terms"):
        assert attribute in ds.attrs


def test_a_missing_variable_is_an_error(scene: Scene) -> None:
    with pytest.raises(KeyError):
        trajectory.assembled({}, [], {})


def test_cf_attributes(tmp_path: Path, stored: xr.Dataset) -> None:
    path = tmp_path / "run.nc"
    trajectory.write(path, stored)
    with xr.open_dataset(path, decode_times=False) as raw:
        assert raw.attrs["Conventions"].startswith("CF-1.")
        assert raw.attrs["title"] == "for the file's sake"
        assert raw.attrs["source"].startswith("sph ")
        versions = json.loads(raw.attrs["versions"])
        assert {"sph", "python", "numpy", "numba", "xarray"} <= versions.keys()
        assert "unknown" not in versions.values()
        assert json.loads(raw.attrs["scene"])["name"] == "small_slope"
        assert raw["x"].encoding["zlib"], "fields are compressed"
        for name in ("time", "sample_time", "probe"):
            assert name in raw.coords


@pytest.mark.parametrize("broken", ["root", "restart"])
def test_an_error_inside_writing_leaves_the_earlier_file_and_no_temporary(
    tmp_path: Path, stored: xr.Dataset, restart: xr.Dataset, broken: str
) -> None:
    path = tmp_path / "run.nc"
    trajectory.write(path, stored, restart)
    before = path.read_bytes()
    with pytest.raises((TypeError, ValueError)):
        if broken == "root":
            trajectory.write(path, unwritable(), restart)
        else:
            trajectory.write(path, stored, unwritable())
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]
    assert path.read_bytes() == before


def test_an_error_inside_writing_leaves_nothing_where_nothing_was(tmp_path: Path, stored: xr.Dataset) -> None:
    with pytest.raises((TypeError, ValueError)):
        trajectory.write(tmp_path / "run.nc", stored, unwritable())
    assert list(tmp_path.iterdir()) == []


def test_a_file_without_a_scene_is_no_trajectory(tmp_path: Path) -> None:
    xr.Dataset({"x": ("n", np.zeros(2))}).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(ValueError, match=r"foreign\.nc: not a trajectory"):
        trajectory.read(tmp_path / "foreign.nc")


@pytest.mark.parametrize("group", [None, "restart"])
def test_files_tell_their_format_and_newer_ones_are_refused(
    tmp_path: Path, stored: xr.Dataset, restart: xr.Dataset, group: str | None
) -> None:
    path = tmp_path / "run.nc"
    read = trajectory.read if group is None else trajectory.read_restart
    trajectory.write(path, stored, restart)
    own = read(path).dataset()
    assert "format" not in own.attrs
    with netCDF4.Dataset(path, "a") as ds:
        place = ds if group is None else ds[group]
        assert place.format == trajectory.FORMAT
        del place.format
    assert read(path).dataset().identical(own), "files of the version before had no format"
    with netCDF4.Dataset(path, "a") as ds:
        (ds if group is None else ds[group]).format = trajectory.FORMAT + 1
    newer = rf"run\.nc: .*format {trajectory.FORMAT + 1}.*newer sph"
    with pytest.raises(ValueError, match=newer):
        read(path)
    with pytest.raises(ValueError, match=newer):
        read_study(path) if group is None else read(path)
