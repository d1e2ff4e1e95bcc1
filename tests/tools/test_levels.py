"""The critical amplitudes of a release with strength that is lost by slip, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from tools.levels import SLIP, STUDIES, levels, read_levels
from tools.reference import slip_choice_lines, slip_level_lines


def test_the_searches_of_a_folder_make_one_table(tmp_path: Path) -> None:
    for number, study in enumerate(STUDIES):
        folder = tmp_path / study / "own" / "trigger"
        folder.mkdir(parents=True)
        row = {"case": "1 m", "lower": 1.0 + number, "upper": 2.0 + number} | ({SLIP: 0.05} if number < 2 else {})
        pd.DataFrame([row]).to_csv(folder / "trigger.csv", index=False)
    found = levels(tmp_path)
    assert found["study"].tolist() == list(STUDIES) and found["lower"].tolist() == [1.0, 2.0, 3.0]
    assert found["slip_at_residual"].isna().tolist() == [False, False, True]
    (tmp_path / STUDIES[1] / "own" / "trigger" / "trigger.csv").unlink()
    with pytest.raises(ValueError, match="0 searches"):
        levels(tmp_path)


ROWS = 15
"""Rows of particles over the height from which on the level is to stand still."""


def spacing(case: str) -> float:
    """Spacing (m) that a case is named after."""
    number = case.removesuffix(" m")
    return 5.0 / 3.0 if number == "5/3" else float(number)


def spans(study: str, height: float) -> dict[tuple[float, float], tuple[float, float]]:
    """Spans of the levels of a study (m/s2) with 50 mm or more from ``ROWS`` on, and what is allowed, by S_R and slip (m).

    Targets written before the runs: within 3 %, or 0.003 g where that is more.
    """
    table, found = read_levels(), {}
    table = table[(table["study"] == study) & (table["slip_at_residual"] >= 0.05)]
    for (ratio, slip), rows in table[height / table["case"].map(spacing) > ROWS - 0.5].groupby(["S_R", "slip_at_residual"], dropna=False):
        middle = 0.5 * (rows["lower"] + rows["upper"])
        assert len(rows) >= 3, "three spacings"
        found[ratio, slip] = (float(middle.max() - middle.min()), max(0.03 * float(middle.mean()), 0.03))
    return found


@pytest.mark.parametrize(("study", "height", "searches"), [("slope_on_rock", 25.0, 4), ("stiff_clay", 15.0, 2)])
def test_with_fifty_millimetres_or_more_the_level_does_not_know_the_spacing(study: str, height: float, searches: int) -> None:
    found = spans(study, height)
    assert len(found) == searches
    for key, (span, allowed) in found.items():
        assert span <= allowed, key


def test_the_lines_hold_every_search() -> None:
    table = read_levels()
    shown = sum(bool(cell) for line in slip_level_lines(table) for cell in line[3:])
    assert shown == table["slip_at_residual"].notna().sum()
    assert len(list(slip_choice_lines(table))) == table["slip_at_residual"].isna().sum()
