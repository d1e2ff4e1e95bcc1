"""The client's questions on the first screen: how far past a place, how wide, how often."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from sph.checks.cover_rows import SCATTER
from sph.checks.finding import finding
from sph.experiments.trigger.annual import annual_columns
from sph.page.answer import held_back, lead
from sph.page.facts import at_places, at_residual, unshaken, yearly
from sph.page.levels import levels, widths
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


def test_what_the_debris_does_at_a_place() -> None:
    assert at_places(RUNS) == [
        (
            "At road",
            "reached in 2 of 6 runs, first 2.5 s after the shaking begins, up to 2.10 m deep; its fastest particle 4.2 m/s; "
            "mean impact pressure over its depth 31 kPa at most",
            "",
        ),
        ("At house", "not reached in 6 runs", "the debris that goes farthest stops 10.0 m short of it"),
    ]
    assert [fact[1:] for fact in at_places(LOST)] == [("not reached in 0 runs", "")] * 2
    stand = RUNS.assign(collapse_class="minor", runout=0.0, house_passed=-30.0)
    assert at_places(stand)[1][2] == "no soil that fails comes within 30.0 m of it", "there is no debris to stop"


def test_debris_of_a_slope_that_falls_unshaken_comes_at_no_time_of_the_shaking() -> None:
    falls = ["complete"] * 5 + ["failed_unshaken"]
    road, _ = at_places(RUNS.assign(status=falls, road_arrival=[math.nan] * 4 + [5.5, 1.0]))
    assert "first 2.5 s after the shaking" in road[1]
    road, _ = at_places(RUNS.assign(status="failed_unshaken"))
    assert road[1].startswith("reached in 2 of 6 runs, up to 2.10 m deep")


def test_a_place_within_the_error_of_the_run_out_may_be_reached() -> None:
    near = RUNS.assign(house_passed=RUNS["runout"] - 22.3)
    (_, words, how) = next(fact for fact in at_places(near) if fact[0] == "At house")
    assert words == "not reached in 6 runs"
    assert how.endswith("stops 2.30 m short of it; that is within the error of a run-out (12 %), so it may be reached")
    farther = RUNS.assign(house_passed=RUNS["runout"] - 22.5)
    assert all("may be reached" not in how for _, _, how in at_places(farther))
    unknown = near.assign(expected_runout_error=math.nan)
    assert any(f"({SCATTER:.0%}".replace("%", " %") in how for _, _, how in at_places(unknown)), "that of covers where none is known"


def test_a_place_that_moving_debris_may_still_reach_is_not_out_of_reach() -> None:
    road, house = at_places(RUNS.assign(at_rest=[1, 1, 1, 0, 0, 0], **MOVING))
    assert house == (
        "At house",
        "not reached in 3 runs; not yet in 3 runs, whose debris still moves at the end",
        "the debris is at least 10.0 m short of it then, and moves on: up to 12 % of the debris, which needs some 7.5 s more to rest",
    )
    assert road[1].endswith("at most; not yet in 1 run, whose debris still moves at the end")
    _, house = at_places(RUNS.assign(at_rest=0, **MOVING))
    assert house[1] == "not yet in 6 runs, whose debris still moves at the end" and "stops" not in house[2]
    _, house = at_places(RUNS.assign(at_rest=[1, 1, 1, 0, 0, 0], **MOVING, findings=["layer-held"] * 2 + [""] * 4), "why")
    assert house[1].startswith("not reached in 1 run; not yet in 3 runs") and "stops" not in house[2]
    _, house = at_places(RUNS.assign(at_rest=0, **MOVING, findings="layer-held"), "why")
    assert house[1].startswith("unknown in 6 runs") and "stops" not in house[2], "braked soil moves, too"


def test_a_place_that_braked_debris_does_not_reach_is_not_out_of_reach() -> None:
    """It is unknown, whatever else was run."""
    why = "2 rows of particles in cover"
    road, house = at_places(RUNS.assign(findings="few-particles weak-on-strong"), why)
    assert road[1].startswith("reached in 2 of 6 runs, ") and road[1].endswith(f"; unknown in 4 runs, whose weak soil is held back: {why}")
    assert house == (
        "At house",
        f"unknown in 6 runs, whose weak soil is held back: {why}",
        "the debris comes to 10.0 m of it",
    )
    road, house = at_places(RUNS.assign(findings=["", "", "", "layer-held", "", ""]), why)
    assert road[1].endswith(f"at most; unknown in 1 run, whose weak soil is held back: {why}")
    assert house[1] == f"not reached in 5 runs; unknown in 1 run, whose weak soil is held back: {why}"
    assert house[2] == "the debris comes to 10.0 m of it"
    assert [fact[1:] for fact in at_places(LOST.assign(findings="layer-held"), why)] == [("not reached in 0 runs", "")] * 2


def test_a_place_below_a_cover_that_stands_for_lack_of_rows_is_not_out_of_reach() -> None:
    """Of runs that came down it is."""
    late = RUNS.assign(findings="cover-late", diverged=0, collapse_class="stable")
    assert at_places(late)[1][1] == "unknown in 6 runs, whose weak soil is held back"
    assert at_places(late.assign(collapse_class="collapse"))[1][1] == "not reached in 6 runs"


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
    _, (_, told, _) = at_places(RUNS.assign(house_ground_displacement=[0.0, 0.1, 0.75, 0.0, 0.0, math.nan]))
    assert told == "not reached in 6 runs; the ground it stands on moves by up to 0.750 m"


def test_how_far_others_would_go_is_beside_the_run_outs() -> None:
    runs = RUNS.assign(collapse_class="stable", displacement_magnitude=0.1, newmark_displacement=math.nan)
    assert "Corominas" not in levels(runs, [], "A").note
    others = runs.assign(energy_line_runout=[70.0, 44.0, 40.0] * 2, corominas_runout=11.0)
    note = levels(others.assign(runout=[0.0, 2.0, 3.0] * 2), [], "A").note
    assert "40.0 to 44.0 m by the energy line" in note and "11.0 m by Corominas" in note, "without runs whose debris stays above the toe"
    assert "Corominas" not in levels(others.assign(runout=0.0), [], "A").note


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
        "Bishop 0.61 (circle), Spencer 0.58 (not circular); in SPH it stands in 0 of 4 runs",
    )
    assert "progressive failure" in meant
    assert at_residual(strong)[0][1:] == ("Bishop 1.21 (circle), Spencer 1.20 (circle); in SPH it stands in 2 of 2 runs", "")
    assert at_residual(weak + strong)[0][1] == "Spencer 0.58 to 1.20; in SPH it stands in 2 of 6 runs"
    assert at_residual(weak[:1])[0][1] == "in SPH it stands in 0 of 4 runs", "a scene without slices"
    assert at_residual([]) == []


def test_a_static_test_against_limit_equilibrium_is_not_certain() -> None:
    runs, rows = RUNS.assign(status="complete"), [Row(finding("stands-unshaken", spacing=1.0, run_spacing=1.0), 6, "a")]
    assert unshaken(runs, rows) == unshaken(runs, rows, 0, 1.08) == ("stands", "by a static test")
    words, how = unshaken(runs, rows, 0, 0.86)
    assert words == "not certain" and how.endswith("by Spencer's method its factor of safety is 0.86")


def test_the_lead_says_what_the_strongest_shaking_does() -> None:
    def said(*given: Any) -> str:
        """The lead and what stands below it."""
        return " ".join(lead(*given))

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
    assert said(runs, []).endswith(
        ". road: reached in 2 of 4 runs, first 2.5 s after the shaking begins, up to 2.10 m deep; its fastest particle 4.2 m/s; "
        "mean impact pressure over its depth 31 kPa at most. "
        "house: not reached in 4 runs; the debris that goes farthest stops 10.0 m short of it."
    )
    assert said(runs.assign(alternative=["base", "base", "base", "base", "drained", "drained"]), []) == (
        "As it is, at 4 m/s2 (0.408 g) 1 of 2 runs fails; debris runs up to 10.0 m beyond the toe. "
        "road: not reached in 2 runs; the debris that goes farthest stops 2.00 m short of it. "
        "house: not reached in 2 runs; the debris that goes farthest stops 20.0 m short of it."
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
        "Run it with more rows of particles. "
        "road: not known, as long as runs stand that should fail. house: not known, as long as runs stand that should fail."
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
