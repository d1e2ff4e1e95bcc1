"""Errors, orders of convergence, and the rows of the suite's table."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from cases import CASES
from cases.case import Case, Found, Kind, Quantity, Result, at_spacings
from cases.suite import case_rows, levels_of, observed_order, runs_of
from sph.scene.schema import make_scene
from sph.storage import trajectory


def measure(level: Any) -> dict[str, Found]:
    return {"overshoot": Found("overshoot", "m", 1.0 + 0.04 * level["run"].scene.numerics.spacing ** 2, 1.0)}


CASE = Case(
    title="a title",
    scene="config/scenes/paper.yaml",
    source="a source",
    measure=measure,
    draw=lambda levels: Figure(),
    levels=at_spacings({"1 m": 1.0, "0.5 m": 0.5}),
    quantities={"overshoot": Quantity(Kind.STRESS, 0.1, 0.2, "a reason")},
)


def test_errors_are_relative_and_absolute_where_the_reference_is_zero() -> None:
    assert Found("", "m", 1.1, 1.0).error == pytest.approx(0.1)
    assert Found("", "m", -1.1, -1.0).error == pytest.approx(-0.1)
    assert Found("", "m", 0.03, 0.0).error == pytest.approx(0.03)


def test_a_number_is_within_its_tolerance() -> None:
    assert Found("", "1", 1.05, 1.0).within(0.051) and not Found("", "1", 0.94, 1.0).within(0.05)
    assert Found("", "1", 2.0, 2.0).within(0.0) and not Found("", "1", math.nan, 1.0).within(1e9)


@given(order=st.floats(0.5, 4.0), size=st.floats(0.01, 10.0), factor=st.floats(1.5, 4.0), constant=st.floats(1e-3, 10.0))
def test_order_of_a_power_law(order: float, size: float, factor: float, constant: float) -> None:
    sizes = [size * factor**2, size * factor, size]
    errors = [constant * (s / size) ** order for s in sizes]
    assert observed_order(sizes, errors) == pytest.approx(order)
    assert observed_order(sizes, [-error for error in errors]) == pytest.approx(order)


def test_no_order_of_rounding_of_one_level_and_of_errors_of_two_signs() -> None:
    assert math.isnan(observed_order([1.0], [0.1]))
    assert math.isnan(observed_order([1.0, 0.5], [0.1, -0.05]))
    assert math.isnan(observed_order([1.0, 0.5], [1e-9, 1e-10]))


def test_rows_hold_every_level() -> None:
    levels = {
        level: {run: Result(make_scene(scene), xr.Dataset(attrs={"wall_time_s": 2.0}))} for (level, run), scene in CASE.scenes().items()
    }
    (row,) = case_rows("V14", CASE, levels)
    assert row["computed"] == pytest.approx(1.01) and row["error"] == pytest.approx(0.01) and row["order"] == pytest.approx(2.0)
    assert (row["levels"], row["errors"], row["cost"], row["verdict"]) == ("1 m, 0.5 m", "0.04, 0.01", 4.0, "holds")
    (row,) = case_rows("V14", CASE._replace(compared="extrapolated"), levels)
    assert row["computed"] == pytest.approx(0.98) and row["levels"] == "1 m, 0.5 m, extrapolated" and row["order"] == pytest.approx(2.0)
    levels["0.5 m"]["run"].data.attrs["status"] = "diverged"
    (row,) = case_rows("V14", CASE, levels)
    assert row["verdict"] == "misses" and math.isnan(row["computed"]) and math.isnan(row["order"]) and row["errors"] == "0.04, nan"
    with pytest.raises(ValueError, match="overshoot"):
        case_rows("V14", CASE._replace(measure=lambda level: {}), levels)


def test_a_run_is_made_for_every_variant_at_every_level() -> None:
    case, runs = CASES["V7"], runs_of("V7")
    assert list(runs) == [(level, run) for level in case.levels for run in case.runs]
    assert runs["2.5 mm", "on_fluid"].file == "results/validation/runs/V7/on_fluid/2.5-mm.nc"
    assert len({run.file for run in runs.values()}) == len(runs)
    assert runs["2.5 mm", "on_fluid"].scene["duration"] == 0.5 and runs["2.5 mm", "on_fluid"].scene["numerics"]["spacing"] == 0.0025
    assert not runs_of("V14"), "a case of functions alone leaves no file"


def test_a_file_of_another_scene_is_refused(tmp_path: Path) -> None:
    _, scene = next(iter(CASES["V9"].scenes().items()))
    path = tmp_path / "trials.nc"
    other = make_scene(scene | {"duration": 2.0 * scene["duration"]}).stored()
    trajectory.write(path, xr.Dataset(attrs={"scene": other, "by": "factor_of_safety"}))
    with pytest.raises(ValueError, match=r"(?s)trials\.nc: was made from another scene.*duration"):
        levels_of("V9", [path])
