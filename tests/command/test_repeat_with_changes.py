"""What is laid over a scene has the same effect whether the scene is in a file or stored with its run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from record_files import geonet

from sph.command.given import read_given
from sph.command.run import compare, stopped_at
from sph.scene.configuration import dotted
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.restart import check_restart
from sph.storage.trajectory import run_attributes, scene_of

LAYERED: dict[str, Any] = {
    "scheme": "paper",
    "name": "layered",
    "geometry": {"shape": "slope"},
    "soil": {"density": 1800.0, "cohesion": 40.0},
    "layers": {
        "clay": {"region": {"kind": "depth", "bottom": 5.0}, "soil": {"friction_angle": 5.0}},
        "rock": {"region": {"kind": "elevation", "top": 5.0}, "soil": {"cohesion": 40.0}, "S_R": 0.9},
        "fill": {"region": {"kind": "polygon", "points": [[0, 0], [9, 0], [9, 9]]}},
    },
    "motion": {"kind": "tapered_sine"},
}


def both(tmp_path: Path, data: dict[str, Any], changes: dict[str, Any]) -> tuple[Scene, Scene]:
    """The scene with changes by its file, and by what a run of it stores."""
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    stored = xr.Dataset(attrs=run_attributes(load_scene(path)))
    assert scene_of(stored) == load_scene(path)
    return read_given(path, dotted(changes))[0], read_given(tmp_path / "run.nc", dotted(changes), stored)[0]


@pytest.mark.parametrize(
    "changes",
    [
        {"soil.cohesion": 10.0},
        {"soil.cohesion": 10.0, "layers.clay.soil.cohesion": 3.0},
        {"soil": {"cohesion": 10.0, "viscosity": 7.0}},
        {"layers.clay.soil.density": 1700.0, "soil.density": 2000.0},
        {"layers.new": {"region": {"kind": "depth", "top": 9.0}}, "soil.friction_angle": 11.0},
        {"coupling.S_R": 0.2, "coupling.gamma": 3.0},
        {"probes.B": "toe"},
        {"motion.amplitude": 2.0, "gravity.ramp": 0.5},
        {"motion.kind": "none"},
        {"geometry": {"shape": "block", "width": 40.0, "height": 20.0}},
        {"damping.ratio": 0.1, "numerics.adaptive_step.courant": 0.5, "numerics.short_range_repulsion.range": 0.5},
        {"walls.friction.base": 0.5, "walls.base": "free_slip", "walls.layers": 5},
    ],
    ids=lambda changes: " ".join(changes),
)
def test_a_change_of_a_stored_scene_is_that_of_its_file(tmp_path: Path, changes: dict[str, Any]) -> None:
    by_file, by_run = both(tmp_path, LAYERED, changes)
    assert by_run == by_file
    assert by_run.stored() == by_file.stored(), "and so the next time"


def test_a_change_of_the_soil_reaches_the_layers_that_do_not_name_the_key(tmp_path: Path) -> None:
    for scene in both(tmp_path, LAYERED, {"soil.cohesion": 10.0}):
        assert [soil.cohesion for soil in scene.soils] == [10.0, 10.0, 40.0, 10.0], "the rock names the value that was the scene's"


def as_earlier_versions_stored(scene: Scene) -> xr.Dataset:
    return xr.Dataset(attrs={"scene": scene.model_dump_json()})


def test_a_run_of_an_earlier_version_does_not_tell_what_its_layers_named() -> None:
    scene = make_scene(LAYERED)
    earlier = as_earlier_versions_stored(scene)
    assert scene_of(earlier) == scene
    check_restart(scene_of(earlier), scene, 1.0, False, "run.nc")  # may still be gone on from
    for unambiguous in ({"coupling.S_R": 0.3}, {"soil.friction_angle": 30.0, "layers.rock.soil.friction_angle": 20.0}):
        changes = unambiguous | ({"layers.fill.soil.friction_angle": 20.0} if "soil.friction_angle" in unambiguous else {})
        assert read_given(Path("run.nc"), dotted(changes), earlier)[0].layers["clay"].soil.friction_angle == 5.0
    with pytest.raises(ValueError, match=r"run\.nc: soil\.cohesion: .*layers\.clay\.soil\.cohesion"):
        read_given(Path("run.nc"), dotted({"soil.cohesion": 10.0}), earlier)[0]


@pytest.mark.parametrize("changes", [{"motion": 3}, {"soil": 3}, {"soil": None}, {"layers": 3}, {"layers.clay": None}])
def test_a_change_that_is_none_is_refused(tmp_path: Path, changes: dict[str, Any]) -> None:
    for stored in (as_earlier_versions_stored(make_scene(LAYERED)), xr.Dataset(attrs=run_attributes(make_scene(LAYERED)))):
        with pytest.raises(ValueError, match=rf"run\.nc: {next(iter(changes))}"):
            read_given(Path("run.nc"), dotted(changes), stored)[0]


def test_a_factor_of_the_vertical_needs_no_file(tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text("t,x (m/s2),y (m/s2)\n" + "".join(f"{0.01 * n:.2f},{n % 7 - 3},{n % 5 - 2}\n" for n in range(100)))
    motion = {"kind": "record", "file": str(tmp_path / "record.csv"), "start": 3.0, "vertical": {"factor": 1.0}}
    by_file, by_run = both(tmp_path, LAYERED | {"motion": motion}, {"motion.vertical.factor": 2.0})
    (tmp_path / "record.csv").unlink()
    assert by_run == by_file
    stored = xr.Dataset(attrs=run_attributes(by_file))
    assert read_given(tmp_path / "run.nc", dotted({"motion.vertical.factor": 2.0}), stored)[0].motion == by_file.motion


def test_a_stored_scene_that_is_no_json_is_refused() -> None:
    for text in ("{", "[" * 20_000, '{"duration": NaN}', json.dumps({"name": "a"})):
        with pytest.raises(ValueError, match=r"run\.nc: "):
            read_given(Path("run.nc"), {}, xr.Dataset(attrs={"scene": text}))[0]


@pytest.mark.parametrize(
    ("status", "time", "stage"),
    [("paused", 1.0, "gravity"), ("paused", 2.35, "first_failure"), ("unfailed", 3.0, "end"), ("diverged", 2.0, "end")],
)
def test_the_stage_of_a_run_is_told_by_its_status_and_its_last_sample(status: str, time: float, stage: str) -> None:
    scene = make_scene(LAYERED | {"gravity": {"ramp": 0.5, "duration": 1.0}})
    earlier = xr.Dataset({"sample_time": ("sample", [0.0, time])}, attrs=run_attributes(scene) | {"status": status})
    assert stopped_at(earlier) == stage
    assert stopped_at(None) == "end"


def test_another_component_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    samples = np.arange(600) % 7 - 3.0
    (tmp_path / "a.V2A").write_text(geonet({"N10E": samples, "Up": samples / 4.0, "N80W": samples / 2.0}, 0.01))
    data = LAYERED | {"motion": {"kind": "record", "file": "a.V2A", "component": "N10E", "start": 3.0, "vertical": {}}}
    here, again = both(tmp_path, data, {"motion.component": "3"})
    assert here == again and here.motion.data is not None  # type: ignore[union-attr]
    np.testing.assert_allclose(here.motion.data.x, samples / 2.0, rtol=1e-12)  # type: ignore[union-attr]


def test_a_run_that_differs_from_one_of_a_card_names_the_backend() -> None:
    made = {"versions": '{"sph": "1"}', "machine": "here"}
    earlier, again = (xr.Dataset({"x": ("particle", [value])}, attrs=made) for value in (1.0, 2.0))
    earlier.attrs["backend"] = "cuda"
    assert compare(earlier, again, Path("run.nc")) == "differs from run.nc in x: --backend cuda there and cpu here"
    assert compare(again, again, Path("run.nc")).endswith("bit for bit")
