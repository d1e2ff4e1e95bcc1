"""The workflow as a user runs it: planned, linted, and a small study from end to end."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from comparison import same_files, same_variables
from forked import snakemake_in
from killing import TIMINGS, killed, start
from small_scenes import SceneBuilder
from typer.testing import CliRunner

from sph.checks.messages import search_words
from sph.command.cli import app
from sph.jobs.log import read_log
from sph.scene.loading import motion_of
from sph.scene.strict_json import parse_json
from sph.stability.newmark import sliding_block
from sph.storage import trajectory
from sph.study.preflight import read_preflight
from sph.study.tables import read_study, read_table

ROOT = Path(__file__).resolve().parents[2]
STUDY: dict[str, Any] = {
    "study": "small",
    "scene": "slope.yaml",
    "fidelity": "draft",
    "grid": {"S_R": ["0.10", "0.50"], "gamma": ["1", "100"], "amplitude": ["0.1", "8.0"]},
    "fidelities": {"draft": {}},
    "figures": {"strengths": ["0.10", "0.50"], "compared_strengths": ["0.10"]},
    "claims": {"amplitude": 8.0},
}
"""Eight runs of 372 particles; at 0.1 m/s2 nothing fails."""
RUN = "results/small/draft/runs/S_R-0.10_gamma-100_amplitude-8.0.nc"


def snakemake_command(folder: Path, *arguments: str) -> list[str]:
    return [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), "--directory", str(folder), *arguments]


def snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return snakemake_in(folder, *snakemake_command(folder, *arguments)[3:])


def made(folder: Path, *arguments: str, cores: int = 2) -> str:
    """What is told of a run of the workflow that ends well."""
    result = snakemake(folder, "--cores", f"{cores}", *arguments)
    assert result.returncode == 0, result.stderr
    return result.stderr


def drawn(folder: Path, *names: str) -> None:
    """Assert that figures are in a folder, as pictures and for print."""
    for name in names:
        picture = folder / f"{name}.png"
        assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 10_000
        assert picture.with_suffix(".pdf").read_bytes().startswith(b"%PDF")


def planned_jobs(folder: Path, *arguments: str) -> dict[str, int]:
    """Rule and number of jobs of a dry run."""
    result = snakemake(folder, "--dry-run", *arguments)
    assert result.returncode == 0, result.stderr
    text = result.stdout + result.stderr
    if "Nothing to be done" in text:
        return {}
    table = text[text.index("Job stats:") :]
    return {name: int(count) for name, count in re.findall(r"^([\w-]+) +(\d+)$", table, re.MULTILINE) if name != "total"}


def write_config(folder: Path, **changes: Any) -> tuple[str, str]:
    path = folder / "study.yaml"
    path.write_text(yaml.safe_dump(STUDY | changes))
    return "--configfile", str(path)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    """Folder of a finished small study."""
    folder = tmp_path_factory.mktemp("study")
    numerics = {"numerics.spacing": 2.5, "numerics.smoothing_ratio": 1.3}
    box = {"geometry.apron_length": 20.0, "geometry.crest_length": 20.0, "geometry.base_depth": 5.0}
    scene = small_slope({"walls.sides": "free_slip", "walls.layers": 4, **numerics, **box})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    config = write_config(folder)
    once = {"all": 1, "check": 1, "preflight": 1, "measure": 1, "study": 1, "claims": 1, "page": 1}
    assert planned_jobs(folder, *config) == once | {"stage": 3, "search": 1, "simulate": 8, "figure": 1}
    told = made(folder, *config)
    assert told.count("results/small/draft/report.html: the study on one page") == 1
    assert told.count("[few-particles]") == 1 and "[stands-unshaken]" not in told, "warnings are said once, notes are not"
    return folder


def test_an_error_that_is_known_before_stops_the_study_before_any_run(tmp_path: Path, small_slope: SceneBuilder) -> None:
    broken = {"lost": {"region": {"kind": "elevation", "bottom": 500.0, "top": 501.0}, "soil": {"cohesion": 5.0}}}
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(small_slope({"layers": broken}).model_dump(mode="json")))
    study = {"study": "broken", "scene": "slope.yaml", "grid": {"S_R": ["0.10", "0.50"]}, "searches": "none"}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study))
    folder, gravity = tmp_path / "results" / "broken" / "own", "results/broken/own/stages/gravity.nc"
    given = ("--cores", "2", "--configfile", str(tmp_path / "study.yaml"))
    stopped = snakemake(tmp_path, *given)
    assert stopped.returncode != 0 and not list(folder.glob("stages/*.nc")) and not list(folder.glob("runs/*.nc"))
    for words in ("S_R-0.10 and 1 more: error: no particle lies in lost", "[layer-broken]", "no further run", "--config on_error=go_on"):
        assert words in stopped.stderr, stopped.stderr
    went_on = snakemake(tmp_path, *given, "--config", "on_error=go_on", "--", gravity, str(folder.relative_to(tmp_path) / "checked.csv"))
    assert went_on.returncode == 0 and (tmp_path / gravity).is_file()
    assert next(row for row in read_preflight(folder / "checked.csv")).finding.code == "layer-broken", "what was found can be read"


def test_the_shipped_study_shares_its_stages() -> None:
    jobs = planned_jobs(ROOT, "--forceall")
    once = {"all": 1, "check": 1, "preflight": 1, "measure": 1, "study": 1, "claims": 1, "page": 1}
    assert jobs == once | {"stage": 4, "search": 1, "simulate": 24, "figure": 1}


@pytest.mark.parametrize(("target", "rule"), [("results/paper/paper/runs/S_R-0.10_gamma-1_amplitude-2.0.nc", "simulate"), ("docs", "docs")])
def test_what_snakemake_tells_of_a_job_fits_a_screen(target: str, rule: str) -> None:
    """What a job depends on but does not read, sources and pages, is a digest and no list of files."""
    result = snakemake(ROOT, "--dry-run", "--forceall", "--printshellcmds", target)
    assert result.returncode == 0, result.stderr
    text = result.stdout + result.stderr
    job = next(part for part in text.split("\n\n") if f"rule {rule}:" in part)
    assert sum(1 + len(line) // 100 for line in job.splitlines()) <= 24 and str(ROOT / "sph") not in job, job


def test_lint_finds_nothing_but_the_missing_containers() -> None:
    """The environment is the project's own (pyproject.toml, constraints.txt), not one a rule."""
    result = snakemake(ROOT, "--lint")
    lints = {line.strip() for line in (result.stdout + result.stderr).splitlines() if line.strip().startswith("*")}
    assert lints == {"* Specify a conda environment or container for each rule.:"}


