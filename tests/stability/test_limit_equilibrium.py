"""Bishop's and Spencer's methods against published slopes, closed forms, and what must not change an answer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brute

from sph.checks.equilibrium import (
    equilibrium_numbers,
    factor_below_1,
    found_equilibrium,
    of_equilibrium,
    of_residual,
    probes_off_slide,
    runs_away,
    slip_at_base,
    that_differ,
    within_cover,
)
from sph.checks.finding import Finding, finding
from sph.checks.messages import line, sentence, words
from sph.command.check import check, equilibrium_rows
from sph.scene.configuration import dotted, merge
from sph.scene.gravity import GRAVITY
from sph.scene.loading import motion_of
from sph.scene.schema import Scene, load_scene, make_scene
from sph.stability.limit_equilibrium import Slices, bishop, spencer, spencer_coefficient
from sph.stability.newmark import sliding_block
from sph.stability.slip_search import MAX_FACTOR, LimitEquilibrium, Surface, applies, limit_equilibrium, worst_circle
from sph.stability.slip_surface import Section, along, circles, guides

PUBLISHED = 0.02
"""Of the answers that the study of programs for ACADS recommends (Giam and Donald 1989)."""
EXACT = 0.01
"""Of stability numbers and closed forms, in which surfaces are cut into slices and searched."""


def soil(cohesion: float, angle: float, weight: float) -> dict[str, float]:
    """Strength (kPa, degrees) and unit weight (kN/m3) as keys of a scene."""
    return {"cohesion": cohesion, "friction_angle": angle, "density": 1e3 * weight / GRAVITY}


def ground(points: Sequence[Sequence[float]], base: float, own: dict[str, float], **settings: Any) -> Scene:
    scene = {
        "name": "ground",
        "scheme": "paper",
        "duration": 3.0,
        "geometry": {"shape": "ground_line", "points": points, "base": base},
        "soil": {"youngs_modulus": 1e5, "poisson_ratio": 0.3, **own},
        "numerics": {"spacing": 0.5, "time_step": 0.01, "adaptive_step": {}},
    }
    return make_scene(merge(scene, dotted(settings)))


def slope(angle: float, number: float, friction: float, depth: float = 5.0, **settings: Any) -> Scene:
    """10 m high, with gamma H / c of a number."""
    run = 0.0 if angle == 90.0 else 10.0 / math.tan(math.radians(angle))
    points = [[0.0, 0.0], [30.0, 0.0], [30.0 + run, 10.0], [70.0 + run, 10.0]]
    return ground(points, -depth, soil(200.0 / number, friction, 20.0), **settings)


STEEP = slope(60.0, 3.21, 20.0)
"""The soil and the slope of the paper's scene, 10 m high: a tension zone as deep as a third of the slope."""
ACADS_1 = [[20, 25], [30, 25], [50, 35], [70, 35]]
ACADS_1A = ground(ACADS_1, 20, soil(3.0, 19.6, 20.0))
ACADS_1C = ground(
    ACADS_1,
    20,
    soil(7.2, 20.0, 19.5),
    layers={
        "upper": {
            "region": {"kind": "polygon", "points": [[30, 25], [50, 35], [70, 35], [70, 31], [54, 31], [50, 29], [40, 27]]},
            "soil": soil(0.0, 38.0, 19.5),
        },
        "middle": {
            "region": {"kind": "polygon", "points": [[40, 27], [50, 29], [54, 31], [70, 31], [70, 24], [52, 24]]},
            "soil": soil(5.3, 23.0, 19.5),
        },
    },
)
ACADS_3A = ground(
    [[20, 27.75], [43, 27.75], [67.5, 40], [84, 40]],
    20,
    soil(28.5, 20.0, 18.84),
    layers={"weak": {"region": {"kind": "elevation", "bottom": 26.5, "top": 27.0}, "soil": soil(0.0, 10.0, 18.84)}},
)


@pytest.mark.crosscheck
@pytest.mark.parametrize(
    ("scene", "coefficient", "published"), [(ACADS_1A, 0.0, 1.00), (ACADS_1C, 0.0, 1.39), (ACADS_1C, 0.15, 1.00)], ids=["1a", "1c", "1d"]
)
def test_acads_slopes(scene: Scene, coefficient: float, published: float) -> None:
    found = limit_equilibrium(scene, coefficient)
    assert found.bishop.value == pytest.approx(published, rel=PUBLISHED)
    assert found.spencer.value == pytest.approx(published, rel=PUBLISHED)
    assert found.spencer.crack == 0.0


