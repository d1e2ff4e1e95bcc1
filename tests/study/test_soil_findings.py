"""Properties of soil that are implausible, mostly mistaken units: who is told, and who is not."""

from __future__ import annotations

from typing import Any

import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.study.finding import Finding
from sph.study.findings import findings
from sph.study.soil_findings import of_soils

OWN: dict[str, Any] = {
    "name": "own",
    "geometry": {"shape": "ground_line", "points": [[100, 440], [160, 440], [180, 460], [220, 460]], "base": 430},
    "soil": {
        "density": 1900.0,
        "youngs_modulus": 3e5,
        "poisson_ratio": 0.3,
        "cohesion": 20.0,
        "friction_angle": 30.0,
        "viscosity": 2.0,
    },
    "coupling": {"S_R": 0.5, "gamma": 10.0},
    "layers": {"clay": {"region": {"kind": "depth", "top": 4.0, "bottom": 9.0}, "soil": {"cohesion": 12.0}}},
    "damping": None,
    "numerics": {"spacing": 1.0},
}
AT = ("soil", "layers.clay.soil")


def told(**settings: Any) -> list[Finding]:
    scene = make_scene(merge(OWN, dotted(settings)))
    found = of_soils(scene)
    assert set(found) <= set(findings(scene))
    return found


@pytest.mark.parametrize("at", AT)
@pytest.mark.parametrize(
    ("settings", "code", "key", "value", "usual"),
    [
        ({"cohesion": 20000.0}, "cohesion-implausible", "cohesion", "20000 kPa", "at most 1,000 kPa"),
        ({"density": 999.0}, "density-implausible", "density", "999 kg/m3", "1,000 to 3,000 kg/m3"),
        ({"density": 3001.0}, "density-implausible", "density", "3001 kg/m3", "1,000 to 3,000 kg/m3"),
        ({"youngs_modulus": 3e8}, "stiffness-implausible", "youngs_modulus", "V_s = 7.79e+03 m/s", "30 to 3,500 m/s"),
        ({"youngs_modulus": 300.0}, "stiffness-implausible", "youngs_modulus", "V_s = 7.79 m/s", "30 to 3,500 m/s"),
        ({"cohesion": 4.9, "friction_angle": 4.9}, "strength-implausible", "cohesion", "4.9 kPa", "5 degree"),
    ],
)
def test_an_implausible_property_is_told_with_its_key_and_what_is_usual(
    at: str, settings: dict[str, float], code: str, key: str, value: str, usual: str
) -> None:
    (one,) = told(**{f"{at}.{name}": number for name, number in settings.items()})
    assert (one.code, one.severity, one.key) == (code, "warning", f"{at}.{key}")
    assert one.measured.startswith(f"{at}.{key} ") and value in one.measured and usual in one.wanted
    assert one.subject == ("soil" if at == "soil" else "clay") and one.subject in one.what


def test_a_density_in_tonnes_is_told_and_the_stiffness_that_follows() -> None:
    assert [each.code for each in told(**{"soil.density": 1.9})] == ["density-implausible", "stiffness-implausible"], (
        "once, though the layer takes it over"
    )


@pytest.mark.parametrize("at", AT)
@pytest.mark.parametrize(
    "settings",
    [
        {"cohesion": 1000.0},
        {"density": 1000.0},
        {"density": 3000.0},
        {"cohesion": 0.0},
        {"friction_angle": 0.0},
        {"cohesion": 5.0, "friction_angle": 0.0},
        {"cohesion": 0.0, "friction_angle": 5.0},
        {"residual_cohesion": 0.0, "residual_friction_angle": 1.0},
    ],
)
def test_what_is_usual_and_what_is_residual_is_not_told(at: str, settings: dict[str, float]) -> None:
    assert told(**{f"{at}.{name}": number for name, number in settings.items()}) == []


def test_only_slopes_of_ones_own_are_told() -> None:
    assert told(**{"scheme": "paper", "soil.cohesion": 20000.0}) == []
    assert told(**{"geometry": {"shape": "block", "width": 30.0, "height": 20.0}, "soil.cohesion": 20000.0}) == []
