"""A run that is killed goes on by the same command, to the same bits; a study: `tests/workflow/test_workflow.py`."""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml
from comparison import same_bits, same_files
from killing import killed, start
from small_scenes import SLOPE, SceneBuilder

from sph.scene.configuration import dotted, merge
from sph.solver.checkpoint import run_to_file
from sph.solver.run import run
from sph.stability.record import search_to_file
from sph.stability.search import Trial
from sph.storage import trajectory
from sph.storage.files import beside

pytestmark = pytest.mark.long

LONGER = merge(SLOPE, dotted({"duration": 4.0, "numerics.time_step": 1e-4, "outputs.frame_interval": 0.05}))
"""The small slope for a second or two of computing, with a long history to write."""
KILLS = 3


def arguments(until: str) -> list[str]:
    return [sys.executable, "-m", "sph.command.cli", "run", "slope.yaml", "--out", "run.nc", "--until", until]


def scene_in(folder: Path) -> Path:
    folder.mkdir()
    (folder / "slope.yaml").write_text(yaml.safe_dump(LONGER))
    return folder


def finish(until: str, folder: Path, *options: str) -> Path:
    process = start([*arguments(until), *options], folder)
    assert process.wait(600) == 0, (folder / "output.log").read_text()
    assert sorted(path.name for path in folder.iterdir()) == ["output.log", "run.nc", "slope.yaml"]
    return folder / "run.nc"


def whole_or_absent(folder: Path) -> None:
    """What lies under a final name can be read."""
    for path in (folder / "run.nc", beside(folder / "run.nc", "checkpoint")):
        if path.exists():
            trajectory.read_run(path)
            trajectory.read_restart(path)


def test_runs_killed_at_random_instants(tmp_path: Path) -> None:
    reference = finish("end", scene_in(tmp_path / "reference"), "--checkpoint", "0")
    folder, instants = scene_in(tmp_path / "run"), random.Random(7)
    began = time.monotonic()
    same_files(finish("end", folder), reference)
    takes = time.monotonic() - began
    (folder / "run.nc").unlink()
    kills = 0
    while kills < KILLS and killed(start(arguments("end"), folder), instants.uniform(0.0, takes)):
        whole_or_absent(folder)
        kills += 1
    assert kills, "no kill came in time"
    same_files(finish("end", folder), reference)


@pytest.fixture(scope="module")
def to_first_failure(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finish("first_failure", scene_in(tmp_path_factory.mktemp("whole") / "run"), "--checkpoint", "0")


@pytest.mark.parametrize("name", ["..run.nc.checkpoint.part", ".run.nc.checkpoint", ".run.nc.part"])
def test_a_run_killed_in_writing(tmp_path: Path, to_first_failure: Path, name: str) -> None:
    """As soon as a file is there: the first checkpoint half written, written, the result half written."""
    folder = scene_in(tmp_path / "run")
    process = start(arguments("first_failure"), folder)
    while not (folder / name).exists():
        assert process.poll() is None, "the process ended before"
        time.sleep(0.001)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    whole_or_absent(folder)
    same_files(finish("first_failure", folder), to_first_failure)
    assert "part" in name or "goes on from this checkpoint" in (folder / "output.log").read_text()


@pytest.mark.parametrize("until", ["end", "gravity", "first_failure"])
def test_a_checkpoint_of_every_block_goes_on_bit_for_bit(tmp_path: Path, small_slope: SceneBuilder, until: Any) -> None:
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
        written = trajectory.read(path).dataset()
        assert written.attrs["particle_steps"] == whole.trajectory.attrs["particle_steps"]
        assert written.attrs["neighbours_mean"] == whole.trajectory.attrs["neighbours_mean"]
        path.unlink()


def test_a_search_repeats_no_trial(tmp_path: Path, small_slope: SceneBuilder) -> None:
    """Stopped in the middle by an error, which leaves what a kill would."""
    scene = small_slope({"duration": 2.0, "numerics.spacing": 2.5, "motion": {"kind": "none"}})
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
    found = trajectory.read(path).dataset()
    assert found["value"].values.tolist() == [trial.value for trial in told] and found.attrs["stood"] < found.attrs["failed"]
    assert [p.name for p in tmp_path.iterdir()] == ["search.nc"]
