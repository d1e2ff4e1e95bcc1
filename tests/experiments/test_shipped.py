"""The tables of the release say what they were measured with."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import pytest

from sph.experiments import shipped
from sph.experiments.shipped import (
    CURRENT,
    MEASURED,
    NOT_RECORDED,
    OLDER,
    SHIPPED,
    Shipped,
    adopt,
    main,
    settings_digest,
    solver_of,
    states,
)
from sph.paper.release import MEASURED as OF_THE_RELEASE
from sph.solver.compiled.jit import solver_digest
from sph.validation.table import SHIPPED_VALIDATION


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
    table = Shipped("results/one", ("config/one.yaml",), "snakemake one", tmp_path / "one.csv")
    table.path.write_text("a\n0\n")
    monkeypatch.setattr(shipped, "SHIPPED", {"one": table})
    monkeypatch.setattr(settings_digest, "__defaults__", (tmp_path,))
    return tmp_path / "origins.csv"


def test_every_measured_table_is_known() -> None:
    found = {*MEASURED.glob("*.csv"), *SHIPPED_VALIDATION.parent.glob("*.csv")} - {MEASURED / "origins.csv"}
    assert {table.path for table in SHIPPED.values()} == found and MEASURED == OF_THE_RELEASE
    assert all(settings_digest(table.configuration) for table in SHIPPED.values())


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


def test_a_table_edited_by_hand_has_no_origin(origins: Path) -> None:
    adopt("one", origins)
    (origins.parent / "one.csv").write_text("a\n2\n")
    assert states(origins)["one"] == (NOT_RECORDED, "the table has changed since its origin was noted")


def test_runs_of_several_solvers_or_of_none_are_refused(tmp_path: Path) -> None:
    one, other, silent = (run(tmp_path / f"{name}.nc", name) for name in ("one", "other", "silent"))
    run(silent, None)
    assert solver_of([one, one]) == "one"
    for runs, told in (([], "no runs"), ([one, other], "not made by one solver"), ([silent], "not noted")):
        with pytest.raises(ValueError, match=told):
            solver_of(runs)


def test_what_is_missing_is_named(origins: Path) -> None:
    (origins.parent / "results/one/one.csv").unlink()
    with pytest.raises(ValueError, match="one.csv: no such file; run 'snakemake one'"):
        adopt("one", origins)


def test_the_command_names_every_table_and_fails_for_none(capsys: pytest.CaptureFixture[str]) -> None:
    main([])
    told = capsys.readouterr().out
    for name, (state, _) in states().items():
        assert f"{name:<11} {state}: " in told and (state == CURRENT or SHIPPED[name].renewal in told)
