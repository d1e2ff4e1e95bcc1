"""Files for ParaView, read back by another library: every number as the trajectory stores it."""

from __future__ import annotations

import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import meshio
import numpy as np
import pytest
import xarray as xr

from sph.output.paraview import PARTICLE_ID, export_paraview
from sph.output.run import Run
from sph.storage.trajectory import BY_NAME, FRAME, VARIABLES

VECTORS = {"displacement": "displacement (m)", "velocity": "velocity (m s-1)"}


@pytest.fixture
def noisy(slid: Run) -> xr.Dataset:
    """A trajectory in which no two numbers of a field are equal, with a particle that never fails and one that was lost."""
    generator = np.random.default_rng(3)
    for variable in VARIABLES:
        if variable.dims == FRAME and variable.dtype == "f4":
            slid[variable.name][:] = generator.normal(size=slid[variable.name].shape).astype("f4")
    ratio = slid.trajectory["beta"].copy(data=generator.random(slid["beta"].shape).astype("f4"))
    slid["t_f"][:] = generator.normal(size=slid.soil.size)
    slid["t_f"][7], slid["x"][-1, 3] = np.nan, np.inf
    return slid.trajectory.assign(pore_pressure_ratio=ratio).isel(frame=slice(0, 3))


@pytest.mark.crosscheck
@pytest.mark.skipif(sys.version_info >= (3, 14), reason="meshio 5.3.5 decodes arrays together with what follows them, which 3.14 refuses")
def test_every_number_is_read_back_as_it_is(tmp_path: Path, noisy: xr.Dataset) -> None:
    export_paraview(noisy, tmp_path / "new" / "folder", "slide")
    for frame in range(3):
        mesh = meshio.read(tmp_path / "new" / "folder" / f"slide_{frame:04d}.vtu")
        read = {name: np.squeeze(values) for name, values in mesh.point_data.items()}
        found = {"x": mesh.points[:, 0], "y": mesh.points[:, 1], "zero": mesh.points[:, 2]}
        for stem, name in VECTORS.items():
            found |= dict(zip((f"{stem}_x", f"{stem}_y", "zero"), read.pop(name).T, strict=True))
            assert not found["zero"].any()
        assert read.pop(PARTICLE_ID).tolist() == list(range(noisy.sizes["particle"]))
        for name, values in read.items():
            variable = BY_NAME[name.partition(" ")[0]]
            assert name == (variable.name if variable.units == "1" else f"{variable.name} ({variable.units})")
            found[variable.name] = values
        wanted = {name for name, row in BY_NAME.items() if row.dims in (FRAME, ("particle",))}
        assert set(found) == wanted | {"zero"}
        for name in wanted:
            stored = noisy[name].values[frame] if BY_NAME[name].dims == FRAME else noisy[name].values
            assert found[name].dtype == stored.dtype and found[name].tobytes() == stored.tobytes(), name
        (cells,) = mesh.cells
        assert cells.type == "vertex" and len(cells.data) == noisy.sizes["particle"]


def test_the_collection_has_the_times(tmp_path: Path, noisy: xr.Dataset) -> None:
    path = export_paraview(noisy, tmp_path, "slide")
    sets = xml.parse(path).getroot().findall("./Collection/DataSet")
    assert [float(item.attrib["timestep"]) for item in sets] == noisy["time"].values.tolist()
    names = [item.attrib["file"] for item in sets]
    assert names == ["slide_0000.vtu", "slide_0001.vtu", "slide_0002.vtu"]
    assert sorted(item.name for item in tmp_path.iterdir()) == ["slide.pvd", *names]


def test_a_fault_leaves_the_earlier_files(tmp_path: Path, noisy: xr.Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    export_paraview(noisy, tmp_path, "slide")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def full(*arguments: object) -> str:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sph.output.paraview.pointsToVTK", full)
    with pytest.raises(OSError, match=r"slide\.pvd: .*No space left.* MB free"):
        export_paraview(noisy.isel(frame=[0]), tmp_path, "slide")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
