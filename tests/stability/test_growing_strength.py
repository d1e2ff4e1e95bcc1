"""Slip circles through clay whose undrained strength grows with depth, against closed forms, and in proportion to the strength."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.optimize  # type: ignore[import-untyped]

from sph.scene.gravity import GRAVITY
from sph.scene.schema import Scene, make_scene
from sph.stability.limit_equilibrium import spencer
from sph.stability.slip_search import NONE, worst_circle, worst_surface
from sph.stability.slip_surface import Section

EXACT = 0.01
"""Of closed forms, in which surfaces are cut into slices and searched."""
WEIGHT = 18.0
"""kN/m3"""


def slope(angle: float, strength: dict[str, float], height: float = 10.0) -> Scene:
    run = 0.0 if angle == 90.0 else height / math.tan(math.radians(angle))
    points = [[0.0, 0.0], [3 * height, 0.0], [3 * height + run, height], [7 * height + run, height]]
    scene: dict[str, Any] = {
        "name": "clay",
        "scheme": "paper",
        "duration": 3.0,
        "geometry": {"shape": "ground_line", "points": points, "base": -0.5 * height},
        "soil": {"undrained_strength": strength, "density": 1e3 * WEIGHT / GRAVITY, "youngs_modulus": 1e5, "poisson_ratio": 0.3},
        "numerics": {"spacing": 0.05 * height, "time_step": 0.01, "adaptive_step": {}},
    }
    return make_scene(scene)


def circle(scene: Scene) -> float:
    return worst_circle(Section.of(scene))[0].value


def number_of_toe_circles(angle: float) -> float:
    """Least F gamma / k of circles through the toe of a cut in clay of the strength k z, z below the crest (Gibson and Morgenstern 1962).

    Moments about the centre: F gamma / k is the integral of z / cos(alpha) over that of d sin(alpha), d the depth below the ground.
    """
    run = 0.0 if angle == 90.0 else 1.0 / math.tan(math.radians(angle))

    def number(given: np.ndarray) -> float:
        right, half = run + abs(given[0]), min(max(abs(given[1]), 1e-3), 1.5)
        chord = math.atan2(1.0, right)
        alpha = chord + half * np.linspace(-1.0, 1.0, 4001)
        if alpha[-1] > 0.5 * math.pi:
            return math.inf
        radius = 0.5 * math.hypot(right, 1.0) / math.sin(half)
        x, y = radius * (np.sin(alpha) - np.sin(alpha[0])), radius * (np.cos(alpha[0]) - np.cos(alpha))
        ground = np.ones_like(x) if run == 0.0 else np.clip(x / run, 0.0, 1.0)
        held = np.trapezoid((1.0 - y) * radius, alpha)
        driven = np.trapezoid((np.where(x < 0.0, 0.0, ground) - y) * np.sin(alpha) * radius * np.cos(alpha), alpha)
        return float(held / driven)

    starts = [(0.2, 0.1), (0.8, 0.4), (1.5, 0.8)]
    return min(scipy.optimize.minimize(number, start, method="Nelder-Mead").fun for start in starts)


@pytest.mark.parametrize("height", [5.0, 10.0, 40.0])
def test_below_the_ground_a_plane_at_45_degrees_is_worst_whatever_the_height(height: float) -> None:
    """F = 2 k / gamma: a plane at theta through any face holds k A / cos(theta) against gamma A sin(theta), A the area above it."""
    assert circle(slope(60.0, {"at_top": 0.0, "gradient": 9.0}, height)) == pytest.approx(2.0 * 9.0 / WEIGHT, rel=EXACT)


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 90.0])
def test_a_cut_in_normally_consolidated_clay_has_the_number_of_its_angle(angle: float) -> None:
    expected = number_of_toe_circles(angle)
    for height in (6.0, 20.0):
        scene = slope(angle, {"at_top": 0.0, "gradient": 3.0, "datum": height}, height)
        assert circle(scene) * WEIGHT / 3.0 == pytest.approx(expected, rel=EXACT)


def test_spencers_factor_is_that_of_the_circles_where_friction_has_no_part() -> None:
    section = Section.of(slope(45.0, {"at_top": 10.0, "gradient": 3.0}))
    worst, near = worst_circle(section)
    surface = worst_surface(section, spencer, near, NONE, 1.06 * worst.value, worst.value)
    assert 0.9 * worst.value < surface.value < (1 + EXACT) * worst.value


def test_without_growth_the_factor_has_the_bits_of_the_constant() -> None:
    level, constant = slope(45.0, {"at_top": 30.0, "gradient": 0.0}), slope(45.0, {"at_top": 30.0, "gradient": 0.0, "datum": 10.0})
    plain = make_scene({**constant.model_dump(), "soil": {**constant.model_dump()["soil"], "cohesion": 30.0}})
    assert circle(level) == circle(constant) == circle(plain)


def test_the_factor_is_proportional_to_the_strength() -> None:
    once, twice = (slope(45.0, {"at_top": 10.0 * by, "gradient": 2.0 * by}) for by in (1.0, 2.0))
    assert circle(twice) == pytest.approx(2.0 * circle(once), rel=1e-9)


def test_growth_lies_between_the_constants_that_bound_it() -> None:
    grown = circle(slope(45.0, {"at_top": 20.0, "gradient": 2.0}))
    least, most = (circle(slope(45.0, {"at_top": strength, "gradient": 0.0})) for strength in (20.0, 50.0))
    assert least < grown < most


def test_an_acceleration_lowers_it() -> None:
    section = Section.of(slope(45.0, {"at_top": 20.0, "gradient": 2.0}))
    assert worst_circle(section, 0.2)[0].value < worst_circle(section)[0].value
