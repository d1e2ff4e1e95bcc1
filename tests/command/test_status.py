"""Progress of a study, read from its files alone: every state a job can be in, what is left, and that nothing is touched."""

from __future__ import annotations

import io
import json
import math
import os
import platform
import re
import time as clock
from pathlib import Path
from typing import Any

import netCDF4
import psutil
import pytest
import yaml
from small_scenes import SLOPE, SceneBuilder
from typer.testing import CliRunner

from sph.command.cli import app
from sph.command.status import MADE, Estimate, State, estimate, look, look_at, look_beside, sentence, watch
from sph.command.study import find_study
from sph.jobs.exit_codes import REFUSED
from sph.jobs.log import FRESH, PROCESS, PROGRESS, Process, job_log, line_of, read_log
from sph.jobs.progress import SECONDS, reporter
from sph.scene.schema import make_scene
from sph.solver.run import Progress
from sph.study.cost import TRIALS, cost, job_cost
from sph.study.plan import Plan
from sph.study.preflight import plan_seconds

POINT = "S_R-0.10_gamma-1_amplitude-8.0"
HERE = Process(platform.node(), os.getpid(), psutil.Process().create_time() + 0.1)
GONE = HERE._replace(started=HERE.started - 1000.0)
"""The same number, given again since."""


class Folder:
    """A study of eight runs and what its jobs leave."""

    def __init__(self, base: Path, plan: Plan) -> None:
        self.base, self.plan, self.path = base, plan, base / plan.folder
        self.jobs = {state.job.run.id: state.job for state in look_at(plan.jobs, base)}

    def finish(self, name: str, took: float, status: str = "complete", **changes: Any) -> None:
        path = self.base / self.jobs[name].run.file
        path.parent.mkdir(parents=True, exist_ok=True)
        scene = json.loads(self.jobs[name].scene.model_dump_json())
        with netCDF4.Dataset(path, "w") as ds:
            ds.setncatts({"scene": json.dumps(scene | changes), "status": status, "wall_time_s": took})
        benchmark = self.path / "benchmarks" / f"{name}.tsv"
        benchmark.parent.mkdir(parents=True, exist_ok=True)
        benchmark.write_text(f"s\th:m:s\n{took}\t0:00:00\n")

    def log(self, name: str, process: Process, *lines: str, age: float = 0.0) -> None:
        path = self.path / "logs" / f"{name}.log"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join([line_of(PROCESS, **process._asdict()), *lines]) + "\n")
        os.utime(path, (path.stat().st_mtime - age,) * 2)

    def state(self, name: str) -> State:
        return look(self.jobs[name], self.base)

    def states(self) -> list[State]:
        return [self.state(name) for name in self.jobs]


PAPERS = {
    "grid": {"S_R": ["0.10", "0.50"], "gamma": ["1", "100"], "amplitude": ["0.1", "8.0"]},
    "figures": {"strengths": ["0.10", "0.50"], "compared_strengths": ["0.10"]},
    "claims": {"amplitude": 8.0},
}
"""Keys of a study over the paper's dimensions."""


@pytest.fixture(params=[PAPERS], ids=[""])
def study(request: pytest.FixtureRequest, tmp_path: Path, small_slope: SceneBuilder) -> Folder:
    config = {
        "study": "small",
        "scene": "slope.yaml",
        "fidelity": "draft",
        "fidelities": {"draft": {}, "coarse": {"numerics": {"smoothing_ratio": 1.3}}},
        **request.param,
    }
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "config.yaml").write_text(yaml.safe_dump(config))
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    return Folder(tmp_path, find_study(tmp_path / "results" / "small" / "draft", None).plan)


def progress(time: float, elapsed: float) -> Progress:
    return Progress(time, 3.0, 1000, elapsed, 0.25)


def told(time: float, left: float = math.nan) -> str:
    """The line of a progress record."""
    return line_of(PROGRESS, **progress(time, 10.0)._asdict(), left=left)


def test_a_study_not_begun_waits(study: Folder) -> None:
    assert [state.state for state in study.states()] == ["waiting"] * 12
    assert len(study.jobs) == 1 + 2 + 8 + 1


def test_done_is_a_file_of_this_configuration(study: Folder) -> None:
    study.finish(POINT, 5.0)
    assert study.state(POINT)[1:3] == ("done", "complete") and study.state(POINT).took == 5.0
    study.finish(POINT, 5.0, duration=4.0)
    assert study.state(POINT)[1:3] == ("outdated", "of another scene")
    study.finish(POINT, 5.0, early_stop=None)
    assert study.state(POINT).state == "done", "an earlier version wrote no key that has been added since"
    (study.base / study.jobs[POINT].run.file).write_bytes(b"half a file")
    assert study.state(POINT)[1:3] == ("outdated", "cannot be read: NetCDF: Unknown file format")


