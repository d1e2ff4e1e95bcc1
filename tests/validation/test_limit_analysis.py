"""Log-spiral limit analysis against published stability numbers and Taylor's circles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from cases.limit_analysis import (
    POINTS,
    Wet,
    _moment_below,
    _work_of_water,
    infinite_slope_factor,
    limit_factor,
    limit_strength_ratio,
    stability_number,
)

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


@pytest.mark.crosscheck
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


@pytest.mark.long
def test_factor_and_ratio_are_where_the_weakened_slope_is_at_its_stability_number() -> None:
    weight, height, cohesion, friction = 2e4, 10.0, 25e3, 20.0
    factor = limit_factor(60.0, height, weight, cohesion, friction)
    divided = math.degrees(math.atan(math.tan(math.radians(friction)) / factor))
    assert stability_number(60.0, divided) * cohesion / factor == pytest.approx(weight * height, rel=1e-5)
    ratio = limit_strength_ratio(60.0, height, weight, cohesion, friction)
    assert stability_number(60.0, ratio * friction) * ratio * cohesion == pytest.approx(weight * height, rel=1e-5)
    assert limit_strength_ratio(60.0, 25.0, 1964.0 * 9.81, 150e3, 20.0) == pytest.approx(0.46, abs=0.005)


def test_infinite_slopes_in_closed_form() -> None:
    """Without friction c / (gamma H sin(i)), without cohesion tan(phi) / tan(i) with associated flow, and sin(phi_s) for it without."""
    assert infinite_slope_factor(20.0, 10.0, 2e4, 1e5, 0.0, 0.0) == pytest.approx(0.5 / math.sin(math.radians(20.0)), rel=1e-5)
    assert infinite_slope_factor(20.0, 10.0, 2e4, 0.0, 30.0, 30.0) == pytest.approx(
        math.tan(math.radians(30.0)) / math.tan(math.radians(20.0)), rel=1e-5
    )
    sine = math.tan(math.radians(20.0))  # phi is where sin(phi) carries tan(i) without dilation
    expected = math.tan(math.radians(30.0)) / math.tan(math.asin(sine))
    assert infinite_slope_factor(20.0, 10.0, 2e4, 0.0, 30.0, 0.0) == pytest.approx(expected, rel=1e-5)


def test_refusals() -> None:
    for slope, friction in ((20.0, 20.0), (91.0, 0.0), (45.0, -1.0), (math.nan, 0.0)):
        with pytest.raises(ValueError, match="slope_angle"):
            stability_number(slope, friction)
    with pytest.raises(ValueError, match="base_depth"):
        stability_number(45.0, 0.0, -1.0)


@pytest.mark.parametrize("friction_angle", [0.0, 20.0])
def test_a_slope_under_water_has_its_buoyant_weight(friction_angle: float) -> None:
    buoyant = stability_number(60.0, friction_angle, 0.5) / (1.0 - 0.45)
    for level in (1.0, 1.7):
        assert stability_number(60.0, friction_angle, 0.5, Wet(weight=0.45, level=level)) == pytest.approx(buoyant, rel=1e-3)


def test_water_below_the_spirals_does_not_matter() -> None:
    assert stability_number(60.0, 20.0, 0.0, Wet(weight=0.5, level=0.0)) == pytest.approx(stability_number(60.0, 20.0, 0.0), rel=1e-3)


@pytest.mark.parametrize("turned", [False, True])
def test_soil_towards_the_toe_from_the_pole_holds_the_body(turned: bool) -> None:
    """A rectangle from x = -3 to 1, 2 high, of which the lower half lies below the level: 4 m2 at x = -1."""
    x, y = np.array([-3.0, 1.0, 1.0, -3.0]), np.array([-2.0, -2.0, 0.0, 0.0])
    order = slice(None, None, -1) if turned else slice(None)
    assert _moment_below(x[order], y[order], -1.0) == pytest.approx(-4.0, rel=1e-12)


@pytest.mark.long
def test_a_gentle_slope_is_least_safe_at_partial_drawdown() -> None:
    """Griffiths and Lane (1999): a 2:1 slope stands less well than the dry one while the water is low."""
    lowered = (0.0, 0.25, 0.5, 0.75)
    numbers = [stability_number(26.565, 15.0, 0.0, Wet(weight=0.49, level=1.0 - below)) for below in lowered]
    assert numbers == sorted(numbers, reverse=True)
    assert numbers[-1] < 0.99 * stability_number(26.565, 15.0, 0.0)


def test_pore_pressure_fells_a_slope_flatter_than_its_friction() -> None:
    """Charts of Bishop and Morgenstern (1960) for 4:1, c/(gamma H) = 0.025 and D = 1.25: 1.97 - 1.78 r_u."""
    slope, chart = math.degrees(math.atan(0.25)), 1.97 - 1.78 * 0.35

    def stands(factor: float) -> bool:
        friction = math.degrees(math.atan(math.tan(math.radians(20.0)) / factor))
        return stability_number(slope, friction, 0.25, Wet(r_u=0.35)) > 16e3 * 31.0 * factor / 12.5e3

    assert stands(0.975 * chart) and not stands(1.025 * chart)


def test_pore_pressure_without_friction_does_no_work() -> None:
    assert stability_number(60.0, 0.0, 0.5, Wet(r_u=0.4)) == pytest.approx(stability_number(60.0, 0.0, 0.5), rel=1e-9)


def test_work_of_a_ratio_is_that_of_the_force_of_the_water() -> None:
    """The pressure's work on the opening spiral is that of -grad u = r_u gamma (-slope of the ground, 1) on the body (Gauss)."""
    tangent, r_u = math.tan(math.radians(25.0)), 0.3
    angle = np.linspace(0.6, 1.9, 4001)
    r = np.exp((angle - angle[0]) * tangent)
    x, y = r * np.cos(angle), -r * np.sin(angle)
    toe, height = (x[-1], y[-1]), y[0] - y[-1]
    crest = (toe[0] + height / math.tan(math.radians(60.0)), y[0])
    ground = ((x[0], y[0]), crest, toe, (x[-1], y[-1]))
    middle_x = np.linspace(toe[0], x[0], 4001)[:-1] + 0.5 * (x[0] - toe[0]) / 4000
    top, bottom = np.interp(middle_x, (toe[0], crest[0], x[0]), (toe[1], crest[1], y[0])), np.interp(-middle_x, -x, y)
    gradient = np.where(middle_x < crest[0], math.tan(math.radians(60.0)), 0.0)
    # A body that turns clockwise has the velocity (y, -x).
    work = r_u * np.sum(-gradient * 0.5 * (top**2 - bottom**2) - middle_x * (top - bottom)) * (x[0] - toe[0]) / 4000
    found = _work_of_water(np.linspace(0.6, 1.9, POINTS), tangent, ground, height, Wet(r_u=r_u))
    assert found == pytest.approx(work, rel=1e-3)