@pytest.mark.crosscheck
def test_acads_slope_with_a_weak_layer() -> None:
    """3(a): 1.24 to 1.27 along the layer, of which circles know nothing."""
    found = limit_equilibrium(ACADS_3A)
    assert found.spencer.value == pytest.approx(1.255, rel=PUBLISHED)
    assert found.spencer.where == "along the layer weak" and found.bishop.value > 1.4


@pytest.mark.parametrize(
    ("angle", "friction", "number"),
    [(90.0, 0.0, 3.83), (75.0, 0.0, 4.56), (60.0, 0.0, 5.25), (45.0, 20.0, 16.16), (30.0, 20.0, 41.22)],
)
def test_stability_numbers_of_taylor_and_chen(angle: float, friction: float, number: float) -> None:
    """Taylor's (1937) circles without friction, Chen's (1975) spirals with it: F = 1; a vertical cut among them."""
    assert worst_circle(Section.of(slope(angle, number, friction)))[0].value == pytest.approx(1.0, rel=EXACT)


@pytest.mark.parametrize(("angle", "depth"), [(20.0, 0.5), (20.0, 2.0), (30.0, 0.5), (30.0, 1.0), (30.0, 5.0)])
def test_a_deep_circle_without_friction_touches_the_base(angle: float, depth: float) -> None:
    """The least c R^2 theta / M of all circles that touch the base, M the moment of the weight about their centre."""
    scene = slope(angle, 5.0, 0.0, depth)
    section = Section.of(scene)

    def factor(circle: np.ndarray) -> float:
        across, radius = circle
        x = np.linspace(max(across - radius, 0.0), across + radius, 4001)
        above = section.ground(x) - (radius - np.sqrt(np.maximum(radius**2 - (x - across) ** 2, 0.0)))
        inside = x[above > 0.0]
        theta = np.ptp(np.arcsin(np.clip((inside[[0, -1]] - across) / radius, -1.0, 1.0)))
        moment = np.trapezoid(np.where(above > 0.0, above, 0.0) * (x - across), x) * scene.soil.density * GRAVITY
        return float(1e3 * scene.soil.cohesion * radius**2 * theta / moment) if moment > 0.0 else 1e6

    least = brute(factor, (slice(30.0, 50.0, 1.0), slice(11.0, 60.0, 2.0)))
    assert worst_circle(section)[0].value == pytest.approx(factor(least), rel=2e-3)


def test_an_infinite_slope_in_closed_form() -> None:
    """F = c / (gamma z sin b cos b) + (1 - r_u / cos2 b) tan(phi) / tan(b), at 20 degrees."""
    slope_angle, depth, weight, cohesion, friction, ratio = math.radians(20.0), 3.0, 2e4, 5e3, math.tan(math.radians(30.0)), 0.2
    x = np.arange(50.0)[None]
    ones, pull = np.ones_like(x), weight * depth * np.ones_like(x)
    endless = Slices(
        x=x,
        y=x * math.tan(slope_angle),
        width=ones,
        inclination=slope_angle * ones,
        weight=pull,
        full_weight=pull,
        centroid=0.5 * depth * ones,
        cohesion=cohesion * ones,
        friction=friction * ones,
        pressure=ratio * pull,
        load=np.zeros((*x.shape, 2)),
        height=depth * ones,
    )
    expected = cohesion / (weight * depth * math.sin(slope_angle) * math.cos(slope_angle))
    expected += (1.0 - ratio / math.cos(slope_angle) ** 2) * friction / math.tan(slope_angle)
    assert spencer(endless).value[0] == pytest.approx(expected, rel=1e-6)


def wedge(cohesion: float, angle: float, **settings: Any) -> Scene:
    """Rock with a face of 60 degrees, 10 m high, over a seam that rises from the toe by 30 degrees."""
    crest = 30.0 + 10.0 / math.tan(math.radians(60.0))
    rise = math.tan(math.radians(30.0))
    seam = {"points": [[30.0, 0.0], [60.0, 30.0 * rise]], "cohesion": cohesion, "friction_angle": angle}
    rock = soil(5e3, 45.0, 25.0)
    return ground([[0.0, 0.0], [30.0, 0.0], [crest, 10.0], [70.0, 10.0]], -5.0, rock, seams={"joint": seam}, **settings)


