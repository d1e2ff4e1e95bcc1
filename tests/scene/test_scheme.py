"""Schemes: nothing that decides the answer is filled in for a slope of one's own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from sph.checks.loss import of_softening
from sph.checks.scene import strengths
from sph.scene.configuration import dotted, flat, merge, read_yaml
from sph.scene.schema import Scene, load_scene, make_scene
from sph.scene.scheme import NEEDED, RESOLVED
from sph.storage.trajectory import scene_of

OWN: dict[str, Any] = {
    "name": "own",
    "geometry": {"shape": "slope", "slope_angle": 30.0, "slope_height": 12.0},
    "soil": {
        "density": 1900.0,
        "youngs_modulus": 2e5,
        "poisson_ratio": 0.3,
        "cohesion": 12.0,
        "friction_angle": 25.0,
        "viscosity": 1.0,
    },
    "coupling": {"S_R": 0.5, "gamma": 10.0},
    "damping": None,
    "numerics": {"spacing": 0.5},
}


def value_at(scene: Scene, name: str) -> Any:
    value: Any = scene.model_dump()
    for part in name.split("."):
        value = None if value is None else value[part]
    return value


def without(name: str) -> dict[str, Any]:
    """The scene without a key."""
    *sections, last = name.split(".")
    scene = merge(OWN, {})
    place = scene
    for part in sections:
        place[part] = dict(place[part])
        place = place[part]
    del place[last]
    return scene


@pytest.mark.parametrize("name", NEEDED)
def test_what_decides_the_answer_must_be_written(name: str) -> None:
    with pytest.raises(ValueError) as raised:
        make_scene(without(name), "own.yaml")
    lines = str(raised.value).splitlines()
    assert lines == [
        f"own.yaml: {name}: must be given, since the results depend on it: {NEEDED[name]}",
        "own.yaml: scheme: paper would take what is not written from the paper's scene",
    ]


def test_all_that_is_missing_is_told_at_once_with_the_other_mistakes() -> None:
    with pytest.raises(ValueError) as raised:
        make_scene({"name": "own", "geometry": {"shape": "slope"}, "colour": "red"})
    lines = str(raised.value).splitlines()
    assert "colour" in lines[0] and len(lines) == 1 + len(NEEDED) + 1


def test_what_a_scene_does_not_write_is_computed_as_resolved() -> None:
    scene = make_scene(OWN)
    assert scene.scheme == "resolved"
    assert {name: value_at(scene, name) for name in flat(RESOLVED)} == flat(RESOLVED)


def test_what_a_scene_writes_counts() -> None:
    scene = make_scene(merge(OWN, dotted({"walls.sides": "absorbing", "walls.base": "absorbing", "numerics.artificial_viscosity": None})))
    assert (scene.walls.base, scene.walls.sides, scene.numerics.artificial_viscosity) == ("absorbing", "absorbing", None)
    stronger = make_scene(merge(OWN, dotted({"numerics.artificial_viscosity.alpha": 0.3})))
    assert stronger.numerics.artificial_viscosity is not None and stronger.numerics.artificial_viscosity.reconstruction == "linear"


def test_the_papers_scheme_fills_in_everything() -> None:
    scene = make_scene({"name": "paper", "scheme": "paper", "geometry": {"shape": "slope"}})
    assert (scene.soil.cohesion, scene.coupling.S_R, scene.walls.base, scene.numerics.smoothing_ratio) == (150.0, 0.25, "fixed", 2.3)
    for name, value in flat(RESOLVED).items():
        assert value_at(scene, name) != value, f"{name} need not be in RESOLVED"


def test_a_file_of_a_version_before_schemes_is_read_as_it_was_run() -> None:
    scene = make_scene({"name": "paper", "scheme": "paper", "geometry": {"shape": "slope"}, "coupling": {"S_R": 0.1}})
    kept = scene.model_dump(mode="json")
    del kept["scheme"], kept["coupling"]["softening"], kept["walls"]["tension"]
    assert scene_of(xr.Dataset(attrs={"scene": json.dumps(kept)})) == scene


def test_a_strength_is_told_at_its_peak_and_as_failed_soil_keeps_it() -> None:
    layer = {"region": {"kind": "depth", "top": 2.0}, "soil": {"cohesion": 40.0}, "S_R": 0.25}
    found = dict(strengths(make_scene(merge(OWN, {"layers": {"clay": layer}}))))
    assert found == {
        "soil": "peak c = 12 kPa, phi = 25 degree; residual c = 6 kPa, phi = 12.5 degree (S_R = 0.5, gamma = 10 1/s)",
        "clay": "peak c = 40 kPa, phi = 25 degree; residual c = 10 kPa, phi = 6.25 degree (S_R = 0.25, gamma = 10 1/s)",
    }


def test_failure_without_a_length_is_warned_of_but_for_the_papers() -> None:
    (found,) = of_softening(make_scene(OWN))
    assert (found.code, found.severity, found.keys) == ("no-process-zone", "warning", ("coupling.softening",))
    (noted,) = of_softening(make_scene(merge(OWN, {"scheme": "paper"})))
    assert (noted.code, noted.severity) == ("no-process-zone", "note")
    assert of_softening(make_scene(merge(OWN, {"coupling": {"softening": {"slip_at_peak": 1e-3, "width": 2.0}}}))) == []


BY_TIME = {
    "long_box": "the claims of the paper are read on it",
    "lower_san_fernando": "liquefied soil; no shear test gives a slip",
    "upper_san_fernando": "as the lower dam",
}
"""Shipped slopes that keep the loss of strength by time, and why."""


def test_shipped_slopes_lose_their_strength_by_slip() -> None:
    root = Path(__file__).resolve().parents[2]
    files = [*(root / "config" / "scenes").glob("*.yaml"), *(root / "docs" / "gallery").glob("*.yaml")]
    scenes = [load_scene(path) for path in files if "geometry" in read_yaml(path)]
    own = {scene.name: scene for scene in scenes if scene.scheme == "resolved"}
    assert len(own) >= 10 and set(BY_TIME) <= set(own)
    assert {name for name, scene in own.items() if not scene.coupling.softens_by_slip} == set(BY_TIME)
    assert not [name for name, scene in own.items() if name not in BY_TIME and scene.coupling.gamma > 0.0]
