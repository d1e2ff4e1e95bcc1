"""Debris that meets the box: by runs of a slope of 8 m in boxes of several lengths, and the room that is asked for before them."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.checks.after_run import after_run, debris_at_wall, found_after, is_bounded, thin_debris
from sph.checks.messages import words
from sph.checks.scene import findings, reach, room_ahead
from sph.measures.metrics import Value, measure
from sph.output.run import Run
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.run import run

LOW: dict[str, Any] = {
    "name": "low",
    "duration": 15.0,
    "geometry": {"shape": "slope", "slope_angle": 60.0, "slope_height": 8.0, "base_depth": 2.0, "apron_length": 16.0, "crest_length": 40.0},
    "soil": {
        "density": 1900.0,
        "youngs_modulus": 3e5,
        "poisson_ratio": 0.3,
        "cohesion": 13.0,
        "friction_angle": 30.0,
        "viscosity": 2.0,
    },
    "walls": {"base": "no_slip", "sides": "no_slip"},
    "coupling": {"S_R": 0.05, "gamma": 100.0, "softening": {"slip_at_peak": 1e-3, "width": 3.0}},
    "motion": {"kind": "tapered_sine", "amplitude": 2.0, "frequency": 2.0, "start": 3.0, "ramp": 1.0, "decay_start": 6.0, "end": 7.0},
    "damping": {"ratio": 0.02, "frequencies": [1.0, 10.0]},
    "numerics": {"spacing": 2.0 / 3.0},
    "outputs": {"frame_interval": 0.25},
}
"""A low slope of weak soil, 12 rows of particles high."""


def low(**changes: Any) -> Scene:
    return make_scene(merge(LOW, dotted(changes)))


@functools.cache
def ran(apron: float, ratio: float) -> xr.Dataset:
    return run(low(**{"geometry.apron_length": apron, "coupling.S_R": ratio})).trajectory


def measured(apron: float, ratio: float) -> dict[str, Value]:
    return measure(ran(apron, ratio))


def room(scene: Scene) -> list[tuple[str, str]]:
    return [(words(each).wanted, words(each).key) for each in findings(scene) if each.code == "little-room"]


def aprons(ratio: float) -> tuple[float, float]:
    """Lengths of an apron with the room that is asked for, and of half of what the debris then covers, m."""
    asked = round(room_ahead(low(**{"coupling.S_R": ratio})))
    return asked, round(0.5 * float(measured(asked, ratio)["runout"]))


@pytest.mark.long
def test_debris_that_the_box_throws_back_is_told_and_the_value_is_a_lower_bound() -> None:
    asked, half = aprons(0.2)
    scene, short = low(**{"coupling.S_R": 0.2, "geometry.apron_length": half}), measured(half, 0.2)
    assert str(short["reached_side"]).split()[0] == "front" and is_bounded(str(short["reached_side"]))
    assert 3.0 < float(short["reached_side_time"]) < 15.0
    (found,) = found_after(Run(ran(half, 0.2)))
    assert (found.code, found.severity) == ("debris-at-wall", "warning") and "lower bounds" in words(found).what
    assert "geometry.apron_length" in words(found).key
    assert [found] == debris_at_wall(scene, str(short["reached_side"]), float(short["reached_side_time"]))
    free = measured(asked, 0.2)
    assert free["reached_side"] == "" and np.isnan(float(free["reached_side_time"]))
    assert debris_at_wall(scene, "", np.nan) == []


@pytest.mark.long
def test_an_apron_that_the_side_holds_is_told() -> None:
    """Deep soft clay: the failed apron at a side that cuts the crest's displacement by 17 % has moved by 0.25 m only."""
    clay = {
        "geometry.slope_angle": 45.0,
        "geometry.base_depth": 8.0,
        "geometry.crest_length": 25.0,
        "soil.cohesion": 28.0,
        "soil.friction_angle": 0.0,
        "coupling.S_R": 0.95,
        "motion.amplitude": 2.5,
        "duration": 10.0,
        "numerics.spacing": 1.0,
    }
    short, long = (measure(run(low(**clay, **{"geometry.apron_length": apron})).trajectory) for apron in (12.0, 40.0))
    assert float(short["displacement_magnitude"]) < 0.9 * float(long["displacement_magnitude"])
    assert "front" in str(short["reached_side"]) and "front" not in str(long["reached_side"])


