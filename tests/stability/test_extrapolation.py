"""Extrapolation of a limit over two spacings, with slopes that need no simulation."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.stability.extrapolation import deviations, extrapolate, extrapolated, slips_along_a_plane, spread, two_spacings
from sph.stability.safety import ACCELERATIONS, FACTORS, STRENGTH_RATIOS, factor_of_safety, yield_acceleration
from sph.stability.search import Trial, around
from sph.stability.standing import FailureRule, static_scene

EXACT = 1.234
SLOPE = 0.1
"""Error of the limit over the spacing, 1/m."""


def scene(spacing: float = 0.5, **numerics: Any) -> Scene:
    shape = {"shape": "slope", "slope_angle": 60.0, "slope_height": 20.0}
    numerics = {"spacing": spacing, "time_step": 1e-4, "smoothing_ratio": 1.6, **numerics}
    return make_scene({"name": "slope", "scheme": "paper", "duration": 4.0, "geometry": shape, "numerics": numerics})


@given(st.floats(0.1, 10.0), st.floats(-0.5, 0.5), st.floats(0.1, 2.0), st.floats(1.3, 4.0))
def test_an_error_of_first_order_vanishes(exact: float, slope: float, spacing: float, ratio: float) -> None:
    coarse, fine = (exact + slope * dx for dx in (ratio * spacing, spacing))
    assert extrapolate(coarse, fine, ratio) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("rule", [FailureRule(), FailureRule(displacement=0.1)])
def test_the_search_at_two_spacings_finds_the_limit_at_none(rule: FailureRule, monkeypatch: pytest.MonkeyPatch) -> None:
    def stand(scene: Scene, rule: FailureRule, value: float) -> Trial:
        stands = value < EXACT + SLOPE * scene.numerics.spacing
        return Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.stability.safety.stand", stand)
    told: list[float] = []
    found = extrapolated(factor_of_safety, scene(), 0.001, rule, lambda spacing, *_: told.append(spacing))
    assert found.spacings == (1.0, 0.5)
    assert abs(found.value - EXACT) < 0.003 and abs(found.value - EXACT) < found.error
    assert found.error > rule.displacement * EXACT
    coarse, fine = (len(search.trials) for search in found.searches)
    assert fine < coarse and told == [1.0] * coarse + [0.5] * fine, "the fine search begins around what the coarse one found"


def test_no_step_is_taken_to_the_unsafe_side(monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit that the finer particles raise, as in a layer of two rows: the value is theirs, the whole step is error."""

    def stand(scene: Scene, rule: FailureRule, value: float) -> Trial:
        stands = value < EXACT - SLOPE * scene.numerics.spacing
        return Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.stability.safety.stand", stand)
    rule = FailureRule()
    found = extrapolated(factor_of_safety, scene(), 0.001, rule)
    assert found.value == found.searches[1].value == pytest.approx(EXACT - 0.5 * SLOPE, abs=1e-3)
    brackets = 0.5 * (2.0 * (found.searches[1].upper - found.searches[1].lower) + found.searches[0].upper - found.searches[0].lower)
    step = found.searches[1].value - found.searches[0].value
    assert found.error == pytest.approx(step + brackets + rule.displacement * found.value)
    assert found.how == "the value at a spacing of 0.5 m, since the extrapolation from 1 m would be on the unsafe side"


def test_a_factor_with_an_error_as_large_as_itself_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A weak layer that slips only with the finer particles: 2.2 times as strong at the coarse spacing."""

    def stand(scene: Scene, rule: FailureRule, value: float) -> Trial:
        stands = value < (2.2 if scene.numerics.spacing > 0.75 else 1.0)
        return Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.stability.safety.stand", stand)
    with pytest.raises(ValueError, match=r"numerics.spacing: 2.2 at 1 m and 1 at 0.5 m are too far apart .* three rows"):
        extrapolated(factor_of_safety, scene(), 0.001)


@pytest.mark.parametrize("sensitive", [0.5, 4.0])
def test_an_error_of_the_strength_is_one_of_the_load_by_its_sensitivity(sensitive: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A slope whose yield acceleration rises by ``sensitive`` times what its strength rises; the rule's 1 % is one of the strength."""
    soil, limit, tolerance = scene().soil, 2.0, 0.001

    def stand(scene: Scene, rule: FailureRule, value: float) -> Trial:
        stands = value < limit * (1.0 + sensitive * math.log(scene.soil.cohesion / soil.cohesion))
        return Trial(value, stands, 0.0 if stands else 1e3, 0.0, "complete", 0.0)

    monkeypatch.setattr("sph.stability.safety.stand", stand)
    rule = FailureRule()
    found = extrapolated(yield_acceleration, scene(), tolerance, rule)
    assert found.sensitivity == pytest.approx(sensitive * limit, rel=0.05)
    assert found.error == pytest.approx(spread(True) * found.sensitivity), "more than the brackets and the rule's displacement"
    assert found.runs > sum(len(each.trials) for each in found.searches)


