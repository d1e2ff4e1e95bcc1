"""The client's questions on the first screen: how far past a place, how wide, how often."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from synthetic import study_row

from sph.checks.after_run import has_thin_debris
from sph.checks.cover_rows import SCATTER
from sph.checks.finding import finding
from sph.experiments.trigger.annual import annual_columns
from sph.page.answer import _by_both, answer, held_back, lead, surer_with, up_to
from sph.page.build import farthest
from sph.page.facts import at_residual, fails_below, fails_in_weakest, unshaken, yearly
from sph.page.levels import levels, widths
from sph.page.places import at_a_glance, at_places
from sph.page.second_spacing import differs, with_second_class
from sph.scene.schema import load_scene
from sph.study.dimensions import Dimension
from sph.study.preflight import Row
from sph.study.tables import write_csv

RUNS = pd.DataFrame(
    {
        "amplitude": ["2.0"] * 2 + ["4.0"] * 4,
        "runout": [0.0, 2.0, 4.0, 10.0, 14.0, 20.0],
        "reached_side": ["", "", "", "", "", "front"],
        "findings": "",
        "expected_runout_error": [0.12] * 6,
        "at_rest": [1] * 6,
        "moving_share": 0.0,
        "time_to_rest": 0.0,
        "shaking_start": 3.0,
    }
).assign(
    road_passed=lambda table: table["runout"] - 12.0,
    road_depth=[0.0, 0.0, 0.0, 0.0, 0.8, 2.1],
    road_arrival=[math.nan] * 4 + [7.25, 5.5],
    house_passed=lambda table: table["runout"] - 30.0,
    house_depth=0.0,
    house_arrival=math.nan,
    road_reached=lambda table: (table["road_passed"] >= 0.0).astype(float),
    road_peak_depth=lambda table: table["road_depth"],
    road_peak_speed=[0.0] * 4 + [2.5, 4.2],
    road_impact_pressure=[0.0] * 4 + [9000.0, 31000.0],
    road_ground_displacement=0.0,
    house_reached=0.0,
    house_peak_depth=0.0,
    house_peak_speed=0.0,
    house_impact_pressure=0.0,
    house_ground_displacement=0.04,
    diverged=0,
    status="complete",
    collapse_class="collapse",
    energy_line_runout=math.nan,
    corominas_runout=math.nan,
)
MOVING: dict[str, Any] = {"moving_share": 0.12, "time_to_rest": 7.5}
"""How runs that are not at rest move on."""
LOST = RUNS.assign(**{name: math.nan for name in RUNS if name.startswith(("road_", "house_"))})
"""The same without what is at the places, as if all runs had diverged."""


def row_of(table: pd.DataFrame, place: str = "house", **given: Any) -> dict[str, str]:
    """What the page says of a place, by column."""
    (found,) = at_places(table, **given)
    return next(dict(zip(found.head, row, strict=True)) for row in found.rows if row[0] == place)


SHORT = "where it is not reached"


def test_what_the_debris_does_at_a_place() -> None:
    (found,) = at_places(RUNS)
    assert found.caption == "Debris at the places at 4 m/s2 (0.408 g)"
    assert [list(row) for row in found.rows] == [
        ["road", "2 of 4", "4 m/s2 (0.408 g)", "2.5", "2.10", "4.2", "31", "stops 2.00 m short"],
        ["house", "0 of 4", "–", "–", "–", "–", "–", "stops 10.0 m short"],
    ]
    assert at_places(LOST.drop(columns=[name for name in LOST if name.startswith(("road_", "house_"))])) == []
    assert at_places(RUNS.assign(diverged=1)) == []
    stand = RUNS.assign(collapse_class="minor", runout=0.0, house_passed=-30.0)
    assert row_of(stand)[SHORT] == "no soil that fails comes within 30.0 m", "there is no debris to stop"
    assert row_of(RUNS[2:], "road")["reached in runs"] == "2 of 4" and "reached from" not in row_of(RUNS[2:]), "one level of shaking"
    assert row_of(RUNS, contradicted=True)[SHORT] == "not known: runs stand that should fail"


def test_a_place_that_fares_worse_in_weaker_shaking_says_so() -> None:
    """An engineer designs for the worst of all levels that were run."""
    weak = RUNS["amplitude"].astype(float) < RUNS["amplitude"].astype(float).max()
    worse = RUNS.assign(
        road_reached=1.0,
        road_peak_speed=np.where(weak, 8.9, 3.3),
        road_impact_pressure=np.where(weak, 85e3, 8.3e3),
        road_peak_depth=np.where(weak, 2.1, 2.0),
        house_reached=np.where(weak, 1.0, 0.0),
        house_peak_speed=np.where(weak, 5.2, 0.0),
        house_ground_displacement=np.where(weak, 3.0, 0.0),
    )
    level = row_of(worse)["reached from"]
    assert level != row_of(RUNS, "road")["reached from"]
    (found,) = at_places(worse)
    strong_road, weak_road, strong_house, weak_house = (dict(zip(found.head, row, strict=True)) for row in found.rows)
    strongest = row_of(RUNS, "road")["reached from"]
    assert [row["shaking"] for row in (strong_road, weak_road, strong_house, weak_house)] == [strongest, level] * 2
    speed, pressure, moves = "fastest particle (m/s)", "impact pressure (kPa)", "its ground moves (m)"
    assert (strong_road[speed], strong_road[pressure], weak_road[speed], weak_road[pressure]) == ("3.3", "8.3", "8.9", "85")
    assert (strong_house["reached in runs"][:4], weak_house[speed], strong_house[moves], weak_house[moves]) == ("0 of", "5.2", "–", "3.00")
    assert (
        "shaking"
        not in at_places(worse.assign(**{name: worse[name].max() for name in worse if name.startswith(("road_", "house_"))}))[0].head
    )
    assert "it reaches road; in weaker shaking it reaches house as well" in lead(worse, [])


def test_the_places_at_a_glance() -> None:
    """The most of all runs of each alternative, without those of which the spacing decides if they stand."""
    glance = at_a_glance(RUNS)
    assert glance is not None and [list(row) for row in glance.rows] == [
        ["road", "from 0.408 g: 2.10 m deep, 4.2 m/s, 31 kPa"],
        ["house", "not reached: stops 10.0 m short"],
    ]
    assert at_a_glance(RUNS[[name for name in RUNS if not name.startswith(("road_", "house_"))]]) is None
    several = at_a_glance(RUNS.assign(alternative=["base", "drained"] * 3, road_ground_displacement=[0.0, 3.0] * 3), contradicted=True)
    assert several is not None and several.head == ("place", "as it is", "drained")
    assert several.rows[0][2].endswith("kPa; moves 3.00 m") and several.rows[1][1:] == (
        "not known: runs stand that should fail",
        "not reached: stops 10.0 m short",
    )
    decided = RUNS.assign(second_class=["stable" if reached else "" for reached in RUNS["road_reached"] > 0.0])
    without = at_a_glance(decided.assign(collapse_class="collapse"))
    assert without is not None and "kPa" not in without.rows[0][1]
    moving = at_a_glance(RUNS.assign(at_rest=0, time_to_rest=7.5))
    assert moving is not None and moving.rows[1][1].startswith("unknown in 4 of 4 runs, still moving")


def test_each_alternative_has_its_own_row() -> None:
    runs = RUNS.assign(alternative=["base", "drained"] * 3)
    assert row_of(runs)["alternative"] == "as it is"
    rows = [dict(zip(at_places(runs)[0].head, row, strict=True)) for row in at_places(runs)[0].rows]
    assert [(row["place"], row["alternative"], row["reached in runs"]) for row in rows] == [
        ("road", "as it is", "1 of 2"),
        ("road", "drained", "1 of 2"),
        ("house", "as it is", "0 of 2"),
        ("house", "drained", "0 of 2"),
    ]
    assert [row["first after (s of shaking)"] for row in rows[:2]] == ["4.25", "2.5"]
    (found,) = at_places(runs, contradicted=True)
    assert [row[-1].startswith("not known") for row in found.rows] == [True, False] * 2, "of the scene as it is alone"


def test_debris_that_comes_before_the_shaking_is_told() -> None:
    assert row_of(RUNS.assign(road_arrival=[math.nan] * 4 + [5.5, 1.0]), "road")["first after (s of shaking)"] == "before it"


def test_a_place_within_the_error_of_the_run_out_may_be_reached() -> None:
    near = RUNS.assign(house_passed=RUNS["runout"] - 22.3)
    assert row_of(near)["reached in runs"] == "0 of 4"
    assert row_of(near)[SHORT] == "may be reached: stops 2.30 m short, within its error of 12 %"
    assert row_of(RUNS.assign(house_passed=RUNS["runout"] - 22.5))[SHORT] == "stops 2.50 m short"
    unknown = near.assign(expected_runout_error=math.nan)
    assert row_of(unknown)[SHORT].endswith(f"{SCATTER:.0%}".replace("%", " %")), "that of covers where none is known"


def test_a_place_that_moving_or_braked_debris_may_still_reach_is_not_out_of_reach() -> None:
    """It is unknown, whatever else was run."""
    moving = RUNS.assign(at_rest=[1, 1, 1, 0, 0, 0], **MOVING)
    assert row_of(moving)[SHORT] == "unknown in 3 of 4 runs, still moving; 10.0 m short at the end"
    assert at_places(moving)[0].note.endswith("Debris that still moves: up to 12 % of the debris, which needs some 7.5 s more to rest.")
    assert row_of(moving, "road")[SHORT] == "unknown in 1 of 2 runs, still moving; 2.00 m short at the end"
    why = "2 rows of particles in cover"
    braked = RUNS.assign(findings="few-particles weak-on-strong")
    assert row_of(braked)[SHORT] == "unknown in 4 of 4 runs, held back; 10.0 m short at the end"
    assert why in at_places(braked, why)[0].note and "held back" not in at_places(RUNS, why)[0].note
    one = RUNS.assign(findings=["", "", "", "layer-held", "", ""])
    assert row_of(one)[SHORT] == "unknown in 1 of 4 runs, held back; 20.0 m short at the end; of those at rest: stops 10.0 m short"
    assert RUNS["house_passed"].idxmax() == 5, "the run that comes nearest"
    nearer = RUNS.assign(at_rest=[1, 1, 1, 0, 0, 1], **MOVING)
    gap = -RUNS["house_passed"][[3, 4]].max()
    assert (
        row_of(nearer)[SHORT] == f"unknown in 2 of 4 runs, still moving; {gap:.1f} m short at the end; of those at rest: stops 10.0 m short"
    )
    both = RUNS.assign(at_rest=[1, 1, 1, 0, 0, 0], **MOVING, findings=["", "", "layer-held", "layer-held", "", ""])
    assert row_of(both)[SHORT].startswith("unknown in 4 of 4 runs, held back and still moving")


def test_a_place_below_a_cover_that_stands_for_lack_of_rows_is_not_out_of_reach() -> None:
    """Of runs that came down it is."""
    late = RUNS.assign(findings="cover-late", diverged=0, collapse_class="stable")
    assert row_of(late)[SHORT].startswith("unknown in 4 of 4 runs, held back")
    assert row_of(late.assign(collapse_class="collapse"))[SHORT] == "stops 10.0 m short"


@pytest.mark.parametrize("code", ["weak-on-strong", "layer-held"])
def test_braked_debris_is_a_lower_bound_with_its_reason(code: str) -> None:
    rows = [Row(finding(code, subject="cover", value=1.9, rows=1.9), 4, "a"), Row(finding("few-particles", value=1, bound=2), 6, "a")]
    braked = RUNS.assign(findings=["", "", code, code, code, code], reached_side="", collapse_class="stable", newmark_displacement=math.nan)
    braked["displacement_magnitude"] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    why = held_back(braked, rows)
    assert why == "1.9 rows of particles in cover" and held_back(RUNS, rows) == "", "of runs that are not in the table nothing is said"
    assert "weak soil" in held_back(braked, []), "where no finding names it"
    found = levels(braked, [Dimension("amplitude", "m/s2", "", False)], "A", why)
    assert [row[2:4] for row in found.rows] == [("0.100 to 0.200", "0 to 2.00"), ("≥ 0.300 to ≥ 0.600", "≥ 4.00 to ≥ 20.0")]
    assert why in found.note and "≥" not in levels(braked.assign(findings=""), [], "A").note
    (table,) = widths(braked)
    assert table.rows[0][2] == "0" and table.rows[1][2] == "≥ 10.0"


def test_ground_that_moves_at_a_place_is_told_whether_or_not_debris_comes() -> None:
    moves = RUNS.assign(house_ground_displacement=[0.0, 0.1, 0.75, 0.0, 0.0, math.nan])
    assert row_of(moves)["its ground moves (m)"] == "0.750" and row_of(moves, "road")["its ground moves (m)"] == "–"


def test_how_far_others_would_go_is_beside_the_run_out() -> None:
    runs = RUNS.assign(corominas_runout=11.0, runout=[0.0, 2.0, 3.0] * 2)
    runs["energy_line_runout"] = [70.0, 44.0, 29.0] * 2
    assert "3.00 m beyond the toe (energy line 29.0 m, mean of past slides 11.0 m)" in lead(runs, [])
    assert "3.00 m beyond the toe (energy line 29.0 m)" in lead(runs.assign(corominas_runout=0.0), []), (
        "no more than that it passes the toe"
    )
    assert "3.00 m beyond the toe (mean of past slides 11.0 m)" in lead(runs.assign(energy_line_runout=701.5), []), "without friction"
    assert "3.00 m beyond the toe (mean of past slides 11.0 m)" in lead(runs.assign(energy_line_runout=math.nan), [])
    assert "beyond the toe" not in lead(runs.assign(runout=0.0), [])


def test_debris_that_goes_farther_in_weaker_shaking_is_told() -> None:
    runs = RUNS.assign(runout=[21.0, 22.0, 4.0, 10.0, 14.0, 20.0])
    assert "debris runs at least 20.0 m beyond the toe, and 22.0 m at 2 m/s2 (0.204 g)" in lead(runs, [])
    assert "and ≥ 22.0 m at" in lead(runs.assign(at_rest=[1, 0, 1, 1, 1, 1], **MOVING), [])
    assert "and 22.0 m" not in lead(runs.assign(diverged=[1, 1, 0, 0, 0, 0]), []), "it has no run-out"
    assert " at 2 m/s2" not in lead(RUNS, []) + lead(runs.assign(runout=[20.0] * 6), [])
    drained = runs.assign(alternative=["drained", "drained", *["base"] * 4])
    assert "and 22.0 m" not in lead(drained, []), "that is not the slope as it is"


def test_a_place_to_which_debris_comes_nearer_in_weaker_shaking_says_so() -> None:
    weaker = RUNS.assign(runout=[0.0, 24.0, 4.0, 10.0, 14.0, 20.0], house_passed=[-30.0, -6.0, -26.0, -20.0, -16.0, -10.0])
    assert row_of(weaker)[SHORT] == "stops 10.0 m short; at 2 m/s2 (0.204 g): stops 6.00 m short"
    moving = weaker.assign(at_rest=[1, 0, 1, 1, 1, 1], **MOVING)
    assert row_of(moving)[SHORT].endswith("; at 2 m/s2 (0.204 g): unknown in 1 of 2 runs, still moving; 6.00 m short at the end")
    assert "at 2 m/s2" not in row_of(weaker.assign(house_reached=[0.0] * 5 + [1.0]))[SHORT] + row_of(RUNS)[SHORT]


def test_a_place_behind_the_crest_is_told_by_its_ground() -> None:
    track = {"track_passed": math.nan, "track_reached": 0.0, "track_depth": 0.0, "track_peak_depth": 0.0, "track_arrival": math.nan}
    runs = RUNS.assign(**track, track_peak_speed=0.0, track_impact_pressure=0.0, track_ground_displacement=11.0, reached_side="")
    runs = runs.assign(road_reached=0.0, road_passed=-20.0)
    assert row_of(runs, "track")[SHORT] == "no debris comes from above it" and row_of(runs, "track")["its ground moves (m)"] == "11.0"
    assert "it does not reach road or house; the ground moves 11.0 m at track" in lead(runs, [])


def test_weaker_shaking_is_asked_for_where_the_slope_fails_in_all_that_was_run() -> None:
    fails = RUNS.assign(collapse_class=["stable", "minor", *["collapse"] * 4])
    assert fails_in_weakest(fails) and not fails_in_weakest(fails.assign(collapse_class=["stable"] * 2 + ["collapse"] * 4))
    assert not fails_in_weakest(fails.assign(status="failed_unshaken")) and not fails_in_weakest(fails.drop(columns="amplitude"))


def test_the_design_level_is_answered_before_stronger_shaking() -> None:
    levels_of = (("2.0", "stable"), ("3.0", "stable"), ("6.0", "collapse"))
    table = pd.DataFrame([study_row("0.1", "100", level, collapse_class=name) for level, name in levels_of])

    def lines(design: float | None) -> Sequence[str]:
        return answer(table, [], load_scene("config/scenes/paper.yaml"), "A", lambda pattern: [], design=design).lead

    first, last = lines(3.001)
    assert first == "At 3 m/s² (0.306 g) no run fails." and last.startswith("At 6 m/s² (0.612 g) the slope collapses")
    assert lines(None) == lines(6.0) == [last]
    assert up_to(table, 1.0) is table, "nothing of it is done"


def test_failure_below_the_yield_acceleration_is_seen() -> None:
    weakest = RUNS["amplitude"].astype(float).min()
    assert not fails_below(RUNS, weakest) and not fails_below(RUNS.drop(columns="amplitude"), 99.0)
    failing = RUNS.loc[RUNS["collapse_class"] != "stable", "amplitude"].astype(float).min()
    assert fails_below(RUNS, failing + 0.1) and not fails_below(RUNS, failing)
    assert not fails_below(RUNS.assign(status="failed_unshaken"), 99.0)


def test_thin_debris_is_counted_and_a_finer_spacing_asked_for() -> None:
    thin = RUNS.assign(findings=["", "thin-debris", "few-particles thin-debris", "thin-layer", "", ""])
    assert has_thin_debris(thin).tolist() == [False, True, True, False, False, False] and not has_thin_debris(RUNS).any()
    assert surer_with(thin, [], checked=True) == "a finer spacing" and surer_with(RUNS, [], checked=True) == ""


def test_the_lower_limit_comes_first() -> None:
    assert _by_both("F", "1.23", "how", "Spencer 1.05", 1.23, 1.05) == ("F", "Spencer 1.05; 1.23 by SPH", "how")
    assert _by_both("F", "1.23", "how", "Spencer 1.25", 1.23, 1.25) == ("F", "1.23 by SPH; Spencer 1.25", "how")
    assert _by_both("F", "not searched", "sph fos", "Spencer 0.6", math.nan, 0.6) == ("F", "Spencer 0.6; not searched by SPH", "sph fos")
    assert _by_both("F", "not known", "too few rows", "Spencer 0.6", math.nan, 0.6) == ("F", "Spencer 0.6", "")


def test_how_wide_by_the_amplitude() -> None:
    (table,) = widths(RUNS)
    assert [tuple(row) for row in table.rows] == [
        ("2.0 (0.204 g)", "2", "0", "2.00", "2.00"),
        ("4.0 (0.408 g)", "4", "≥ 10.0", "≥ 20.0", "≥ 20.0"),
    ]
    assert "an error of up to 12%" in table.note
    assert widths(RUNS.iloc[:5]) == [], "too few to speak of shares"
    assert widths(RUNS.drop(columns=[name for name in RUNS if name.endswith("passed")])) == []


def test_how_often_with_a_fit_and_by_the_brackets_alone(tmp_path: Path) -> None:
    columns = annual_columns("1")
    row = {column.name: "" if column.dtype == "str" else math.nan for column in columns}
    fitted = {"collapse_class": "runout: road", "frequency": 1.24e-3, "frequency_lower": 4e-4, "frequency_upper": 3e-3, "beyond_last": 1e-4}
    bounds = {"collapse_class": "collapse", "frequency_least": 0.0, "frequency_most": 4.9e-4}
    write_csv(pd.DataFrame([row | fitted, row | bounds]), tmp_path / "fragility_annual.csv")
    assert yearly([str(tmp_path / "fragility_annual.csv")]) == [
        (
            "How often: road reached by debris",
            "0.0012 times a year (0.0004 to 0.003)",
            "fragility integrated over the hazard curve; shaking beyond the curve adds at most 0.0001",
        ),
        ("How often: class collapse", "0 to 0.00049 times a year", "bounds from the brackets, over the hazard curve"),
    ]
    ((_, words, _),) = yearly([str(tmp_path / "fragility_annual.csv")], falls=True)
    assert words.startswith("no frequency") and yearly([], falls=True) == [], "it falls without an earthquake"


def test_the_factor_at_the_residual_strength_by_both_methods() -> None:
    def rows(code: str, bishop: float, spencer: float, surface: str, runs: int) -> list[Row]:
        slices = finding("limit-equilibrium-residual", bishop=bishop, spencer=spencer, spencer_surface=surface, spencer_crack=0.0)
        return [Row(finding(code, S_R=0.5), runs, "a"), Row(slices, runs, "a")]

    weak = rows("fails-at-residual", 0.61, 0.58, "line", 4)
    strong = rows("stands-at-residual", 1.21, 1.20, "circle", 2)
    ((name, words, meant),) = at_residual(weak)
    assert (name, words) == (
        "Factor of safety at residual strength",
        "Bishop 0.61 (circle), Spencer 0.58 (not circular); by a static test of SPH the slope would stand in 0 of 4 runs",
    )
    assert "progressive failure" in meant
    by_slices = "Bishop 1.21 (circle), Spencer 1.20 (circle)"
    assert at_residual(strong)[0][1:] == (f"{by_slices}; by a static test of SPH the slope would stand in 2 of 2 runs", "")
    assert at_residual(weak + strong)[0][1] == "Spencer 0.58 to 1.20; by a static test of SPH the slope would stand in 2 of 6 runs"
    assert at_residual(weak[:1])[0][1] == "by a static test of SPH the slope would stand in 0 of 4 runs", "a scene without slices"
    assert at_residual([]) == []


def test_a_static_test_against_limit_equilibrium_is_not_certain() -> None:
    runs, rows = RUNS.assign(status="complete"), [Row(finding("stands-unshaken", spacing=1.0, run_spacing=1.0), 6, "a")]
    assert unshaken(runs, rows) == unshaken(runs, rows, 0, 1.08) == ("stands", "by a static test")
    words, how = unshaken(runs, rows, 0, 0.86)
    assert words == "not certain" and how.endswith("by Spencer's method its factor of safety is 0.86")


def test_the_lead_says_what_the_strongest_shaking_does() -> None:
    def said(*given: Any) -> str:
        return lead(*given)

    runs = RUNS.assign(status="complete", diverged=0, collapse_class=["stable", "stable", "stable", "minor", "collapse", "collapse"])
    bare = runs.drop(columns=[name for name in runs if name.startswith(("road", "house"))])
    fails = "At 4 m/s2 (0.408 g) 3 of 4 runs fail, 2 of them by collapse"
    assert said(bare, []) == f"{fails}; debris runs at least 20.0 m beyond the toe.", "one met the end of the box"
    assert said(bare.assign(reached_side=""), []) == f"{fails}; debris runs up to 20.0 m beyond the toe."
    moving = "; debris runs at least 20.0 m beyond the toe; soil still moves at the end of 4 runs, up to 12 % of the debris, which "
    on = bare.assign(reached_side="", at_rest=0, **MOVING)
    assert said(on, []) == f"{fails}{moving}needs some 7.5 s more to rest."
    on["time_to_rest"] = [math.nan] * 3 + [2.0] * 3
    assert said(on, []) == f"{fails}{moving}does not slow down yet in 1 of them."
    assert said(runs.assign(alternative=["base", "base", "base", "base", "drained", "drained"]), []) == (
        "As it is, at 4 m/s2 (0.408 g) 1 of 2 runs fails; debris runs up to 10.0 m beyond the toe; it does not reach road or house."
    ), "an alternative is no run of the slope as it is"
    assert said(bare.assign(alternative="drained"), []).startswith("With drained, at 4 m/s2 (0.408 g) 3 of 4 runs fail"), "so far"
    assert said(bare.assign(collapse_class="stable"), []) == "At 4 m/s2 (0.408 g) no run fails."
    held = said(bare.assign(collapse_class="stable"), [], "2 rows of particles in cover")
    assert held.endswith("no run fails, but weak soil is held back and might fail with more rows: 2 rows of particles in cover.")
    away = Row(finding("block-runs-away", value=0.417, bound=0.1, strength=0.39, residual=0.36), 3, "5")
    stable = runs.assign(collapse_class="stable").set_index(runs.index.astype(str))
    assert said(stable, [away]) == (
        "At 4 m/s2 (0.408 g) no run fails; by limit equilibrium it should fail: with Spencer's yield acceleration of 0.39 m/s2 (0.0398 g) "
        "a rigid block slips 0.417 m, strength is lost within 0.1 m, and at residual strength the factor of safety is 0.36. "
        "Run it with more rows of particles."
    )
    assert said(bare.set_index(bare.index.astype(str)), [away]).startswith(fails), "it does"
    assert said(bare.assign(runout=math.nan), []) == f"{fails}.", "a block has no run-out"
    assert said(bare[4:5], []) == "At 4 m/s2 (0.408 g) the slope collapses; debris runs up to 14.0 m beyond the toe."
    assert said(bare.drop(columns="amplitude")[:2], []) == "In this study no run fails."
    assert "every run diverged" in said(bare.assign(diverged=1), [])
    assert said(bare.assign(diverged=[0] * 5 + [1]), []).startswith(
        "At 4 m/s2 (0.408 g) 2 of 3 runs fail, 1 of them by collapse; 1 diverged;"
    )
    broken = finding("fails-unshaken", displaced_area=7.0, status="complete", spacing=1.0, run_spacing=1.0)
    assert said(bare, [Row(broken, 2, "a")]).startswith("The slope does not stand without shaking in 2 of 6 runs. At 4 m/s2")
    soft = bare.assign(status="failed_unshaken")
    assert said(soft, []).startswith("The slope does not stand without shaking. At")
    stands = Row(finding("stands-unshaken", spacing=1.0), 6, "a")
    assert said(soft, [stands]).startswith("The slope stands at peak strength, but soil yields and softens before the shaking, so the")
    assert said(soft, [stands, Row(broken, 2, "a")]).startswith("The slope does not stand without shaking in 2 of 6 runs. At")


def test_what_would_make_the_results_surer_is_said_in_a_line() -> None:
    """Longer runs where debris moves, a second spacing where none was run, then what the worst warnings ask for; at most three."""
    thin = Row(finding("thin-layer", "numerics.spacing", subject="berm", value=1.0, bound=4.0), 2, "a")
    wrong_way = Row(
        finding("record-polarity", "motion.factor", value=0.01, bound=0.03, as_recorded=0.01, reversed=0.03, strength=1.0), 2, "a"
    )
    few = Row(finding("few-particles", "numerics.spacing", value=4.0, bound=20.0, height=10.0), 2, "a")
    assert surer_with(RUNS, [few], checked=True) == ""
    assert surer_with(RUNS, [few, wrong_way, thin], checked=True) == "more rows of particles in berm, each record in both directions"
    assert surer_with(RUNS.assign(at_rest=0), [thin, thin], checked=False) == (
        "longer runs, runs at a second spacing, more rows of particles in berm"
    )
    assert surer_with(RUNS.assign(at_rest=0, diverged=1), [], checked=False) == "runs at a second spacing"
    assert surer_with(RUNS, [], True, assumed=True) == "shear tests of the slip at which strength is lost"
    assert surer_with(RUNS.assign(at_rest=0), [], True, differs=True, ended=True) == "a finer spacing, longer runs without an early stop"


def test_the_sentence_names_the_places_that_are_reached_and_those_that_go_along() -> None:
    said = lead(RUNS.assign(road_ground_displacement=13.7), [])
    assert "; it reaches road; the ground moves 13.7 m at road" in said and "house" not in said
    short = RUNS.assign(road_reached=0.0, reached_side="", road_passed=-20.0)
    assert "; it does not reach road or house" in lead(short, [])
    assert "reach" not in lead(short.assign(at_rest=0, **MOVING), []) + lead(short.assign(road_passed=-1.0), [])


def test_what_the_spacing_decides_counts_neither_way() -> None:
    """The weaker level reaches the house, but stands with other particles."""
    runs = RUNS.assign(
        status="complete",
        diverged=0,
        collapse_class=["stable", "collapse", "collapse", "collapse", "collapse", "collapse"],
        alternative=["base"] * 6,
        gamma=["1", "2", "1", "2", "3", "4"],
        runout=[0.0, 50.0, 4.0, 10.0, 14.0, 20.0],
        house_reached=[0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        displacement_magnitude=1.0,
        reached_side="",
    )
    again = pd.DataFrame({"run": [1, 4], "second_class": ["stable", "collapse"]})
    sure, unsure = (with_second_class(runs, each, ["amplitude", "gamma", "alternative"]) for each in (None, again))
    assert differs(unsure).tolist() == [False, True, False, False, False, False] and not differs(sure).any()
    assert row_of(sure)["reached from"] == "2 m/s2 (0.204 g)"
    assert row_of(unsure)["reached from"] == "4 m/s2 (0.408 g); 2 m/s2 (0.204 g), where the spacing decides"
    assert "and 50.0 m at 2 m/s2" in lead(sure, []) and "50.0 m" not in lead(unsure, [])
    assert farthest(sure) == "1" and farthest(unsure) == "5"
    failing = with_second_class(runs, again.assign(run=[4, 5]), ["amplitude", "gamma", "alternative"])
    assert "4 of 4 runs collapse, 1 of them at one of two spacings alone" in lead(failing, [])
    other = runs[1:2].assign(alternative="berm").set_index(pd.Index([6]))
    with_berm = with_second_class(pd.concat([runs, other]), again, ["amplitude", "gamma", "alternative"])
    assert differs(with_berm)[6], "nobody has repeated the alternative"
    held = with_second_class(pd.concat([runs, other.assign(collapse_class="stable")]), again, ["amplitude", "gamma", "alternative"])
    assert not differs(held)[6], "it stands, as the repeated run does"