@pytest.mark.parametrize(("cohesion", "angle"), [(0.0, 40.0), (20.0, 25.0)])
def test_a_block_on_a_plane_yields_where_its_strength_is_used_up(cohesion: float, angle: float) -> None:
    """k = (c A + W (cos(p) tan(phi) - sin(p))) / (W (cos(p) + sin(p) tan(phi))); without cohesion tan(phi - p)."""
    dip, friction = math.radians(30.0), math.tan(math.radians(angle))
    weight, length = 25.0 * 0.5 * 10.0 * (10.0 / math.tan(dip) - 10.0 / math.tan(math.radians(60.0))), 10.0 / math.sin(dip)
    expected = cohesion * length / weight + math.cos(dip) * friction - math.sin(dip)
    found = limit_equilibrium(wedge(cohesion, angle))
    assert found.critical.where == "along the seam joint"
    assert found.critical.value == pytest.approx(expected / (math.cos(dip) + math.sin(dip) * friction), rel=EXACT)


@pytest.mark.long
def test_a_slope_of_half_the_size_and_cohesion_has_the_same_answers() -> None:
    """By dimensions: F and k depend on gamma H / c alone, in a slope with a crack too."""
    half = ground(
        [[0.0, 0.0], [15.0, 0.0], [15.0 + 5.0 / math.tan(math.radians(60.0)), 5.0], [40.0, 5.0]], -2.5, soil(100.0 / 3.21, 20.0, 20.0)
    )
    found, whole = limit_equilibrium(half), limit_equilibrium(STEEP)
    for name in LimitEquilibrium._fields:
        assert getattr(found, name).value == pytest.approx(getattr(whole, name).value, rel=EXACT)


def test_a_slope_under_water_is_one_of_its_buoyant_weight() -> None:
    drowned = limit_equilibrium(slope(30.0, 20.0, 20.0, water={"pressure": "by_place", "level": 12.0, "unit_weight": 10.0}))
    buoyant = limit_equilibrium(
        ground([[0, 0], [30, 0], [30 + 10 / math.tan(math.radians(30.0)), 10], [87.3, 10]], -5.0, soil(10.0, 20.0, 10.0))
    )
    for name in ("bishop", "spencer"):
        assert getattr(drowned, name).value == pytest.approx(getattr(buoyant, name).value, rel=1e-6)


def test_water_before_the_toe_is_the_same_as_a_load_on_the_ground() -> None:
    """One circle, once by Bishop's (1955) buoyant weights and once with the water's pressure on toe and face; Spencer's forces between the
    slices have another direction, since they hold the water in the slope or do not."""
    section = Section.of(slope(30.0, 20.0, 20.0, water={"pressure": "by_place", "level": 5.0}))
    edges, centre = circles(section, np.array([[30.0, 55.0, math.radians(25.0)]]), 400)
    assert section.level == pytest.approx(10.0), "above the base"
    loaded = section._replace(level=-math.inf)
    assert np.abs(loaded.slices(edges).load).max() > 1e3 and np.abs(section.slices(edges).load).max() == 0.0
    (by_buoyancy, by_load) = (bishop(each.slices(edges), centre).value[0] for each in (section, loaded))
    assert by_load == pytest.approx(by_buoyancy, rel=1e-3)
    (by_buoyancy, by_load) = (spencer(each.slices(edges)).value[0] for each in (section, loaded))
    assert by_load == pytest.approx(by_buoyancy, rel=0.02)


def test_the_factor_falls_with_the_load_to_one_at_the_critical_coefficient() -> None:
    scene = slope(30.0, 20.0, 20.0)
    free = limit_equilibrium(scene)
    pushed = [limit_equilibrium(scene, k) for k in (0.1, free.critical.value)]
    for name in ("bishop", "spencer"):
        values = [getattr(each, name).value for each in (free, *pushed)]
        assert values == sorted(values, reverse=True) and values[0] > 1.2 > values[-1]
    assert pushed[-1].spencer.value == pytest.approx(1.0, rel=EXACT)