def test_the_sensitivity_of_a_factor_is_the_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sph.stability.safety.stand", lambda scene, rule, value: Trial(value, value < EXACT, 1e3, 0.0, "complete", 0.0))
    found = extrapolated(factor_of_safety, scene())
    assert found.sensitivity == found.value and found.runs == sum(len(each.trials) for each in found.searches)


def test_the_spacings() -> None:
    rule = FailureRule()
    assert two_spacings(scene(0.5), rule) == (1.0, 0.5)
    assert two_spacings(scene(1.5), rule) == pytest.approx((2.0, 20.0 / 14)), "no coarser than the rule allows; whole rows over 20 m"
    assert two_spacings(scene(0.8), rule) == pytest.approx((20.0 / 13, 0.8)), "twice 0.8 m would be 12.5 rows"
    assert two_spacings(scene(0.8), rule, (1.6, 0.8)) == (1.6, 0.8), "what is asked for"
    assert two_spacings(scene(0.5), rule, (0.5, 2.0)) == (2.0, 0.5)
    for spacing, asked in ((2.0, None), (0.5, (0.5, 0.6)), (0.5, (1.0, -1.0)), (0.5, (1.0, float("nan")))):
        with pytest.raises(ValueError, match="numerics.spacing: .* --single"):
            two_spacings(scene(spacing), rule, asked)
    with pytest.raises(ValueError, match="--spacings: 3"):
        two_spacings(scene(), rule, (1.0, 0.5, 0.25))


def test_a_smaller_displacement_needs_a_finer_spacing_and_a_larger_one_still_ten_rows() -> None:
    assert two_spacings(scene(0.5), FailureRule(displacement=0.005)) == pytest.approx((1.0, 0.5))
    assert two_spacings(scene(1.5), FailureRule(displacement=0.05)) == pytest.approx((2.0, 20.0 / 14))
    with pytest.raises(ValueError, match="numerics.spacing"):
        two_spacings(scene(1.0), FailureRule(displacement=0.005))


@pytest.mark.parametrize("values", [FACTORS, STRENGTH_RATIOS, ACCELERATIONS])
@given(near=st.floats(0.07, 0.99))
def test_values_around_one(values: tuple[float, ...], near: float) -> None:
    closer, start = around(values, near, 0)
    assert closer[start] == near
    assert list(closer) == sorted(set(closer), reverse=values[0] > values[-1])
    assert {closer[0], closer[-1]} == {values[0], values[-1]}


def test_values_beyond_the_ends_and_none() -> None:
    assert around(FACTORS, None, 7) == (FACTORS, 7)
    assert around(ACCELERATIONS, 0.0, 0) == (ACCELERATIONS, 0)


def test_absorbing_walls_are_tested_as_walls_that_stand() -> None:
    """They hold no load that stays, and a constant acceleration is one."""
    bedrock = {"density": 2400.0, "s_wave_speed": 900.0, "p_wave_speed": 1600.0}
    free = make_scene(
        merge(scene(2.0).model_dump(), {"walls": {"base": "absorbing", "sides": "absorbing", "bedrock": bedrock, "layers": 3}})
    )
    held = static_scene(free, FailureRule(), acceleration=1.0)
    assert (held.walls.base, held.walls.sides, held.walls.bedrock) == ("no_slip", "free_slip", None)
    half = make_scene(merge(scene(2.0).model_dump(), {"walls": {"base": "absorbing", "sides": "free_slip", "layers": 3}}))
    assert static_scene(half, FailureRule()).walls == held.walls


def test_the_stated_error_covers_the_references_of_validated_slopes() -> None:
    """All 40; 39 where the spread is that of the others of its kind.  By the step and the rule alone, as two spacings give them, 34."""
    found = deviations()
    step = (found["fine"] - found["coarse"]).abs()  # to spacing 0 as well, at a ratio of two
    alone = step.where(~found["step_taken"], 0.5 * step) + FailureRule().displacement
    kinds = found["plane"].map(spread)
    squares = found["value"] ** 2
    rest = found.groupby("plane")["value"].transform("size") - 1
    others = 2.0 * ((squares.groupby(found["plane"]).transform("sum") - squares) / rest) ** 0.5
    covered = [(found["value"].abs() <= error).sum() for error in (alone, alone.clip(lower=kinds), alone.clip(lower=others))]
    assert (len(found), int(found["plane"].sum()), covered) == (40, 7, [34, 40, 39])
    assert 0.02 < spread(False) < 0.03 < spread(True) < 0.06


def test_soil_in_layers_beside_seams_and_without_dilation_has_the_wider_spread() -> None:
    own = merge(scene().model_dump(), {"soil": {"friction_angle": 20.0, "dilation_angle": 20.0}})
    layer = {"layers": {"upper": {"region": {"kind": "depth", "bottom": 3.0}, "soil": {"cohesion": 20.0}}}}
    seam = {"seams": {"joint": {"points": [[30.0, 0.0], [60.0, 15.0]], "cohesion": 5.0, "friction_angle": 20.0}}}
    assert not slips_along_a_plane(make_scene(own))
    for change in (layer, seam, {"soil": {"dilation_angle": 0.0}}):
        assert slips_along_a_plane(make_scene(merge(own, change)))
