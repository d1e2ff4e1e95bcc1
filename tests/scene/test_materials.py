"""What holds for each soil of a scene: what its layer has of its own, else what is written for the whole scene."""

from __future__ import annotations

import pickle
from typing import Any

import pytest

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene

SCENE: dict[str, Any] = {
    "scheme": "paper",
    "name": "layered",
    "geometry": {"shape": "slope"},
    "soil": {"cohesion": 40.0, "friction_angle": 20.0},
    "coupling": {
        "S_R": 0.5,
        "gamma": 2.0,
        "solid_after_failure": "elastic_plastic",
        "softening": {"slip_at_peak": 0.01, "slip_at_residual": 0.1, "width": 3.0},
    },
    "water": {"r_u": 0.2, "pressure": "by_place"},
    "layers": {
        "clay": {"region": {"kind": "depth", "top": 5.0}},
        "silt": {
            "region": {"kind": "depth", "top": 10.0},
            "soil": {"residual_cohesion": 30.0},
            "S_R": 0.1,
            "gamma": 0.0,
            "slip_at_residual": 0.3,
            "r_u": 0.0,
        },
    },
}


def scene(**changes: Any) -> Scene:
    return make_scene(merge(SCENE, changes))


def test_a_layer_takes_what_it_has_not_of_its_own() -> None:
    soil, clay, silt = scene().materials
    assert (soil.name, clay.name, silt.name) == ("soil", "clay", "silt")
    assert clay == soil._replace(name="clay", soil=clay.soil) and clay.soil == soil.soil
    assert (soil.S_R, soil.gamma, soil.r_u) == (0.5, 2.0, 0.2) and (silt.S_R, silt.gamma, silt.r_u) == (0.1, 0.0, 0.0)
    assert soil.softening is not None and silt.softening is not None
    assert silt.softening == soil.softening.model_copy(update={"slip_at_residual": 0.3})


def test_what_failed_soil_keeps() -> None:
    soil, _, silt = scene().materials
    assert soil.residual == (20.0, 10.0) and silt.residual == (30.0, 2.0)
    assert soil.kept(2e4, 0.3) == (1e4, 0.15)
    assert silt.kept(2e4, 0.3, kPa=1e3) == (2e4, pytest.approx(0.03)), "never more than at the peak"
    assert soil.uses_S_R and silt.uses_S_R


def test_a_copy_with_other_sections_has_other_materials() -> None:
    before = scene()
    assert before.materials is before.materials, "worked out once"
    after = before.model_copy(update={"coupling": before.coupling.model_copy(update={"S_R": 0.2})})
    assert [each.S_R for each in after.materials] == [0.2, 0.2, 0.1] and before.materials[0].S_R == 0.5
    assert before == scene() and pickle.loads(pickle.dumps(before)) == before
    assert "materials" not in before.model_dump() and before.stored() == scene().stored()
