"""Faults of disks, folders and files: one line that names file and remedy, no earlier result damaged, nothing left behind."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from calling import call
from comparison import same_files
from small_scenes import SceneBuilder
from typer.testing import CliRunner, Result

from sph.jobs.exit_codes import REFUSED
from sph.jobs.log import job_log
from sph.solver.checkpoint import run_to_file
from sph.storage import trajectory
from sph.storage.files import alone, beside, whole

SHORT = {"duration": 1.5, "motion.end": 1.5, "motion.decay_start": 1.4, "motion.ramp": 0.2}


def called_alone(*arguments: object) -> Result:
    """As ``call``, in a process of its own: HDF5 may leave one in disorder that it could not write for."""
    done = subprocess.run([sys.executable, "-m", "sph.command.cli", *map(str, arguments)], capture_output=True, check=False)
    return Result(CliRunner(), done.stdout, done.stderr, done.stdout + done.stderr, None, done.returncode, None)


def refused(result: Result, *words: object) -> None:
    """One line on stderr, beside the progress, that holds the words; the documented exit code; no traceback."""
    assert result.exit_code == REFUSED, result.output
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("sph: ") and "Traceback" not in result.stderr
    for word in words:
        assert str(word) in last


@pytest.fixture
def scene_file(tmp_path: Path, small_slope: SceneBuilder) -> Path:
    path = tmp_path / "slope.yaml"
    path.write_text(yaml.safe_dump(small_slope(SHORT).model_dump(mode="json")))
    return path


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.nc"
    run_to_file(small_slope(SHORT), path, "first_failure")
    return path


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 1 MB."""
    yield from mounted(tmp_path / "disk", "size=1m")


def mounted(folder: Path, options: str) -> Iterator[Path]:
    folder.mkdir()
    try:
        subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        pytest.skip(f"this user may not mount a file system: {error}")
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)  # HDF5 keeps open what it could not write


def fill(folder: Path, leave: int) -> Path:
    """Leave some bytes of a disk."""
    free = os.statvfs(folder).f_bavail * os.statvfs(folder).f_frsize
    (folder / "filler").write_bytes(bytes(free - leave))
    return folder / "filler"


# ---------------------------------------------------------------- full and read-only disks


@pytest.mark.long
@pytest.mark.parametrize("leave", [0, 60_000])
def test_a_full_disk(scene_file: Path, small_disk: Path, leave: int) -> None:
    out = small_disk / "run.nc"
    (small_disk / "earlier.nc").write_bytes(b"an earlier result")
    filler = fill(small_disk, leave)
    refused(called_alone("run", scene_file, "--out", out, "--checkpoint", 0.01), out, "cannot be written", "MB free", "same command again")
    names = {path.name for path in small_disk.iterdir()}
    assert names - {beside(out, "checkpoint").name} == {"earlier.nc", "filler"}
    filler.unlink()
    result = called_alone("run", scene_file, "--out", out)
    assert result.exit_code == 0, result.output
    assert {path.name for path in small_disk.iterdir()} == {"earlier.nc", "run.nc"}


def test_a_disk_that_is_full_for_the_checkpoints_alone(small_disk: Path, small_slope: SceneBuilder, run_file: Path) -> None:
    filler = fill(small_disk, 8_000)
    said: list[str] = []

    def free_in_time(progress: Any) -> None:
        if progress.time > 1.0:
            filler.unlink(missing_ok=True)

    run_to_file(small_slope(SHORT), small_disk / "run.nc", "first_failure", report=free_in_time, seconds=0.02, say=said.append)
    assert said and all("the run goes on without this checkpoint" in line for line in said)
    same_files(small_disk / "run.nc", run_file)