def test_a_diverged_run_is_done(study: Folder) -> None:
    study.finish(POINT, 5.0, "diverged")
    assert study.state(POINT)[1:3] == ("done", "diverged")


def test_running_is_told_by_the_process_in_the_log(study: Folder) -> None:
    study.log(POINT, HERE)
    assert study.state(POINT)[1:3] == ("running", "compiling or reading")
    lines = ("a line for people: 2.50 of 3 s", told(1.01), told(1.80, 90.0), "{a line for people}")
    study.log(POINT, HERE, *lines, age=20.0)
    state = study.state(POINT)
    assert (state.state, state.time) == ("running", 1.8) and state.left == pytest.approx(70.0, abs=2.0)
    study.log(POINT, GONE, *lines)
    assert study.state(POINT).state == "waiting"
    elsewhere = HERE._replace(machine="another-machine")
    study.log(POINT, elsewhere, *lines)
    assert study.state(POINT).state == "running"
    study.log(POINT, elsewhere, *lines, age=FRESH + 1.0)
    assert study.state(POINT).state == "waiting"


def test_a_killed_job_is_stopped(study: Folder) -> None:
    study.log(POINT, GONE, told(1.80, 90.0))
    (study.path / "runs").mkdir()
    (study.path / "runs" / f".{POINT}.nc.checkpoint").touch()
    assert (study.state(POINT).state, study.state(POINT).time) == ("stopped", 1.8)


@pytest.mark.parametrize(
    ("error", "wanted"), [(OSError("stage.nc: cannot be read\nmore"), "stage.nc: cannot be read"), (KeyError("x"), "KeyError('x')")]
)
def test_a_failed_job_says_why(study: Folder, error: Exception, wanted: str) -> None:
    with pytest.raises(SystemExit), job_log(study.path / "logs" / f"{POINT}.log") as log:
        with reporter("results/run.nc", make_scene(SLOPE), log) as report:
            report(progress(1.5, 10.0))
        raise error
    state = study.state(POINT)
    assert state[1:4] == ("failed", wanted, 1.5)


def test_the_log_begins_with_its_process(tmp_path: Path) -> None:
    with job_log(tmp_path / "job.log") as log:
        print("a line", file=log)
        read = read_log(tmp_path / "job.log")
        assert read is not None and read.time is read.left is read.reason is None and read.process is not None
        assert read.process.number == os.getpid() and read.process.alive(math.inf)
    assert read_log(tmp_path / "absent.log") is None


def test_lines_come_at_every_tenth_and_every_half_minute(tmp_path: Path) -> None:
    path = tmp_path / "log"
    with path.open("w") as stream, reporter("run", make_scene(SLOPE), stream) as tell:
        for step in range(100):
            tell(progress(0.3 + 0.001 * step, 2.0 * step))
    lines = path.read_text().splitlines()
    assert len(lines) == 1 + int(198 / SECONDS), "a run as slow as this one passes less than a tenth in 200 s"
    assert "left" not in lines[0] and lines[-1].startswith("run: 0.39 of 3 s, 25% failed, ") and lines[-1].endswith(", 5220 s left")


def left(study: Folder) -> Estimate:
    return estimate(study.plan, study.states(), look_beside(study.plan, study.base))


def made(study: Folder) -> None:
    """The tables of the tests and searches beside the runs."""
    study.path.mkdir(parents=True, exist_ok=True)
    for table in MADE.values():
        (study.path / table).write_text("")


def test_the_time_left_is_that_of_finished_jobs_of_the_kind(study: Folder) -> None:
    settled, runs = cost(study.jobs["gravity"].scene, until=1.0), [job for job in study.jobs.values() if job.is_run]
    study.finish("gravity", 2.0 * settled.seconds)  # half the speed of the reference machine
    made(study)
    parts = [job_cost(job.run).seconds for name, job in study.jobs.items() if name != "gravity"]
    found = left(study)
    assert found.work == pytest.approx(2.0 * math.fsum(parts)) and found.unknown == 0 and math.isnan(found.time)
    assert found.searches == pytest.approx(2.0 * job_cost(study.jobs["yield_acceleration"].run).seconds)
    study.finish("pre_failure_amplitude-8.0", 3.0)
    study.finish("pre_failure_amplitude-0.1", 1.0)
    study.finish("yield_acceleration", 7.0)
    assert left(study).work == pytest.approx(2.0 * math.fsum(job_cost(job.run).seconds for job in runs)) and left(study).searches == 0.0
    study.finish(POINT, 20.0)
    study.finish(POINT.replace("8.0", "0.1"), 2.0, "unfailed")
    assert left(study).work == pytest.approx(3 * 20.0 + 3 * 2.0) and left(study).unknown == 0
    running = POINT.replace("0.10", "0.50")
    study.log(running, HERE, told(1.80, 50.0))
    found = left(study)
    assert found.work == pytest.approx(2 * 20.0 + 3 * 2.0 + 50.0, abs=2.0) == found.time
    study.log(running.replace("1_", "100_"), HERE)
    assert left(study).time == pytest.approx(50.0, abs=2.0), "two at work, of which one takes longer than half of all"


