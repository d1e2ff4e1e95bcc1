"""The twelve claims on hand-made studies, decided in every direction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from synthetic import study_of, study_row

from sph.experiments.paper.claims import CLAIMS, ClaimSettings, decide_claims
from sph.study.tables import write_csv

Point = tuple[str, str, str]
Changes = dict[Point, dict[str, Any] | None]
S10, S25, S50, S25_SLOW = (("0.10", "100", "6.0"), ("0.25", "100", "6.0"), ("0.50", "100", "6.0"), ("0.25", "1", "6.0"))


def moved(total: float, at_end_of_shaking: float, onset: float, arrest: float, speed: float, name: str, **more: Any) -> dict[str, Any]:
    """Metrics of a run in which A goes straight down."""
    return {
        "displacement_magnitude": total,
        "displacement_vertical": -total,
        "displacement_horizontal": 0.0,
        "displacement_magnitude_end_of_shaking": at_end_of_shaking,
        "displacement_vertical_end_of_shaking": -at_end_of_shaking,
        "displacement_horizontal_end_of_shaking": 0.0,
        "onset_time": onset,
        "arrest_time": arrest,
        "probe_peak_speed": speed,
        "collapse_class": name,
        "first_failure_time": 4.01,
        **more,
    }


AS_IN_THE_PAPER: dict[Point, dict[str, Any]] = {
    S10: moved(25.0, 24.8, 4.4, 9.9, 6.0, "collapse", failed_fraction=0.99, runout=30.0, runout_over_height=1.2),
    S25: moved(10.0, 9.8, 4.6, 9.8, 3.0, "collapse", failed_fraction=0.9, runout=12.0, runout_over_height=0.48),
    S50: moved(1.0, 0.95, 5.0, 9.7, 0.4, "damaged", failed_fraction=0.6, runout=0.6, runout_over_height=0.024),
    S25_SLOW: moved(1.2, 0.1, 10.5, math.nan, 0.5, "damaged", failed_fraction=0.8, runout=1.5, runout_over_height=0.06),
    ("0.25", "100", "4.0"): {"collapse_class": "minor"},
    ("0.25", "100", "5.0"): {"collapse_class": "collapse"},
}


def cell(claims: pd.DataFrame, number: int, column: str) -> str:
    return str(claims.loc[number, column])


def decide(changes: Changes | None = None, settings: ClaimSettings | None = None) -> pd.DataFrame:
    """Claims by number for the study above with some metrics changed; None takes the run out."""
    runs = {point: dict(metrics) for point, metrics in AS_IN_THE_PAPER.items()}
    for point, metrics in (changes or {}).items():
        if metrics is None:
            del runs[point]
        else:
            runs[point] = runs.get(point, {}) | metrics
    study = study_of([study_row(*point, **metrics) for point, metrics in runs.items()])
    return decide_claims(study, settings).set_index("claim")


def test_every_claim_holds_on_a_study_as_in_the_paper() -> None:
    claims = decide()
    no_test = {4: "holds, fitted", 5: "true by construction", 9: "holds, fitted"}
    expected = {number: "holds" for number in range(1, 13)} | {11: "not yet"} | no_test
    assert claims["verdict"].to_dict() == expected
    assert [claim.number for claim in CLAIMS] == list(range(1, 13))
    assert not claims["test"].str.contains("[{}]").any()


FAILURES: list[tuple[int, Changes, str]] = [
    (1, {S25: {"displacement_magnitude": 26.0}}, "26.00 m"),
    (1, {S50: {"displacement_magnitude": 10.0}}, "10.00 m"),
    (2, {S10: {"failed_fraction": 0.49}}, "49 % failed"),
    (2, {S10: {"runout_over_height": 0.49}}, "0.49 H"),
    (2, {S10: {"collapse_class": "damaged"}}, "damaged"),
    (3, {S50: {"collapse_class": "collapse"}}, "collapse"),
    (3, {S50: {"collapse_class": "stable"}}, "stable"),
    (3, {S50: {"runout_over_height": 0.5}}, "0.50 H"),
    (4, {S25: {"collapse_class": "damaged"}}, "γ 100: damaged"),
    (4, {S25_SLOW: {"collapse_class": "collapse"}}, "γ 1: collapse"),
    (4, {S25_SLOW: {"displacement_magnitude": 2.01}}, "2.01 m"),
    (5, {S25: {"first_failure_time": 4.02}}, "spread 0.0100 s"),
    (5, {S25: {"first_failure_time": math.nan}}, "nan"),
    (6, {S50: {"onset_time": 4.4}}, "4.40 s"),
    (6, {S10: {"onset_time": math.nan}}, "never"),
    (7, {S50: {"probe_peak_speed": 3.0}}, "3.00 m/s"),
    (8, {S25: {"displacement_magnitude": 0.9}}, "0.90 m"),
    (8, {S25: {"probe_peak_speed": 6.1}}, "6.10 m/s"),
    (8, {S25: {"onset_time": 5.1}}, "5.10 s"),
    (9, {S25_SLOW: {"displacement_vertical_end_of_shaking": -0.7}}, "41.7 % after"),
    (9, {S25_SLOW: {"onset_time": math.nan}}, "does not move"),
    (10, {S25: {"displacement_vertical_end_of_shaking": -9.4}}, "6.0 % after"),
    (10, {S25: {"onset_time": 2.9}}, "onset 2.90 s"),
    (10, {S25: {"onset_time": math.nan}}, "does not move"),
    (12, {S10: {"still_moving": 1}}, "still moving"),
    (12, {S25: {"runout": 0.0}}, "run-out 0.0 m"),
]


def test_a_runout_that_met_an_end_of_the_box_is_a_lower_bound() -> None:
    free, bounded = decide({}), decide({S10: {"reached_side": "front"}})
    for number, words in {
        1: "S_R 0.10, γ 100: ≥ 25.00 m",
        8: "≥ 25.00 m",
        2: "run-out ≥ 30.0 m (≥ 1.20 H), up to an end",
        12: "≥ 30.0 m",
    }.items():
        assert "≥" not in cell(free, number, "measured") and words in cell(bounded, number, "measured")
        # A bound is enough for what is larger than something, but it is no travel distance.
        assert cell(bounded, number, "verdict") == ("holds at least" if number == 12 else "holds")
    assert cell(decide({S10: {"reached_side": "front", "still_moving": 1}}), 12, "verdict") == "fails"


@pytest.mark.parametrize(("number", "changes", "measured"), FAILURES)
def test_each_claim_can_fail_and_shows_the_number(number: int, changes: Changes, measured: str) -> None:
    claims = decide(changes)
    assert cell(claims, number, "verdict") == "fails"
    assert measured in cell(claims, number, "measured")


def test_failures_cover_every_claim_but_the_trigger() -> None:
    assert {number for number, _, _ in FAILURES} == set(range(1, 13)) - {11}


def test_the_vertical_motion_of_a_decides_as_in_figure_7() -> None:
    """What it goes forward takes no part."""
    claims = decide({S25: {"displacement_horizontal": 8.0, "displacement_horizontal_end_of_shaking": 4.0}})
    assert cell(claims, 10, "verdict") == "holds" and "A sinks 9.80 m by the end of the shaking, 10.00 m in all, 2.0 %" in cell(
        claims, 10, "measured"
    )
    assert "40.0 % of its displacement" in cell(claims, 10, "measured")


def test_an_arrest_soon_after_the_shaking_is_shown_beside_the_share() -> None:
    claims = decide({S25: {"arrest_time": 10.8}})
    assert cell(claims, 10, "verdict") == "holds" and "arrest 10.80 s" in cell(claims, 10, "measured")


@pytest.mark.parametrize(
    ("point", "uncovered"),
    [(S10, {1, 2, 5, 6, 7, 8, 12}), (S25, {1, 4, 5, 6, 7, 8, 10, 12}), (S50, {1, 3, 5, 6, 7, 8, 12}), (S25_SLOW, {4, 9})],
)
def test_a_missing_or_diverged_run_leaves_exactly_its_claims_uncovered(point: Point, uncovered: set[int]) -> None:
    for change, reason in ((None, "no run with"), ({"status": "diverged", "diverged": 1}, "diverged")):
        claims = decide({point: change})
        found = claims[claims["verdict"] == "not covered"]
        assert set(found.index) == uncovered
        assert found["measured"].str.contains(reason).all()


def test_the_reference_amplitude_is_an_argument() -> None:
    claims = decide(settings=ClaimSettings(amplitude=7.0))
    assert claims["verdict"].drop(11).eq("not covered").all() and "at 7 m/s²" in cell(claims, 1, "test")


def test_thresholds_are_arguments_and_shown_in_the_test() -> None:
    claims = decide(settings=ClaimSettings(most=0.95))
    assert cell(claims, 9, "verdict") == "fails" and "more than 0.95 of" in cell(claims, 9, "test")
    claims = decide(settings=ClaimSettings(slight=0.1))
    assert cell(claims, 4, "verdict") == "fails" and "at most 0.1 of" in cell(claims, 4, "test")


def test_displacement_during_the_shaking_does_not_decide_the_collapse_with_gamma_100() -> None:
    # Fig. 5 shows the slopes at the end of the run: what A does by the end of the shaking is no part of it.
    claims = decide({S25_SLOW: {"displacement_magnitude_end_of_shaking": 9.9}, S25: {"displacement_magnitude_end_of_shaking": 0.1}})
    assert cell(claims, 4, "verdict") == "holds, fitted"


def test_trigger_bracket() -> None:
    assert cell(decide(), 11, "measured") == "from the grid only: S_R 0.25: no collapse up to 4 m/s², collapse from 5 m/s²"
    never = decide({("0.25", "100", "5.0"): {"collapse_class": "stable"}, S25: {"collapse_class": "minor"}})
    assert cell(never, 11, "measured").endswith("S_R 0.25: no collapse up to 6 m/s²")
    always = decide({("0.25", "100", "4.0"): {"collapse_class": "collapse"}})
    assert cell(always, 11, "measured").endswith("S_R 0.25: collapse already at 4 m/s²")
    assert {cell(table, 11, "verdict") for table in (never, always)} == {"not yet"}
    single = decide({("0.25", "100", "4.0"): None, ("0.25", "100", "5.0"): None})
    assert cell(single, 11, "verdict") == "not covered"


def test_no_failure_at_all_and_no_collapse_at_all_are_not_covered() -> None:
    unfailed: Changes = {point: {"first_failure_time": math.nan} for point in (S10, S25, S50)}
    assert cell(decide(unfailed), 5, "verdict") == "not covered"
    standing: Changes = {point: {"collapse_class": "stable"} for point in (S10, S25, S50)}
    assert cell(decide(standing), 12, "verdict") == "not covered"


def test_the_second_reading_of_figure_7_is_shown_but_does_not_decide() -> None:
    other: Changes = {("0.35", "1", "6.0"): moved(4.0, 3.9, 5.5, 14.0, 1.0, "collapse")}
    claims = decide(other)
    assert cell(claims, 9, "verdict") == "holds, fitted"
    assert "S_R 0.35, γ 1: A sinks 3.90 m by the end of the shaking" in cell(claims, 9, "measured")


def test_the_file_holds_the_table(tmp_path: Path) -> None:
    study = study_of([study_row(*point, **metrics) for point, metrics in AS_IN_THE_PAPER.items()])
    claims = decide_claims(study)
    write_csv(claims, tmp_path / "claims.csv")
    back = pd.read_csv(tmp_path / "claims.csv")
    assert list(back.columns) == ["claim", "statement", "test", "measured", "verdict"]
    pd.testing.assert_frame_equal(back, claims, check_dtype=False)