def test_a_disk_that_is_full_in_the_middle_leaves_the_earlier_file(small_disk: Path, run_file: Path) -> None:
    ds, restart = trajectory.read(run_file).dataset(), trajectory.read_restart(run_file).dataset()
    path = small_disk / "run.nc"
    trajectory.write(path, ds, restart)
    before = path.read_bytes()
    fill(small_disk, len(before) // 2)
    with pytest.raises(OSError, match=r"run\.nc: cannot be written"):
        trajectory.write(path, ds, restart)
    assert path.read_bytes() == before
    assert {p.name for p in small_disk.iterdir()} == {"run.nc", "filler"}


def test_a_folder_that_cannot_be_written(scene_file: Path, small_disk: Path, run_file: Path) -> None:
    """Refused before any computing."""
    (small_disk / "run.nc").write_bytes(run_file.read_bytes())
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    result = call("run", scene_file, "--out", small_disk / "run.nc")
    refused(result, small_disk / "run.nc", "cannot be written", "Read-only", "another place")
    assert len(result.stderr.splitlines()) == 1, "no step was made"
    refused(call("plot", small_disk / "run.nc"), "run.png", "cannot be written")
    assert (small_disk / "run.nc").read_bytes() == run_file.read_bytes()


# ---------------------------------------------------------------- damaged and foreign files


GARBLE = """
import sys
from pathlib import Path
import numpy as np
from sph.storage import trajectory

source, target, seed, number = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
data, sound, state = source.read_bytes(), trajectory.read(source).dataset(), trajectory.read_restart(source).dataset()
chance = np.random.default_rng(seed)
refused = 0
for place in chance.integers(len(data) - 64, size=number):
    target.write_bytes(data[:place] + chance.bytes(64) + data[place + 64:])
    try:
        read, again = trajectory.read_run(target).dataset(), trajectory.read_restart(target).dataset()
    except ValueError as error:
        assert str(target) in str(error)
        refused += 1
    else:
        for left, right in ((read, sound), (again, state)):
            assert all(left[name].equals(right[name]) for name in right.data_vars), place
print(refused)
"""


@pytest.mark.long
def test_a_garbled_file_is_refused_or_read_as_it_was(tmp_path: Path, run_file: Path) -> None:
    """Fields are compressed, and carry a checksum by that."""
    command = [sys.executable, "-c", GARBLE, str(run_file), str(tmp_path / "garbled.nc"), "3", "40"]
    assert int(subprocess.run(command, check=True, capture_output=True, text=True).stdout) > 10


@pytest.mark.parametrize("fault", ["truncated", "foreign", "another scene", "another stage", "another restart", "no restart state"])
def test_a_checkpoint_that_is_not_this_run_s_is_ignored(tmp_path: Path, run_file: Path, small_slope: SceneBuilder, fault: str) -> None:
    path = tmp_path / "run.nc"
    kept = beside(path, "checkpoint")
    scene = small_slope(SHORT)

    def stop(progress: Any) -> None:
        if progress.time > 0.1:
            raise KeyboardInterrupt

    other = small_slope(SHORT | {"soil.cohesion": 40.0}) if fault == "another scene" else scene
    gravity = tmp_path / "gravity.nc"
    if fault == "another restart":
        run_to_file(scene, gravity, "gravity")
    with pytest.raises(KeyboardInterrupt):
        run_to_file(other, path, "end" if fault == "another stage" else "first_failure", report=stop, seconds=1e-9)
    if fault == "truncated":
        kept.write_bytes(kept.read_bytes()[:5000])
    elif fault == "foreign":
        kept.write_text("not a checkpoint")
    elif fault == "no restart state":
        trajectory.write(kept, trajectory.read(kept))
    said: list[str] = []
    restart = gravity if fault == "another restart" else None
    run_to_file(scene, path, "first_failure", restart, say=said.append)
    assert len(said) == 1 and "ignored, the run starts anew" in said[0] and kept.name in said[0]
    assert not kept.exists()
    if fault != "another restart":
        same_files(path, run_file)


# ---------------------------------------------------------------- names


@pytest.mark.parametrize("letter", ["x", "é"])
@pytest.mark.parametrize("size", [139, 140, 237, 238, 240, 243, 244, 245, 246, 250, 254, 255])
def test_every_name_that_the_file_system_takes_will_do(tmp_path: Path, letter: str, size: int) -> None:
    """With lock, temporary file and checkpoint beside it; sizes are bytes."""
    name = (size - 3) // len(letter.encode()) * letter
    path = tmp_path / f"{name.ljust(len(name) + (size - 3) % len(letter.encode()), 'x')}.nc"
    assert len(os.fsencode(path.name)) == size
    with alone(path, "run"):
        kept = beside(path, "checkpoint")
        for file in (kept, path):
            with whole(file) as temporary:
                temporary.write_text(file.name)
        assert len({beside(file, role) for file in (path, kept) for role in ("part", "lock", "run", "checkpoint")}) == 8
        assert sorted(tmp_path.iterdir()) == sorted({path, kept, beside(path, "run")})
        assert beside(path, "part") != beside(path.with_name(f"y{path.name[1:]}"), "part")
    kept.unlink()
    assert path.read_text() == path.name and list(tmp_path.iterdir()) == [path]


@pytest.mark.long
def test_a_run_with_the_longest_name(tmp_path: Path, scene_file: Path) -> None:
    path = tmp_path / f"{'x' * 252}.nc"
    result = call("run", scene_file, "--until", "gravity", "--checkpoint", 1e-9, "--out", path)
    assert result.exit_code == 0, result.output
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted([scene_file.name, path.name])
    assert trajectory.read_run(path).attrs["status"] == "paused"


def test_a_name_that_is_too_long_is_refused_before_any_work(tmp_path: Path, scene_file: Path) -> None:
    for name in (f"{'x' * 253}.nc", f"{'é' * 127}.nc"):
        result = call("run", scene_file, "--out", tmp_path / name)
        refused(result, "the name takes 25", "at most 255 are possible there; choose a shorter one")
        assert "of 3 s" not in result.stderr and [p.name for p in tmp_path.iterdir()] == [scene_file.name]
    with pytest.raises(ValueError, match="256 bytes"), whole(tmp_path / ("x" * 256)):
        pytest.fail("the work has begun")
    plotted = call("check", scene_file, "--plot", tmp_path / f"{'x' * 252}.png")
    refused(plotted, "256 bytes")


# ---------------------------------------------------------------- two processes, clocks, logs


def sph(*arguments: object, folder: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "sph.command.cli", *map(str, arguments)]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_two_processes_write_one_file(tmp_path: Path, scene_file: Path, run_file: Path) -> None:
    path = tmp_path / "run.nc"
    with alone(path, "run"):
        both = [sph("run", scene_file, "--until", "first_failure", "--out", path, folder=tmp_path) for _ in range(2)]
        for process in both:
            assert process.stderr is not None
            said = (process.stderr.readline() for _ in range(6))  # behind what is found of the scene
            assert any("another process is writing it, waiting" in line for line in said)
    for process in both:
        process.communicate()
        assert process.returncode == 0
    same_files(path, run_file)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.nc", "slope.yaml"]


def test_what_the_other_process_has_finished_is_not_repeated(tmp_path: Path, small_slope: SceneBuilder, run_file: Path) -> None:
    path = tmp_path / "run.nc"
    beside(path, "run").touch()  # as a process leaves it that is killed after its result was written
    path.write_bytes(run_file.read_bytes())
    result = run_to_file(small_slope(SHORT), path, "first_failure", report=lambda progress: pytest.fail("a step was made"))
    assert result.status == "paused" and path.read_bytes() == run_file.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["run.nc"]


def test_many_writers_of_one_file(tmp_path: Path) -> None:
    """Each writes its own letter, again and again: the file holds one letter at any time."""
    path = tmp_path / "letters.txt"
    code = (
        "import sys\nfrom sph.storage.files import whole\n"
        "for _ in range(200):\n    with whole(sys.argv[1]) as part, open(part, 'w') as f:\n"
        "        for _ in range(50):\n            f.write(sys.argv[2]); f.flush()\n"
    )
    writers = [subprocess.Popen([sys.executable, "-c", code, str(path), letter]) for letter in "abc"]
    while any(writer.poll() is None for writer in writers):
        if path.exists():
            text = path.read_text()
            assert text in {50 * letter for letter in "abc"}
    assert all(writer.returncode == 0 for writer in writers)
    assert [p.name for p in tmp_path.iterdir()] == ["letters.txt"]


def test_what_killed_writers_left_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    for role in ("part", "lock"):
        beside(path, role).write_text("left")
    with whole(path) as temporary:
        temporary.write_text("whole")
    assert path.read_text() == "whole" and [p.name for p in tmp_path.iterdir()] == ["table.csv"]


def test_files_from_the_future(tmp_path: Path, small_slope: SceneBuilder, run_file: Path) -> None:
    """Neither restart nor checkpoint asks the clock on the wall."""
    path = tmp_path / "run.nc"

    def stop(progress: Any) -> None:
        if progress.time > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_to_file(small_slope(SHORT), path, "first_failure", report=stop, seconds=1e-9)
    for when in (0, 2**33):
        os.utime(beside(path, "checkpoint"), (when, when))
    said: list[str] = []
    result = run_to_file(small_slope(SHORT), path, "first_failure", say=said.append)
    assert "goes on" in said[0] and result.trajectory.attrs["wall_time_s"] > 0
    same_files(path, run_file)


def test_a_job_s_log_holds_the_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "absent" / "folder" / "job.log"
    for error, code, wanted in ((ValueError("run.nc: bad"), REFUSED, "job: run.nc: bad\n"), (KeyError("fault"), 1, "Traceback")):
        with pytest.raises(SystemExit) as ended, job_log(log) as stream:
            print("progress", file=stream)
            raise error
        assert ended.value.code == code
        text = log.read_text()
        assert text.startswith('{"record": "process"') and "\nprogress\n" in text and wanted in text and str(error) in text.splitlines()[-1]
        assert capsys.readouterr().err.count("\n") == 1


def test_a_log_that_cannot_be_written_stops_nobody(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "logs").write_text("a file where the folder should be")
    with job_log(tmp_path / "logs" / "job.log") as stream:
        print("progress", file=stream)
    assert "no log" in capsys.readouterr().err


def test_an_interval_that_is_no_time_is_refused(scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SPH_CHECKPOINT", "often")
    refused(call("run", scene_file, "--out", tmp_path / "out.nc"), "SPH_CHECKPOINT=often", "seconds of wall time")
