"""The tables of the release say what they were measured with."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import numpy as np
import pandas as pd
import pytest
from small_scenes import SceneBuilder

from cases.suite import SHIPPED_VALIDATION, read_validation
from sph.scene.scheme import RESOLVED
from sph.solver.checkpoint import run_to_file
from sph.solver.compiled.jit import solver_digest
from sph.stability.record import search_to_file
from sph.storage.trajectory import read
from sph.study.tables import write_csv
from tools import shipped
from tools.shipped import (
    CURRENT,
    MEASURED,
    NOT_RECORDED,
    OLDER,
    SHIPPED,
    Shipped,
    adopt,
    chosen_runs,
    main,
    note,
    read_origins,
    repeat,
    settings_digest,
    solver_of,
    states,
)


def run(path: Path, solver: str | None) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with netCDF4.Dataset(path, "w") as data:
        if solver is not None:
            data.solver_digest = solver
    return path


@pytest.fixture
def origins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A release with one table, whose results lie in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "one.yaml").write_text("spacing: 1.0\n")
    run(tmp_path / "results/one/runs/a.nc", solver_digest())
    (tmp_path / "results/one/one.csv").write_text("a\n1\n")
    table = Shipped(("results/one",), ("config/one.yaml",), "snakemake one", tmp_path / "one.csv")
    table.path.write_text("a\n0\n")
    monkeypatch.setattr(shipped, "SHIPPED", {"one": table})
    monkeypatch.setattr(settings_digest, "__defaults__", (None, tmp_path))
    return tmp_path / "origins.csv"


def test_every_measured_table_is_known() -> None:
    found = {*MEASURED.glob("*.csv")} - {MEASURED / "origins.csv"}
    assert {table.path for table in SHIPPED.values()} == found
    assert all(settings_digest(table.configuration, table.settings()) for table in SHIPPED.values())


def test_a_table_is_not_recorded_until_it_is_adopted(origins: Path) -> None:
    assert states(origins)["one"][0] == NOT_RECORDED
    adopt("one", origins)
    assert states(origins)["one"] == (CURRENT, f"solver {solver_digest()}")
    assert (origins.parent / "one.csv").read_text() == "a\n1\n"


def test_another_solver_makes_it_older(origins: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    adopt("one", origins)
    monkeypatch.setattr(shipped, "solver_digest", lambda: "another")
    assert states(origins)["one"] == (OLDER, f"solver {solver_digest()}, now another")


def test_another_setting_makes_it_older_but_a_comment_does_not(origins: Path) -> None:
    adopt("one", origins)
    settings = origins.parent / "config" / "one.yaml"
    settings.write_text("# in metres\nspacing: 1.0\n")
    assert states(origins)["one"][0] == CURRENT
    settings.write_text("spacing: 2.0\n")
    assert states(origins)["one"][0] == OLDER and "configuration" in states(origins)["one"][1]


def test_what_a_scheme_fills_into_a_scene_is_of_its_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = tmp_path / "config" / "scenes"
    scenes.mkdir(parents=True)
    (scenes / "own.yaml").write_text("name: own\n")
    (scenes / "paper.yaml").write_text("scheme: paper\n")
    before = [settings_digest([f"config/scenes/{name}.yaml"], root=tmp_path) for name in ("own", "paper")]
    monkeypatch.setitem(RESOLVED["numerics"], "time_step", 1e-3)
    after = [settings_digest([f"config/scenes/{name}.yaml"], root=tmp_path) for name in ("own", "paper")]
    assert after[0] != before[0] and after[1] == before[1]


def test_a_table_edited_by_hand_has_no_origin(origins: Path) -> None:
    adopt("one", origins)
    (origins.parent / "one.csv").write_text("a\n2\n")
    assert states(origins)["one"] == (NOT_RECORDED, "the table has changed since its origin was noted")


def test_measured_cases_take_the_place_of_their_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of the shipped cases measured again and one that is new, in the order of the cases; the others keep their code."""
    monkeypatch.chdir(tmp_path)
    before = read_validation(SHIPPED_VALIDATION)
    path = tmp_path / "validation.csv"
    write_csv(before[before["case"].isin(["V1", "V2", "V10"])], path)
    again = before[before["case"] == "V2"].assign(computed=7.0, code="sph 9.9, solver abc123, 2030-01-01")
    for name in ("V2", "V9"):
        part = tmp_path / f"results/validation/cases/{name}.csv"
        part.parent.mkdir(parents=True, exist_ok=True)
        write_csv(again.assign(case=name), part)
    monkeypatch.setitem(SHIPPED, "validation", SHIPPED["validation"]._replace(path=path))
    adopt("validation", tmp_path / "origins.csv")
    after = read_validation(path)
    assert list(dict.fromkeys(after["case"])) == ["V1", "V2", "V9", "V10"]
    assert (after[after["case"].isin(["V2", "V9"])]["computed"] == 7.0).all() and len(after[after["case"] == "V2"]) == len(again)
    pd.testing.assert_frame_equal(after[after["case"] == "V1"], before[before["case"] == "V1"])
    (solvers,) = read_origins(tmp_path / "origins.csv")["solver"]
    assert "abc123" in solvers.split(" and ") and len(solvers.split(" and ")) >= 2
    assert states(tmp_path / "origins.csv")["validation"][0] == OLDER