@pytest.mark.parametrize(
    ("runout", "deposit", "told"),
    [(10.1, 3.9, True), (10.1, 4.0, False), (9.9, 3.9, False), (0.0, 0.0, False), (np.nan, np.nan, False)],
)
def test_debris_that_ran_far_and_is_thin_is_told(runout: float, deposit: float, told: bool) -> None:
    """Further than ten spacings, thinner than four."""
    spacing = low().numerics.spacing
    found = thin_debris(low(), runout * spacing, deposit * spacing)
    assert [(each.code, words(each).key) for each in found] == [("thin-debris", "numerics.spacing")] * told
    assert all("3.9 particles thick" in words(each).measured for each in found)
    assert all(words(each).what.endswith("is not reliable") for each in found), "a slope without a cover"


@pytest.mark.long
def test_a_run_and_its_metrics_tell_the_same_of_thin_debris() -> None:
    asked, _ = aprons(0.2)
    scene, trajectory = low(**{"coupling.S_R": 0.2, "geometry.apron_length": asked}), ran(asked, 0.2)
    values = measure(trajectory)
    assert thin_debris(scene, float(values["runout"]), float(values["deposit_thickness"])), "weak soil on a long apron runs out thin"
    assert found_after(Run(trajectory)) == after_run(scene, values)


def within(scene: Scene) -> float:
    """Reach of the debris beyond the toe, m."""
    return reach(scene) - (scene.geometry.crest[0] - scene.geometry.toe[0])


@pytest.mark.long
@pytest.mark.parametrize("ratio", [0.2, 0.4])
def test_the_room_that_is_asked_for_is_enough_and_half_of_the_run_out_is_not(ratio: float) -> None:
    asked, half = aprons(ratio)
    free = measured(asked, ratio)
    assert "front" not in str(free["reached_side"])
    assert 0.7 < float(free["runout"]) / within(low(**{"coupling.S_R": ratio})) < 1.0
    assert "front" in str(measured(half, ratio)["reached_side"]).split()


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "apron", "runout"), [(0.05, 110.0, 66.0), (0.1, 80.0, 50.0)])
def test_weak_debris_goes_as_far_as_is_asked_for(ratio: float, apron: float, runout: float) -> None:
    free = measured(apron, ratio)
    assert "front" not in str(free["reached_side"]) and float(free["runout"]) == pytest.approx(runout, rel=0.1)
    assert float(free["runout"]) < within(low(**{"coupling.S_R": ratio}))


def test_the_apron_that_weak_debris_needs_is_named() -> None:
    soil = {"soil.cohesion": 40.0, "soil.friction_angle": 20.0}
    ((wanted, key),) = room(low(**soil))
    assert "at least 62.11 m, 7.8 H" in wanted and key == "geometry.apron_length"
    assert room(low(**soil, **{"geometry.apron_length": 63.0})) == []
    assert room(low(**soil, **{"coupling.S_R": 1.0})) == [], "soil that keeps its strength needs no more than 2 H"


@settings(max_examples=40)
@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.5, 20.0), st.sampled_from([None, "weak"]))
def test_less_strength_asks_for_more_room_never_for_less_than_before(first: float, second: float, apron: float, layer: str | None) -> None:
    weak = {} if layer is None else {"layers": {layer: {"region": {"kind": "depth", "top": 3.0}, "soil": {"cohesion": 6.0}}}}
    less, more = sorted((first, second))
    lengths = [reach(low(**{"coupling.S_R": ratio}, **weak)) for ratio in (less, more)]
    assert lengths[0] >= lengths[1] > 0.0
    assert reach(low(**{"coupling.S_R": less}, **weak)) >= reach(low(**{"coupling.S_R": less}))
    scene = low(**{"coupling.S_R": less, "geometry.apron_length": 8.0 * apron}, **weak)
    assert room_ahead(scene) >= 16.0 and bool(room(scene)) == (8.0 * apron < room_ahead(scene) * (1 - 1e-9))
