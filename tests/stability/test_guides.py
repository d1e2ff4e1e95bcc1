"""Slip surfaces along seams and thin layers, however thin, long or deep they are, against closed forms of a plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene, make_scene
from sph.stability.slip_search import limit_equilibrium
from sph.stability.slip_surface import Edges, Section

EXACT = 0.01
"""Of closed forms, in which surfaces are cut into slices and searched."""
WEIGHT, HEIGHT = 25.0, 10.0
"""Of a slope of rock, kN/m3 and m; its toe is at (30, 0)."""


def soil(cohesion: float, angle: float) -> dict[str, float]:
    return {"cohesion": cohesion, "friction_angle": angle, "density": 1e3 * WEIGHT / GRAVITY}


def rock(face: float, end: float, base: float = -5.0, own: dict[str, float] | None = None, **settings: Any) -> Scene:
    crest = 30.0 + HEIGHT / math.tan(math.radians(face))
    scene = {
        "name": "rock",
        "scheme": "paper",
        "duration": 3.0,
        "geometry": {"shape": "ground_line", "points": [[0, 0], [30, 0], [crest, HEIGHT], [end, HEIGHT]], "base": base},
        "soil": {"youngs_modulus": 1e5, "poisson_ratio": 0.3, **(own or soil(5e3, 45.0))},
        "numerics": {"spacing": 0.5, "time_step": 0.01, "adaptive_step": {}},
    }
    return make_scene(merge(scene, dotted(settings)))


def seam(points: Sequence[Sequence[float]], cohesion: float, angle: float) -> dict[str, Any]:
    return {"joint": {"points": points, "cohesion": cohesion, "friction_angle": angle}}


def plane(face: float, dip: float, cohesion: float, angle: float, r_u: float = 0.0) -> float:
    """F = (c A + (W cos(p) - U) tan(phi)) / (W sin(p)) (Hoek and Bray 1981), here with the water's force U = r_u W / cos(p)."""
    p, friction = math.radians(dip), math.tan(math.radians(angle))
    weight = WEIGHT * 0.5 * HEIGHT * (HEIGHT / math.tan(p) - HEIGHT / math.tan(math.radians(face)))
    held = cohesion * HEIGHT / math.sin(p) + (weight * math.cos(p) - r_u * weight / math.cos(p)) * friction
    return held / (weight * math.sin(p))


def up(dip: float, length: float) -> list[float]:
    """A place on a plane through the toe, so far to the right of it, m."""
    return [30.0 + length, length * math.tan(math.radians(dip))]


def test_a_seam_that_comes_out_far_behind_the_crest_is_slid_on_as_a_whole() -> None:
    """At 10 degrees 3.9 heights behind the crest of a face of 30 degrees."""
    found = limit_equilibrium(rock(30.0, 130.0, seams=seam([up(10.0, 0.0), up(10.0, 62.0)], 2.0, 12.0)))
    assert plane(30.0, 10.0, 2.0, 12.0) == pytest.approx(1.340, abs=5e-4)
    assert found.spencer.where == "along the seam joint"
    assert found.spencer.value == pytest.approx(plane(30.0, 10.0, 2.0, 12.0), rel=EXACT)


def test_a_crack_in_the_rock_does_not_hide_the_whole_plane() -> None:
    water = {"pressure": "by_place", "r_u": 0.2}
    found = limit_equilibrium(rock(60.0, 70.0, seams=seam([up(30.0, 0.0), up(30.0, 30.0)], 20.0, 25.0), water=water))
    assert plane(60.0, 30.0, 20.0, 25.0, 0.2) == pytest.approx(1.147, abs=5e-4)
    assert found.spencer.value == pytest.approx(plane(60.0, 30.0, 20.0, 25.0, 0.2), rel=EXACT)


@pytest.mark.parametrize(
    ("lower", "upper"),
    [([], []), ([[55.0, 4.0 * 25.0 / 15.0]], []), ([], [[42.0, 4.0 - 3.0 * 8.0 / 7.0]])],
    ids=["at their ends", "on the lower one", "on the upper one"],
)
def test_two_seams_that_meet_are_slid_on_like_one(lower: list[list[float]], upper: list[list[float]]) -> None:
    """A step in the rock: drawn as one line, as two, of which either may go on beyond the other, and as two of other strength."""
    low, bend, high = [30.0, 0.0], [45.0, 4.0], [52.0, 12.0]
    (whole,) = seam([low, bend, high], 0.0, 20.0).values()
    parts = {"lower": whole | {"points": [low, bend, *lower]}, "upper": whole | {"points": [high, bend, *upper]}}
    one, two = (limit_equilibrium(rock(60.0, 70.0, seams=seams)).spencer for seams in ({"joint": whole}, parts))
    assert one.where == "along the seam joint" and two.where == "along the seams lower and upper"
    assert two.value == pytest.approx(one.value, rel=1e-6) and two.value < 1.5
    stronger = limit_equilibrium(rock(60.0, 70.0, seams=parts | {"upper": parts["upper"] | {"friction_angle": 35.0}})).spencer
    assert one.value < stronger.value < limit_equilibrium(rock(60.0, 70.0, seams={"joint": whole | {"friction_angle": 35.0}})).spencer.value