def test_cases_that_were_repeated_stay_so_when_others_are_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path, origins = tmp_path / "validation.csv", tmp_path / "origins.csv"
    before = read_validation(SHIPPED_VALIDATION).assign(code="sph 0.1, solver earlier, 2020-01-01")
    write_csv(before[before["case"].isin(["V1", "V2"])], path)
    monkeypatch.setitem(SHIPPED, "validation", SHIPPED["validation"]._replace(path=path))
    note("validation", solver_digest(), origins, "5 runs of earlier")
    part = tmp_path / "results/validation/cases/V2.csv"
    part.parent.mkdir(parents=True)
    write_csv(before[before["case"] == "V2"].assign(code=f"sph 9.9, solver {solver_digest()}, 2030-01-01"), part)
    adopt("validation", origins)
    (row,) = read_origins(origins).to_dict("records")
    assert (row["solver"], row["repeated"]) == (solver_digest(), "5 runs of earlier") and states(origins)["validation"][0] == CURRENT
    path.write_text(path.read_text().replace("V1,", "V1 ,", 1))  # by hand: nobody knows what its rows were made by
    adopt("validation", origins)
    assert states(origins)["validation"][0] == OLDER


def test_without_a_measured_case_there_is_nothing_to_adopt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="no case has been measured; run 'snakemake"):
        adopt("validation", tmp_path / "origins.csv")


@pytest.fixture
def older(origins: Path, small_slope: SceneBuilder) -> Path:
    """The one run of the release's table, made by an earlier solver."""
    path = origins.parent / "results/one/runs/a.nc"
    path.unlink()
    run_to_file(small_slope({"duration": 1.5}), path)
    with netCDF4.Dataset(path, "a") as data:
        data.solver_digest = "earlier"
    adopt("one", origins)
    assert states(origins)["one"][0] == OLDER
    return path


def test_a_solver_that_repeats_the_runs_makes_it_current(origins: Path, older: Path) -> None:
    repeat("one", origins)
    assert states(origins)["one"] == (CURRENT, f"solver {solver_digest()}")
    assert read_origins(origins)["repeated"].tolist() == ["1 of 1 runs of earlier"]
    with pytest.raises(ValueError, match="one is current"):
        repeat("one", origins)