def test_tables(finished: Path) -> None:
    folder = finished / "results" / "small" / "draft"
    study, table = read_study(folder / "study.nc"), read_table(folder / "study.csv")
    assert dict(study.sizes) == {"S_R": 2, "gamma": 2, "amplitude": 2}
    assert list(table["S_R"].unique()) == ["0.10", "0.50"] and len(table) == 8
    weak, strong = (float(study["displacement_magnitude"].sel(S_R=S_R, gamma=100, amplitude=8)) for S_R in (0.10, 0.50))
    assert weak > strong > 0
    row = table[(table["S_R"] == "0.10") & (table["gamma"] == "100") & (table["amplitude"] == "8.0")].iloc[0]
    assert row["displacement_magnitude"] == weak
    unknown = "not known for this slope" in study.attrs["expected_error"]
    assert study["expected_runout_error"].isnull().all() and unknown, "no variant has this box"
    claims = pd.read_csv(folder / "claims.csv")
    assert list(claims["claim"]) == list(range(1, 13))
    assert set(claims["verdict"]) <= {"holds", "fails", "not yet", "not covered"}


def test_the_sliding_block_beside_every_run(finished: Path) -> None:
    # A shaking of 0.1 m/s2 moves no block, and a stronger one moves it by the same for every S_R and gamma: it loses no strength.
    study = read_study(finished / "results" / "small" / "draft" / "study.nc")
    trials = trajectory.read(finished / "results" / "small" / "draft" / "stages" / "yield_acceleration.nc").dataset()
    found = study["yield_acceleration"].values
    assert trials.attrs["by"] == "yield_acceleration" and np.all(found == trials.attrs["value"])
    assert trials.attrs["error"] > 0.0 and found[0, 0, 0] <= 0.5 * (trials.attrs["stood"] + trials.attrs["failed"])
    assert set(trials["spacing"].values) == {2.5, 10.0 / 6} and set(trials["strength"].values) == {1.0, 1.1}
    slip = study["newmark_displacement"]
    assert (slip.sel(amplitude=0.1) == 0).all() and (slip == slip.isel(S_R=0, gamma=0)).all()
    motion = motion_of(trajectory.scene_of(trajectory.read(finished / RUN)))
    assert slip.sel(amplitude=8.0).values[0, 0] == sliding_block(motion.time, motion.acceleration, found[0, 0, 0]).permanent


