"""Factors of safety against liquefaction and cyclic softening, layer by layer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from calling import call

from sph.checks.liquefaction import of_liquefaction
from sph.checks.messages import words
from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles

GROUND: dict[str, Any] = {
    "name": "ground",
    "scheme": "paper",
    "duration": 8.0,
    "geometry": {"shape": "block", "width": 10.0, "height": 20.0},
    "soil": {"density": 1900.0, "cohesion": 0.0, "friction_angle": 33.0, "blow_count": 10.0},
    "layers": {
        "clay": {"region": {"kind": "elevation", "bottom": 5.0, "top": 10.0}, "soil": {"undrained_strength": 40.0, "blow_count": None}},
        "dense": {"region": {"kind": "elevation", "top": 5.0}, "soil": {"blow_count": 32.0}},
    },
    "water": {"pressure": "carried", "level": 18.0, "excess_pressure": {}},
    "motion": {"kind": "tapered_sine", "amplitude": 2.5, "start": 3.0, "ramp": 1.0, "decay_start": 6.0, "end": 7.0},
    "numerics": {"spacing": 1.0},
}


def test_layers_have_the_factors_of_the_simplified_procedure() -> None:
    scene = make_scene(GROUND)
    found = {each.subject: each for each in of_liquefaction(scene, place_particles(scene), 7.5)}
    assert [found[name].code for name in ("soil", "clay", "dense")] == ["liquefaction", "cyclic-softening", "liquefaction"]
    assert [found[name].severity for name in ("soil", "clay", "dense")] == ["warning", "warning", "note"]
    # By hand at 9.5 m: total 177.1, effective 103.5 kPa, r_d 0.91; 0.118 / (0.65 2.5/9.81 1.711 0.91).
    assert found["soil"].numbers["value"] == pytest.approx(0.46, abs=0.01) and found["soil"].numbers["share"] == 1.0
    assert found["dense"].numbers["value"] > 1.5
    weaker = of_liquefaction(scene, place_particles(scene), 6.0)
    assert all(less.numbers["value"] > found[less.subject].numbers["value"] for less in weaker[:2])
    still = make_scene(merge(GROUND, dotted({"motion": {"kind": "none"}})))
    assert of_liquefaction(still, place_particles(still), 7.5) == []


def test_the_command_tells_them_for_a_magnitude(tmp_path: Path) -> None:
    path = tmp_path / "ground.yaml"
    path.write_text(yaml.safe_dump(GROUND))
    asked = call("check", path, "--magnitude", "7.5")
    assert asked.exit_code == 0 and "soil liquefies in the earthquake" in asked.output, asked.output
    assert "factor of safety" in words(of_liquefaction(make_scene(GROUND), place_particles(make_scene(GROUND)), 7.5)[0]).measured
    assert "liquefies" not in call("check", path).output