def test_the_critical_coefficient_of_a_surface_is_where_its_factor_is_one() -> None:
    section = Section.of(ACADS_3A)
    (layer,) = guides(section)
    lines = along(section, layer, np.array([[20.0, 60.0, 0.0, 24.0, 40.0, 0.0, 0.2]]), 8)
    slices = section.slices(lines)
    k = float(spencer_coefficient(slices).value[0])
    assert spencer(slices, k).value[0] == pytest.approx(1.0, rel=1e-5)
    assert spencer(slices, k + 0.05).value[0] < 1.0 < spencer(slices, k - 0.05).value[0]


def test_a_wet_cover_that_just_stands_yields_as_one_on_a_plane() -> None:
    """Surfaces on the edge of what balances have a further root near k = 0, which is none of a slope that stands."""
    points = [[-100.0, 0.0], [0.0, 0.0], [31.17691454, 18.0], [85.17691454, 18.0]]
    rock = {"region": {"kind": "depth", "top": 3.5}, "soil": soil(200.0, 38.0, 21.57)}
    wet = {"pressure": "carried", "points": [[x, y - 2.0] for x, y in points]}
    found = limit_equilibrium(ground(points, -9.0, soil(7.0, 27.0, 18.5), layers={"rock": rock}, water=wet))
    factor, sine, cosine = found.spencer.value, math.sin(math.radians(30.0)), math.cos(math.radians(30.0))
    on_a_plane = (factor - 1.0) * sine / (cosine + sine * math.tan(math.radians(27.0)))
    assert factor == pytest.approx(1.06, abs=0.01)
    assert found.critical.value == pytest.approx(on_a_plane, rel=0.15)


HILLSIDE = [
    [0.0, 40.2], [48.0, 41.3], [62.0, 42.0], [70.0, 46.1], [78.0, 50.4], [86.0, 54.6], [92.0, 57.9], [97.0, 58.0],
    [104.0, 62.3], [112.0, 66.9], [120.0, 71.2], [128.0, 74.6], [140.0, 75.8], [160.0, 76.4], [190.0, 76.9],
]  # fmt: skip
"""With a road bench at x = 92 to 97 m."""


def test_a_weak_cover_does_not_yield_in_shaking_in_which_it_stands() -> None:
    """A surface that dips a decimetre into the rock has a further root, at 0.376, where the factor of the hillside is 1.07."""
    rock = {"region": {"kind": "depth", "top": 2.5}, "soil": soil(60.0, 36.0, 18.0)}
    scene = ground(HILLSIDE, 25.1, soil(9.0, 35.0, 14.0), layers={"rock": rock})
    critical = limit_equilibrium(scene).critical
    assert critical.depth == pytest.approx(2.5, abs=0.01), "it slides on the rock"
    assert limit_equilibrium(scene, critical.value).spencer.value == pytest.approx(1.0, rel=0.005)


def test_the_limits_of_a_cover_stand_beside_those_of_the_hill() -> None:
    """A nailed cover has limits of its own, which those of the rock below do not show."""
    rock = {"region": {"kind": "depth", "top": 3.0}, "soil": soil(60.0, 36.0, 18.0)}
    water = {"pressure": "carried", "points": [[x, y - 6.0] for x, y in HILLSIDE]}
    plain, nailed = (ground(HILLSIDE, 25.1, soil(cohesion, 35.0, 14.0), layers={"rock": rock}, water=water) for cohesion in (9.0, 20.0))
    limits = [equilibrium_numbers(limit_equilibrium(each)) | within_cover(each, limit_equilibrium(each)) for each in (plain, nailed)]
    assert all(each["spencer_depth"] > 20.0 and each["cover"] == "soil" for each in limits), "deep in the rock"
    # Of an endless incline as steep as the face above the bench; its toe on the bench and its head hold more.
    beta = math.atan((71.2 - 58.0) / (120.0 - 97.0))
    endless = (9.0 / (14.0 * 3.0 * math.cos(beta) ** 2) + math.tan(math.radians(35.0))) / math.tan(beta)
    assert endless < limits[0]["cover_spencer"] < 1.2 * endless
    assert limits[1]["spencer"] == pytest.approx(limits[0]["spencer"], rel=0.02)
    assert limits[1]["cover_spencer"] > 1.3 * limits[0]["cover_spencer"] and limits[1]["cover_critical"] > 1.5 * limits[0]["cover_critical"]
    assert ("; within soil 2.0" in equilibrium_rows(limits[0])[0][1]) and "; within soil 4." in equilibrium_rows(limits[0])[1][1]
    shallow = ground(HILLSIDE, 25.1, soil(9.0, 35.0, 14.0), layers={"rock": rock})
    assert within_cover(shallow, limit_equilibrium(shallow)) == {}, "the worst surface is in the cover"


