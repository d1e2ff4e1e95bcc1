"""Log-spiral limit analysis against published stability numbers and Taylor's circles."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import minimize_scalar

from sph.stability.limit_analysis import limit_factor, limit_strength_ratio, stability_number

CHEN = {
    (90.0, 0.0): 3.83,
    (90.0, 20.0): 5.50,
    (75.0, 0.0): 4.56,
    (75.0, 20.0): 7.48,
    (60.0, 0.0): 5.25,
    (60.0, 20.0): 10.39,
    (60.0, 30.0): 16.04,
    (45.0, 20.0): 16.16,
    (30.0, 20.0): 41.22,
}
"""gamma H / c by slope angle and friction angle (degrees), Chen (1975), chapter 9."""


@pytest.mark.parametrize("angles", CHEN, ids=str)
def test_stability_numbers_of_chen(angles: tuple[float, float]) -> None:
    assert stability_number(*angles) == pytest.approx(CHEN[angles], abs=0.01)


def test_without_friction_flat_slopes_fail_through_the_ground_below() -> None:
    """A deep circle whose centre lies above the middle of the slope turns by 2 a: gamma H / c = 4 a / sin(a)^2, least at 66.8 degrees."""
    deep = minimize_scalar(lambda a: 4.0 * a / math.sin(a) ** 2, bounds=(0.5, 1.5), method="bounded").fun
    assert deep == pytest.approx(5.52, abs=0.01)
    for angle in (30.0, 45.0):
        assert stability_number(angle, 0.0) == pytest.approx(deep, rel=1e-3)
        assert stability_number(angle, 0.0, base_depth=0.0) > stability_number(angle, 0.0, base_depth=0.5) > deep


def test_a_spiral_is_better_than_a_plane() -> None:
    """Culmann's wedge: gamma H / c = 4 sin(beta) cos(phi) / (1 - cos(beta - phi)); spirals include all but planes."""
    for slope, friction in ((90.0, 0.0), (90.0, 30.0), (60.0, 20.0), (45.0, 30.0)):
        beta, phi = math.radians(slope), math.radians(friction)
        plane = 4.0 * math.sin(beta) * math.cos(phi) / (1.0 - math.cos(beta - phi))
        assert stability_number(slope, friction) < plane


def test_factor_and_ratio_are_where_the_weakened_slope_is_at_its_stability_number() -> None:
    weight, height, cohesion, friction = 2e4, 10.0, 25e3, 20.0
    factor = limit_factor(60.0, height, weight, cohesion, friction)
    divided = math.degrees(math.atan(math.tan(math.radians(friction)) / factor))
    assert stability_number(60.0, divided) * cohesion / factor == pytest.approx(weight * height, rel=1e-5)
    ratio = limit_strength_ratio(60.0, height, weight, cohesion, friction)
    assert stability_number(60.0, ratio * friction) * ratio * cohesion == pytest.approx(weight * height, rel=1e-5)
    assert limit_strength_ratio(60.0, 25.0, 1964.0 * 9.81, 150e3, 20.0) == pytest.approx(0.46, abs=0.005)


def test_refusals() -> None:
    for slope, friction in ((20.0, 20.0), (91.0, 0.0), (45.0, -1.0), (math.nan, 0.0)):
        with pytest.raises(ValueError, match="slope_angle"):
            stability_number(slope, friction)
    with pytest.raises(ValueError, match="base_depth"):
        stability_number(45.0, 0.0, -1.0)
