"""A run or a study that is killed goes on by the same command, to the same bits; `kills.py` does it hundreds of times."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import kills
import pytest
from comparison import same_bits, same_files
from killing import start

from sph.scene.schema import Scene
from sph.solver.checkpoint import run_to_file
from sph.solver.run import run
from sph.stability.record import search_to_file
from sph.stability.search import Trial
from sph.storage import trajectory
from sph.storage.files import beside

pytestmark = pytest.mark.long

Builder = Callable[[dict[str, Any]], Scene]


def test_runs_killed_at_random_instants(tmp_path: Path) -> None:
    reference, takes = kills.uninterrupted(tmp_path / "reference", "end")
    hits = kills.killed_run(tmp_path / "run", reference, "end", random.Random(7), takes, most=3)
    assert hits, "no kill came in time"


def waiting_for(path: Path, process: Any) -> None:
    """Until a file appears."""
    while not path.exists():
        assert process.poll() is None, "the process ended before"
        time.sleep(0.001)


@pytest.mark.parametrize("name", ["..run.nc.checkpoint.part", ".run.nc.checkpoint", ".run.nc.part"])
def test_a_run_killed_in_writing(tmp_path: Path, name: str) -> None:
    """As soon as a file is there: the first checkpoint half written, written, the result half written."""
    reference, _ = kills.uninterrupted(tmp_path / "reference", "first_failure")
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "slope.yaml").write_text((reference.parent / "slope.yaml").read_text())
    arguments = kills.run_arguments("first_failure")
    process = start(arguments, folder)
    waiting_for(folder / name, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kills.whole_or_absent(folder)
    kills.finish(arguments, folder)
    same_files(folder / "run.nc", reference)
    assert sorted(path.name for path in folder.iterdir()) == ["output.log", "run.nc", "slope.yaml"]
    went_on = "goes on from this checkpoint" in (folder / "output.log").read_text()
    assert went_on or "part" in name


@pytest.mark.parametrize("until", ["end", "gravity", "first_failure"])
def test_a_checkpoint_of_every_block_goes_on_bit_for_bit(tmp_path: Path, small_slope: Builder, until: Any) -> None:
    """Stopped in the middle by an error, which leaves what a kill would."""
    scene = small_slope({"duration": 2.0, "outputs.series_interval": 0.05})
    whole = run(scene, until)
    last = float(whole.trajectory["sample_time"][-1])
    for stop in (0.06, 0.5, last - 0.08):

        def stopping(progress: Any, stop: float = stop) -> None:
            if progress.time > stop:  # after a checkpoint at the block before
                raise KeyboardInterrupt

        said: list[str] = []
        path = tmp_path / "run.nc"
        with pytest.raises(KeyboardInterrupt):
            run_to_file(scene, path, until, report=stopping, seconds=1e-9)
        assert not path.exists() and beside(path, "checkpoint").exists()
        for role in ("part", "lock"):  # left by a kill in writing a checkpoint, after which no further one is due
            beside(beside(path, "checkpoint"), role).touch()
        same_bits(run_to_file(scene, path, until, seconds=0, say=said.append), whole)
        assert len(said) == 1 and "goes on" in said[0]
        assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]
        written = trajectory.read(path)
        assert written.attrs["particle_steps"] == whole.trajectory.attrs["particle_steps"]
        assert written.attrs["neighbours_mean"] == whole.trajectory.attrs["neighbours_mean"]
        path.unlink()


def test_a_search_repeats_no_trial(tmp_path: Path, small_slope: Builder) -> None:
    """Stopped in the middle by an error, which leaves what a kill would."""
    scene = small_slope({"duration": 2.0, "numerics.spacing": 2.5, "motion": {"kind": "none"}}).model_dump(mode="json")
    path, made, told = tmp_path / "search.nc", [], []

    def stop(trial: Trial) -> None:
        made.append(trial)
        if len(made) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        search_to_file(scene, "yield_acceleration", path, stop)
    search_to_file(scene, "yield_acceleration", path, told.append)
    # The time a trial took tells it from its repetition.  The fourth was made, but not kept.
    assert told[:3] == made[:3] and told[3]._replace(wall_time=0.0) == made[3]._replace(wall_time=0.0) and len(told) > 4
    found = trajectory.read(path)
    assert found["value"].values.tolist() == [trial.value for trial in told] and found.attrs["stood"] < found.attrs["failed"]
    assert [p.name for p in tmp_path.iterdir()] == ["search.nc"]