def test_a_dam_that_stands_yields_in_shaking_towards_its_toe() -> None:
    """Along the foundation of the upper dam there were roots at -0.56 and 0.08, under which no surface fails."""
    scene = load_scene("docs/gallery/upper_san_fernando.yaml")
    critical = limit_equilibrium(scene).critical.value
    assert critical > 0.0 and limit_equilibrium(scene, critical).spencer.value == pytest.approx(1.0, rel=0.005)


def test_a_mirrored_slope_has_the_same_factors() -> None:
    points, own = ACADS_1, soil(3.0, 19.6, 20.0)
    mirrored = ground([[-x, y] for x, y in points][::-1], 20, own, **{"geometry.downhill": "right"})
    found = limit_equilibrium(mirrored)
    assert found.bishop.value == pytest.approx(limit_equilibrium(ACADS_1A).bishop.value, rel=1e-6)
    assert found.spencer.value == pytest.approx(limit_equilibrium(ACADS_1A).spencer.value, rel=1e-6)


def test_steep_cohesive_soil_gets_a_crack_and_says_so() -> None:
    found = limit_equilibrium(STEEP)
    assert 0.0 < found.spencer.crack <= 5.0 and found.spencer.value < found.bishop.value
    assert found.critical.crack > 0.0
    ((_, factor), (_, yields)) = equilibrium_rows(equilibrium_numbers(limit_equilibrium(STEEP)))
    assert "with a tension crack of" in factor and "with a tension crack of" in yields
    assert f", {found.spencer.depth:.2g} m deep, with" in factor and f", {found.critical.depth:.2g} m deep, with" in yields
    deepest = (STEEP.geometry.ground(found.spencer.x) - found.spencer.y).max()
    assert found.spencer.depth == pytest.approx(deepest) and found.spencer.crack < deepest < 11.0


def factor(value: float, error: float) -> Finding:
    return finding("factor-of-safety", value=value, error=error)


def test_a_difference_from_the_particles_is_told_with_what_applies() -> None:
    (note,) = of_equilibrium(ACADS_1A)
    assert that_differ(ACADS_1A, [factor(0.97, 0.01), factor(0.90, 0.2)]) == []
    assert (note.code, note.severity) == ("limit-equilibrium", "note") and words(note).measured.startswith("Bishop 0.9")
    (weaker,) = that_differ(ACADS_1A, [factor(0.90, 0.02)])
    assert "below Spencer's" in words(weaker).what and "Davis 1968" in words(weaker).measured and "crack" not in words(weaker).measured
    (stronger,) = that_differ(STEEP, [factor(2.2, 0.05)])
    assert (
        "above Spencer's" in words(stronger).what
        and "tension crack" in words(stronger).measured
        and "Davis" not in words(stronger).measured
    )
    assert stronger.severity == "note" and words(stronger).wanted == words(stronger).key == ""


def test_a_yield_acceleration_is_compared_by_its_own_measure() -> None:
    spencer = GRAVITY * limit_equilibrium(STEEP).critical.value

    def told(share: float, error: float) -> list[Finding]:
        value = finding("yield-acceleration", value=share * spencer, error=error * spencer)
        return that_differ(STEEP, [value])

    assert told(0.85, 0.05) == told(0.6, 0.5) == told(1.19, 0.0) == []
    (lower,) = told(0.58, 0.05)
    assert lower.severity == "note" and words(lower).what == "the yield acceleration by SPH lies 42% below Spencer's"
    assert (
        "Davis 1968" in words(lower).measured
        and "large part of a yield acceleration" in words(lower).measured
        and " g)" in words(lower).measured
    )


