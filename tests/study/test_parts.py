"""Tables of many runs: measured in parts and joined, in memory that does not grow with the runs' trajectories."""

from __future__ import annotations

import importlib.util
import json
import os
import tracemalloc
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from synthetic import study_row, synthetic, translation

from sph.measures.metrics import MetricSettings
from sph.storage import trajectory
from sph.storage.trajectory import Variable
from sph.study.dimensions import CASE
from sph.study.planned import planned
from sph.study.tables import VALUES, Layout, join_study, joined_dataset, read_study, read_table, study_rows, write_csv

SCRIPTS = Path(__file__).resolve().parents[2] / "workflow" / "scripts" / "study"
KERNEL = Variable("numerics.kernel", ("numerics.kernel",), "str", "1", "kernel")
COHESION = Variable("soil.cohesion", ("soil.cohesion",), "f8", "kPa", "cohesion")
LIST = Layout(tuple(axis._replace(dims=(CASE,)) for axis in (KERNEL, COHESION)), (), True)
GRID = Layout((KERNEL, COHESION), (("wendland_c2", "cubic_spline"), ("20", "150", "300.0")))


def script(name: str) -> ModuleType:
    found = importlib.util.spec_from_file_location(name, SCRIPTS / f"{name}.py")
    assert found is not None and found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def row(kernel: str, cohesion: str, runout: float, case: str = "") -> dict[str, object]:
    values = {name: value for name, value in study_row("1", "1", "1", runout=runout).items() if name in {found.name for found in VALUES}}
    return ({CASE: case} if case else {}) | {KERNEL.name: kernel, COHESION.name: cohesion} | values


def joined(folder: Path, parts: list[list[dict[str, object]]], layout: Layout) -> tuple[xr.Dataset, pd.DataFrame]:
    paths = [folder / f"{number}.csv" for number in range(len(parts))]
    for path, rows in zip(paths, parts, strict=True):
        write_csv(study_rows(rows, layout), path)
    join_study(paths, layout, folder / "study.nc", folder / "study.csv", {"title": "t"})
    return read_study(folder / "study.nc"), read_table(folder / "study.csv", layout)


def test_a_grid_of_numbers_and_words_in_parts_of_any_size(tmp_path: Path) -> None:
    rows = [row(kernel, cohesion, 10.0 * i + j) for i, kernel in enumerate(GRID.labels[0]) for j, cohesion in enumerate(GRID.labels[1])]
    study, table = joined(tmp_path, [rows[:1], rows[1:4], rows[4:]], GRID)
    assert study["runout"].dims == ("numerics.kernel", "soil.cohesion")
    np.testing.assert_array_equal(study["runout"], [[0, 1, 2], [10, 11, 12]])
    assert study["numerics.kernel"].values.tolist() == ["wendland_c2", "cubic_spline"]
    assert study["soil.cohesion"].values.tolist() == [20, 150, 300] and study["soil.cohesion"].attrs["units"] == "kPa"
    assert study["soil.cohesion_label"].values.tolist() == ["20", "150", "300.0"]
    assert study["runout"].sel({"numerics.kernel": "cubic_spline", "soil.cohesion": 150}) == 11
    assert table["soil.cohesion"].tolist() == ["20", "150", "300.0"] * 2 and table["runout"].tolist() == [0, 1, 2, 10, 11, 12]


def test_a_list_has_its_dimensions_along_the_cases(tmp_path: Path) -> None:
    rows = [row("cubic_spline", "20", 1.0, "case-000001"), row("null", "20", 2.0, "case-000002"), row("null", "-3", 3.0, "case-000003")]
    study, table = joined(tmp_path, [rows[:2], rows[2:]], LIST)
    assert dict(study.sizes) == {CASE: 3} and study[CASE].values.tolist() == table[CASE].tolist()
    assert study.coords["soil.cohesion"].values.tolist() == [20, 20, -3] and study["numerics.kernel"].values.tolist()[1:] == [
        "null",
        "null",
    ]
    assert study["runout"].sel(case="case-000003") == 3


def test_parts_give_what_one_table_gives(tmp_path: Path) -> None:
    """Bit for bit, over the paper's dimensions."""
    rng = np.random.default_rng(1)
    points = [(S_R, gamma, "6.0") for S_R in ("0.10", "0.50") for gamma in ("1", "100")]
    frame = study_rows([study_row(*point, runout=rng.lognormal(), onset_time=rng.normal() * 1e-7) for point in points])
    for number in range(2):
        write_csv(frame.iloc[2 * number : 2 * number + 2], tmp_path / f"{number}.csv")
    layout = Layout(labels=(("0.10", "0.50"), ("1", "100"), ("6.0",)))
    join_study([tmp_path / "0.csv", tmp_path / "1.csv"], layout, tmp_path / "study.nc", tmp_path / "study.csv")
    write_csv(frame, tmp_path / "whole.csv")
    assert (tmp_path / "study.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    xr.testing.assert_identical(read_study(tmp_path / "study.nc"), joined_dataset([frame], layout))


def test_a_row_of_a_list_needs_its_name() -> None:
    with pytest.raises(ValueError, match=r"missing columns \['case'\]"):
        study_rows([row("a", "1", 1.0)], LIST)


@pytest.mark.long
def test_memory_does_not_grow_with_the_runs(tmp_path: Path) -> None:
    """Four times the runs in as many more parts; a run takes hundreds of kB, a row of the table 0.4 kB."""
    run = tmp_path / "run.nc"
    few = {"numerics": {"spacing": 5.0}, "outputs": {"frame_interval": 0.5, "series_interval": 0.1}}
    trajectory.write(run, synthetic(translation(-3.0), overrides=few).trajectory)
    scene = planned(json.loads(trajectory.read(run).attrs["scene"]))
    size = 3
    names = [f"case-{number:06d}" for number in range(1, 8 * size + 1)]
    for name in names:
        os.link(run, tmp_path / f"{name}.nc")
    measure = script("measure_study").measure_study
    peaks = []
    for parts in (2, 8):
        tracemalloc.start()
        paths = []
        for part in range(parts):
            own = names[part * size : (part + 1) * size]
            paths.append(str(tmp_path / f"part-{part}.csv"))
            points = {name: {KERNEL.name: "cubic_spline", COHESION.name: "20"} for name in own}
            runs = [str(tmp_path / f"{name}.nc") for name in own]
            measure(runs, paths[-1], [scene] * size, {}, points, LIST, MetricSettings().model_dump())
        join_study(paths, LIST, tmp_path / "study.nc", tmp_path / "study.csv")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert read_study(tmp_path / "study.nc").sizes[CASE] == parts * size
    loaded = sum(variable.nbytes for variable in trajectory.read(run).dataset().variables.values())
    assert peaks[1] < 1.2 * peaks[0], f"{peaks[1]} after {peaks[0]} bytes"
    assert peaks[1] < 8 * size * loaded / 4, "far less than all trajectories"
