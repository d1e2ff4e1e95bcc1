"""The page of a study that is under way: what it says of a part of the runs, and that it grows with them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from synthetic import PAPER, synthetic, translation
from typer.testing import CliRunner

import sph.command.page as page_of
from sph.checks.finding import finding
from sph.command.cli import app
from sph.command.study import find_study
from sph.jobs.exit_codes import REFUSED
from sph.jobs.log import job_log
from sph.storage import trajectory
from sph.study.plan import Plan
from sph.study.planned import digest, planned
from sph.study.preflight import Row, looked_at, write_preflight
from sph.study.tables import read_table

FOLDER = "results/growing/own"


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plan:
    """A study of four runs, in the working folder."""
    monkeypatch.chdir(tmp_path)
    config = {
        "study": "growing",
        "scene": "slope.yaml",
        "grid": {"S_R": ["0.10", "0.50"], "amplitude": ["4.0", "6.0"]},
        "metrics": {"places": {"house": "8 beyond the toe"}},
        "searches": "quick",
        "fidelities": {"own": {}, "coarse": {"numerics": {"spacing": 6.25}}, "fine": {"numerics": {"spacing": 2.5}}},
        "second_fidelity": "coarse",
    }
    Path("study.yaml").write_text(yaml.safe_dump(config))
    Path("slope.yaml").write_text(yaml.safe_dump(PAPER | {"numerics": {"spacing": 5.0}}))
    return find_study(Path("study.yaml")).plan


def finish(plan: Plan, name: str, slip: float) -> None:
    run = synthetic(translation(slip), overrides=plan.shared.runs[name].scene)
    run.attrs["particle_steps"] = 6_000_000
    trajectory.write(plan.shared.runs[name].file, run.trajectory)


def call(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["page", *map(str, arguments)])


def words() -> str:
    """What a reader sees first."""
    page = Path(FOLDER, page_of.PAGE).read_text()
    return " ".join(re.sub(r"<[^>]*>", " ", page[page.index("</style>") : page.index("<h2>One run</h2>")]).split())


def test_a_page_of_some_runs_says_which_are_missing_and_nothing_of_them(plan: Plan) -> None:
    Path(FOLDER).mkdir(parents=True)
    Path(FOLDER, page_of.PAGE).write_text("of another plan")
    refused = call("study.yaml")
    assert refused.exit_code == REFUSED and "no run is done yet" in refused.stderr and "--watch" in refused.stderr
    assert not Path(FOLDER, page_of.PAGE).exists(), "it told of runs that are not planned now"
    scenes = {name: planned(run.scene) for name, run in looked_at(plan).items()}
    for job, table, runs, of in (
        ("check", "checked", 4, digest(scenes)),
        ("preflight", "preflight", 6, digest(dict(list(scenes.items())[:2]))),  # of an earlier plan, which named these runs too
    ):
        with job_log(f"{FOLDER}/logs/{job}.log", of=of):
            kinds = (
                finding("stands-unshaken", spacing=5.0, run_spacing=5.0),
                finding("few-particles", "numerics.spacing", value=4.0, bound=20.0, height=10.0),
            )
            write_preflight(f"{FOLDER}/{table}.csv", [Row(each, runs, "S_R-0.50_amplitude-4.0") for each in kinds])
    finish(plan, "S_R-0.50_amplitude-4.0", 0.0)
    assert call("study.yaml").stdout.strip() == f"{FOLDER}/{page_of.PAGE}: 1 of 4 runs"
    first = words()
    for said in (
        "1 of 4 runs over",
        "So far 1 of 4 runs are done, and what is said here is of these alone. At 4 m/s²",
        "3 runs are still to come",
        "S_R 0.10, amplitude 4.0 m/s² (0.408 g): waiting",
        "house 0 of 1 no soil that fails comes within 8.00 m",
        "no failure found so far up to 4 m/s²",
        "still to come",
        "stands by a static test",
        "Factor of safety still to come",
        "Yield acceleration not searched",
        "4 of 4 runs: ",
    ):
        assert said in first, first
    assert "6 of" not in first, "found in other scenes"
    assert first.count("…") == 3, "cells of the matrix"
    assert 'http-equiv="refresh"' not in Path(FOLDER, page_of.PAGE).read_text()
    assert not Path(FOLDER, "report.html").exists() and not Path(FOLDER, "study.csv").exists(), "those are the workflow's"


def test_the_page_grows_until_all_runs_are_there(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    left, pages, measured = list(plan.study.runs), [], []

    def one_more(seconds: float) -> None:
        assert seconds >= page_of.REFRESH
        finish(plan, left.pop(), -3.0)

    run_values = page_of.run_values
    monkeypatch.setattr(page_of.clock, "sleep", one_more)
    monkeypatch.setattr(page_of, "run_values", lambda run, *rest: measured.append(run) or run_values(run, *rest))
    monkeypatch.setattr(page_of, "write_page", lambda path, study: pages.append((len(read_table(study.table, plan.layout)), study)))
    told = call("study.yaml", "--watch")
    assert told.exit_code == 0, told.output
    assert [(rows, len(study.runs), len(study.missing), study.renewed) for rows, study in pages] == [
        (1, 1, 3, page_of.RENEWED), (2, 2, 2, page_of.RENEWED), (3, 3, 1, page_of.RENEWED), (4, 4, 0, 0)
    ]  # fmt: skip
    assert len(measured) == 4, "each run is measured once"
    assert pages[-1][1].to_come == ["stands-unshaken", "factor-of-safety"], "no search is done"
    assert f"{FOLDER}/{page_of.PAGE}: 4 of 4 runs\n" in told.stderr
    assert told.stdout.strip() == f"{FOLDER}/report.html follows when snakemake is done"


def test_the_draft_of_a_study_is_shown_before_its_runs(plan: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert plan.draft is not None and plan.draft.folder == "results/growing/coarse"
    Path("finer.yaml").write_text(Path("study.yaml").read_text().replace("second_fidelity: coarse", "second_fidelity: fine"))
    assert find_study(Path("finer.yaml")).plan.draft is None, "finer particles come last"
    finish(plan.draft, "S_R-0.10_amplitude-4.0", -3.0)
    monkeypatch.setattr(page_of, "write_page", lambda path, study: None)
    assert call("study.yaml").stdout.strip() == "results/growing/coarse/so_far.html: 1 of 4 runs"
    Path("results/growing/coarse/report.html").touch()
    assert "; there is results/growing/coarse/report.html: of fidelity coarse" in call("finer.yaml").stderr, "no run of its own yet"


def test_the_workflow_tells_the_runs_before_searches_that_take_long(plan: Plan) -> None:
    """And those of the draft before all others."""
    assert page_of.ahead_of_page(plan) == ["results/growing/coarse"], "the searches of this study are quick"
    full = yaml.safe_load(Path("study.yaml").read_text()) | {"searches": "full"}
    long = full | {"second_fidelity": None, "fidelities": {"own": {"numerics": {"spacing": 0.25}}, "coarse": {}}}
    for study, told in ((full, ["results/growing/coarse"]), (long, [FOLDER])):
        Path("other.yaml").write_text(yaml.safe_dump(study))
        assert page_of.ahead_of_page(find_study(Path("other.yaml")).plan) == told