def test_what_is_found_before_the_runs_is_in_the_table_the_runs_and_the_page(finished: Path) -> None:
    folder = finished / "results" / "small" / "draft"
    rows = {row.finding.code: row for row in read_preflight(folder / "preflight.csv")}
    # All eight runs have the paper's scheme and one slope.
    assert {"stands-unshaken", "factor-of-safety", "no-process-zone", "few-particles"} <= rows.keys()
    assert rows["stands-unshaken"].runs == rows["no-process-zone"].runs == 8 and rows["few-particles"].finding.severity == "warning"
    assert rows["factor-of-safety"].finding.numbers["value"] > 1.0
    assert "yield-acceleration" not in rows, "one number: that of the search for the sliding block, which the page tells"
    found = set(parse_json(trajectory.read(finished / RUN).attrs["findings"]))
    row = next(row for _, row in read_table(folder / "study.csv").iterrows() if row["S_R"] == "0.10" and row["amplitude"] == "8.0")
    assert set(row["findings"].split()) == found >= {"no-process-zone", "few-particles"}
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Before the runs" in page and "stands-unshaken" in page
    found, how = search_words(trajectory.read(folder / "stages" / "yield_acceleration.nc").attrs)
    assert " ± " in found and found.replace("m/s2", "m/s²") in page and how in page


def test_an_amplitude_that_fails_nothing_needs_no_branches(finished: Path) -> None:
    folder = finished / "results" / "small" / "draft"
    study = read_study(folder / "study.nc")
    assert (study["status"].sel(amplitude=0.1) == "unfailed").all() and (study["status"].sel(amplitude=8.0) == "complete").all()
    pre_failure = trajectory.read(folder / "stages" / "pre_failure_amplitude-0.1.nc").dataset()
    run = trajectory.read(folder / "runs" / "S_R-0.50_gamma-1_amplitude-0.1.nc").dataset()
    assert run.attrs["particle_steps"] == pre_failure.attrs["particle_steps"], "the branch made no step of its own"
    assert trajectory.scene_of(run).coupling.S_R == 0.5
    assert run.equals(pre_failure)


def test_branches_start_from_the_shared_pre_failure_run(finished: Path) -> None:
    folder = finished / "results" / "small" / "draft"
    pre_failure = trajectory.read(folder / "stages" / "pre_failure_amplitude-8.0.nc").dataset()
    assert pre_failure.attrs["status"] == "paused" and not pre_failure["failed"].any()
    shared = pre_failure.sizes["sample"]
    for path in folder.glob("runs/*_amplitude-8.0.nc"):
        run = trajectory.read(path).dataset()
        assert run["failed"].any()
        np.testing.assert_array_equal(run["kinetic_energy"][:shared], pre_failure["kinetic_energy"])


def test_figures_are_drawn(finished: Path) -> None:
    drawn(finished / "results" / "small" / "draft" / "figures", *(f"fig{number}" for number in range(1, 8)))


def test_the_page_holds_the_study(finished: Path) -> None:
    folder = finished / "results" / "small" / "draft"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert all(f"runs/{path.name}" in page for path in folder.glob("runs/*.nc"))
    assert page.count("data:image/png") == 9, "seven figures, and the run that goes farthest, on a desk and on a phone"
    assert "snakemake --cores 2 sensitivity" in page, "not made yet"


def test_a_finished_study_has_nothing_to_do(finished: Path) -> None:
    assert planned_jobs(finished, *write_config(finished)) == {}


def test_a_new_grid_value_runs_only_what_is_new(finished: Path) -> None:
    grid = STUDY["grid"] | {"S_R": ["0.10", "0.30", "0.50"]}
    assert planned_jobs(finished, *write_config(finished, grid=grid)) == {
        "all": 1,
        "check": 1,
        "preflight": 1,
        "simulate": 4,
        "measure": 1,
        "study": 1,
        "claims": 1,
        "page": 1,
    }


def test_short_runs_share_a_job_and_each_is_made_by_itself(finished: Path, copied: Path) -> None:
    """One core makes a missing run and those of a value that is added in one process; runs that are there stay as they are."""
    folder = copied / "results" / "small" / "draft"
    (copied / RUN).unlink()
    before = {path: path.stat().st_mtime_ns for path in folder.glob("*/*.nc")}
    arguments = write_config(copied, grid=STUDY["grid"] | {"S_R": ["0.10", "0.30", "0.50"]})
    files = [
        f"results/small/draft/runs/S_R-0.30_gamma-{gamma}_amplitude-{amplitude}.nc" for gamma in (1, 100) for amplitude in ("0.1", "8.0")
    ]
    assert planned_jobs(copied, *arguments, "--", RUN, *files)["simulate"] == 5
    made(copied, *arguments, "--", RUN, *files, cores=1)
    same_files(copied / RUN, finished / RUN)
    assert {path: path.stat().st_mtime_ns for path in before} == before
    logs = [read_log(copied / file.replace("/runs/", "/logs/").replace(".nc", ".log")) for file in (RUN, *files)]
    assert all(log and log.process for log in logs) and len({log.process.number for log in logs if log and log.process}) == 1
    assert planned_jobs(copied, *arguments, "--", RUN, *files) == {} and not list(folder.rglob(".*"))