def test_searches_that_run_are_counted(study: Folder) -> None:
    """A search that has run for a while and the one beside the runs: what the cost predicts of them, less the time that has passed."""
    for name, job in study.jobs.items():
        if name != "yield_acceleration":
            study.finish(name, 100.0 * cost(job.scene).seconds)
    assert sentence(study.plan, study.states()).startswith("nothing is running; ")
    search = 100.0 * job_cost(study.jobs["yield_acceleration"].run).seconds
    _, limits = (100.0 * seconds for seconds in plan_seconds(study.plan))
    (study.path / MADE["check"]).write_text("")
    begun = HERE._replace(started=clock.time() - 10.0)
    study.log("yield_acceleration", begun._replace(machine="another-machine"))
    found = left(study)
    assert found.work == found.searches == pytest.approx(search - 10.0 + limits, rel=0.01) and found.unknown == 0
    assert "of computing are static tests and searches" in call(study.path).stdout.splitlines()[-1]
    study.finish("yield_acceleration", 1.0)
    study.log("preflight", begun._replace(machine="another-machine", started=clock.time() - 10.0 * limits))
    assert left(study).time == pytest.approx(limits / TRIALS), "longer than predicted: another of its tests"
    assert call(study.path).stdout.splitlines()[-1].startswith("time left: about ")
    made(study)
    study.log("preflight", GONE)
    assert call(study.path).stdout.splitlines()[-1].startswith("all simulations are done")


@pytest.mark.parametrize("study", [{"grid": {"S_R": ["0.10", "0.50"]}, "second_fidelity": "coarse"}], indirect=True)
def test_the_runs_of_the_second_fidelity_are_told_apart(study: Folder) -> None:
    rows = dict(re.split(r"  +", row.strip()) for row in call(study.path).stdout.splitlines()[1:-3])
    assert rows["runs"] == rows["runs of fidelity coarse"] == "0 of 2 done, 2 waiting"
    name = next(name for name, job in study.jobs.items() if job.is_run)
    log = study.base / study.jobs[name].run.log
    log.parent.mkdir(parents=True)
    log.write_text(line_of(PROCESS, **HERE._asdict()))
    assert f"running: {name} of fidelity coarse: compiling or reading" in call(study.path).stdout, "the later one of a name"


@pytest.mark.parametrize("study", [{"grid": {"S_R": ["0.10", "0.50"]}}], indirect=True)
def test_a_stage_that_all_runs_share_is_none_of_them(study: Folder) -> None:
    """Over S_R alone its name is the bare kind; what it took says nothing of the runs after it."""
    study.finish("gravity", cost(study.jobs["gravity"].scene, until=1.0).seconds)
    study.finish("pre_failure", 1000.0)
    assert left(study).work < 1000.0


@pytest.mark.parametrize("study", [{"grid": {"S_R": ["0.10", "0.50"]}, "second_fidelity": "coarse"}], indirect=True)
def test_any_gravity_stage_tells_the_speed(study: Folder) -> None:
    """Also that of the coarser fidelity, which is made first: what is not measured is then predicted."""
    ahead = next(job for job in study.jobs.values() if job.run.group.startswith("gravity at"))
    study.finish(ahead.run.id, 2.0 * cost(ahead.scene, until=1.0).seconds)
    states = look_at(study.plan.jobs, study.base)
    assert [state.state for state in states].count("done") == 1 and states[0].state == "waiting"
    parts = [job_cost(state.job.run).seconds for state in states if state.state == "waiting"]
    found = estimate(study.plan, states, look_beside(study.plan, study.base))
    assert found.unknown == 0 and found.work == pytest.approx(2.0 * math.fsum([*parts, *plan_seconds(study.plan)]))


