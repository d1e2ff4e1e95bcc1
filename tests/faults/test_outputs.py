"""What a command writes and prints: never over its inputs, whatever the names, the terminal and the reader of its output."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from hashlib import sha256
from pathlib import Path
from shutil import copyfile

import numpy as np
import pytest
import yaml
from calling import call
from small_scenes import SLOPE, SceneBuilder

from sph.jobs.exit_codes import REFUSED
from sph.jobs.log import job_log
from sph.solver.checkpoint import run_to_file
from sph.study.plan import load_study

SHORT = {"duration": 1.0, "gravity.duration": 1.0, "motion": {"kind": "none"}}
NOT_UTF8 = os.fsdecode(b"\xe9t\xe9")
"""A file name that a system of Latin-1 has left."""


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    path = tmp_path_factory.mktemp("whole") / "run.nc"
    run_to_file(small_slope(SHORT), path)
    return path


@pytest.fixture
def folder(tmp_path: Path, run_file: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working folder: scenes, with a record of two files and with a ground line, and a trajectory under many names."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inputs").mkdir()
    time = np.arange(0.0, 0.5, 0.02)
    for name in ("h", "v"):
        (tmp_path / "inputs" / f"{name}.csv").write_text("t,a (m/s2)\n" + "".join(f"{t:.2f},{np.sin(40 * t):.4f}\n" for t in time))
    (tmp_path / "inputs" / "ground.csv").write_text("x,z\n0,0\n20,0\n40,20\n60,20\n")
    record = {"kind": "record", "file": "inputs/h.csv", "vertical": {"file": "inputs/v.csv"}, "start": 1.0}
    ground_line = {"shape": "ground_line", "file": "inputs/ground.csv", "base": -10.0}
    scenes = {"slope": SLOPE, "shaken": SLOPE | {"motion": record}, "survey": SLOPE | {"geometry": ground_line}}
    for name, scene in scenes.items():
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(scene))
    for name in ("run.nc", "small_slope.nc", "run.png", "run.gif", "run.pvd", ".out.nc.checkpoint"):
        copyfile(run_file, tmp_path / name)
    (tmp_path / "link.yaml").symlink_to("slope.yaml")
    (tmp_path / "hard.yaml").hardlink_to("slope.yaml")
    (tmp_path / "here").symlink_to(".")
    before = contents(tmp_path)
    yield tmp_path
    assert contents(tmp_path) == before, "no file was changed, none was made"


def contents(folder: Path) -> dict[str, str]:
    return {str(path): sha256(path.read_bytes()).hexdigest() for path in folder.rglob("*") if path.is_file()}


# ---------------------------------------------------------------- inputs stay


@pytest.mark.parametrize(
    "arguments",
    [
        "run slope.yaml --out slope.yaml",
        "run slope.yaml --out link.yaml",
        "run link.yaml --out slope.yaml",
        "run slope.yaml --out hard.yaml",
        "run slope.yaml --out here/./here/slope.yaml",
        "run slope.yaml --restart run.nc --out run.nc",
        "run slope.yaml --restart run.nc --out here/run.nc",
        "run slope.yaml --restart .out.nc.checkpoint --out out.nc",
        "run slope.yaml --restart small_slope.nc",
        "run small_slope.nc",
        "run run.nc --out run.nc",
        "run shaken.yaml --out inputs/h.csv",
        "run shaken.yaml --out here/inputs/v.csv",
        "run survey.yaml --out inputs/ground.csv",
        "run slope.yaml --set motion.kind=record --set motion.start=1 --set motion.file=inputs/h.csv --out inputs/h.csv",
        "run run.nc --set motion.kind=record --set motion.start=1 --set motion.file=inputs/h.csv --out inputs/h.csv",
        "fos slope.yaml --out slope.yaml",
        "fos shaken.yaml --out inputs/v.csv",
        "yield-acceleration survey.yaml --out inputs/ground.csv",
        "yield-acceleration run.nc --out here/run.nc",
        "check run.png --plot run.png",
        "motion run.png --plot here/run.png",
        "plot run.png",
        "plot run.nc --out run.nc",
        "animate run.gif",
        "animate run.nc --out run.nc",
        "export run.pvd --vtk .",
    ],
)
def test_no_command_replaces_what_it_reads(folder: Path, arguments: str) -> None:
    result = call(*arguments.split())
    assert result.exit_code == REFUSED and "Traceback" not in result.output, result.output
    assert "would replace" in result.stderr or "the name must end in" in result.stderr


@pytest.mark.parametrize("place", ["pipe", "-"])
def test_what_is_no_file_is_not_replaced(folder: Path, place: str) -> None:
    """A pipe stands for the devices of the machine, which root could replace, and a test that fails would."""
    os.mkfifo("pipe")
    for command in ("run", "fos", "yield-acceleration"):
        result = call(command, "slope.yaml", "--out", place)
        assert result.exit_code == REFUSED and f"--out {place}: must be a new file" in result.stderr
    assert Path("pipe").is_fifo()


def test_a_picture_is_refused_before_any_work(folder: Path) -> None:
    for command in (["check", "slope.yaml", "--plot"], ["motion", "inputs/h.csv", "--plot"], ["plot", "run.nc", "--out"]):
        for name, wanted in (("picture", "must end in .png"), ("picture.bmp", "must end in .png"), ("absent/x.png", "does not exist")):
            result = call(*command, name)
            assert result.exit_code == REFUSED and wanted in result.stderr and name in result.stderr


@pytest.mark.parametrize("source", ["scene", "cases", "record"])
def test_a_study_is_not_read_from_among_its_results(folder: Path, source: str) -> None:
    place = folder / "results" / "hills" / "kept"
    place.mkdir(parents=True)
    (place / "slope.yaml").symlink_to(folder / "slope.yaml")
    scene = place / "slope.yaml" if source == "scene" else folder / "slope.yaml"
    if source == "scene":
        scene.unlink()
        copyfile(folder / "slope.yaml", scene)
    cases, record = ((place if source == name else folder / "inputs") / f"{name}.csv" for name in ("cases", "record"))
    copyfile("inputs/h.csv", record)
    cases.write_text("coupling.S_R\n0.2\n0.3\n")
    motion = {"kind": "record", "file": str(record), "start": 1.0}
    study = {"study": "hills", "scene": str(scene), "cases": str(cases), "fidelity": "f", "fidelities": {"f": {"motion": motion}}}
    with pytest.raises(ValueError, match=rf"{place}.*results/hills"):
        load_study(study, [folder])
    load_study(study | {"study": "hill"}, [folder])
    for path in (cases, record, *place.glob("*")):
        path.unlink(missing_ok=True)


def test_a_scene_may_come_through_a_pipe(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    writer = threading.Thread(target=Path("pipe").write_text, args=(yaml.safe_dump(SLOPE),))
    writer.start()
    result = call("check", "pipe", "--plot", "scene.png")
    writer.join()
    assert result.exit_code == 0 and Path("scene.png").is_file(), result.output


# ---------------------------------------------------------------- characters


def sph(*arguments: object, **environment: str) -> subprocess.CompletedProcess[bytes]:
    command = [sys.executable, "-m", "sph.command.cli", *map(str, arguments)]
    return subprocess.run(command, env=os.environ | environment, capture_output=True)


ASCII: Sequence[dict[str, str]] = (
    {"PYTHONIOENCODING": "ascii"},
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""},
)


@pytest.mark.parametrize("environment", [ASCII[0], pytest.param(ASCII[1], marks=pytest.mark.long)], ids=["streams", "locale"])
def test_a_terminal_without_greek_letters(tmp_path: Path, environment: dict[str, str]) -> None:
    path = tmp_path / "slope.yaml"
    path.write_text(yaml.safe_dump(SLOPE | {"title": "Böschung, γ"}, allow_unicode=True), encoding="utf-8")
    shown = sph("check", path, **environment)
    assert shown.returncode == 0, shown.stderr
    assert rb"B\xf6schung, \u03b3" in shown.stdout and rb"\u03bb (m)" in shown.stdout


@pytest.mark.long
def test_names_that_are_not_utf8(tmp_path: Path, run_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sph.solver.run.Run.go", lambda *_, **__: pytest.fail("a step was made"))
    for name in ("run.nc", "slope.yaml", "record.csv"):
        (tmp_path / f"{NOT_UTF8}{name}").touch()
    copyfile(run_file, f"{NOT_UTF8}run.nc")
    Path(f"{NOT_UTF8}slope.yaml").write_text(yaml.safe_dump(SLOPE))
    Path(f"{NOT_UTF8}record.csv").write_text("t,a (m/s2)\n" + "".join(f"{0.02 * i:.2f},{np.sin(i):.3f}\n" for i in range(50)))
    refused = {
        ("metrics", f"{NOT_UTF8}run.nc"): "is not utf-8",
        ("run", f"{NOT_UTF8}slope.yaml", "--out", f"{NOT_UTF8}out.nc"): "is not utf-8",
        ("run", f"{NOT_UTF8}slope.yaml", "--restart", f"{NOT_UTF8}run.nc"): "is not utf-8",
    }
    for arguments, wanted in refused.items():
        done = call(*arguments)
        assert done.exit_code == REFUSED and wanted in done.stderr and "rename it" in done.stderr, done.output
    drawn = call("motion", f"{NOT_UTF8}record.csv", "--plot", f"{NOT_UTF8}motion.png")
    assert drawn.exit_code == 0 and Path(f"{NOT_UTF8}motion.png").read_bytes().startswith(b"\x89PNG"), drawn.output
    drawn = call("check", f"{NOT_UTF8}slope.yaml", "--plot", f"{NOT_UTF8}scene.pdf")
    assert drawn.exit_code == 0 and Path(f"{NOT_UTF8}scene.pdf").read_bytes().startswith(b"%PDF"), drawn.output


@pytest.mark.long
def test_a_picture_s_name_is_printed_whatever_it_is(tmp_path: Path, run_file: Path) -> None:
    drawn = sph("plot", run_file, "--out", tmp_path / f"{NOT_UTF8}.png")
    assert drawn.returncode == 0 and rb"\udce9t\udce9.png" in drawn.stdout, drawn.stderr


def test_a_log_is_utf8_whatever_is_written(tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as ended, job_log(tmp_path / "job.log") as log:
        print(f"γ {NOT_UTF8}", file=log)
        raise ValueError(f"{NOT_UTF8}: bad")
    assert ended.value.code == REFUSED
    assert (tmp_path / "job.log").read_text(encoding="utf-8").splitlines()[1:3] == [r"γ \udce9t\udce9", r"job: \udce9t\udce9: bad"]


# ---------------------------------------------------------------- who reads


@pytest.mark.long
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_enough_and_output_that_is_lost(unbuffered: str) -> None:
    """The first ends the command without a word; the second is told."""
    reading, writing = os.pipe()
    os.close(reading)
    full = os.open("/dev/full", os.O_WRONLY)
    told = b"sph: the output cannot be printed: No space left on device\n"
    for out, arguments, wanted in (
        (writing, ["schema", "scene"], (1, b"")),
        (writing, ["--help"], (1, b"")),
        (full, ["schema", "scene"], (REFUSED, told)),
    ):
        command = [sys.executable, "-m", "sph.command.cli", *arguments]
        done = subprocess.run(command, env=os.environ | {"PYTHONUNBUFFERED": unbuffered}, stdout=out, stderr=subprocess.PIPE)
        assert (done.returncode, done.stderr) == wanted
    os.close(writing)
    os.close(full)


# ---------------------------------------------------------------- odd values


@pytest.mark.parametrize("tolerance", ["nan", "inf", "1.5"])
def test_a_tolerance_that_closes_no_bracket(folder: Path, tolerance: str) -> None:
    """A bracket as wide as it began would pass for an answer."""
    for command in ("fos", "yield-acceleration"):
        assert call(command, "slope.yaml", "--tolerance", tolerance).exit_code == REFUSED