def test_a_slope_that_stands_by_the_particles_alone_is_a_warning() -> None:
    """The steep slope with four tenths of its cohesion."""
    weak = make_scene(merge(STEEP.model_dump(), {"soil": {"cohesion": 0.4 * STEEP.soil.cohesion / 1e3}}))
    assert found_equilibrium(weak).spencer.value < 1.0  # type: ignore[union-attr]
    above, below = that_differ(weak, [factor(1.2, 0.05), factor(0.99, 0.01)])
    assert (above.severity, below.severity) == ("warning", "note")
    assert "by which the slope does not stand" in words(above).what and "trust Spencer's" in line(above)
    assert words(above).key == "numerics.spacing" and "trust" not in line(below)


def clay(**changes: Any) -> Scene:
    data = {
        "name": "clay",
        "duration": 5.0,
        "geometry": {"shape": "slope", "slope_angle": 30.0, "slope_height": 6.0, "base_depth": 9.0, "apron_length": 30, "crest_length": 30},
        "walls": {"base": "absorbing", "sides": "absorbing"},
        "soil": {
            "density": 1800.0,
            "shear_wave_speed": 150.0,
            "poisson_ratio": 0.4,
            "cohesion": 25.0,
            "friction_angle": 0.0,
            "viscosity": 2.0,
        },
        "coupling": {"S_R": 0.5, "softening": {"slip_at_peak": 0.01, "slip_at_residual": 0.2, "width": 3.0}},
        "damping": None,
        "numerics": {"spacing": 0.5},
    }
    return make_scene(merge(data, dotted(changes)))


@pytest.mark.long
def test_a_slope_that_does_not_stand_is_told_the_strength_with_which_it_does() -> None:
    """By closed forms: without friction F is in proportion to c; an infinite slope of sand stands with an angle of its inclination."""
    weak = clay(**{"soil.cohesion": 10.0})
    factor = limit_equilibrium(weak).spencer.value
    (told,) = [each for each in check(weak).findings if each.code == "factor-below-1"]
    assert told.severity == "warning" and told.numbers["value"] == factor < 1.0
    assert told.numbers["cohesion"] == pytest.approx(1e4 / factor, rel=EXACT)
    assert f"{factor:.2f} (Spencer), should be at least 1, as with a cohesion of {10.0 / factor:.2g}" in line(told)

    (sand,) = factor_below_1(loose := clay(**{"soil.cohesion": 0.0, "soil.friction_angle": 25.0}), found_equilibrium(loose))
    assert math.degrees(sand.numbers["friction_angle"]) == pytest.approx(30.0, rel=EXACT)
    assert "a friction angle of 30 degree in soil; change soil.cohesion or" in line(sand)

    cover = {"cover": {"region": {"kind": "depth", "bottom": 2.0}, "soil": {"cohesion": 2.0, "friction_angle": 0.0}}}
    (thin,) = factor_below_1(layered := clay(layers=cover), found_equilibrium(layered))
    assert (thin.subject, thin.keys[0]) == ("cover", "layers.cover.soil.cohesion")
    assert factor_below_1(clay(), None) == []


def test_the_limit_equilibrium_of_residual_strengths_names_the_ratios_that_decide() -> None:
    layers = {"top": {"region": {"kind": "depth", "bottom": 2.0}, "soil": {"cohesion": 40.0}, "S_R": 0.25}}
    given = {"soil.residual_cohesion": 12.5, "soil.residual_friction_angle": 0.0}
    for scene, ratios in (
        (clay(), " (strength ratio 0.5)"),
        (clay(layers=layers), " (strength ratio 0.5, top 0.25)"),
        (clay(**given), ""),
    ):
        (told,) = of_residual(scene)
        assert words(told).what == f"limit equilibrium at the residual strength{ratios}"


