"""Places before and on the slope on hand-made trajectories."""

from __future__ import annotations

import math

import numpy as np
import pytest
from synthetic import PAPER, synthetic, translation

from sph.measures.metrics import MetricSettings, measure
from sph.measures.places import beyond_toe, check_places, place_columns, places_in
from sph.output.run import Run
from sph.scene.schema import make_scene

GROUND = {"shape": "ground_line", "points": [[120, 440], [175, 440], [190, 465], [224, 465]], "base": 430}


def at(run: Run, **places: float | str) -> dict[str, float | int | str]:
    """What is measured at places beside the metrics of every run."""
    values, others = measure(run, MetricSettings(places=places)), measure(run)
    assert {name: values[name] for name in others} == pytest.approx(others, nan_ok=True), "places change no other metric"
    return {name: value for name, value in values.items() if name not in others}


def test_a_block_that_slides_3_m_passes_a_place_2_m_beyond_the_toe_by_1_m() -> None:
    """It starts at 4 s with 0.75 m/s, so that 2 m are passed at 6.67 s, before the frame at 7 s.  The columns that lay half a spacing and
    one and a half behind the toe come to lie within a spacing of the place; the second is three particles high."""
    found = at(synthetic(translation(-3.0)), road="2 beyond the toe")
    assert found == pytest.approx({
        "road_passed": 1.0, "road_depth": 3.0, "road_arrival": 7.0, "road_reached": 1.0, "road_peak_depth": 3.0, "road_peak_speed": 0.75,
        "road_front_speed": 0.75, "road_impact_pressure": 1964.0 * 0.75**2, "road_ground_displacement": 0.0,
    }, abs=1e-5)  # fmt: skip


def test_debris_on_the_slope_buries_a_bench_and_a_slide_along_it_carries_it_away() -> None:
    """Soil that lay above a bench 7 m behind the toe of a slope of 60 degrees comes over it by 3 m; on a slide along the slope nothing lies
    on it, but the bench itself moves."""
    buried = at(synthetic(translation(-3.0)), bench=62.0)
    assert buried["bench_passed"] == pytest.approx(3.0, abs=1e-4) and buried["bench_reached"] == 1.0
    assert buried["bench_depth"] == buried["bench_peak_depth"] == pytest.approx(5.4, abs=0.5) and buried["bench_ground_displacement"] == 3.0
    down = math.tan(math.radians(60.0))
    slid = at(synthetic(translation(-1.0, -down)), bench=62.0)
    assert slid["bench_reached"] == 0.0 and slid["bench_ground_displacement"] == pytest.approx(2.0)
    standing = at(synthetic(), bench=62.0)
    assert (standing["bench_reached"], standing["bench_depth"], standing["bench_impact_pressure"]) == (0.0, 0.0, 0.0)
    assert math.isnan(float(standing["bench_passed"])) and math.isnan(float(standing["bench_arrival"]))


def test_debris_counts_from_a_stated_depth_and_the_pressure_has_a_factor() -> None:
    settings = MetricSettings(places={"road": "2 beyond the toe"}, debris_depth=3.5, impact_factor=2.0)
    found = measure(synthetic(translation(-3.0)), settings)
    assert found["road_reached"] == 0.0 and found["road_peak_depth"] == pytest.approx(3.0)
    assert found["road_impact_pressure"] == pytest.approx(2.0 * 1964.0 * 0.75**2)


def test_a_place_that_is_not_reached() -> None:
    found = at(synthetic(translation(-3.0)), house="10 m beyond the toe", road="2.5 beyond the toe")
    assert (found["house_passed"], found["house_depth"]) == pytest.approx((-7.0, 0.0), abs=1e-5) and math.isnan(
        float(found["house_arrival"])
    )
    assert found["road_arrival"] == 7.5, "2.5 m are passed at 7.33 s"
    standing = at(synthetic(), house="10 beyond the toe")
    assert standing["house_passed"] == -10.0 and standing["house_depth"] == 0.0
    noise = at(synthetic(lambda scene, x, y: (0.0 * x, np.where(x < 50.0, 0.3, 0.0))), house="10 beyond the toe")
    assert noise["house_depth"] == noise["house_peak_depth"] == 0.0 and noise["house_ground_displacement"] == pytest.approx(0.3)


def test_a_place_by_its_x_is_that_of_the_survey_whichever_way_the_slope_falls() -> None:
    left = at(synthetic(translation(-3.0), overrides={"geometry": GROUND}), road=173.0)
    turned = GROUND | {"points": [[-x, y] for x, y in GROUND["points"]], "downhill": "right"}  # type: ignore[attr-defined]
    right = at(synthetic(translation(-3.0), overrides={"geometry": turned}), road=-173.0)
    assert left == pytest.approx(right, abs=1e-5) and left["road_passed"] == pytest.approx(1.0, abs=1e-5)
    assert beyond_toe("12.5 beyond the toe", synthetic(overrides={"geometry": GROUND}).scene.geometry) == 12.5  # type: ignore[arg-type]


def test_a_diverged_run_has_no_values_at_places() -> None:
    found = at(synthetic(translation(-3.0), status="diverged"), road="2 beyond the toe")
    assert set(found) == {column.name for column in place_columns(["road"])} and all(math.isnan(float(value)) for value in found.values())


def test_the_places_are_known_from_the_columns() -> None:
    columns = [column.name for column in place_columns(["road", "river_bank"])]
    assert places_in(["runout", *columns]) == ["road", "river_bank"] and len(columns) == 18


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("56 beyond the toe", "at most 55 m beyond the toe (x from 103.434 to 0 m)"),
        (104.0, "must lie within the model"),
        (-1.0, "lengthen the apron or the crest to include it"),
    ],
)
def test_a_place_outside_the_model_is_refused(place: float | str, words: str) -> None:
    with pytest.raises(ValueError, match="config: metrics.places.road: ") as raised:
        check_places({"road": place}, make_scene(PAPER), "config")
    assert words in str(raised.value)


def test_behind_the_crest_a_place_tells_how_its_ground_moves() -> None:
    """No debris comes there from above, where the ground is level."""
    found = at(synthetic(translation(-3.0)), track=75.0)
    assert found["track_ground_displacement"] == pytest.approx(3.0) and found["track_reached"] == found["track_peak_depth"] == 0.0
    assert math.isnan(float(found["track_passed"])) and math.isnan(float(found["track_arrival"]))


def test_a_shape_without_a_toe_has_no_places() -> None:
    block = make_scene({**PAPER, "geometry": {"shape": "block", "width": 10.0, "height": 5.0}})
    with pytest.raises(ValueError, match=r"metrics.places.road: 3.0: a place needs geometry.shape slope or ground_line, not block"):
        check_places({"road": 3.0}, block, "config")


@pytest.mark.parametrize("place", ["12", "12 behind the toe", "-3 beyond the toe", [1.0]])
def test_a_place_is_a_number_or_a_distance_from_the_toe(place: object) -> None:
    if place == "12":
        assert MetricSettings(places={"road": place}).places == {"road": 12.0}
        return
    with pytest.raises(ValueError):
        MetricSettings(places={"road": place})
