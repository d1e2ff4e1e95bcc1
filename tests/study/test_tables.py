"""Table and dataset of a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from synthetic import study_row

from sph.study.tables import AXES, VALUES, Layout, join_study, joined_dataset, read_study, read_table, study_rows, write_csv

ROWS = [
    study_row("0.10", "1", "6.0", runout=8.0),
    study_row("0.10", "100", "6.0", runout=32.0, collapse_class="collapse"),
    study_row("0.10", "100", "10.0", status="diverged", diverged=1),
    study_row("0.50", "100", "6.0", runout=0.5, collapse_class="minor", still_moving=1),
]
GRID = Layout(labels=(("0.10", "0.50"), ("1", "100"), ("6.0", "10.0")))


def test_rows_keep_their_order_and_their_labels() -> None:
    frame = study_rows(ROWS)
    assert list(frame.columns) == GRID.names
    points = list(zip(frame["S_R"], frame["gamma"], frame["amplitude"], strict=True))
    assert points == [("0.10", "1", "6.0"), ("0.10", "100", "6.0"), ("0.10", "100", "10.0"), ("0.50", "100", "6.0")]


def test_dataset_has_numbers_as_coordinates_and_every_metric_with_units() -> None:
    ds = joined_dataset([study_rows(ROWS)], GRID, {"title": "a study"})
    assert dict(ds.sizes) == {"S_R": 2, "gamma": 2, "amplitude": 2} and ds.attrs["title"] == "a study"
    assert ds["S_R"].values.tolist() == [0.1, 0.5] and ds["S_R_label"].values.tolist() == ["0.10", "0.50"]
    assert ds["amplitude"].values.tolist() == [6.0, 10.0]
    for row in AXES + VALUES:
        assert ds[row.name].attrs["long_name"] == row.text
        assert row.dtype == "str" or ds[row.name].attrs["units"] == row.units


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_values_lie_at_their_grid_point_and_missing_ones_are_nan(order: slice) -> None:
    ds = joined_dataset([study_rows(ROWS[order])], GRID)
    assert ds["runout"].sel(S_R=0.1, gamma=100, amplitude=6).item() == 32.0
    assert ds["runout"].sel(S_R=0.1, gamma=1, amplitude=6).item() == 8.0
    assert ds["collapse_class"].sel(S_R=0.5, gamma=100, amplitude=6).item() == "minor"
    assert ds["diverged"].sel(S_R=0.1, gamma=100, amplitude=10).item() == 1
    missing = ds.sel(S_R=0.5, gamma=1, amplitude=6)
    assert np.isnan(missing["runout"]) and np.isnan(missing["diverged"]) and missing["status"].item() == ""


def test_files_hold_what_was_written(tmp_path: Path) -> None:
    frame = study_rows(ROWS)
    part, nc, csv = tmp_path / "part.csv", tmp_path / "new" / "study.nc", tmp_path / "new" / "study.csv"
    write_csv(frame, part)
    join_study([part], GRID, nc, csv, {"title": "a study"})
    assert sorted(path.name for path in nc.parent.iterdir()) == ["study.csv", "study.nc"]
    back = read_table(csv)
    assert back.to_dict("list").keys() == frame.to_dict("list").keys()
    for name in GRID.names:
        np.testing.assert_array_equal(back[name].to_numpy(), frame[name].to_numpy(), err_msg=name)
    made = joined_dataset([frame], GRID)
    np.testing.assert_array_equal(read_study(nc)["runout"].values, made["runout"].values)
    assert read_study(nc)["status"].values.tolist() == made["status"].values.tolist()
    assert read_study(nc)["runout"].attrs["units"] == "m" and read_study(nc).attrs["title"] == "a study"


def test_a_failed_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    csv = tmp_path / "study.csv"
    csv.write_text("old")

    def broken(*args: object, **options: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("pandas.DataFrame.to_csv", broken)
    with pytest.raises(OSError, match="disk full"):
        write_csv(study_rows(ROWS), csv)
    assert csv.read_text() == "old"


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "at least one run"),
        ([{**ROWS[0], "S_R": "big"}], "S_R: 'big' is not a number"),
        ([{**ROWS[0], "amplitude": "inf"}], "amplitude: 'inf' is not a finite number"),
        ([{**ROWS[0], "colour": 1}], "unknown columns \\['colour'\\]"),
        ([{name: value for name, value in ROWS[0].items() if name != "runout"}], "missing columns \\['runout'\\]"),
    ],
)
def test_bad_rows_are_refused_with_key_and_value(rows: list[dict[str, object]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        study_rows(rows)


def test_files_of_another_kind_are_refused_by_name(tmp_path: Path) -> None:
    other = tmp_path / "other.csv"
    other.write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="other.csv"):
        read_table(other)
    with pytest.raises(ValueError, match="other.csv"):
        read_study(other)
