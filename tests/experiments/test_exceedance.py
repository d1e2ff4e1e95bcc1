"""Shares of motions that exceed a length, counted by hand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.exceedance import exceedance, exceedance_columns, width_columns, width_within, widths
from sph.experiments.trigger.figures_reach import figure_reach
from sph.measures.metrics import UNDETERMINED
from sph.scene.schema import Scene
from sph.study.dimensions import Dimension
from sph.study.tables import read_csv, write_csv

SEARCHED = Searched((Dimension("amplitude", "m/s2", "", False), Dimension("seed", "-", "", False)), "amplitude")
NOT_KNOWN = math.nan


def points(runouts: dict[str, list[float]], case: str = "as it is") -> pd.DataFrame:
    """Runs of motions 1, 2, ... at amplitudes; those without a run-out diverged, displacements are half of it."""
    rows = [
        {
            "case": case, "amplitude": amplitude, "seed": str(seed), "still_moving": int(math.isnan(runout) or seed == 2),
            "collapse_class": UNDETERMINED if math.isnan(runout) else "damaged", "runout": runout, "displacement_magnitude": 0.5 * runout,
            "findings": "",
        }
        for amplitude, values in runouts.items()
        for seed, runout in enumerate(values, start=1)
    ]  # fmt: skip
    return pd.DataFrame(rows)


FOUR = points({"9": [4.0, NOT_KNOWN, 2.0, 8.0], "1": [0.0, 0.0, 2.0, 0.0], "5": [1.0, 2.0]})
"""Four motions at 1 and 9 m/s2, two of them at 5 between."""


def test_the_shares_are_those_counted(tmp_path: Path) -> None:
    table = exceedance(FOUR, SEARCHED)
    write_csv(table, tmp_path / "exceedance.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "exceedance.csv", exceedance_columns("1"), "the exceedance"), table)
    assert list(dict.fromkeys(table["intensity"])) == [1.0, 9.0], "not all motions were run at 5"
    runout = table[table["metric"] == "runout"]
    strong = runout[runout["intensity"] == 9.0]
    assert strong["exceeded"].tolist() == [0.0, 2.0, 4.0, 8.0] and strong["exceeding"].tolist() == [3, 2, 1, 0]
    assert strong["share_lower"].tolist() == [0.75, 0.5, 0.25, 0.0] and strong["share_upper"].tolist() == [1.0, 0.75, 0.5, 0.25]
    assert set(strong["motions"]) == {4} and set(strong["diverged"]) == {1} and set(strong["still_moving"]) == {0}
    weak = runout[runout["intensity"] == 1.0]
    assert weak["exceeded"].tolist() == [0.0, 2.0] and weak["exceeding"].tolist() == [1, 0] and set(weak["still_moving"]) == {1}
    displacement = table[(table["metric"] == "displacement_magnitude") & (table["intensity"] == 9.0)]
    assert displacement["exceeded"].tolist() == [0.0, 1.0, 2.0, 4.0]


def test_what_is_braked_may_go_further() -> None:
    """The debris of the third motion, 2 m, counts for every length as if it might exceed it; its depth and width are not known either."""
    braked = FOUR.assign(findings=np.where(FOUR["seed"] == "3", "weak-on-strong", "cover-rows"))
    runout = exceedance(braked, SEARCHED).query("metric == 'runout' and intensity == 9.0")
    assert runout["share_lower"].tolist() == [0.75, 0.5, 0.25, 0.0] and runout["share_upper"].tolist() == [1.0, 1.0, 0.75, 0.5]
    assert set(runout["braked"]) == {1} and set(runout["diverged"]) == {1}
    weak, strong = widths(braked, SEARCHED).to_dict("records")
    assert (weak["width_50"], weak["width_84"], weak["widest"], weak["braked"]) == (0.0, math.inf, 2.0, 1)
    assert (strong["width_50"], strong["width_84"], strong["widest"]) == (8.0, math.inf, 8.0)


def test_what_all_diverged_may_be_any() -> None:
    table = exceedance(points({"1": [1.0, 2.0], "9": [NOT_KNOWN, NOT_KNOWN]}), SEARCHED)
    (row,) = table[(table["intensity"] == 9.0) & (table["metric"] == "runout")].to_dict("records")
    assert (row["exceeded"], row["share_lower"], row["share_upper"]) == (0.0, 0.0, 1.0)


def test_a_shape_without_a_slope_has_no_run_out() -> None:
    table = exceedance(FOUR.assign(runout=math.nan), SEARCHED)
    assert set(table["metric"]) == {"displacement_magnitude"}


def test_the_figure_counts_and_stands_over_the_section(small_slope: Any) -> None:
    scene: Scene = small_slope({"water": {"pressure": "by_place", "level": 12.0}})
    figure = figure_reach(exceedance(FOUR, SEARCHED), SEARCHED, {"as it is": scene}, "note")
    runout, displacement, section = figure.axes
    assert runout.get_xlabel() == "run-out (m)" and displacement.get_xlabel() == "displacement of the probe (m)"
    (legend,) = figure.subfigs[0].legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "1 m/s²: 4 motions, 1 still moving, may go farther",
        "9 m/s²: 4 motions, 1 diverged (band)",
    ]
    (water,) = (drawn for drawn in section.lines if drawn.get_color() == "tab:blue")
    assert set(water.get_ydata()) == {12.0} and [text.get_text() for text in section.texts].count("water") == 1
    (above,) = section.child_axes
    toe, line = scene.geometry.toe[0], above.lines[1]
    assert line.get_xdata().tolist() == [toe, toe - 2.0, toe - 4.0, toe - 8.0, 0.0]
    assert line.get_ydata().tolist() == [0.75, 0.5, 0.25, 0.0, 0.0]
    figure.canvas.draw()
    shown, there = (ax.transData.transform((toe, 0.0))[0] for ax in (section, above))
    assert shown == pytest.approx(there, abs=0.5), "pixels: one place is above itself"


def test_nothing_to_draw_is_refused() -> None:
    with pytest.raises(ValueError, match="no row"):
        figure_reach(exceedance(FOUR.iloc[:0], SEARCHED), SEARCHED, {})


def test_widths_are_those_that_enough_runs_do_not_pass(tmp_path: Path) -> None:
    table = widths(FOUR, SEARCHED)
    write_csv(table, tmp_path / "widths.csv")
    pd.testing.assert_frame_equal(read_csv(tmp_path / "widths.csv", width_columns("1"), "widths"), table)
    weak, strong = table.to_dict("records")
    assert (weak["intensity"], weak["width_50"], weak["width_84"], weak["width_95"], weak["widest"]) == (1.0, 0.0, 2.0, 2.0, 2.0)
    assert (strong["width_50"], strong["width_84"], strong["widest"], strong["diverged"]) == (4.0, math.inf, 8.0, 1)
    assert (weak["still_moving"], strong["still_moving"]) == (1, 0), "the second motion; at 9 m/s2 it is the one that diverged"


@pytest.mark.parametrize(("share", "width"), [(0.5, 10.0), (0.84, 17.0), (0.95, 19.0), (1.0, 20.0)])
def test_a_width_of_twenty_runs(share: float, width: float) -> None:
    assert width_within(np.random.default_rng(1).permutation(np.arange(1.0, 21.0)), share) == width


def test_the_depth_at_a_place_is_counted_as_a_length() -> None:
    table = exceedance(FOUR.assign(road_passed=1.0, road_depth=[0.5, NOT_KNOWN, 0.0, 1.5, 0, 0, 0, 0, 0, 0]), SEARCHED)
    deep = table[(table["metric"] == "road_depth") & (table["intensity"] == 9.0)]
    assert deep["exceeded"].tolist() == [0.0, 0.5, 1.5] and deep["share_lower"].tolist() == [0.5, 0.25, 0.0]
