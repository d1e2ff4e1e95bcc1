"""``sph cost``: what a study is predicted to take, from its configuration and what of it is done; no clock is read."""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import netCDF4
import pytest
import yaml
from small_scenes import SceneBuilder
from typer.testing import CliRunner

from sph.checks.stability import settled
from sph.command.cli import app
from sph.command.cost import card_speed_here, coarse, speed_here, study_cost
from sph.command.status import Job, look_at
from sph.command.study import find_study
from sph.jobs.exit_codes import REFUSED
from sph.scene.schema import make_scene
from sph.solver.cuda import ensemble
from sph.solver.simulation import Simulation
from sph.stability.extrapolation import at_spacing
from sph.stability.safety import DEFAULT_RULE
from sph.stability.standing import static_scene
from sph.study.cost import CARD_START, CARD_STEP, START, cost
from sph.study.preflight import (
    QUICK_SENSITIVITY,
    QUICK_TRIALS,
    preflight_searches,
    preflight_seconds,
    quick_spacings,
    standing_scene,
)

CONFIG: dict[str, Any] = {
    "study": "small",
    "scene": "slope.yaml",
    "fidelity": "draft",
    "grid": {"S_R": ["0.10", "0.50"], "gamma": ["1", "100"], "amplitude": ["0.1", "8.0"]},
    "fidelities": {"draft": {}, "fine": {"numerics": {"spacing": 2.5, "time_step": 5e-4}}},
    "figures": {"strengths": ["0.10", "0.50"], "compared_strengths": ["0.10"]},
    "claims": {"amplitude": 8.0},
}


@pytest.fixture
def config(tmp_path: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(CONFIG))
    return tmp_path / "study.yaml"


def predicted(*arguments: object) -> dict[str, Any]:
    result = CliRunner().invoke(app, ["cost", *(str(argument) for argument in arguments), "--json"])
    assert result.exit_code == 0, result.output
    return dict(json.loads(result.stdout))


def finish(base: Path, job: Job, took: float) -> None:
    path = base / job.run.file
    path.parent.mkdir(parents=True, exist_ok=True)
    with netCDF4.Dataset(path, "w") as ds:
        ds.setncatts({"scene": job.scene.model_dump_json(), "status": "complete", "wall_time_s": took})


def test_a_study_that_has_not_begun(config: Path) -> None:
    one, two = predicted(config, "--speed", 1, "--cores", 1), predicted(config, "--speed", 1, "--cores", 2)
    assert (one["runs"], one["jobs"], one["jobs_left"]) == (8, 12, 12) and one["left"] == one["computing"]
    assert one["wall"] == one["left"] and one["left"] / 2 <= two["wall"] < one["wall"]
    assert one["memory"] < two["memory"] <= 2 * one["memory"] and two["computing"] == one["computing"]
    fine = predicted(config, "--speed", 1, "--cores", 1, "--fidelity", "fine")
    scenes = find_study(None, config).plan.at("fine")
    of_a_run = cost(scenes.built(**next(iter(scenes.study.runs.values())))).particles
    assert fine["particles"] == of_a_run, "not of the search, which has finer particles"
    assert fine["folder"].endswith("small/fine") and fine["run"] > 2 * one["run"] and fine["disk"] > 2 * one["disk"]
    slow = predicted(config, "--speed", 0.5, "--cores", 1)
    assert slow["run"] == 2 * one["run"] and slow["computing"] > one["computing"]
    assert slow["shared"] == 2 * one["shared"] == 2 * two["shared"] and 0 < one["shared"] < one["computing"]
    queued = predicted(config, "--speed", 1, "--cores", 1, "--start", START + 10.0)
    more = queued["computing"] - one["computing"]
    assert 0 < one["searches"] < one["computing"] and slow["searches"] == 2 * one["searches"]
    assert 3 * 10.0 < more < 4 * 10.0, "search, check, preflight, and one job of all short stages and runs"
    many = predicted(config, "--speed", 1, "--cores", 1000)
    assert many["wall"] >= one["run"], "no run is shorter for all the cores"


