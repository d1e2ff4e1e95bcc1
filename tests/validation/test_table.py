"""Errors, orders of convergence, verdicts and the suite's configuration."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from small_scenes import study_plan

from sph.experiments.validation.cases import CASES
from sph.experiments.validation.design import Case, load_suite
from sph.experiments.validation.level import Found, Result
from sph.experiments.validation.measure import case_rows, observed_order, verdict
from sph.scene.schema import make_scene

SCENE: dict[str, Any] = {"scheme": "paper", "name": "small", "duration": 0.5, "geometry": {"shape": "block", "width": 4.0, "height": 4.0}}
SUITE: dict[str, Any] = {
    "cases": {
        "V14": {
            "title": "a title",
            "scene": "scene.yaml",
            "by": "computation",
            "source": "a source",
            "levels": {"1 m": {"numerics": {"spacing": 1.0}}, "0.5 m": {"numerics": {"spacing": 0.5}}},
            "quantities": {"overshoot": {"kind": "stress", "tolerance": 0.1, "coarse": 0.2, "reason": "a reason"}},
        }
    }
}
SCENE |= {"gravity": {"ramp": 0.1, "duration": 0.1}}


def write(folder: Path, **changes: Any) -> str:
    suite = copy.deepcopy(SUITE)
    suite["cases"]["V14"] |= changes
    (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE))
    (folder / "suite.yaml").write_text(yaml.safe_dump(suite, sort_keys=False))
    return str(folder / "suite.yaml")


def test_errors_are_relative_and_absolute_where_the_reference_is_zero() -> None:
    assert Found("", "m", 1.1, 1.0).error == pytest.approx(0.1)
    assert Found("", "m", -1.1, -1.0).error == pytest.approx(-0.1)
    assert Found("", "m", 0.03, 0.0).error == pytest.approx(0.03)


def test_verdict() -> None:
    assert verdict(Found("", "1", 1.05, 1.0), 0.051) == "holds"
    assert verdict(Found("", "1", 0.94, 1.0), 0.05) == "misses"
    assert verdict(Found("", "1", 2.0, 2.0), 0.0) == "holds"
    assert verdict(Found("", "1", math.nan, 1.0), 1e9) == "misses"


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


def test_rows_hold_every_level(monkeypatch: pytest.MonkeyPatch) -> None:
    def measure(level: Any) -> dict[str, Found]:
        spacing = level["run"].scene.numerics.spacing
        return {"overshoot": Found("overshoot", "m", 1.0 + 0.04 * spacing**2, 1.0)}

    monkeypatch.setitem(CASES, "V14", (measure, CASES["V14"][1]))
    case = Case(**SUITE["cases"]["V14"])
    levels = {}
    for label, overrides in case.levels.items():
        scene = make_scene(SCENE | overrides)
        levels[label] = {"run": Result(scene, pd.DataFrame().to_xarray().assign_attrs(wall_time_s=2.0))}
    (row,) = case_rows("V14", case, levels, [1.0, 0.5])
    assert row["computed"] == pytest.approx(1.01) and row["error"] == pytest.approx(0.01) and row["order"] == pytest.approx(2.0)
    assert (row["levels"], row["errors"], row["cost"], row["verdict"]) == ("1 m, 0.5 m", "0.04, 0.01", 4.0, "holds")
    levels["0.5 m"]["run"].data.attrs["status"] = "diverged"
    (row,) = case_rows("V14", case, levels, [1.0, 0.5])
    assert row["verdict"] == "misses" and math.isnan(row["computed"]) and math.isnan(row["order"]) and row["errors"] == "0.04, nan"
    monkeypatch.setitem(CASES, "V14", (lambda level: {}, CASES["V14"][1]))
    with pytest.raises(ValueError, match="V14: .*overshoot"):
        case_rows("V14", case, levels, [1.0, 0.5])


def test_suite_gives_a_scene_a_run_and_level(tmp_path: Path) -> None:
    suite = load_suite(write(tmp_path, runs={"a": {}, "b": {"duration": 1.0}}), study_plan(), [tmp_path])
    runs = suite.of("V14")
    assert list(runs) == ["V14/a/1-m", "V14/b/1-m", "V14/a/0.5-m", "V14/b/0.5-m"]
    assert suite.sizes("V14") == [1.0, 0.5]
    assert runs["V14/b/0.5-m"].scene["duration"] == 1.0 and runs["V14/b/0.5-m"].scene["numerics"]["spacing"] == 0.5
    assert not suite.runs and not suite.files("V14"), "a case of functions alone leaves no file"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scene": "nowhere.yaml"}, ["cases.V14.scene", "nowhere.yaml"]),
        ({"runs": {"a": {"soil": {"cohesin": 3.0}}}}, ["case V14, run 'a', level '1 m'", "soil.cohesin"]),
        ({"levels": {"1 m": {"numerics": {"time_step": 0.1, "spacing": 1.0}}}}, ["case V14", "time_step"]),
        (
            {"quantities": {"overshoot": {"kind": "stress", "tolerance": -1.0, "coarse": 0.2, "reason": "x"}}},
            ["cases.V14.quantities.overshoot.tolerance"],
        ),
        ({"by": "guessing"}, ["cases.V14.by", "guessing"]),
    ],
)
def test_errors_name_the_key(tmp_path: Path, changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        load_suite(write(tmp_path, **changes), study_plan(), [tmp_path])
    for word in words:
        assert word in str(raised.value)