def test_a_metric_setting_reruns_no_simulation(finished: Path) -> None:
    assert planned_jobs(finished, *write_config(finished, metrics={"link_length": 3.0})) == {
        "all": 1,
        "measure": 1,
        "study": 1,
        "claims": 1,
        "page": 1,
    }


def test_a_scene_key_reruns_the_stages(finished: Path) -> None:
    jobs = planned_jobs(finished, *write_config(finished, fidelities={"draft": {"soil": {"cohesion": 140.0}}}))
    assert jobs["stage"] == 3 and jobs["search"] == 1 and jobs["simulate"] == 8


def test_a_bad_configuration_is_refused_before_any_job(finished: Path) -> None:
    result = snakemake(finished, "--cores", "1", *write_config(finished, fidelity="best"))
    assert result.returncode != 0 and "fidelity: 'best' is not one of draft" in result.stdout + result.stderr


def sph(*arguments: object) -> str:
    """Output of the command, stderr included."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.output


def said(*arguments: object) -> str:
    """The same without stderr, which holds the progress of what takes longer than a moment."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_status_counts_what_the_workflow_makes(finished: Path, copied: Path) -> None:
    write_config(copied)
    asked = ("status", copied / "results" / "small" / "draft", "--configfile", copied / "study.yaml")
    shown = sph(*asked)
    for wanted in (
        "gravity stage                 1 of 1 done",
        "shaking to the first failure  2 of 2 done",
        "runs                          8 of 8 done (4 unfailed, 4 complete)",
        "yield acceleration            1 of 1 done",
        "all simulations are done",
    ):
        assert wanted in shown
    assert "time left" not in shown
    rows = {row["job"]: row for row in json.loads(said(*asked, "--json"))["jobs"]}
    files = {path.stem for kind in ("runs", "stages") for path in (finished / "results" / "small" / "draft" / kind).glob("*.nc")}
    assert set(rows) == files, "every file that the workflow simulates, and no other"
    assert all(row["took"] >= 0 for row in rows.values())  # 0: a job shorter than a benchmark's clock shows
    (copied / RUN).unlink()
    assert "7 of 8 done (4 unfailed, 3 complete), 1 waiting" in sph(*asked)
    write_config(copied, fidelities={"draft": {"soil": {"cohesion": 140.0}}})
    assert "0 of 8 done, 7 outdated, 1 waiting" in sph(*asked)


# ---------------------------------------------------------------- faults


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """The finished study in a folder of its own, Snakemake's records included."""
    return Path(shutil.copytree(finished, tmp_path / "study"))


def test_the_page_of_the_runs_is_there_before_the_first_search(copied: Path) -> None:
    """By the priorities of jobs that are ready at once; it is not what a finished study waits for."""
    folder = copied / "results" / "small" / "draft"
    page, search = folder / "so_far.html", folder / "stages" / "yield_acceleration.nc"
    search.unlink()
    told = made(copied, *write_config(copied), "--", *(str(path.relative_to(copied)) for path in (search, page)), cores=1)
    assert "small/draft/so_far.html: 8 of 8 runs; to be read until report.html takes its place" in told
    assert page.stat().st_mtime_ns < search.stat().st_mtime_ns and "Yield acceleration" in page.read_text(encoding="utf-8")
    jobs = planned_jobs(ROOT, "--config", "fidelity=fine", "--", "results/paper/fine/report.html")
    assert jobs["answer"] == 1, "its searches take long"


@pytest.mark.long
def test_what_another_target_has_made_comes_onto_the_page(copied: Path) -> None:
    table = copied / "results" / "small" / "draft" / "sensitivity" / "morris.csv"
    table.parent.mkdir()
    table.write_text("parameter,share\ncohesion,0.5\n")
    assert planned_jobs(copied, *write_config(copied)) == {"all": 1, "page": 1}
    made(copied, *write_config(copied), cores=1)
    page = (copied / "results" / "small" / "draft" / "report.html").read_text(encoding="utf-8")
    assert "snakemake --cores 2 sensitivity" not in page and "cohesion" in page
    assert planned_jobs(copied, *write_config(copied)) == {}


