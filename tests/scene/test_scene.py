"""Scenes: bad input is refused with key, value and what is allowed, before any work."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import pytest
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from sph.scene.configuration import dotted, merge, read_yaml
from sph.scene.geometry import Slope
from sph.scene.schema import Scene, load_scene, make_scene

PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"

BAD = [
    # override, and the words its error must hold: key, value, what is allowed
    ({"colour": 1}, ["colour", "no such key"]),
    ({"soil.colour": 1}, ["soil.colour", "no such key"]),
    ({"geometry.radius": 3.0}, ["geometry.radius", "no such key"]),
    ({"coupling.fluid": {"law": "elastic_viscoplastic", "colour": 1}}, ["coupling.fluid.colour", "no such key"]),
    ({"numerics.artificial_viscosity.beta": 1}, ["numerics.artificial_viscosity.beta", "no such key"]),
    ({"soil.density": -1964}, ["soil.density", "-1964", "greater than or equal to 0.001"]),
    ({"soil.cohesion": -1}, ["soil.cohesion", "-1", "greater than or equal to 0"]),
    ({"soil.poisson_ratio": 0.5}, ["soil.poisson_ratio", "0.5", "less than or equal to 0.49"]),
    ({"coupling.S_R": 1.5}, ["coupling.S_R", "1.5", "less than or equal to 1"]),
    ({"soil.density": math.nan}, ["soil.density", "nan", "finite"]),
    ({"duration": math.inf}, ["duration", "inf", "finite"]),
    ({"soil.density": "nan"}, ["soil.density", "nan", "finite"]),
    ({"soil.density": "heavy"}, ["soil.density", "heavy", "number"]),
    ({"soil.density": [1, 2]}, ["soil.density", "[1, 2]", "number"]),
    ({"soil": None}, ["soil", "None"]),
    ({"walls": "fixed"}, ["walls", "fixed"]),
    ({"walls.sides": "free_slip"}, ["walls.layers", "2 layers", "needs 4"]),
    ({"walls.sides": "wet"}, ["walls.sides", "wet", "fixed", "free_slip", "none"]),
    ({"walls.layers": 1.5}, ["walls.layers", "1.5", "integer"]),
    ({"geometry.shape": "round"}, ["geometry", "round", "slope", "block"]),
    ({"coupling.fluid": {"law": "honey"}}, ["coupling.fluid", "honey", "elastic_viscoplastic", "capped_viscosity"]),
    ({"damping.frequencies": [5.6, 1.0]}, ["damping", "frequencies", "5.6", "increasing"]),
    ({"damping.frequencies": [1.0]}, ["damping.frequencies", "1.0"]),
    ({"damping.frequencies": [1.0, 2.0, 3.0]}, ["damping.frequencies", "3.0", "2 items"]),
    ({"motion.start": 0.5}, ["motion.start", "0.5", "gravity.duration"]),
    ({"motion.end": 1.9}, ["motion", "1.9", "decay_start", "end"]),
    ({"gravity.ramp": 2.0}, ["gravity.ramp", "2.0", "gravity.duration"]),
    ({"gravity.initial_stress": "geostatic"}, ["gravity.ramp", "0.5", "geostatic", "set gravity.ramp: 0"]),
    ({"gravity.initial_stress": "hydrostatic"}, ["gravity.initial_stress", "hydrostatic", "none", "geostatic"]),
    ({"duration": 0.5, "motion": {"kind": "none"}}, ["gravity.duration", "duration"]),
    ({"duration": 3.005}, ["duration", "3.005", "multiple", "outputs.series_interval"]),
    ({"outputs.series_interval": 0.0105}, ["outputs.series_interval", "0.0105", "multiple", "numerics.time_step"]),
    ({"outputs.frame_interval": 0.015}, ["outputs.frame_interval", "0.015", "multiple", "outputs.series_interval"]),
    ({"early_stop.window": 0.505}, ["early_stop.window", "0.505", "multiple", "outputs.series_interval"]),
    ({"numerics.spacing": 30.0}, ["numerics.spacing", "30", "fewer than two particles"]),
    ({"name": "a/b"}, ["name", "a/b", "A-Za-z0-9"]),
    ({"name": ""}, ["name", "A-Za-z0-9"]),
    ({"name": 5}, ["name", "5", "string"]),
    ({"probes": {"A": "top"}}, ["probes.A", "top", "crest_edge", "toe"]),
    ({"probes": {"A": [1, 2, 3]}}, ["probes.A", "[1, 2, 3]", "2 items"]),
    ({"probes": {"1st": [1, 2]}}, ["probes.1st", "A-Za-z"]),
]


@pytest.mark.parametrize(("overrides", "words"), BAD, ids=lambda v: ",".join(v) if isinstance(v, dict) else "")
def test_bad_input_is_named(small_slope, overrides: dict[str, Any], words: list[str]) -> None:
    base = small_slope({}).model_dump()
    data = merge(base, dotted(overrides))
    if "motion" in overrides:
        data["motion"] = overrides["motion"]
    with pytest.raises(ValueError) as raised:
        make_scene(data, "some.yaml")
    message = str(raised.value)
    for word in ["some.yaml", *words]:
        assert word in message, f"{word!r} is missing in: {message}"
    assert "pydantic.dev" not in message


def test_every_bad_key_is_reported_at_once(small_slope) -> None:
    data = merge(small_slope({}).model_dump(), dotted({"soil.density": -1, "coupling.gamma": "fast", "colour": 1}))
    with pytest.raises(ValueError) as raised:
        make_scene(data)
    lines = str(raised.value).splitlines()
    assert len(lines) == 3
    assert {"soil.density", "coupling.gamma", "colour"} == {line.split(": ")[1] for line in lines}


def test_missing_keys_are_named() -> None:
    with pytest.raises(ValueError, match=r"name: Field required") as raised:
        make_scene({})
    assert "geometry: Field required" in str(raised.value)


@pytest.mark.parametrize("answer", [True, False])
def test_a_yes_or_no_is_no_number(small_slope, answer: bool) -> None:
    # YAML reads yes, no, on and off as truth values; as a number they would silently be 1 and 0.
    with pytest.raises(ValueError, match=r"coupling.gamma"):
        small_slope({"coupling.gamma": answer})


@pytest.mark.parametrize("content", ["a: [1, 2", "- 1\n- 2\n", "just words\n", "", "\tname: x\n", b"\xff\xfe\x00"])
def test_bad_yaml_names_the_file(tmp_path: Path, content: str | bytes) -> None:
    path = tmp_path / "broken.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(ValueError, match=r"broken\.yaml"):
        read_yaml(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"nowhere\.yaml"):
        load_scene(tmp_path / "nowhere.yaml")


def test_numbers_written_without_a_sign_in_the_exponent() -> None:
    # YAML 1.1 reads 1.675e9 as text and 1.675e+9 as a number.
    scene = load_scene(PAPER, dotted({"soil.youngs_modulus": "1.675e6", "numerics.time_step": "1e-4", "duration": "15"}))
    assert scene == load_scene(PAPER)


def test_paper_values_of_derived_quantities() -> None:
    # VALIDATION.md V2 and MODEL.md section 3: G 622.2 MPa, K 1812.8 MPa, V_p 1159.9, V_s 562.9 m/s.
    soil = load_scene(PAPER).soil
    assert soil.shear_modulus_si == pytest.approx(622.2e6, abs=5e4)
    assert soil.bulk_modulus_si == pytest.approx(1812.8e6, abs=5e4)
    assert soil.p_wave_speed == pytest.approx(1159.9, abs=0.05)
    assert soil.s_wave_speed == pytest.approx(562.9, abs=0.05)
    assert soil.cohesion_si == 150e3
    assert soil.friction_angle_si == pytest.approx(math.pi / 9)


def test_rayleigh_coefficients_meet_the_ratio_at_both_frequencies(small_slope) -> None:
    damping = small_slope({"damping": {"ratio": 0.05, "frequencies": [1.0, 5.0]}}).damping
    for frequency in (1.0, 5.0):
        omega = 2 * math.pi * frequency
        ratio = 0.5 * (damping.mass_coefficient / omega + damping.stiffness_coefficient * omega)
        assert ratio == pytest.approx(0.05, rel=1e-12)


def test_a_scene_is_frozen(small_slope) -> None:
    scene = small_slope({})
    with pytest.raises(ValidationError):
        scene.duration = 5.0
    with pytest.raises(ValidationError):
        scene.soil.density = 5.0


def test_merge_and_dotted() -> None:
    assert dotted({"a.b": 1, "a.c": 2, "d": 3}) == {"a": {"b": 1, "c": 2}, "d": 3}
    base = {"a": {"b": 1, "c": [1, 2]}, "d": {"e": 1}}
    assert merge(base, {"a": {"c": [3]}, "d": None}) == {"a": {"b": 1, "c": [3]}, "d": None}
    assert base == {"a": {"b": 1, "c": [1, 2]}, "d": {"e": 1}}, "merge changes its argument"


def test_steps_are_rounded_not_truncated(small_slope) -> None:
    scene = small_slope({"numerics.time_step": 1e-4})
    assert scene.steps(0.3) == 3000  # 0.3 / 1e-4 is 2999.9999999999995
    assert scene.steps(2.9) == 29000


# ---------------------------------------------------------------- every key is described


def sections(annotation: Any) -> Iterator[type[BaseModel]]:
    """Models that a field's type holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) in (Union, UnionType, Annotated, dict, tuple, list):
        for part in get_args(annotation):
            yield from sections(part)


