"""Soil by the speed of its shear waves and by its undrained strength."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene, stored_scene, written_scene

ROOT = Path(__file__).resolve().parents[2]
GENTLE = written_scene(ROOT / "config" / "scenes" / "gentle_layered.yaml")


def without(*keys: str) -> dict[str, Any]:
    """The gentle slope without some keys of its soil."""
    return {**GENTLE, "soil": {name: value for name, value in GENTLE["soil"].items() if name not in keys}}


def test_a_speed_of_shear_waves_is_that_of_the_soil_made() -> None:
    scene = make_scene(merge(without("youngs_modulus"), {"soil": {"shear_wave_speed": 250.0, "density": 1900.0, "poisson_ratio": 0.3}}))
    assert scene.soil.youngs_modulus == pytest.approx(2 * 1.3 * 1900.0 * 250.0**2 / 1000) and scene.soil.s_wave_speed == pytest.approx(
        250.0
    )


def test_a_layer_takes_density_and_ratio_of_the_scenes_soil() -> None:
    scene = make_scene(merge(GENTLE, {"soil": {"density": 1900.0}, "layers": {"fill": {"region": {"kind": "depth", "bottom": 2.0}, "soil": {
        "shear_wave_speed": 120.0}}}}))  # fmt: skip
    fill = scene.layers["fill"].soil
    assert (fill.density, fill.s_wave_speed) == (1900.0, pytest.approx(120.0)) and scene.soil.youngs_modulus == GENTLE["soil"][
        "youngs_modulus"
    ]
    heavier = merge(scene.model_dump(), {"layers": {"fill": {"soil": {"density": 2000.0}}}})
    assert make_scene(heavier).layers["fill"].soil.youngs_modulus == fill.youngs_modulus, "a stored scene keeps the modulus"


def test_undrained_strength_is_a_cohesion_without_friction() -> None:
    scene = make_scene(merge(without("cohesion", "friction_angle", "dilation_angle"), {"soil": {"undrained_strength": 45.0}}))
    assert (scene.soil.cohesion, scene.soil.friction_angle) == (45.0, 0.0)


def test_what_is_stored_has_the_keys_of_the_equations_alone() -> None:
    speed = make_scene(merge(without("youngs_modulus"), {"soil": {"shear_wave_speed": 250.0}}))
    modulus = make_scene(merge(GENTLE, {"soil": {"youngs_modulus": speed.soil.youngs_modulus}}))
    assert speed.model_dump_json() == modulus.model_dump_json() and "shear_wave_speed" not in speed.model_dump()["soil"]
    assert Scene.model_validate_json(speed.model_dump_json()) == speed


@pytest.mark.parametrize(
    ("soil", "words"),
    [
        ({"shear_wave_speed": 250.0}, "soil.shear_wave_speed: 250.0 stands for youngs_modulus; leave out youngs_modulus"),
        (
            {"undrained_strength": 40},
            "undrained_strength: 40 stands for cohesion and friction_angle; leave out cohesion and friction_angle",
        ),
        ({"youngs_modulus": None, "shear_wave_speed": "fast"}, "soil.shear_wave_speed"),
        ({"youngs_modulus": None, "shear_wave_speed": -3.0}, "soil.shear_wave_speed"),
        ({"undrained_strength": 40, "cohesion": None}, "leave out friction_angle"),
    ],
)
def test_two_forms_and_nonsense_are_refused(soil: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError) as raised:
        make_scene(merge(GENTLE, {"soil": soil}), "scene.yaml")
    assert words in str(raised.value)


def test_a_speed_without_density_is_refused_with_what_it_needs() -> None:
    with pytest.raises(ValueError) as raised:
        make_scene(merge(without("youngs_modulus", "density"), {"soil": {"shear_wave_speed": 250.0}}), "scene.yaml")
    assert "shear_wave_speed: 250 m/s needs density and poisson_ratio" in str(raised.value)
    assert "scene.yaml: soil.density: must be given" in str(raised.value) and "soil.youngs_modulus: must" not in str(raised.value)


def test_without_either_the_refusal_names_both() -> None:
    with pytest.raises(ValueError, match="soil.youngs_modulus: must be given.*or write soil.shear_wave_speed"):
        make_scene(without("youngs_modulus"), "scene.yaml")


def test_sph_new_writes_the_speed(tmp_path: Path) -> None:
    from sph.command.known import Known
    from sph.command.new import write_new

    ground = tmp_path / "ground.csv"
    ground.write_text("x,elevation\n0,0\n60,0\n90,20\n160,20\n")
    record = ROOT / "config" / "motions"
    scene = write_new(Known(ground, [record / "synthetic.csv"]), tmp_path / "new").scene
    assert yaml.safe_load(scene.read_text(encoding="utf-8"))["soil"]["shear_wave_speed"] == 250


def test_strength_that_grows_with_depth_is_a_cohesion_and_its_growth() -> None:
    bare = without("cohesion", "friction_angle", "dilation_angle")
    scene = make_scene(merge(bare, {"soil": {"undrained_strength": {"at_top": 20.0, "gradient": 1.5}}}))
    assert (scene.soil.cohesion, scene.soil.friction_angle, scene.soil.gradient) == (20.0, 0.0, 1.5)
    assert stored_scene(json.loads(scene.stored())) == scene
    assert stored_scene(scene.model_dump(mode="json")) == scene


def test_a_layer_with_a_strength_of_its_own_does_not_grow_as_the_soil_does() -> None:
    bare = without("cohesion", "friction_angle", "dilation_angle")
    growing = {"soil": {"undrained_strength": {"at_top": 20.0, "gradient": 1.5, "datum": 3.0}}}
    layers = {
        name: {"region": {"kind": "elevation", "bottom": float(number), "top": number + 1.0}, "soil": soil}
        for number, (name, soil) in enumerate(
            {"own": {"undrained_strength": 40.0}, "as_soil": {"density": 1700.0}, "faster": {"cohesion_growth": {"gradient": 3.0}}}.items()
        )
    }
    scene = make_scene(merge(bare, {**growing, "layers": layers}))
    found = {name: (scene.layers[name].soil.cohesion, scene.layers[name].soil.gradient) for name in layers}
    assert found == {"own": (40.0, 0.0), "as_soil": (20.0, 1.5), "faster": (20.0, 3.0)}
    assert stored_scene(json.loads(scene.stored())) == scene


def test_without_growth_nothing_is_stored_of_it() -> None:
    bare = without("cohesion", "friction_angle", "dilation_angle")
    constant = make_scene(merge(bare, {"soil": {"undrained_strength": 20.0}}))
    level = make_scene(merge(bare, {"soil": {"undrained_strength": {"at_top": 20.0, "gradient": 0.0}}}))
    assert level.stored() == constant.stored() and "growth" not in constant.stored() + constant.model_dump_json()


@pytest.mark.parametrize(
    ("strength", "words"),
    [
        ({"at_top": 20.0}, "soil.undrained_strength: gradient: Field required"),
        ({"at_top": -1.0, "gradient": 1.0}, "soil.undrained_strength: at_top: Input should be greater than or equal to 0 (found -1.0)"),
        ({"at_top": 0.0, "gradient": 0.0}, "at_top: 0 kPa with gradient: 0 kPa/m is no strength"),
        ({"top": 20.0, "gradient": 1.0}, "soil.undrained_strength: top: there is no such key here"),
        ("soft", "soil.undrained_strength: 'soft' must be above 0 kPa and at most 1e+06, or a section with at_top and gradient"),
        (0, "soil.undrained_strength: 0 must be above 0 kPa"),
    ],
)
def test_a_strength_that_is_none_is_refused(strength: Any, words: str) -> None:
    with pytest.raises(ValueError) as raised:
        make_scene(merge(without("cohesion", "friction_angle", "dilation_angle"), {"soil": {"undrained_strength": strength}}), "scene.yaml")
    assert words in str(raised.value)


def test_a_strength_that_grows_beside_a_growth_is_refused() -> None:
    with pytest.raises(ValueError, match="leave out cohesion_growth"):
        soil = {"undrained_strength": {"at_top": 20.0, "gradient": 1.0}, "cohesion_growth": {"gradient": 1.0}}
        make_scene(merge(without("cohesion", "friction_angle", "dilation_angle"), {"soil": soil}))


STIFFNESS = {"youngs_modulus": st.floats(1e4, 1e6), "shear_wave_speed": st.floats(60.0, 900.0)}
"""Forms of the stiffness."""
STRENGTH = st.one_of(
    st.fixed_dictionaries({"cohesion": st.floats(5.0, 80.0), "friction_angle": st.floats(21.0, 40.0)}),
    st.fixed_dictionaries(
        {
            "cohesion": st.floats(5.0, 80.0),
            "friction_angle": st.floats(21.0, 40.0),
            "cohesion_growth": st.fixed_dictionaries({"gradient": st.floats(0.1, 5.0)}),
        }
    ),
    st.fixed_dictionaries({"undrained_strength": st.floats(5.0, 80.0)}),
    st.fixed_dictionaries(
        {
            "undrained_strength": st.fixed_dictionaries(
                {"at_top": st.floats(5.0, 80.0), "gradient": st.floats(0.1, 5.0), "datum": st.just(3.0)}
            )
        }
    ),
)
"""Forms of the peak strength."""
LAYERED: dict[str, Any] = {
    "scheme": "paper",
    "name": "s",
    "geometry": {"shape": "slope"},
    "gravity": {"ramp": 0.0, "initial_stress": "geostatic"},
}
TOP: dict[str, Any] = {"kind": "depth", "bottom": 2.0}


def in_words(soil: Any) -> dict[str, float | None]:
    """What each quantity of a soil is in all its forms."""
    return {
        "density": soil.density,
        "poisson_ratio": soil.poisson_ratio,
        "youngs_modulus": soil.youngs_modulus,
        "shear_wave_speed": soil.s_wave_speed,
        "cohesion": soil.cohesion,
        "friction_angle": soil.friction_angle,
        "gradient": soil.gradient,
        "datum": soil.cohesion_growth and soil.cohesion_growth.datum,
        "residual_cohesion": soil.residual_cohesion,
        "residual_friction_angle": soil.residual_friction_angle,
        "K0": soil.K0,
        "viscosity": soil.viscosity,
    }


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_layer_takes_over_what_is_written(data: st.DataObject) -> None:
    """A layer names one key or one form: it has that, and of all else the number that the scene's soil writes, in its form."""
    stiff = data.draw(st.sampled_from([*STIFFNESS]))
    peak = data.draw(STRENGTH)
    rest = data.draw(
        st.fixed_dictionaries(
            {"density": st.floats(1500.0, 2300.0), "poisson_ratio": st.floats(0.2, 0.4)},
            optional={"K0": st.floats(0.6, 0.9), "residual_cohesion": st.floats(0.0, 4.0), "viscosity": st.floats(1.0, 9.0)},
        )
    )
    written = {stiff: data.draw(STIFFNESS[stiff])} | peak | rest
    new = data.draw(
        st.sampled_from(
            [
                {"density": 1400.0},
                {"poisson_ratio": 0.15},
                {"youngs_modulus": 5.0e4},
                {"shear_wave_speed": 111.0},
                {"cohesion": 90.0},
                {"undrained_strength": 33.0},
                {"undrained_strength": {"at_top": 33.0, "gradient": 2.0}},
                {"viscosity": 5.0},
                {"K0": 0.8},
                {"residual_cohesion": 1.0},
            ]
        )
    )
    scene = make_scene(LAYERED | {"soil": written, "layers": {"other": {"region": TOP, "soil": new}}})
    own, found = in_words(scene.soil), in_words(scene.layers["other"].soil)
    expected = dict(own)
    strengths = new.get("undrained_strength")
    if strengths is not None:
        section = strengths if isinstance(strengths, dict) else {"at_top": strengths, "gradient": 0.0}
        under = peak.get("undrained_strength")
        datum = under["datum"] if isinstance(strengths, dict) and isinstance(under, dict) else None
        expected |= {"cohesion": section["at_top"], "friction_angle": 0.0, "gradient": section["gradient"], "datum": datum}
    else:
        expected |= new
    if "cohesion" in new:
        expected |= {"gradient": 0.0, "datum": None}
    form = next((name for name in STIFFNESS if name in new), stiff)
    expected[form] = new.get(form, written.get(form))
    shear = 2e-3 * (1.0 + expected["poisson_ratio"]) * expected["density"]
    if form == "shear_wave_speed":
        expected["youngs_modulus"] = shear * expected[form] ** 2
    else:
        expected["shear_wave_speed"] = math.sqrt(expected[form] / shear)
    assert found == {name: value if value is None else pytest.approx(value, rel=1e-12) for name, value in expected.items()}
    assert stored_scene(json.loads(scene.stored())) == scene, "a stored scene repeats the run"
    assert make_scene(json.loads(scene.stored())) == scene and make_scene(scene.model_dump()) == scene


