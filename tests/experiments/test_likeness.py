"""Which scenes are like the slope whose errors were measured: one change at a time, inside and outside its range."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from sph.experiments.variants.advice import REMEDY, expected_error, expected_metrics, expected_sentence
from sph.experiments.variants.likeness import unlike
from sph.scene.configuration import dotted, merge, read_scene
from sph.scene.schema import Scene, load_scene, make_scene

SCENES = Path(__file__).resolve().parents[2] / "config" / "scenes"


def measured(**changes: Any) -> Scene:
    """The measured slope; ``rock=None`` takes the rock away."""
    scene = read_scene(SCENES / "slope_on_rock.yaml")
    if "rock" in changes:
        del scene["layers"]
    return make_scene(merge(scene, dotted({name.replace("__", "."): value for name, value in changes.items() if name != "rock"})))


@pytest.mark.parametrize(
    "like",
    [
        {},
        {"geometry__slope_height": 20.0, "numerics__spacing": 0.8},
        {"geometry__base_depth": 2.0, "rock": None},
        {"geometry__slope_angle": 50.0},
        {"soil__cohesion": 100.0},
        {"soil__friction_angle": 28.0},
        {"coupling__S_R": 0.1},
        {"coupling__S_R": 0.4},
        {"coupling__softening__slip_at_residual": 0.01},
        {"layers__rock__region__top": 8.0},
        {"motion__amplitude": 5.0},
    ],
)
def test_a_slope_like_the_measured_one_has_its_error(like: dict[str, Any]) -> None:
    scene = measured(**like)
    assert unlike(scene) == [] and expected_error(scene) is not None
    assert "within" in expected_sentence(scene) and not math.isnan(expected_metrics(scene)["expected_runout_error"])


SLIP_OF_8_M = {"coupling__softening__slip_at_residual": 6e-3}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"geometry__slope_height": 8.0, "numerics__spacing": 0.32, "soil__cohesion": 48.0, **SLIP_OF_8_M}, "height 8 m"),
        ({"geometry__slope_height": 60.0, "soil__cohesion": 360.0}, "height 60 m"),
        ({"geometry__slope_angle": 30.0}, "slope angle 30 degrees"),
        ({"geometry__slope_angle": 85.0}, "slope angle 85 degrees"),
        ({"soil__cohesion": 15.0, "coupling__softening__slip_at_residual": 0.02}, "c / (rho g H) 0.0311"),
        ({"soil__cohesion": 400.0}, "c / (rho g H) 0.83"),
        ({"soil__friction_angle": 38.0}, "friction angle 38 degrees"),
        ({"soil__friction_angle": 0.0, "coupling__softening__slip_at_residual": 0.02}, "friction angle 0 degrees"),
        ({"soil__residual_cohesion": 20.0}, "residual strength is given directly"),
        ({"coupling__S_R": 0.05}, "S_R 0.05"),
        ({"coupling__S_R": 0.5, "coupling__softening__slip_at_residual": 0.02}, "S_R 0.5 is not within 0.1 to 0.4"),
        ({"coupling__S_R": 0.7, "coupling__softening__slip_at_residual": 0.02}, "S_R 0.7"),
        ({"coupling__gamma": 100.0}, "lost with time"),
        ({"coupling__softening__slip_at_residual": None, "coupling__gamma": 100.0}, "lost with time"),
        ({"coupling__softening__slip_at_residual": 0.2}, "slip zone over height 27.7"),
        ({"layers__clay": {"region": {"kind": "elevation", "bottom": 20.0}, "soil": {"cohesion": 120.0}}}, "it has layers"),
        ({"layers__rock__region__top": 6.0}, "it has layers"),
        ({"layers__rock__soil__cohesion": 400.0}, "it has layers"),
        ({"rock": None}, "soil, not rock, lies below its toe"),
        ({"water": {"level": 5.0, "pressure": "carried"}}, "it has water"),
    ],
)
def test_one_respect_in_which_it_is_not_is_named_with_the_remedy(changes: dict[str, Any], words: str) -> None:
    scene = measured(**changes)
    assert [words in each for each in unlike(scene)] == [True]
    assert expected_error(scene) is None and all(map(math.isnan, expected_metrics(scene).values()))
    said = expected_sentence(scene)
    assert said.startswith("not known for this slope") and words in said and said.endswith(REMEDY)


def test_a_bench_makes_it_unlike_and_a_plane_ground_line_does_not() -> None:
    geometry = {"shape": "ground_line", "base": 0.0}
    plane = [(0.0, 10.0), (110.0, 10.0), (124.4, 35.0), (190.0, 35.0)]
    benched = [(0.0, 10.0), (110.0, 10.0), (114.0, 21.0), (119.0, 21.5), (124.4, 35.0), (190.0, 35.0)]
    base = {name: part for name, part in read_scene(SCENES / "slope_on_rock.yaml").items() if name != "geometry"}
    scenes = [make_scene(merge(base, {"geometry": geometry | {"points": points}})) for points in (plane, benched)]
    assert [unlike(scene) for scene in scenes] == [[], ["its face is not plane"]]


def test_the_scheme_of_the_paper_was_measured_at_one_rate() -> None:
    paper = load_scene(SCENES / "paper.yaml", {"coupling": {"S_R": 0.25, "gamma": 100.0}})
    slow = load_scene(SCENES / "paper.yaml", {"coupling": {"S_R": 0.25, "gamma": 1.0}})
    assert unlike(paper) == [] and unlike(slow) == ["gamma 1 1/s is not 100 1/s"]
