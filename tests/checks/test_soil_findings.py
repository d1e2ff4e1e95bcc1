"""Properties of soil that are implausible, mostly mistaken units: who is told, and who is not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sph.checks.finding import Finding
from sph.checks.messages import words
from sph.checks.scene import findings
from sph.checks.soil import MAX_TANGENT, USED_UP, at_rest, of_rest, of_soils
from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.pore_pressure import effective_overburden

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
        ({"cohesion": 0.008}, "cohesion-implausible", "cohesion", "0.008 kPa", "at least 0.1 kPa, or 0; 20 kPa are 0.02 MPa"),
        ({"residual_cohesion": 0.008}, "cohesion-implausible", "residual_cohesion", "0.008 kPa", "at least 0.1 kPa"),
        ({"friction_angle": 0.52}, "angle-implausible", "friction_angle", "0.52 degree", "0.52 rad are 29.8 degree"),
        ({"friction_angle": 0.6}, "angle-implausible", "friction_angle", "0.6 degree", "0.6 is the tangent of 31 degree"),
        ({"residual_friction_angle": 0.3}, "angle-implausible", "residual_friction_angle", "0.3 degree", "17.2 degree"),
        ({"dilation_angle": 0.09}, "angle-implausible", "dilation_angle", "0.09 degree", "5.16 degree"),
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
    assert (one.code, one.severity, words(one).key) == (code, "warning", f"{at}.{key}")
    assert words(one).measured.startswith(f"{at}.{key} ") and value in words(one).measured and usual in words(one).wanted
    assert one.subject == ("soil" if at == "soil" else "clay") and one.subject in words(one).what


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
        {"residual_cohesion": 0.0, "residual_friction_angle": 1.5},
        {"cohesion": 5.0, "friction_angle": 1.5},
        {"cohesion": 0.1},
    ],
)
def test_what_is_usual_and_what_is_residual_is_not_told(at: str, settings: dict[str, float]) -> None:
    assert told(**{f"{at}.{name}": number for name, number in settings.items()}) == []


def test_a_stronger_layer_that_takes_over_the_residual_strength_is_told() -> None:
    """As rock under a cover, which would flow like it; not where it names its own, or keeps its peak."""
    residual = {"soil.residual_cohesion": 0.0, "soil.residual_friction_angle": 17.0}
    rock = {"layers.clay.soil.cohesion": 200.0, "layers.clay.soil.friction_angle": 38.0}
    (one,) = told(**residual, **rock)
    assert (one.code, one.subject) == ("residual-taken-over", "clay") and words(one).measured == "c = 0 kPa, phi = 17 degree"
    assert one.keys == ("layers.clay.soil.residual_cohesion", "layers.clay.soil.residual_friction_angle")
    assert told(**residual, **rock, **{"layers.clay.soil.residual_friction_angle": 30.0}) == [] == told(**rock) == told(**residual)


def test_only_slopes_of_ones_own_are_told() -> None:
    assert told(**{"scheme": "paper", "soil.cohesion": 20000.0}) == []
    assert told(**{"geometry": {"shape": "block", "width": 30.0, "height": 20.0}, "soil.cohesion": 20000.0}) == []


SEAM: dict[str, Any] = {"points": [[160, 435], [220, 455]], "cohesion": 5.0, "friction_angle": 20.0}
LOST = {"residual_friction_angle": 12.0, "slip_at_residual": 0.1}
ANGLES = (
    *(f"{at}.{angle}" for at in AT for angle in ("friction_angle", "dilation_angle", "residual_friction_angle")),
    *("seams.plane.friction_angle", "seams.plane.residual_friction_angle"),
)


def of_angles(key: str, value: float, cohesion: float) -> list[Finding]:
    """What is told of the angles of a scene with a seam, one key at a value and soil of one cohesion."""
    seam = SEAM if key == "seams.plane.friction_angle" else SEAM | LOST
    settings = {key: value, "soil.cohesion": cohesion, "layers.clay.soil.cohesion": cohesion}
    found = of_soils(make_scene(merge(merge(OWN, {"seams": {"plane": seam}}), dotted(settings))))
    return [each for each in found if each.code == "angle-implausible"]


@given(st.sampled_from(ANGLES), st.floats(5.0, 50.0), st.floats(0.0, 200.0), st.booleans())
def test_every_angle_in_radians_and_every_tangent_is_told_at_every_cohesion(key: str, angle: float, cohesion: float, tangent: bool) -> None:
    """And the same angle in degrees is not; that of the soil is taken over by a layer, which is told once."""
    written = math.tan(math.radians(angle)) if tangent else math.radians(angle)
    (one,) = of_angles(key, written, cohesion)
    assert words(one).key == key and words(one).measured == f"{key} {written:g} degree" and f"{angle:.3g} degree" in words(one).wanted
    if angle <= {"dilation_angle": 30.0, "residual_friction_angle": 12.0}.get(key.rsplit(".", 1)[-1], 50.0):
        assert of_angles(key, angle, cohesion) == []


def test_the_inclination_of_a_slope_in_radians_is_told() -> None:
    for angle, number in ((60.0, 0), (1.0472, 1)):
        slope = {"shape": "slope", "slope_height": 5.0, "slope_angle": angle}
        found = of_soils(make_scene(OWN | {"geometry": slope}))
        assert [words(each).key for each in found] == ["geometry.slope_angle"] * number and all(
            "60 degree" in words(each).wanted for each in found
        )


def test_a_coefficient_of_wall_friction_that_is_an_angle_is_told() -> None:
    walls = {"base": "free_slip", "layers": 3, "friction": {"base": 8.0, "sides": 0.0}}
    (one,) = told(**{"walls": walls})
    assert words(one).key == "walls.friction.base" and "0.141" in words(one).wanted and MAX_TANGENT < 8.0
    assert told(**{"walls": walls | {"friction": {"base": 0.5}}}) == []


# ---------------------------------------------------------------- soil that gravity alone brings to its strength


def test_ground_at_its_active_limit_is_told_with_layer_depth_and_remedy() -> None:
    """Deep ground of c 10 kPa, phi 20 degrees and nu 0.3: by hand, 0.2857 x 223.6 / (9.397 + 0.7143 x 0.3420 x 223.6) = 0.998 at 12 m."""
    weak = {"soil.cohesion": 10.0, "soil.friction_angle": 20.0, "numerics.spacing": 1.0, "geometry.base": 427.5, "layers": {}}
    ground = {"geometry.points": [[100, 430], [130, 430], [150, 440], [180, 440]]}
    made = make_scene(merge(OWN, dotted(weak | ground)) | {"layers": {}})
    (one,) = of_rest(made, place_particles(made))
    assert one in findings(made) and (one.code, one.severity, one.subject) == ("mobilised-strength", "warning", "soil")
    told = "100 % of its peak strength at a depth of 12 m with K0 = 0.429 = nu / (1 - nu), 95 % or more from 9 m downwards"
    assert words(one).measured == told and one.numbers["value"] == pytest.approx(0.998, abs=1e-3)
    assert one.keys == ("soil.K0", "soil.poisson_ratio")
    at_least = one.numbers["held_K0"]
    for off, told_again in ((0.002, False), (-0.002, True)):
        given = make_scene(merge(OWN, dotted(weak | ground | {"soil.K0": at_least + off})) | {"layers": {}})
        assert bool(of_rest(given, place_particles(given))) == told_again


def test_hardly_any_strength_is_mobilised_without_an_overflow() -> None:
    made = make_scene(merge(OWN, dotted({"soil.cohesion": 5e-324, "soil.friction_angle": 0.0, "layers": {}})) | {"layers": {}})
    (one,) = of_rest(made, place_particles(made))
    assert 1.0 < one.numbers["value"] < np.inf


@pytest.mark.parametrize("seed", range(8))
def test_the_mobilised_strength_of_layers_at_random_is_that_between_rankines_limits(seed: int) -> None:
    """1 at the limits that ``Soil.limits_at_rest`` gives, below it between them and above it outside, whatever layers and water."""
    random = np.random.default_rng(seed)
    layers = {}
    for number, top in enumerate(np.cumsum(random.uniform(1.0, 6.0, 3))):
        ranges = {"cohesion": (0.0, 30.0), "friction_angle": (0.0, 45.0), "poisson_ratio": (0.1, 0.49), "density": (1500.0, 2300.0)}
        soil = {key: random.uniform(*bounds) for key, bounds in ranges.items()}
        layers[f"layer{number}"] = {"region": {"kind": "depth", "top": top, "bottom": top + 6.0}, "soil": soil}
    water = {"water": {"level": random.uniform(431.0, 440.0), "pressure": "carried"}} if seed % 2 else {}
    made = make_scene(merge(OWN, {"layers": layers} | water))
    particles = place_particles(made)
    soil = slice(0, particles.n_soil)
    vertical, shares = effective_overburden(made, particles.x[soil], particles.y[soil]), at_rest(made, particles)
    for stress, number, share in zip(vertical, particles.layer[soil], shares, strict=True):
        its = made.soils[number]
        if stress > 0.0:
            low, high = its.limits_at_rest(stress)
            assert (share <= 1.0 + 1e-9) == (low - 1e-9 <= its.at_rest <= high + 1e-9)
    near = {name for number, name in enumerate(("soil", *made.layers)) if (shares[particles.layer[soil] == number] >= USED_UP).sum() > 4}
    assert {one.subject for one in of_rest(made, particles)} == near, "more than 4 particles of 1 m2 on a slope of 20 m"