def layered(soil: dict[str, Any], layer: dict[str, Any]) -> Scene:
    return make_scene(LAYERED | {"soil": soil, "layers": {"other": {"region": TOP} | layer}})


def test_a_lighter_layer_has_the_speed_that_its_soil_writes() -> None:
    soil = {"density": 2200.0, "shear_wave_speed": 200.0, "poisson_ratio": 0.25}
    assert layered(soil, {"soil": {"density": 1500.0}}).layers["other"].soil.s_wave_speed == pytest.approx(200.0)


def test_a_strength_ratio_of_a_layer_replaces_the_residual_strengths_of_the_soil() -> None:
    """Also where only one of them is written; and a stored scene says so, whatever its version."""
    for residual in ({"residual_cohesion": 5.0, "residual_friction_angle": 10.0}, {"residual_friction_angle": 10.0}):
        scene = layered({"cohesion": 20.0, "friction_angle": 30.0} | residual, {"S_R": 0.6})
        assert scene.materials[1].residual == (12.0, 18.0)
        assert stored_scene(json.loads(scene.stored())) == scene
    earlier = json.loads(scene.stored())
    earlier["layers"]["other"]["soil"] = {}  # as versions stored it that took the angle over
    assert stored_scene(earlier).layers["other"].soil.residual_friction_angle == 10.0
    assert make_scene(json.loads(stored_scene(earlier).stored())).layers["other"].soil.residual_friction_angle == 10.0