def test_a_slope_whose_block_slips_farther_than_its_strength_lasts_should_fail() -> None:
    """Above 1 at the peak and half of it at the residual strength, lost within 0.2 m."""
    motion = {"kind": "tapered_sine", "amplitude": 4.0, "frequency": 1.0, "start": 3.0, "ramp": 1.0, "decay_start": 6.0, "end": 7.0}
    shaken = {"a": clay(motion=motion), "b": clay(motion=motion | {"amplitude": 6.0}), "c": clay(motion=motion | {"amplitude": 1.0})}
    found = runs_away(shaken, 1.0)
    assert set(found) == {"a", "b"} and runs_away(shaken, 7.0) == {} == runs_away(shaken, 0.0)
    of, made = found["a"].numbers, motion_of(shaken["a"])
    assert of["value"] == sliding_block(made.time, made.acceleration, 1.0).permanent > of["bound"] == 0.2
    assert of["residual"] == pytest.approx(0.5 * limit_equilibrium(clay()).spencer.value, rel=EXACT) and of["residual"] < 1.0
    assert "a rigid block slips" in line(found["b"]) and found["b"].severity == "note"
    assert runs_away({"stands": clay(**{"motion": motion, "coupling.S_R": 0.95})}, 1.0) == {}, "at its residual strength"
    by_time = clay(motion=motion, coupling={"S_R": 0.5, "gamma": 1.0, "softening": None})
    assert runs_away({"by time": by_time}, 1.0) == {} == runs_away({"calm": clay()}, 1.0)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, True),  # without friction circles go as deep as they may
        ({"walls.bedrock": {"density": 2200.0, "s_wave_speed": 900.0, "p_wave_speed": 1800.0}}, False),
        ({"walls.bedrock": {"density": 1900.0, "s_wave_speed": 200.0, "p_wave_speed": 400.0}}, True),
        ({"walls.base": "no_slip"}, False),
        ({"soil.friction_angle": 30.0}, False),
        ({"layers": {"deep": {"region": {"kind": "depth", "top": 8.0}, "soil": {"cohesion": 200.0}}}}, False),
    ],
)
def test_a_slip_surface_that_ends_at_soil_which_goes_on_is_told(changes: dict[str, Any], told: bool) -> None:
    scene = clay(**changes)
    found = slip_at_base(scene, found_equilibrium(scene))
    assert [each.code for each in found] == ["slip-at-base"] * told
    assert all(each.keys == ("geometry.base_depth", "walls.bedrock") for each in found)


def test_a_slide_below_the_crest_edge_asks_for_a_probe_on_it() -> None:
    """A cover that thins out towards the crest slides on the face alone."""
    ground = [[0.0, 10.0], [20.0, 10.0], [60.0, 30.0], [110.0, 30.5]]
    below = [[0.0, 7.5], [20.0, 7.5], [50.0, 22.5], [60.0, 30.0], [110.0, 30.5]]
    strong = {"cohesion": 200.0, "friction_angle": 40.0}
    data = {
        "name": "face",
        "scheme": "paper",
        "duration": 3.0,
        "geometry": {"shape": "ground_line", "points": ground, "base": 0.0},
        "soil": {"cohesion": 3.0, "friction_angle": 28.0},
        "layers": {"rock": {"region": {"kind": "below", "points": below}, "soil": strong}},
        "numerics": {"spacing": 0.5, "smoothing_ratio": 1.3, "time_step": 1e-3},
    }
    scene = make_scene(data)
    (found,) = probes_off_slide(scene, found_equilibrium(scene))
    assert found.numbers["low"] < found.numbers["high"] < 60.0 and "a probe between them" in words(found).wanted
    on_it = make_scene(data | {"probes": {"A": "crest_edge", "face": [40.0, 19.5]}})
    assert probes_off_slide(on_it, found_equilibrium(on_it)) == []
    plain = clay()
    assert probes_off_slide(plain, found_equilibrium(plain)) == [] == probes_off_slide(plain, None)


@pytest.mark.parametrize(
    ("deep", "measured"),
    [
        (["bishop"], "the surface of Bishop's factor of safety"),
        (["spencer"], "the surface of Spencer's factor of safety"),
        (["critical"], "the surface of Spencer's yield acceleration"),
        (["bishop", "spencer"], "the surfaces of Bishop's factor of safety and Spencer's factor of safety"),
        (["spencer", "critical"], "the surfaces of Spencer's factor of safety and Spencer's yield acceleration"),
        (
            ["bishop", "spencer", "critical"],
            "the surfaces of Bishop's factor of safety, Spencer's factor of safety and Spencer's yield acceleration",
        ),
    ],
)
def test_the_surfaces_that_reach_the_base_are_named_by_method_and_limit(deep: list[str], measured: str) -> None:
    """Hand-made surfaces, at the base or 3 m above it."""
    surfaces = {
        name: Surface(1.5, "circle", np.array([40.0, 50.0]), np.full(2, 0.0 if name in deep else 3.0), np.zeros(1, int), 0.0, 0.0)
        for name in LimitEquilibrium._fields
    }
    (found,) = slip_at_base(clay(), LimitEquilibrium(**surfaces))
    assert words(found).measured == measured
    assert f": {measured}, should lie above the base, or end on stiff ground; change geometry.base_depth" in sentence(found)


