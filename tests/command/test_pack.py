"""``sph pack``: an archive with everything that a study names runs elsewhere."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest
import yaml
from calling import call
from forked import snakemake_in

from sph.command.pack import named_files, pack
from sph.command.study import find_study
from sph.scene.configuration import read_yaml, scene_files
from sph.solver.compiled.jit import solver_digest
from sph.storage.trajectory import scene_digest

ROOT = Path(__file__).resolve().parents[2]
SCENE = """\
# A scene of one's own.
scheme: paper
name: own
duration: 3.0
geometry: {shape: ground_line, file: ../survey/line.csv, base: 430.0} # from the surveyor
gravity: {ramp: 0.5, duration: 1.0}
motion:
  kind: record
  file: records/quake.csv # beside the scene
  start: 1.0
numerics: {spacing: 5.0, time_step: 1.0e-3}
outputs: {frame_interval: 0.25, series_interval: 0.01}
"""
STUDY = """\
study: own
scene: scenes/slope.yaml # the slope
grid: {S_R: ["0.10", "0.50"]} # two
experiments: {trigger: experiments/trigger.yaml}
"""
TRIGGER = """\
cases: {as it is: {}, weaker shaking: {motion: {file: 'survey/quake.csv'}}}
intensity: {dimension: amplitude, lowest: 1.0, highest: 8.0, cells: 2}
tolerance: 0.5
classes: [collapse]
at: {S_R: ["0.10"]}
hazard: hazard.csv
"""
STUDY_OF_CASES = STUDY.replace('grid: {S_R: ["0.10", "0.50"]} # two', "cases: cases.csv")
GROUND = "100,440\n150,440\n165,465\n200,465\n"
RECORD = "time (s),acceleration (m/s2)\n" + "".join(f"{0.01 * step:.2f},{(-1) ** (step // 20) * 2.0}\n" for step in range(150))
HAZARD = "amplitude (m/s2),annual frequency\n1,0.1\n8,0.001\n"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working folder of a study whose files lie in it, and beside its scene."""
    folder = tmp_path / "home"
    texts = {
        "study.yaml": STUDY,
        "scenes/slope.yaml": SCENE,
        "scenes/records/quake.csv": RECORD,
        "hazard.csv": HAZARD,
        "experiments/trigger.yaml": TRIGGER,
        "survey/line.csv": GROUND,
        "survey/quake.csv": RECORD.replace("2.0", "1.5"),
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    monkeypatch.chdir(folder)
    return folder


def unpacked(archive: Path, to: Path) -> Path:
    """The folder that an archive holds."""
    shutil.unpack_archive(archive, to)
    (folder,) = to.iterdir()
    return folder


def held(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def digests_of_runs(configuration: str) -> dict[str, str]:
    """What each run of a study simulates, whatever its files are called; read from the working folder."""
    plan = find_study(None, Path(configuration)).plan
    return {name: scene_digest(plan.built(**point)) for name, point in plan.study.runs.items()}


def digests(configuration: str) -> dict[str, str]:
    """The same with the cases of its trigger, and the hazard curve of that."""
    trigger = find_study(None, Path(configuration)).trigger
    shaken = {str(at): scene_digest(each.build()) for at, each in trigger.shaken.items()}
    return digests_of_runs(configuration) | shaken | {"hazard": Path(trigger.hazard_file).read_text()}


def test_the_same_runs_are_planned_elsewhere(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (home / "unnamed.csv").write_text(RECORD)
    told = call("pack", "study.yaml", "-o", "mine.zip")
    assert told.exit_code == 0 and told.stdout.startswith("mine.zip: 8 files, 0.0"), told.output
    wanted = digests("study.yaml")
    assert len(wanted) == 2 + 2 + 1
    folder = unpacked(home / "mine.zip", tmp_path / "there")
    contents = {name: (home / name).read_bytes() for name in held(home) - {"mine.zip", "unnamed.csv"}}
    os.rename(home, home.with_name("away"))
    monkeypatch.chdir(folder)
    assert digests("study.yaml") == wanted
    assert folder.name == "own" and held(folder) == {*contents, "README.txt"}
    assert {name: (folder / name).read_bytes() for name in contents} == contents
    assert f"digest {solver_digest()}, with\nPython 3." in (folder / "README.txt").read_text()


def test_a_table_of_cases(home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (home / "cases.csv").write_text("S_R, motion.file\n0.10, hazard.csv\n0.50, scenes/records/quake.csv\n")
    (home / "hazard.csv").write_text(RECORD.replace("2.0", "1.0"))
    (home / "cases.yaml").write_text(yaml.safe_dump({"study": "cases", "scene": "scenes/slope.yaml", "cases": "cases.csv"}))
    folder = unpacked(home / pack(Path("cases.yaml"))[0], tmp_path / "there")
    assert (folder / "cases.csv").read_bytes() == (home / "cases.csv").read_bytes()
    wanted = digests_of_runs("cases.yaml")
    monkeypatch.chdir(folder)
    assert digests_of_runs("cases.yaml") == wanted and len(set(wanted.values())) == 2


def test_what_the_program_brings_is_packed_as_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text('study: mine\nscene: config/scenes/gentle_layered.yaml\ngrid: {S_R: ["0.5"]}\n')
    folder = unpacked(pack(Path("mine.yaml"))[0].resolve(), tmp_path / "there")
    brought = {f"config/{name}" for name in ("scenes/gentle_layered.yaml", "ground/gentle_layered.csv", "motions/synthetic.csv")}
    assert brought < held(folder)
    assert (folder / "config/scenes/gentle_layered.yaml").read_bytes() == (ROOT / "config/scenes/gentle_layered.yaml").read_bytes()


def test_a_study_that_is_laid_over_another(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config").mkdir()
    shutil.copy(ROOT / "config" / "config.yaml", tmp_path / "config")
    (tmp_path / "mine.yaml").write_text('study: mine\ngrid: {S_R: ["0.5"]}\n')
    folder = unpacked(pack(Path("mine.yaml"))[0].resolve(), tmp_path / "there")
    assert {"mine.yaml", "config/config.yaml", "config/scenes/paper.yaml"} < held(folder)
    (tmp_path / "config" / "config.yaml").unlink()
    with pytest.raises(ValueError, match=r"mine.yaml: scene: is missing, and there is no config/config.yaml"):
        pack(Path("mine.yaml"))


def test_results_are_packed_without_what_is_half_written(home: Path, tmp_path: Path) -> None:
    place = home / "results" / "own" / "own"
    place.mkdir(parents=True)
    for name in ("report.html", "runs/S_R-0.10.nc", "runs/.S_R-0.50.nc.part"):
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_text(name)
    (home / "results" / "own" / "scene_file.txt").write_text("scenes/slope.yaml\n")
    folder = unpacked(home / pack(Path("study.yaml"), results=True)[0], tmp_path / "there")
    results = {name for name in held(folder) if name.startswith("results/")}
    assert results == {f"results/own/{name}" for name in ("own/report.html", "own/runs/S_R-0.10.nc", "scene_file.txt")}
    assert "--touch" in (folder / "README.txt").read_text()


@pytest.mark.parametrize(
    ("changes", "arguments", "message"),
    [
        ({"hazard.csv": None}, (), r"trigger.yaml: hazard: no file 'hazard.csv'"),
        ({"scenes/records/quake.csv": None}, (), "'records/quake.csv' cannot be read: No such file"),
        ({"study.yaml": STUDY.replace("experiments/trigger.yaml", "gone.yaml")}, (), r"experiments.trigger: no file 'gone.yaml'"),
        ({"study.yaml": STUDY + "fidelities: {own: {motion: {file: gone.csv}}}\n"}, (), "gone.csv"),
        ({}, ("--results",), "results/own: holds no results"),
        ({}, ("-o", "own.rar"), "must end in .zip"),
        ({}, ("-o", "nowhere/own.zip"), "folder nowhere does not exist"),
        ({"study.zip": STUDY}, ("-o", "study.zip"), "would replace"),
        ({"README.txt": HAZARD, "experiments/trigger.yaml": TRIGGER.replace("hazard.csv", "README.txt")}, (), "README.txt in the archive"),
        (
            {"experiments/trigger.yaml": TRIGGER.replace("survey/quake.csv", "HOME/survey/quake.csv")},
            (),
            "cases.weaker shaking.motion.file: '/.*/survey/quake.csv': would not lead to its file elsewhere; write survey/quake.csv",
        ),
        (
            {"scenes/slope.yaml": SCENE.replace("../survey/line.csv", "../../line.csv"), "../line.csv": GROUND},
            (),
            r"slope.yaml: geometry.file: /.*/line.csv lies outside the working folder /.*/home; copy it below that folder",
        ),
        (
            {"study.yaml": STUDY.replace("{S_R:", "{motion.file: [survey/../../quake.csv], S_R:"), "../quake.csv": RECORD},
            (),
            r"grid.motion.file: /.*/quake.csv lies outside the working folder",
        ),
        (
            {"cases.csv": "motion.file\nsurvey/../../quake.csv\n", "study.yaml": STUDY_OF_CASES, "../quake.csv": RECORD},
            (),
            "cases.csv: motion.file of case 1: /.*/quake.csv lies outside the working folder",
        ),
    ],
)
def test_what_cannot_be_packed_is_refused(home: Path, changes: dict[str, str | None], arguments: tuple[str, ...], message: str) -> None:
    for name, text in changes.items():
        if text is None:
            (home / name).unlink()
        else:
            (home / name).write_text(text.replace("HOME", home.as_posix()))
    before = held(home)
    told = call("pack", "study.zip" if "study.zip" in changes else "study.yaml", *arguments)
    assert told.exit_code == 2 and re.search(message, told.stderr), told.output
    assert held(home) == before, "nothing is written"


def test_two_files_of_one_place_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = "config/ground/gentle_layered.csv"
    (tmp_path / "config" / "ground").mkdir(parents=True)
    study = {"study": "mine", "scene": "config/scenes/gentle_layered.yaml", "grid": {"geometry.file": [line]}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(study))
    shutil.copy(ROOT / line, tmp_path / line)
    assert pack(Path("mine.yaml"))[1] == 5, "the same content"
    (tmp_path / line).write_text((ROOT / line).read_text() + "# edited\n")
    with pytest.raises(ValueError, match=f"would be {line} in the archive, and so would .* which differs; rename one of them"):
        pack(Path("mine.yaml"))


def test_an_archive_among_the_results_is_refused(home: Path) -> None:
    (home / "results" / "own").mkdir(parents=True)
    (home / "results" / "own" / "study.csv").write_text("run\n")
    with pytest.raises(ValueError, match="lies among the results"):
        pack(Path("study.yaml"), Path("results/own/own.zip"), results=True)


def test_named_files_of_a_scene_are_those_that_it_is_read_from() -> None:
    for path in sorted((ROOT / "config" / "scenes").glob("*.yaml")):
        data = read_yaml(path)
        assert sorted({name for _, name, _ in named_files(data)}) == scene_files(data), path


def test_forms_of_names() -> None:
    data = yaml.safe_load(
        "motion: {file: gone.csv, data: [1]}\ngrid: {motion.file: [x y.csv, 'null', a.csv]}\ncases: [{motion.file: b.csv}]\n"
    )
    found = [(key, name) for key, name, _ in named_files(data)]
    assert found == [("grid.motion.file", "x y.csv"), ("grid.motion.file", "a.csv"), ("cases.motion.file", "b.csv")]


@pytest.mark.long
def test_the_command_in_the_archive_lists_the_same_jobs(home: Path, tmp_path: Path) -> None:
    def jobs(folder: Path, *arguments: str) -> dict[str, str]:
        done = snakemake_in(folder, "--dry-run", *arguments)
        assert done.returncode == 0, done.stderr
        table = (done.stdout + done.stderr).partition("Job stats:")[2].partition("total")[0]
        return dict(re.findall(r"^(\w+) +(\d+)$", table, re.MULTILINE))

    wanted = jobs(home, "--snakefile", str(ROOT / "Snakefile"), "--cores", "2", "--configfile", "study.yaml")
    folder = unpacked(home / pack(Path("study.yaml"))[0], tmp_path / "there")
    line = next(line for line in (folder / "README.txt").read_text().splitlines() if "bin/snakemake" in line)
    program, *arguments = shlex.split(line.replace("~/sph-slope", str(ROOT)))
    assert Path(program).name in os.listdir(Path(sys.executable).parent)
    os.rename(home, tmp_path / "away")
    assert jobs(folder, *arguments) == wanted and wanted["simulate"] == "2"
    assert "trigger" in jobs(folder, *arguments, "--", "trigger"), "its configuration and hazard curve are found"