def described_keys(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, FieldInfo]]:
    for name, field in model.model_fields.items():
        yield f"{path}{name}", field
        for section in sections(field.annotation):
            yield from described_keys(section, f"{path}{name}.")


KEYS = list(described_keys(Scene))


def test_the_walk_reaches_every_level() -> None:
    names = {name for name, _ in KEYS}
    assert {"soil.density", "coupling.fluid.max_viscosity", "geometry.slope_angle", "numerics.artificial_viscosity.alpha"} <= names
    assert len(names) > 50


def test_every_key_has_a_sentence_a_unit_and_a_source_and_every_number_a_range() -> None:
    for name, field in KEYS:
        assert field.description and field.description.strip(), name
        extra = field.json_schema_extra
        assert isinstance(extra, dict), name
        assert extra.get("unit"), f"{name} has no unit ('-' for none)"
        assert extra.get("source"), f"{name} has no source"
        if field.annotation in (float, int, float | None):
            assert any(hasattr(m, "gt") or hasattr(m, "ge") for m in field.metadata), f"{name} has no lower limit"


def test_slope_dimensions_by_hand() -> None:
    # 25 / tan 45 = 25: width 10 + 25 + 5.
    slope = Slope(shape="slope", slope_angle=45, slope_height=25, base_depth=2, apron_length=10, crest_length=5)
    assert slope.width == pytest.approx(40)
    assert slope.height == 27
    assert slope.toe == (10, 2)
    assert slope.crest == pytest.approx((35, 27))


def test_an_override_may_choose_another_variant_of_a_section() -> None:
    assert load_scene(PAPER, dotted({"motion.kind": "none"})).motion.kind == "none"
    scene = load_scene(PAPER, dotted({"geometry.shape": "block", "geometry.width": 20.0, "geometry.height": 10.0}))
    assert scene.geometry.height == 10.0
    assert load_scene(PAPER, dotted({"motion.kind": "tapered_sine", "motion.amplitude": 2.0})).motion.frequency == 1.0