def asking(searches: str) -> Any:
    """A plan with a value of the key ``searches``, of which no yield acceleration is searched."""
    return SimpleNamespace(study=SimpleNamespace(searches=searches), searches={})


def test_the_preflight_is_counted(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many static tests as it makes: each slope, each residual strength, and the searches of a slope."""
    catalogue = find_study(None, config)
    plan = catalogue.plan.at("fine")
    scenes = {name: plan.built(**plan.study.runs[name]) for name in plan.study.runs}
    slope = scenes[next(iter(scenes))]
    coarse, fine = (cost(static_scene(at_spacing(slope, spacing), DEFAULT_RULE)).seconds for spacing in quick_spacings(slope))
    standing = standing_scene(slope)
    tests = (1 + 2) * cost(static_scene(standing, DEFAULT_RULE)).seconds + cost(settled(standing)).seconds
    a_search = QUICK_TRIALS[0] * coarse + QUICK_TRIALS[1] * fine
    quick = preflight_searches(plan)
    assert quick == preflight_searches(asking("quick")) == ("factor-of-safety",) and plan.searches
    assert len(preflight_searches(asking("full")) or ()) == 2 and preflight_searches(asking("none")) is None
    seconds = preflight_seconds(scenes, quick)
    assert seconds == pytest.approx((tests, a_search)), "one slope, two values of S_R, a search"
    with_yield = pytest.approx((tests, 2 * a_search + QUICK_SENSITIVITY * coarse))
    assert preflight_seconds(scenes) == with_yield and preflight_seconds(scenes, None) == (0.0, 0.0), "nothing is tested"
    counted = study_cost(plan, catalogue.base, cores=1, speed=1.0)
    monkeypatch.setattr("sph.command.cost.plan_seconds", lambda plan: (0.0, 0.0))
    assert counted.left - study_cost(plan, catalogue.base, cores=1, speed=1.0).left == pytest.approx(sum(seconds))


def test_linear_reconstruction_takes_its_time(small_slope: SceneBuilder) -> None:
    steps = {"numerics.spacing": 2.5, "numerics.gradient_tolerance": 0.1}  # decide the cost, not samples and renewals
    viscosity = steps | {"numerics.artificial_viscosity": {"alpha": 0.1}}
    plain, linear = (
        cost(small_slope(viscosity | {"numerics.artificial_viscosity.reconstruction": name})).seconds for name in ("none", "linear")
    )
    assert 1.5 < linear / plain < 2.0, "measured: 1.95 of the steps"


def test_finished_runs_tell_the_speed_and_are_not_left(config: Path) -> None:
    catalogue = find_study(None, config)
    plan, base = catalogue.plan, catalogue.base
    jobs = [state.job for state in look_at(plan.jobs, base)]
    runs = [job for job in jobs if job.is_run]
    took = [2.0 * cost(job.scene).seconds * factor for job, factor in zip(runs, (1.0, 1.1, 5.0), strict=False)]
    for job, seconds in zip(runs, took, strict=False):
        finish(base, job, seconds)
    found = study_cost(plan, base, cores=1)
    assert found.speed.value == pytest.approx(1 / statistics.median((2.0, 2.2, 10.0))) and found.speed.known_by == "from 3 finished runs"
    assert found.jobs - found.jobs_left == 3 and found.left < found.computing
    for job in jobs:
        finish(base, job, 1.0)
    for name in ("checked.csv", "preflight.csv"):
        (base / plan.folder / name).write_text("")
    done = study_cost(plan, base, cores=1)
    assert done.jobs_left == 0 and done.left == done.wall == 0.0 and done.computing > 0


def test_the_speed_here(config: Path, small_slope: SceneBuilder) -> None:
    assert 1e-3 < speed_here(small_slope({})) < 1e3
    told = CliRunner().invoke(app, ["cost", str(config)])
    assert told.exit_code == 0 and "measured here" in told.stdout and "core-hours" in told.stdout and "MiB of trajectories" in told.stdout


RECORD = {"kind": "record", "start": 1.0, "data": {"interval": 0.005, "x": [0.0, 1.0, -4.0, 1.0, 0.0] * 20}}


@pytest.mark.parametrize(
    ("motion", "step"),
    [
        (RECORD, 5e-3),
        (RECORD | {"start": 1.001}, 1e-3),
        (RECORD | {"data": RECORD["data"] | {"interval": 0.02}}, 0.01),  # type: ignore[operator]
        ({"kind": "ricker", "amplitude": 1.0, "peak": 2.0, "frequency": 8.0}, 5e-3),
    ],
    ids=["record of 0.005 s", "record between the steps", "record of 0.02 s", "short wave"],
)
def test_the_coarse_copy_resolves_the_motion(motion: dict[str, Any], step: float, small_slope: SceneBuilder) -> None:
    scene = small_slope({}).model_dump() | {"motion": motion}
    assert coarse(make_scene(scene)).numerics.time_step == pytest.approx(step)


def test_refusals(config: Path, tmp_path: Path) -> None:
    for arguments, words in (
        ((config, "--fidelity", "best"), ["--fidelity: 'best'", "draft, fine"]),
        ((config, "--speed", 0), ["--speed 0", "0.001"]),
        ((tmp_path / "none.yaml",), ["none.yaml"]),
    ):
        refused = CliRunner().invoke(app, ["cost", *(str(argument) for argument in arguments)])
        assert refused.exit_code == REFUSED and all(word in refused.stderr for word in words), refused.output


def test_a_study_on_a_card(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of a kind advance together; searches, the preflight and tables stay on the cores."""
    monkeypatch.setattr(ensemble, "find_spec", lambda name: None)
    on_cores, on_card = (predicted(config, "--speed", 1, "--cores", 1, "--backend", name) for name in ("cpu", "cuda"))
    card = on_card["card"]
    assert on_cores["card"] is None and on_card["computing"] < on_cores["computing"] and on_card["run"] == on_cores["run"]
    assert card["together"] == 8 and "H200; there is no card here" in card["known_by"]
    assert card["speed"] == pytest.approx(8 * on_card["particles"] / CARD_STEP), "few particles: as many steps a second as one run makes"
    # One job, in it gravity with a thousand steps, the shaking to the first failure with one interval, and runs with two thousand.
    assert card["left"] == pytest.approx(START + CARD_START + CARD_STEP * (1000 + 10 + on_card["steps"]))
    assert on_card["wall"] >= card["left"]
    refused = CliRunner().invoke(app, ["cost", str(config), "--backend", "opencl"])
    assert refused.exit_code == REFUSED and "cpu" in refused.stderr and "cuda" in refused.stderr
    write = yaml.safe_load(config.read_text())
    config.write_text(yaml.safe_dump(write | {"backend": "cuda"}))
    assert predicted(config, "--speed", 1, "--cores", 1) == on_card, "as the study says"
    told = CliRunner().invoke(app, ["cost", str(config), "--speed", "1"]).stdout
    assert "8 runs together" in told and "M particle-steps/s" in told and "and a card" in told


def test_the_speed_of_a_card(small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> None:
    """On runs to their eleventh interval, here one after the other on a processor."""

    class OneByOne:
        def __init__(self, size: int) -> None:
            self.size = size

        def simulation(self, scene: Any, enforce_limit: bool) -> Simulation:
            return Simulation(scene, 1, enforce_limit)

        def carry(self, calls: Any) -> list[Any]:
            assert len(calls) == self.size
            return [call() for call in calls]

    monkeypatch.setattr("sph.command.cost.Ensemble", OneByOne)
    monkeypatch.setattr(ensemble, "most_runs", lambda simulation: 3)
    found = card_speed_here(small_slope({}), 2)
    assert 1e3 < found.value < 1e12 and found.known_by.startswith("measured here on 2 runs together")
