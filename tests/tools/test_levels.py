"""The critical amplitudes of a release with strength that is lost by slip, and what is said of them."""

from __future__ import annotations

import math
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


def spans(study: str, height: float, at_rows: float) -> dict[str, tuple[float, float]]:
    """Spans (m/s2) of the levels of a study with 50 mm or more, from a number of rows over the height on, and what is allowed."""
    table = read_levels()
    found = {}
    for (name, ratio, slip), rows in table.groupby(["study", "S_R", "slip_at_residual"], dropna=False):
        fine = rows[[height / spacing(case) >= at_rows - 0.01 for case in rows["case"]]]
        middle = 0.5 * (fine["lower"] + fine["upper"])
        if name == study and slip >= 0.05 and len(fine) > 1:
            found[f"{ratio} {slip}"] = (float(middle.max() - middle.min()), max(0.03 * float(middle.mean()), 0.03))
    return found


def spacing(case: str) -> float:
    """Spacing (m) in the name of a case; infinite in that of another case."""
    number = case.removesuffix(" m")
    return 5.0 / 3.0 if number == "5/3" else float(number) if number != case and number.replace(".", "").isdigit() else math.inf


@pytest.mark.parametrize(("study", "height", "searches"), [("slope_on_rock", 25.0, 3), ("stiff_clay", 15.0, 2)])
def test_with_fifty_millimetres_or_more_the_level_does_not_know_the_spacing(study: str, height: float, searches: int) -> None:
    """Targets written before the runs: within 3 %, or 0.003 g where that is more, from 20 rows over the height down."""
    found = {
        name: span for name, span in spans(study, height, 10.0 if study == "stiff_clay" else 20.0).items() if not name.startswith("0.5 ")
    }
    assert len(found) == searches
    for name, (span, allowed) in found.items():
        assert span <= allowed, name


@pytest.mark.xfail(
    strict=True, reason="S_R 0.50 does not run out: A passes the limit of the class without a step (docs/model/softening.md)"
)
def test_a_slope_that_does_not_run_out_has_such_a_level_as_well() -> None:
    span, allowed = spans("slope_on_rock", 25.0, 20.0)["0.5 0.05"]
    assert span <= allowed


def test_the_lines_hold_every_search() -> None:
    table = read_levels()
    shown = sum(bool(cell) for line in slip_level_lines() for cell in line[3:])
    assert shown == table["slip_at_residual"].notna().sum()
    assert len(list(slip_choice_lines())) == table["slip_at_residual"].isna().sum()