@pytest.mark.parametrize("path", sorted((ROOT / "workflow" / "rules").glob("*.smk")), ids=lambda path: path.stem)
def test_every_result_in_snakemakes_report_has_a_caption_a_category_and_a_label(path: Path) -> None:
    """With one key of labels throughout: Snakemake shows bare file names in a category where one is missing."""
    text = path.read_text(encoding="utf-8")
    for marked in re.findall(r"^ +shown\((.+?)\),$", text, re.MULTILINE | re.DOTALL):
        assert re.search(r"""\.\w+",\s+"[\w ]+",\s+"[^"]*",?\s*$""", marked), marked
    if path.stem == "common":  # whose words are those of other files
        assert (path.parents[1] / "report" / "about.rst").is_file()
        return
    for marked in text.split(" report(")[1:]:
        written = marked.partition("),\n")[0]
        caption = re.search(r'caption="([^"]+)"', written)
        assert caption and (path.parent / caption[1]).is_file() and 'category="' in written and 'labels={"shows": "' in written


@pytest.mark.long
def test_snakemakes_own_report_takes_the_page_in(copied: Path) -> None:
    result = snakemake(copied, *write_config(copied), "--report", "report.zip")
    assert result.returncode == 0, result.stderr
    names = zipfile.ZipFile(copied / "report.zip").namelist()
    assert any(name.endswith("report.html") and "data" in name for name in names), names


@pytest.mark.long
@pytest.mark.parametrize(("removed", "after"), [(["runs/*_gamma-1_*.nc"], 5.0), ([], 3.0)], ids=["simulating", "measuring"])
def test_a_study_killed_with_its_jobs_is_finished_by_the_same_command(
    finished: Path, copied: Path, removed: list[str], after: float
) -> None:
    """After ``--unlock``, and with ``--rerun-incomplete``: Snakemake asks for these."""
    for pattern in ("study.*", *removed):
        for path in (copied / "results" / "small" / "draft").glob(pattern):
            path.unlink()
    arguments = ["--cores", "2", *write_config(copied), "--rerun-incomplete", "results/small/draft/study.csv"]
    hit = killed(start(snakemake_command(copied, *arguments), copied), after)
    assert not hit or snakemake(copied, *arguments, "--unlock").returncode == 0
    result = snakemake(copied, *arguments)
    assert result.returncode == 0, result.stderr
    for path in finished.glob("results/small/draft/runs/*.nc"):
        same_files(copied / path.relative_to(finished), path)
    one, other = (read_study(folder / "results" / "small" / "draft" / "study.nc") for folder in (finished, copied))
    same_variables(one.drop_vars(TIMINGS), other.drop_vars(TIMINGS))
    assert not list((copied / "results").rglob(".*"))


def test_a_failed_job_tells_its_reason(copied: Path) -> None:
    """In one line on stderr, beside Snakemake's own words, and in the job's log; earlier results stay."""
    folder = copied / "results" / "small" / "draft"
    stage = folder / "stages" / "pre_failure_amplitude-8.0.nc"
    stage.write_bytes(stage.read_bytes()[:10_000])
    before = {path: path.read_bytes() for path in folder.glob("runs/*_amplitude-0.1.nc")}
    shutil.rmtree(folder / "logs")
    (copied / RUN).unlink()
    result = snakemake(copied, "--cores", "1", *write_config(copied), "--", RUN)
    assert result.returncode != 0
    reason = f"{stage.relative_to(copied)}: cannot be read as a trajectory"
    assert reason in result.stderr + result.stdout
    log = (folder / "logs" / Path(RUN).with_suffix(".log").name).read_text()
    first, *_, said, last = log.splitlines()
    assert json.loads(first)["record"] == "process" and reason in said and "delete it and repeat its command" in said
    assert reason in json.loads(last)["reason"] and json.loads(last)["record"] == "failed"
    assert before and all(path.read_bytes() == data for path, data in before.items())
    # The remedy is the one that the line names.
    stage.unlink()
    assert planned_jobs(copied, *write_config(copied), "--", RUN) == {"stage": 1, "simulate": 1}


@pytest.mark.long
def test_results_from_the_future(finished: Path, copied: Path) -> None:
    """A clock that was wrong: inputs newer than now are worked up once, and to the same result."""
    stage = copied / "results" / "small" / "draft" / "stages" / "pre_failure_amplitude-8.0.nc"
    os.utime(stage, (2**33, 2**33))
    made(copied, *write_config(copied), "--", RUN, cores=1)
    same_files(copied / RUN, finished / RUN)