def test_what_is_no_slope_of_solid_soil_is_refused_and_has_no_rows() -> None:
    column = make_scene(
        {"name": "column", "scheme": "paper", "duration": 3.0, "geometry": {"shape": "block", "width": 30.0, "height": 20.0}}
    )
    assert not applies(column) and found_equilibrium(column) is None and equilibrium_rows({}) == [] and of_equilibrium(column) == []
    with pytest.raises(ValueError, match=r"column: limit equilibrium needs geometry\.shape: slope or ground_line"):
        limit_equilibrium(column)
    fluid = merge(slope(30.0, 20.0, 20.0).model_dump(), {"coupling": {"initial_state": "fluid"}})
    assert not applies(make_scene(fluid))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", range(8))
def test_a_cut_with_little_ground_behind_its_crest_has_a_surface_or_none(seed: int) -> None:
    """No stronger than the best plane wedge from the toe to the ground that there is; where none is as large as a failure, none."""
    random = np.random.default_rng(seed)
    height, face, cohesion = random.uniform(5.0, 40.0), random.uniform(50.0, 88.0), random.uniform(5.0, 100.0)
    angle, behind = random.choice([0.0, random.uniform(5.0, 40.0)]), height * 10.0 ** random.uniform(-3.0, -1.1)
    crest = 30.0 + height / math.tan(math.radians(face))
    points = [[0.0, 0.0], [30.0, 0.0], [crest, height], [crest + behind, height]]
    scene = ground(points, -random.choice([0.01, 0.5]) * height, soil(cohesion, angle, 20.0), **{"numerics.spacing": height / 20.0})
    found = limit_equilibrium(scene)
    out = np.linspace(0.0, behind, 201)[1:] + crest - 30.0
    dip, weight = np.arctan2(height, out), 10.0 * height * (out - crest + 30.0)
    held = cohesion * np.hypot(out, height) + weight * np.cos(dip) * math.tan(math.radians(angle))
    wedges = np.where((weight >= 0.0101 * 20.0 * height**2) & (dip < math.radians(87.9)), held / (weight * np.sin(dip)), math.inf)
    assert found.spencer.value <= (1.0 + EXACT) * wedges.min() or wedges.min() > MAX_FACTOR
    assert all(each.value == math.inf or 0.0 < each.value <= MAX_FACTOR for each in (found.bishop, found.spencer))
    assert found.critical.value == math.inf or found.spencer.value > 1.0


def test_a_slope_without_a_surface_is_checked_all_the_same() -> None:
    """A vertical cut in front of a strip of ground: no factor of 1e16, but a finding with what to change."""
    scene = ground([[0.0, 0.0], [30.0, 0.0], [30.2, 20.0], [30.4, 20.0]], -2.0, soil(50.0, 20.0, 20.0))
    assert limit_equilibrium(scene).bishop.value == math.inf and found_equilibrium(scene) is None
    (told,) = (each for each in check(scene).findings if each.code == "stability-unknown")
    assert line(told).startswith("note: limit equilibrium: no slip surface found with a factor of safety up to 20")
    assert "should have ground behind the crest" in line(told) and words(told).key == "geometry.points" and of_equilibrium(scene) == [told]
    (strong,) = of_equilibrium(slope(30.0, 0.2, 40.0))
    assert strong.code == "stability-unknown" and words(strong).key == ""


def test_no_circle_fails_below_the_critical_coefficient_of_the_supplied_cut() -> None:
    """Its surface of least k stands on the edge of what balances."""
    scene = load_scene("config/scenes/steep_cut.yaml")
    assert worst_circle(Section.of(scene), limit_equilibrium(scene).critical.value)[0].value > 1.0 - EXACT
