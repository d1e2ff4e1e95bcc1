"""What a result was made from counts, not the dates of files: replaced records, runs copied over others, and the trace of a number."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from small_scenes import SLOPE
from test_record_workflow import write_record
from test_workflow import made, planned_jobs, snakemake
from typer.testing import CliRunner, Result

from sph.command.cli import app
from sph.jobs.exit_codes import DIFFERS, REFUSED
from sph.scene.schema import load_scene
from sph.storage import trajectory

pytestmark = pytest.mark.long  # that what is new alone runs again is in test_workflow also

TABLE = "results/small/draft/study.csv"
RUN = "results/small/draft/runs/S_R-{}.nc"
LONG_AGO = (1e9, 1e9)
AWKWARD = 'rec{1}<x> "$é.csv'


def write(folder: Path, *strengths: str, **changes: Any) -> tuple[str, ...]:
    """Configuration of a study, with what a command is given after the target."""
    study = {"study": "small", "scene": "scenes/slope.yaml", "fidelity": "draft", "fidelities": {"draft": {}}}
    (folder / "study.yaml").write_text(yaml.safe_dump(study | {"grid": {"S_R": list(strengths)}} | changes))
    return "--configfile", "study.yaml"


def replace(folder: Path, kept: str) -> None:
    """``cp -p`` of a kept record over that of the scene."""
    shutil.copy2(folder / kept, folder / "scenes" / AWKWARD)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a table of two runs under a weak record; its name and the record's hold what Snakemake and a shell take for their own."""
    folder = tmp_path_factory.mktemp("a{b}c <x> $HOME 'q'", numbered=False)
    (folder / "scenes").mkdir()
    for name, factor in (("weak.csv", 0.2), ("strong.csv", 1.0)):
        write_record(folder / name, factor)
        os.utime(folder / name, LONG_AGO)
    replace(folder, "weak.csv")
    motion = {"kind": "record", "file": AWKWARD, "start": 0.5, "baseline": {"degree": 0}}
    changes: dict[str, Any] = {"motion": motion, "duration": 1.5, "gravity": {"ramp": 0.2, "duration": 0.5}}
    (folder / "scenes" / "slope.yaml").write_text(yaml.safe_dump(SLOPE | changes))
    made(folder, *write(folder, "0.10", "0.50"), "--", TABLE, cores=1)
    return folder


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Iterator[Path]:
    yield Path(shutil.copytree(finished, tmp_path / "study"))


def explained(folder: Path, monkeypatch: pytest.MonkeyPatch, file: str, *arguments: str) -> Result:
    monkeypatch.chdir(folder)
    return CliRunner().invoke(app, ["explain", file, *arguments, "--configfile", "study.yaml"])