def test_a_time_that_counts_some_jobs_only_is_a_bound(study: Folder) -> None:
    made(study)
    study.log("gravity", HERE, told(0.5, 50.0))
    words = sentence(study.plan, study.states())
    assert words.startswith("time left: at least 50 s with the 1 running now") and "11 jobs of unknown time not counted" in words


def test_words_for_what_is_left(study: Folder) -> None:
    made(study)
    assert sentence(study.plan, study.states()) == "nothing is running; time left: unknown until the first job is done"
    study.log("gravity", HERE)
    assert sentence(study.plan, study.states()) == "time left: unknown until the first job is done"
    study.finish("gravity", 6.0)
    words = sentence(study.plan, study.states())
    assert words.startswith("nothing is running; ") and " of computing remaining, from 1 benchmark; " in words
    assert words.endswith("are static tests and searches")
    for name in study.jobs:
        study.finish(name, 1.0)
    assert sentence(study.plan, study.states()).startswith("all simulations are done")


def test_what_goes_on_beside_the_simulations_is_named(study: Folder) -> None:
    study.log("check", HERE)
    study.log("preflight", GONE)
    with pytest.raises(SystemExit), job_log(study.path / "logs" / "page.log", io.StringIO()):
        raise ValueError("no table")
    shown = call(study.path).stdout.splitlines()
    assert shown[-4:] == [
        "  running: check: static tests of the slopes",
        "  failed: page: no table",
        "  waiting: preflight: searches for limits of the slopes",
        "time left: unknown until the first job is done",
    ]
    assert [each["job"] for each in json.loads(call(study.path, "--json").stdout)["beside"]] == ["check", "page", "preflight"]
    refused = CliRunner().invoke(app, ["page", str(study.path)])
    assert refused.exit_code == REFUSED and "no run is done yet; at work: check" in refused.stderr


def test_a_killed_snakemake_leaves_a_lock_and_the_way_out_is_told(study: Folder) -> None:
    (study.base / ".snakemake" / "locks").mkdir(parents=True)
    assert "--unlock" not in call(study.path).stdout, "nothing is locked"
    (study.base / ".snakemake" / "locks" / "0.output.lock").touch()
    assert "--unlock" in call(study.path).stdout.splitlines()[-1]
    study.log("gravity", HERE)
    assert "--unlock" not in call(study.path).stdout, "by a snakemake that is at work"


def test_a_lock_of_work_elsewhere_names_that(study: Folder) -> None:
    """No advice to unlock the folder of a run in progress."""
    (study.base / ".snakemake" / "locks").mkdir(parents=True)
    (study.base / ".snakemake" / "locks" / "0.output.lock").touch()
    log = study.base / "results" / "other" / "coarse" / "logs" / "yield_acceleration.log"
    log.parent.mkdir(parents=True)
    log.write_text(line_of(PROCESS, **HERE._asdict()))
    last = call(study.path).stdout.splitlines()[-1]
    assert last == "at work in this folder, which locks it: results/other/coarse; sph status FOLDER shows it"
    log.write_text(line_of(PROCESS, **GONE._asdict()))
    assert "--unlock" in call(study.path).stdout.splitlines()[-1]


