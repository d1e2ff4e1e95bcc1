"""A job whose run is short goes ahead with others, whose own jobs take up what it has made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from comparison import same_files
from small_scenes import SceneBuilder

from sph.jobs import simulation
from sph.jobs.ahead import Task, finished, take_up
from sph.jobs.log import read_log
from sph.jobs.simulation import work
from sph.scene.schema import Scene
from sph.solver.cuda import ensemble
from sph.solver.simulation import Simulation
from sph.storage import trajectory
from sph.storage.files import alone
from sph.study.planned import planned
from sph.study.runs import SIMULATION


def tasks(folder: Path, small_slope: SceneBuilder, **amplitudes: float) -> list[Task]:
    """Gravity stages, a few steps each."""
    return [
        Task(
            str(folder / "runs" / f"{name}.nc"),
            str(folder / "logs" / f"{name}.log"),
            None,
            *planned(small_slope({"motion.amplitude": amplitude, "gravity.ramp": 0.01, "gravity.duration": 0.02}).model_dump(mode="json")),
            "gravity",
            SIMULATION,
            False,
            True,
            "cpu",
            f"digest-{name}",
        )
        for name, amplitude in amplitudes.items()
    ]


def test_what_is_made_ahead_is_taken_up(tmp_path: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> None:
    own, other, fails, held, later = tasks(tmp_path, small_slope, own=1.0, other=2.0, fails=3.0, held=4.0, later=5.0)
    fails = fails._replace(restart=str(tmp_path / "missing.nc"))
    simulate = simulation.simulate

    def own_job_begins(scene: Scene, task: Task, *rest: Any) -> None:
        if task is other:
            Path(task.log).unlink()  # by Snakemake; that job then waits for this one
        simulate(scene, task, *rest)

    monkeypatch.setattr(simulation, "simulate", own_job_begins)
    with alone(Path(held.file), "job"):
        work(own, [fails, held, other], 1)
    assert Path(own.file).is_file() and not own.made.exists()
    # One that fails loses no other, and says why in its own log alone; one at which another job works is left to that.
    reason = read_log(Path(fails.log)).reason  # type: ignore[union-attr]
    assert reason and "missing.nc" in reason and not fails.made.exists()
    assert not held.made.exists() and not Path(held.log).exists()
    assert other.made.is_file() and not Path(other.file).exists() and finished(Path(other.file)) == other.made
    log = other.made.with_suffix(".log").read_text()
    assert "complete" in log or "paused" in log
    # Its own job makes nothing, keeps the log, and leaves no hidden file; what was made of something else it does not take.
    assert not take_up(other._replace(digest="of another scene")) and not take_up(later)
    assert take_up(other) and Path(other.log).read_text() == log and finished(Path(other.file)) == Path(other.file)
    work(other._replace(file=str(tmp_path / "alone.nc")), [], 1)
    same_files(tmp_path / "alone.nc", Path(other.file))
    assert sorted(path.name for path in Path(own.file).parent.glob(".*")) == [], "what is held leaves its lock, which is deleted"


def test_a_killed_job_has_lost_nothing_that_it_had_finished(
    tmp_path: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, other, meanwhile, last = tasks(tmp_path, small_slope, own=1.0, other=2.0, meanwhile=3.0, last=4.0)
    make = simulation.make

    def killed_at_last(task: Task, *rest: Any) -> None:
        if task is last:
            raise KeyboardInterrupt
        make(task, *rest)
        Path(meanwhile.file).touch()  # by its own job, which another core had time for

    monkeypatch.setattr(simulation, "make", killed_at_last)
    with pytest.raises(KeyboardInterrupt):
        work(own, [other, meanwhile, last], 1)
    assert not Path(own.file).exists(), "Snakemake deletes the result of a job that ends so"
    assert take_up(own) and take_up(other) and not take_up(last)
    assert not meanwhile.made.exists(), "it is not made twice"


class OnProcessor(Simulation):
    """A run that is told to be on a card."""

    backend = "cuda"
    made = 0

    def __init__(self, scene: Scene, ensemble: Any, enforce_limit: bool = True) -> None:
        super().__init__(scene, 1, enforce_limit)
        self.ensemble = ensemble
        OnProcessor.made += 1


def test_runs_on_a_card_advance_together(tmp_path: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("own", "fails", "large", "changed", "held", "other", "third", "after", "never")
    own, fails, large, changed, held, other, third, after, never = (
        task._replace(backend="cuda") for task in tasks(tmp_path, small_slope, **{name: 1.0 + number for number, name in enumerate(names)})
    )
    fails, never = fails._replace(restart=str(tmp_path / "missing.nc")), never._replace(restart=fails.file)
    changed = changed._replace(contents={str(Path(__file__)): "of what was planned"})
    after = after._replace(restart=own.file)
    batches: list[int] = []

    class Card(ensemble.Ensemble):
        def __init__(self, size: int) -> None:
            batches.append(size)
            super().__init__(size, cuda=object())

    def most_runs(run: Simulation) -> int:
        if run.scene.motion.amplitude == 3.0:
            raise ValueError("needs 300 MiB")
        assert not batches or finished(Path(own.file)).exists(), "what is done is kept while others are under way"
        return 2

    # By their amplitudes: what is large does not fit, the others are of two kinds.
    monkeypatch.setattr(ensemble, "CardSimulation", OnProcessor)
    monkeypatch.setattr(ensemble, "Ensemble", Card)
    monkeypatch.setattr(ensemble, "card", object)
    monkeypatch.setattr(ensemble, "most_runs", most_runs)
    monkeypatch.setattr(ensemble, "variant", lambda run: run.scene.motion.amplitude in (1.0, 2.0, 6.0) or run.scene.motion.amplitude)
    with alone(Path(held.file), "job"):
        work(own, [fails, large, changed, held, other, third, after, never], 1)
    assert batches == [2, 1, 1, 1, 1, 1], "own and one that fails; what is refused, by itself; the rest; what goes on from own"
    assert OnProcessor.made == 6, "each is built once, what has changed and what is held not at all"
    assert Path(own.file).is_file() and trajectory.read(own.file).attrs["backend"] == "cuda"
    reasons = [read_log(Path(task.log)).reason for task in (fails, large, changed)]  # type: ignore[union-attr]
    assert all(said in str(reason) for said, reason in zip(("missing.nc", "300 MiB", "has changed"), reasons, strict=True))
    assert not held.made.exists() and take_up(other) and take_up(third) and take_up(after)
    assert not Path(never.log).exists(), "what it goes on from is missing: left to its own job"
    with pytest.raises(SystemExit):
        work(fails, [], 1)
    monkeypatch.undo()
    monkeypatch.setattr(ensemble, "find_spec", lambda name: None)
    with pytest.raises(SystemExit):
        work(held, [], 1)
    assert "numba-cuda, which is not installed" in str(read_log(Path(held.log)).reason)  # type: ignore[union-attr]