def test_each_run_of_a_part_made_anew_is_repeated(origins: Path, older: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of one kind, of which one would do; the row says how many there were."""
    for name in "bc":
        (older.parent / f"{name}.nc").write_bytes(older.read_bytes())
    seen: list[str] = []
    monkeypatch.setattr(shipped, "_comes_again", lambda path: not seen.append(path.stem))
    repeat("one", origins, every=True)
    assert seen == ["a", "b", "c"] and read_origins(origins)["repeated"].tolist() == ["3 runs of earlier"]


def test_a_solver_of_other_answers_does_not(origins: Path, older: Path) -> None:
    with netCDF4.Dataset(older, "a") as data:
        data["kinetic_energy"][-1] = np.nextafter(data["kinetic_energy"][-1], np.inf)
    with pytest.raises(ValueError, match="a.nc: .*differ.*solver earlier.*snakemake one"):
        repeat("one", origins)
    assert states(origins)["one"][0] == OLDER


def test_a_table_of_other_runs_or_settings_is_not_repeated(origins: Path, older: Path) -> None:
    (origins.parent / "config" / "one.yaml").write_text("spacing: 2.0\n")
    with pytest.raises(ValueError, match="one is older: solver earlier.*configuration"):
        repeat("one", origins)


def test_one_run_of_every_combination_of_terms_is_repeated_and_a_tenth_of_all(tmp_path: Path) -> None:
    runs = []
    for number in range(30):
        runs.append(run(tmp_path / f"{number:02d}.nc", "earlier"))
        with netCDF4.Dataset(runs[-1], "a") as data:
            data.wall_time_s, data.status = 100.0 - number, "complete"
            data.active_terms = "layers" if number == 3 else "damping" if number < 8 else ""
    for name, seconds in (("slow", 3e3), ("slower", 4e3)):
        runs.append(run(tmp_path / f"{name}.nc", "earlier"))
        with netCDF4.Dataset(runs[-1], "a") as data:
            data.wall_time_s, data.by = seconds, "factor_of_safety"
    assert [path.stem for path in chosen_runs(runs)] == ["29", "28", "27", "26", "07", "03", "slow"]


@pytest.mark.long
def test_a_search_is_repeated_with_all_its_trials(origins: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> None:
    path = origins.parent / "results/one/runs/a.nc"
    path.unlink()
    scene = small_slope({"duration": 2.0, "numerics.spacing": 2.5, "motion": {"kind": "none"}})
    search_to_file(scene, "yield_acceleration", path, lambda trial: None)
    with netCDF4.Dataset(path, "a") as data:
        data.solver_digest = "earlier"
    adopt("one", origins)
    repeat("one", origins)
    assert states(origins)["one"][0] == CURRENT
    same = read(path)
    monkeypatch.setattr(shipped, "run_search", lambda *_, **__: same)
    with netCDF4.Dataset(path, "a") as data:
        data["displaced_area"][0] += 1e-9
    note("one", "earlier", origins)
    with pytest.raises(ValueError, match="a.nc: .*differ"):
        repeat("one", origins)


def test_runs_of_several_solvers_or_of_none_are_refused(tmp_path: Path) -> None:
    one, other, silent = (run(tmp_path / f"{name}.nc", name) for name in ("one", "other", "silent"))
    run(silent, None)
    assert solver_of([one, one]) == "one"
    for runs, told in (([], "no runs"), ([one, other], "not made by one solver"), ([silent], "not noted")):
        with pytest.raises(ValueError, match=told):
            solver_of(runs)


def test_what_is_missing_is_named(origins: Path) -> None:
    (origins.parent / "results/one/one.csv").unlink()
    with pytest.raises(ValueError, match="one.csv: .*snakemake one"):
        adopt("one", origins)


def test_the_command_names_every_table_and_fails_for_none(capsys: pytest.CaptureFixture[str]) -> None:
    main([])
    told = capsys.readouterr().out
    for name, (state, _) in states().items():
        assert f"{name:<15} {state}: " in told and (state == CURRENT or SHIPPED[name].renewal in told)
