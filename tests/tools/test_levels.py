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
    with pytest.raises(ValueError, match="0 searches, one is needed"):
        levels(tmp_path)


def test_with_fifty_millimetres_the_level_does_not_know_the_spacing() -> None:
    """Targets written before the runs: within 3 % from 1.25 m down, or 0.003 g where that is more."""
    table = read_levels()
    for study, rows in table[table["slip_at_residual"] == 0.05].groupby("study"):
        middle = 0.5 * (rows["lower"] + rows["upper"])
        assert len(rows) >= 3 and middle.max() - middle.min() <= max(0.03 * middle.mean(), 0.03), study


def test_the_lines_hold_every_search() -> None:
    table = read_levels()
    shown = sum(bool(cell) for line in slip_level_lines() for cell in line[2:])
    assert shown == table["slip_at_residual"].notna().sum()
    assert len(list(slip_choice_lines())) == table["slip_at_residual"].isna().sum()
