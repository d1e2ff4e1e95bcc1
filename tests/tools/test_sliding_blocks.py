"""Ratios of sliding blocks and slopes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sph.scene.configuration import merge
from sph.scene.natural_periods import natural_frequency
from sph.scene.schema import make_scene
from tools.sliding_blocks import ROWS, cause_rows, column_motion, compared, main, read_blocks, scene_of, spread, spread_rows
from tools.slow_sine import damping_at


def table(*pairs: tuple[float, float]) -> pd.DataFrame:
    """A table of rigid block (m) and slope (m)."""
    row: dict[str, object] = {"slope": "stiff_clay", "strength": "peak strength kept", "record": "a.csv", "peak_ratio": 3.0}
    row |= {"yield_acceleration": 1.0, "arias_intensity": 1.0, "peak_velocity": 0.1, "status": "complete"}
    rows = [
        row | {"newmark_displacement": block, "column_displacement": 2.0 * block, "overload": 1.5, "displacement": slope}
        for block, slope in pairs
    ]
    return pd.DataFrame(rows)[[column.name for column in ROWS]]


def test_mean_and_scatter_are_those_of_the_logarithms() -> None:
    """A half and two: geometric mean 1, and standard deviation sqrt(2) ln 2."""
    found = spread(np.array([0.5, 2.0]))
    assert found == pytest.approx((2, 1.0, math.sqrt(2.0) * math.log(2.0), 0.5, 2.0))
    assert spread(np.array([0.5])).pairs == 1 and math.isnan(spread(np.array([0.5])).scatter) and spread(np.array([])).pairs == 0


def test_slopes_that_run_out_and_those_that_hardly_move_are_not_compared() -> None:
    kept = compared(table((0.1, 0.2), (0.1, 3.0), (1e-4, 0.2), (0.1, 1e-4)))
    assert kept["ratio"].tolist() == [0.5]


def test_the_rows_name_what_they_leave_out() -> None:
    base, column = spread_rows(table((0.1, 0.2), (0.4, 0.2), (0.1, 3.0)))
    assert base == ("stiff_clay", "peak strength kept", "under the motion of the base", "2", "1", "1.00", "0.98", "0.50 to 2.00", "")
    assert column[3:] == ("2", "1", "2.00", "0.98", "1.00 to 4.00", "1.5")


def test_causes_are_correlated_by_their_logarithms() -> None:
    """A ratio that is the square of the overload, and falls as the Arias intensity grows."""
    made = table((0.1, 0.2), (0.2, 0.2), (0.4, 0.2)).assign(overload=[1.0, math.sqrt(2.0), 2.0], arias_intensity=[4.0, 2.0, 1.0])
    (row,) = cause_rows(made)
    assert row == ("stiff_clay", "1 to 4", "1 to 2", "1 to 4", "1.00", "-1.00")


def test_the_column_has_the_mean_acceleration_of_its_first_mode() -> None:
    """In resonance 8 / pi^2 / (2 xi) of the base but for what 24 cycles have not built up; of a stiff column that of the base, nearly."""
    scene = scene_of("stiff_clay")
    period = 1.0 / natural_frequency(make_scene(scene), make_scene(scene).geometry.crest)
    motion = {"kind": "tapered_sine", "amplitude": 1.0, "frequency": 1.0 / period, "start": 3.0, "ramp": 0.0}
    shaken = make_scene(merge(scene, {"motion": motion | {"decay_start": 3.0 + 24.0 * period, "end": 3.0 + 24.0 * period}}))
    xi = damping_at(shaken, 1.0 / period)
    built_up = 1.0 - math.exp(-2.0 * math.pi * 24.0 * xi)
    assert np.abs(column_motion(shaken).acceleration).max() == pytest.approx(8.0 / math.pi**2 / (2.0 * xi) * built_up, rel=0.03)
    stiff = make_scene(merge(shaken.model_dump(), {"soil": {"youngs_modulus": 1e9}}))
    assert np.abs(column_motion(stiff).acceleration).max() == pytest.approx(1.0, rel=0.05)


def test_a_folder_without_records_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([str(tmp_path)])
    assert str(tmp_path) in capsys.readouterr().err


def test_the_measured_table_holds_every_record_once() -> None:
    measured = read_blocks()
    assert not measured.duplicated(["slope", "strength", "record", "peak_ratio"]).any()
    assert (measured["yield_acceleration"] > 0.0).all() and set(measured["status"]) <= {"complete", "unfailed", "diverged"}
    left = measured[measured["status"] == "diverged"]  # debris left the box, as the page says
    assert set(zip(left["slope"], left["strength"], strict=True)) == {("gentle_layered", "strength lost by slip")} and len(left) == 5
    assert not set(left.index) & set(compared(measured).index), "no ratio is made of them"