def test_an_older_record_runs_everything_again_and_a_table_holds_one(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = write(copied, "0.10", "0.50")
    assert planned_jobs(copied, *config, "--", TABLE) == {}
    weak = pd.read_csv(copied / TABLE)
    replace(copied, "strong.csv")
    assert (copied / "scenes" / AWKWARD).stat().st_mtime == LONG_AGO[0]
    again = {"stage": 2, "search": 1, "measure": 1, "study": 1}
    assert planned_jobs(copied, *config, "--", TABLE) == again | {"simulate": 2}
    shown = explained(copied, monkeypatch, TABLE)
    assert shown.exit_code == DIFFERS and "motion.data.x" in shown.stdout and "0 of 2 rows agree" in shown.stdout
    config = write(copied, "0.10", "0.30", "0.50")
    assert planned_jobs(copied, *config, "--", TABLE) == again | {"simulate": 3}
    made(copied, *config, "--", TABLE, cores=1)
    peaks = {
        float(np.abs(trajectory.read(copied / RUN.format(S_R))["ground_acceleration"].values).max()) for S_R in ("0.10", "0.30", "0.50")
    }
    assert len(peaks) == 1
    strong = pd.read_csv(copied / TABLE)
    assert list(strong["S_R"]) == [0.1, 0.3, 0.5]
    assert (strong["peak_speed"].iloc[[0, 2]].to_numpy() > 1.3 * weak["peak_speed"].to_numpy()).all()
    shown = explained(copied, monkeypatch, TABLE)
    assert shown.exit_code == 0 and "3 of 3 rows agree" in shown.stdout, shown.output
    assert planned_jobs(copied, *config, "--", TABLE) == {}


def test_with_dates_alone_records_are_not_mixed_either(copied: Path) -> None:
    """``--rerun-triggers mtime`` makes Snakemake blind to contents and to new values: what does not belong together is refused."""
    replace(copied, "strong.csv")
    asked = ("--cores", "1", "--rerun-triggers", "mtime", *write(copied, "0.10", "0.30", "0.50"), "--", TABLE)
    assert planned_jobs(copied, *asked) == {}
    for name in (TABLE, "results/small/draft/study.nc", "results/small/draft/parts/0001.csv"):
        (copied / name).unlink()
    result = snakemake(copied, *asked)
    assert result.returncode != 0 and "motion.data" in result.stdout + result.stderr
    assert not (copied / TABLE).exists()


def test_an_older_scene_file_runs_everything_again(copied: Path) -> None:
    path = copied / "scenes" / "slope.yaml"
    path.write_text(path.read_text().replace("duration: 1.5", "duration: 1.6"))
    os.utime(path, LONG_AGO)
    jobs = planned_jobs(copied, *write(copied, "0.10", "0.50"), "--", TABLE)
    assert jobs["stage"] == 2 and jobs["search"] == 1 and jobs["simulate"] == 2


def test_a_newer_date_alone_runs_nothing(copied: Path) -> None:
    os.utime(copied / "scenes" / AWKWARD)
    assert planned_jobs(copied, *write(copied, "0.10", "0.50"), "--", TABLE) == {}


def test_a_run_copied_over_another_is_not_measured(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config, run = write(copied, "0.10", "0.50"), copied / RUN.format("0.10")
    before = (copied / TABLE).read_bytes()
    shutil.copy(copied / RUN.format("0.50"), run)
    result = snakemake(copied, "--cores", "1", *config, "--", TABLE)
    text = result.stdout + result.stderr
    assert result.returncode != 0 and "coupling.S_R: 0.5 in the file, 0.1 planned" in text
    assert f"{RUN.format('0.10')}: was made from another scene than the one planned; delete it" in text
    shown = explained(copied, monkeypatch, RUN.format("0.10"))
    assert shown.exit_code == DIFFERS and "coupling.S_R" in shown.stdout
    run.unlink()
    made(copied, *config, "--", TABLE, cores=1)
    assert len(pd.read_csv(copied / TABLE)) == len(before.splitlines()) - 1


# ---------------------------------------------------------------- sph explain


def test_a_number_is_traced(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(finished, "0.10", "0.50")
    shown = explained(finished, monkeypatch, TABLE, "S_R=0.1", "--column", "displacement_magnitude")
    assert shown.exit_code == 0, shown.output
    value = pd.read_csv(finished / TABLE, dtype=str)["displacement_magnitude"][0]
    scene = load_scene(finished / "scenes" / "slope.yaml", {"coupling": {"S_R": 0.1}})
    for wanted in (
        RUN.format("0.10"),
        f"scene    {trajectory.scene_digest(scene)}",
        f"motion from {AWKWARD}",
        f"displacement_magnitude = {value} m: magnitude of the probe's permanent displacement",
        "probe A",
        "agrees with the configuration, the files on disk and the installed solver",
    ):
        assert wanted in shown.stdout, wanted
    assert "runout =" not in shown.stdout


def test_what_is_traced_is_there_for_machines(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(finished, "0.10", "0.50")
    found = json.loads(explained(finished, monkeypatch, TABLE, "S_R=0.50", "--json").stdout)
    run, search = found["rows"][0]["runs"]
    assert found["agrees"] and run["file"] == RUN.format("0.50") and search["file"].endswith("yield_acceleration.nc")
    assert run["solver_digest"] == search["solver_digest"] == found["installed_solver"]
    assert run["contents"][0]["section"] == "motion" and len(run["contents"][0]["digest"]) == 16
    numbers = {number["column"]: number for number in found["rows"][0]["numbers"]}
    assert all(number["again"] is not None for number in numbers.values())
    assert numbers["runout"]["unit"] == "m" and float(numbers["runout"]["again"]) == float(numbers["runout"]["value"])


def test_a_search_is_traced_with_what_it_found(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(finished, "0.10", "0.50")
    file = f"{Path(TABLE).parent}/stages/yield_acceleration.nc"
    shown = explained(finished, monkeypatch, file)
    assert shown.exit_code == 0 and "(yield acceleration: " in shown.stdout, shown.output


def test_single_runs_of_other_targets_are_traced_and_checked(copied: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changes = {"S_R": {"variants": {"as it is": {}, "weak": {"coupling": {"S_R": 0.1}}}}}
    scene = {"scene": "scenes/slope.yaml", "cases": {"one": {}}}
    assumptions = scene | {"reference": {"parameter": "S_R", "variant": "as it is"}, "parameters": changes}
    (copied / "assumptions.yaml").write_text(yaml.safe_dump(assumptions, sort_keys=False))
    sweep = {"scene_key": "coupling.S_R", "values": [0.1, 2.0]}
    steps = {"factors": [0.5], "schemes": {"plain": {}}}
    robustness = scene | {"parameters": {"S_R": sweep}, "time_steps": steps}
    (copied / "robustness.yaml").write_text(yaml.safe_dump(robustness, sort_keys=False))
    config = write(copied, "0.10", "0.50", experiments={name: f"{name}.yaml" for name in ("assumptions", "robustness")})
    tables = ("results/assumptions/assumptions.csv", "results/robustness/robustness.csv")
    made(copied, *config, "--", *tables, cores=1)
    for table in tables:
        one, *_ = sorted((copied / table).parent.glob("runs/**/*.nc"))
        shown = explained(copied, monkeypatch, str(one.relative_to(copied)))
        assert shown.exit_code == 0 and "the run agrees" in shown.stdout, shown.output
        shutil.copy(copied / RUN.format("0.50"), one)
    result = snakemake(copied, "--cores", "1", "--keep-going", *config, "--", *tables)
    text = result.stdout + result.stderr
    assert text.count("was made from another scene than the one planned") >= 2
    replace(copied, "strong.csv")
    jobs = planned_jobs(copied, *config, "--", *tables)
    assert jobs == {"simulate": 4, "assumptions_table": 1, "robustness_table": 1}


FAULTS: dict[str, tuple[Callable[[Path], None], str]] = {}


def fault(words: str) -> Callable[[Callable[[Path], None]], Callable[[Path], None]]:
    def known(make: Callable[[Path], None]) -> Callable[[Path], None]:
        FAULTS[make.__name__] = (make, words)
        return make

    return known


@fault("displacement_magnitude: 12.5 in the table, ")
def an_edited_table(folder: Path) -> None:
    table = pd.read_csv(folder / TABLE, dtype=str, keep_default_na=False)
    table.loc[0, "displacement_magnitude"] = "12.5"
    table.to_csv(folder / TABLE, index=False)


@fault("made by the solver 0123; the installed solver is ")
def another_solver(folder: Path) -> None:
    changed(folder, solver_digest="0123")


@fault("version that did not record it")
def an_older_version(folder: Path) -> None:
    changed(folder, solver_digest=None)


@fault("it has been changed")
def another_digest(folder: Path) -> None:
    changed(folder, scene_digest="0123")


@fault("soil.cohesion")
def another_configuration(folder: Path) -> None:
    write(folder, "0.10", "0.50", fidelities={"draft": {"soil": {"cohesion": 30.0}}})


@fault("arrest_time")
def other_settings(folder: Path) -> None:
    write(folder, "0.10", "0.50", metrics={"onset_threshold": 1e-9, "arrest_tolerance": 100.0, "moving_speed": 100.0})


@fault("there is no such file")
def no_run(folder: Path) -> None:
    (folder / RUN.format("0.10")).unlink()


def changed(folder: Path, **attrs: str | None) -> None:
    path = folder / RUN.format("0.10")
    run, restart = trajectory.read(path).dataset(), trajectory.read_restart(path).dataset()
    run.attrs = {name: value for name, value in (run.attrs | attrs).items() if value is not None}
    trajectory.write(path, run, restart)


@pytest.mark.parametrize("name", FAULTS)
def test_what_is_not_as_planned_is_said(copied: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    make, words = FAULTS[name]
    write(copied, "0.10", "0.50")
    make(copied)
    shown = explained(copied, monkeypatch, TABLE, "S_R=0.10")
    assert shown.exit_code == DIFFERS and "DIFFERS: " in shown.stdout and words in shown.stdout, shown.output


def test_refusals_of_explain(finished: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    write(finished, "0.10", "0.50")
    (finished / "results/small/draft/claims.csv").write_text("claim\n1\n")
    shutil.copy(finished / RUN.format("0.10"), tmp_path / "alone.nc")
    for arguments, words in (
        ([TABLE, "gamma=1"], "has no column 'gamma'"),
        ([TABLE, "S_R=0.2"], "has no row with S_R=0.2; it has 2 rows"),
        ([TABLE, "S_R"], "write COLUMN=VALUE"),
        ([TABLE, "--column", "speed"], "--column: 'speed' is not one of "),
        (["results/small/draft/claims.csv"], "is not study.csv of study small, nor a run"),
        (["results/small/draft/absent.csv"], "there is no such file"),
        ([str(tmp_path / "alone.nc")], "is not in a folder 'results'"),
    ):
        shown = explained(finished, monkeypatch, *arguments)
        assert shown.exit_code == REFUSED and words in shown.stderr, shown.output
    (finished / "results/small/draft/claims.csv").unlink()