@pytest.mark.parametrize("tail", [[up(30.0, 30.0), [60.0, 30.0]], [up(30.0, 30.0), [58.0, 30.0]]], ids=["vertical", "turning back"])
def test_a_seam_with_a_part_that_no_surface_follows_is_slid_on_beside_it(tail: list[list[float]]) -> None:
    found = limit_equilibrium(rock(60.0, 70.0, seams=seam([up(30.0, 0.0), *tail], 20.0, 25.0)))
    assert found.spencer.where == "along the seam joint"
    assert found.spencer.value == pytest.approx(plane(60.0, 30.0, 20.0, 25.0), rel=EXACT)


@pytest.mark.parametrize("base", [-5.0, -90.0])
@pytest.mark.parametrize("thickness", [0.1, 0.05, 0.02])
def test_a_thin_layer_is_a_plane_however_thin_it_is(thickness: float, base: float) -> None:
    (x1, y1), (x2, y2) = up(30.0, -1.0), up(30.0, 30.0)
    corners = [[x1, y1], [x2, y2], [x2, y2 + thickness], [x1, y1 + thickness]]
    layer = {"band": {"region": {"kind": "polygon", "points": corners}, "soil": soil(20.0, 25.0)}}
    found = limit_equilibrium(rock(60.0, 70.0, base, layers=layer))
    assert found.spencer.where == "along the layer band"
    assert found.spencer.value == pytest.approx(plane(60.0, 30.0, 20.0, 25.0), rel=EXACT)


def test_a_band_is_the_same_whichever_soil_of_the_scene_it_is() -> None:
    band, weaker, strong = soil(2.0, 10.0), soil(1.0, 8.0), soil(20.0, 25.0)

    def level(bottom: float | None, top: float | None, own: dict[str, float]) -> dict[str, Any]:
        return {"region": {"kind": "elevation", "bottom": bottom, "top": top}, "soil": own}

    as_layer = rock(26.565, 90.0, -8.0, strong, layers={"band": level(-1.5, -1.0, band)})
    own = rock(26.565, 90.0, -8.0, band, layers={"upper": level(-1.0, None, strong), "lower": level(None, -1.5, strong)})
    deep = rock(26.565, 90.0, -8.0, weaker, layers={"upper": level(-7.8, None, strong), "band": level(-1.5, -1.0, band)})
    values = [limit_equilibrium(scene).spencer.value for scene in (as_layer, own, deep)]
    assert values == pytest.approx([values[0]] * 3, rel=1e-6) and values[0] < 0.95 * limit_equilibrium(as_layer).bishop.value
    assert limit_equilibrium(own).spencer.where == "along the scene's own soil"


def test_a_thin_layer_that_only_its_water_weakens_is_a_plane_too() -> None:
    """r_u = 0.6 in a seam-like band; in the soil above, of the same strength, none."""
    (x1, y1), (x2, y2) = up(30.0, -1.0), up(30.0, 30.0)
    corners = [[x1, y1], [x2, y2], [x2, y2 + 0.1], [x1, y1 + 0.1]]
    layer = {"band": {"region": {"kind": "polygon", "points": corners}, "soil": soil(20.0, 25.0), "r_u": 0.6}}
    scene = rock(60.0, 70.0, own=soil(20.0, 25.0), layers=layer, water={"pressure": "by_place", "r_u": 0.0})
    found = limit_equilibrium(scene)
    assert found.spencer.value < (1.0 + EXACT) * plane(60.0, 30.0, 20.0, 25.0, 0.6) < 0.9 * found.bishop.value


@pytest.mark.parametrize("spacing", [0.25, 2.0])
def test_the_strength_at_the_base_is_that_of_the_layer_there_without_a_particle_in_it(spacing: float) -> None:
    layer = {"band": {"region": {"kind": "elevation", "top": -4.7}, "soil": soil(3.0, 10.0)}}
    settings: dict[str, Any] = {"layers": layer, "numerics.spacing": spacing}
    section = Section.of(rock(60.0, 70.0, **settings))
    slices = section.slices(Edges(np.array([[20.0, 30.0, 40.0]]), np.array([[0.1, 0.1, 0.1]]), np.zeros((1, 2), int)))
    assert slices.cohesion == pytest.approx(3e3) and slices.friction == pytest.approx(math.tan(math.radians(10.0)))