def test_a_friction_angle_alone_under_an_undrained_strength_is_refused() -> None:
    with pytest.raises(ValueError, match="layers.other.soil.friction_angle: 25.0 under soil.undrained_strength.*write the cohesion"):
        layered({"undrained_strength": 40.0}, {"soil": {"friction_angle": 25.0}})
    assert layered({"undrained_strength": 40.0}, {"soil": {"friction_angle": 25.0, "cohesion": 3.0}}).layers["other"].soil.cohesion == 3.0
    grows = layered({"undrained_strength": 40.0}, {"soil": {"undrained_strength": {"gradient": 2.0}}}).layers["other"].soil
    assert (grows.cohesion, grows.gradient) == (40.0, 2.0), "a section names the keys that differ, too"


def test_what_is_drawn_reaches_a_layer_in_the_form_in_which_it_is_written() -> None:
    """Density is drawn, and the speed is written: both soils keep it."""
    variable = {"of": "soil.density", "kind": "normal", "mean": 2000.0, "sd": 100.0}
    soil = {"density": 2000.0, "shear_wave_speed": 200.0}
    data = LAYERED | {"soil": soil, "layers": {"other": {"region": TOP, "soil": {"poisson_ratio": 0.2}}}}
    scene = make_scene(data | {"uncertain": {"seed": 3, "variables": {"rho": variable}}})
    assert scene.soil.density != 2000.0 and [each.s_wave_speed for each in scene.soils] == pytest.approx([200.0, 200.0])
    assert stored_scene(json.loads(scene.stored())) == scene