def test_a_configuration_is_followed_at_the_fidelity_started_last(study: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """By ``--config fidelity=coarse``: its searches run there, in no job of the configuration's own fidelity."""
    monkeypatch.chdir(study.base)
    assert "results/small/draft: " in call("config/config.yaml").stdout
    other = study.path.with_name("coarse")
    log = other / "logs" / "yield_acceleration.log"
    log.parent.mkdir(parents=True)
    (other / "plan.json").write_text("{}")
    log.write_text(line_of(PROCESS, **HERE._asdict()))
    for shown in (call("config/config.yaml").stdout, call().stdout):
        assert "results/small/coarse: " in shown and "running: yield_acceleration: 0 trials so far" in shown
    assert "results/small/draft: " in call(study.path).stdout, "a folder is that of its fidelity"
    os.utime(other / "plan.json", (0.0, 0.0))
    (study.path).mkdir(exist_ok=True)
    (study.path / "plan.json").write_text("{}")
    assert "results/small/draft: " in call("config/config.yaml").stdout


def call(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["status", *map(str, arguments)])


def test_the_command_touches_nothing_and_works_from_either_end(study: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    study.finish("gravity", 6.0)
    study.log("pre_failure_amplitude-8.0", HERE, told(1.80, 50.0))
    before = {path: path.stat().st_mtime_ns for path in study.base.rglob("*")}
    named = call(study.path)
    assert named.exit_code == 0, named.output
    for text in (
        "gravity stage                 1 of 1 done",
        "0 of 2 done, 1 running, 1 waiting",
        "running: pre_failure_amplitude-8.0: at 1.80 s",
        "50 s left",
    ):
        assert text in named.stdout or text.replace("50", "49") in named.stdout
    monkeypatch.chdir(study.base)
    assert call().stdout.splitlines()[:5] == named.stdout.splitlines()[:5]
    rows = json.loads(call("--json").stdout)
    assert [row["state"] for row in rows["jobs"]][:4] == ["done", "waiting", "running", "waiting"] and rows["fidelity"] == "draft"
    assert {path: path.stat().st_mtime_ns for path in study.base.rglob("*")} == before


def test_another_fidelity_is_another_folder(study: Folder) -> None:
    study.finish("gravity", 6.0)
    other = call(study.path.with_name("coarse"))
    assert other.exit_code == 0 and "fidelity coarse" in other.stdout and "0 of 1 done" in other.stdout


@pytest.mark.parametrize(
    ("folder", "wanted"),
    [
        ("results/small/best", ("fidelity: 'best' is not one of coarse, draft",)),
        ("results/other/draft", ("the configuration's study is 'small'", "--configfile")),
        ("small/draft", ("results/<study>/<fidelity>",)),
    ],
)
def test_a_folder_that_is_no_study_is_refused(study: Folder, folder: str, wanted: tuple[str, ...]) -> None:
    result = call(study.base / folder)
    assert result.exit_code == REFUSED
    for text in wanted:
        assert text in result.stderr


def test_a_configuration_of_another_name(study: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """As with Snakemake's option of that name, it lies over ``config/config.yaml``."""
    (study.base / "mine.yaml").write_text("study: mine\n")
    assert "results/mine/draft" in call(study.base / "results" / "mine" / "draft", "--configfile", study.base / "mine.yaml").stdout
    monkeypatch.chdir(study.base)
    assert "results/mine/draft" in call("mine.yaml").stdout, "or the configuration alone"
    assert "give one of them" in call("mine.yaml", "--configfile", "mine.yaml").stderr
    (study.base / "config" / "config.yaml").unlink()
    assert "config/config.yaml: no such file; " in call().stderr and "give its configuration" in call().stderr


def test_a_folder_of_one_s_own_needs_no_shipped_configuration(study: Folder) -> None:
    (study.base / "config" / "config.yaml").rename(study.base / "study.yaml")
    assert "results/small/draft" in call(study.path).stdout
    (study.base / "study.yaml").unlink()
    refused = call(study.path)
    assert refused.exit_code == REFUSED and f"no configuration of it is found in {study.base}" in refused.stderr


def test_the_configuration_of_a_folder_of_results_is_found_by_the_name_of_its_study(study: Folder) -> None:
    (study.base / "config" / "studies").mkdir()
    (study.base / "config" / "studies" / "mine.yaml").write_text("study: mine\n")
    (study.base / "config" / "broken.yaml").write_text("study: [mine\n")
    shown = call(study.base / "results" / "mine" / "draft")
    assert shown.exit_code == 0 and "results/mine/draft" in shown.stdout, shown.output
    (study.base / "second.yaml").write_text("study: mine\n")
    refused = call(study.base / "results" / "mine" / "draft")
    both = "several files are configurations of this study: second.yaml, config/studies/mine.yaml; give the one with --configfile"
    assert refused.exit_code == REFUSED and both in refused.stderr
    # A copy of the study with another scene is not that of these results.
    scene = yaml.safe_load((study.base / "config" / "config.yaml").read_text())["scene"]
    (study.base / "config" / "studies" / "mine.yaml").write_text(f"study: mine\nscene: {scene}\ngrid: {{S_R: [0.5]}}\n")
    (study.base / "results" / "mine" / "scene_file.txt").parent.mkdir(parents=True, exist_ok=True)
    (study.base / "results" / "mine" / "scene_file.txt").write_text(f"{scene}\n")
    again = call(study.base / "results" / "mine" / "own")
    assert again.exit_code == 0, again.output


def test_watching_ends_with_the_study(study: Folder, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    left = list(study.jobs)

    def one_more(seconds: float) -> None:
        if left:
            study.finish(left.pop(), 1.0)
        else:
            made(study)

    monkeypatch.setattr("sph.command.status.clock.sleep", one_more)
    watch(study.plan, study.states, study.base)
    assert capsys.readouterr().out.count("results/small/draft: study small") == 2 + len(study.jobs), "one for every change"
