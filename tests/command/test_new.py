"""``sph new``: a scene and a study that can be run as they are written, and say that their soil is not the user's."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

import sph
from sph.checks.cover_rows import covers, enough_rows
from sph.checks.scene import PLACEHOLDER
from sph.command.cli import app
from sph.command.new import write_new
from sph.scene.natural_periods import column_at, natural_frequencies
from sph.scene.schema import load_scene
from sph.study.cost import cost
from sph.study.machine import duration
from sph.study.plan import load_study

ROOT = Path(__file__).parents[2]
GROUND = ROOT / "config" / "ground" / "gentle_layered.csv"
STEEP = ROOT / "config" / "ground" / "steep_cut.geojson"
RECORD = ROOT / "config" / "motions" / "synthetic.csv"


def test_what_is_written_can_be_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    told = CliRunner().invoke(app, ["new", str(GROUND), str(RECORD), "--out", "own"])
    assert told.exit_code == 0, told.output
    scene = load_scene("own/scene.yaml")
    assert scene.scheme == "resolved" and scene.coupling.softening is not None
    assert scene.geometry.slope_height / scene.numerics.spacing == pytest.approx(20, 1e-5)  # type: ignore[union-attr]
    assert scene.motion.start + 16.0 < scene.duration  # type: ignore[union-attr]
    assert "not replaced" in scene.title and (tmp_path / "own" / "scene.yaml").read_text().count("REPLACE") >= 7
    plan = load_study(yaml.safe_load((tmp_path / "own" / "study.yaml").read_text()), [tmp_path])
    assert len(plan.study.runs) == 9 and plan.study.names == ["S_R", "amplitude"]
    coarse = CliRunner().invoke(app, ["check", "own/scene.yaml", "--set", "numerics.spacing=1.64667"])
    assert "spacing: 1.64667" in (tmp_path / "own" / "study.yaml").read_text()
    assert coarse.output.count("\nwarning:") == 1, "of the soil alone"
    checked = CliRunner().invoke(app, ["check", "own/scene.yaml", "--json"])
    found = {each["code"]: each for each in json.loads(checked.stdout)["findings"]}
    assert checked.exit_code == 0 and {code for code, each in found.items() if each["severity"] != "note"} == {"soil-not-replaced"}


def test_a_cover_has_the_rows_that_its_run_out_needs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the scene that is written, by its own check; a thick cover changes nothing."""
    monkeypatch.chdir(tmp_path)
    told = CliRunner().invoke(app, ["new", str(GROUND), str(RECORD), "--out", "own", "--cover", "2"])
    assert told.exit_code == 0 and "enough rows" in told.stderr and "on one core of the reference machine" in told.stderr
    scene = load_scene("own/scene.yaml")
    height = scene.geometry.slope_height  # type: ignore[union-attr]
    study = yaml.safe_load(Path("own/study.yaml").read_text())
    coarse = load_scene("own/scene.yaml", study["fidelities"]["coarse"])
    for each in (scene, coarse):
        ((cover,), rows) = covers(each), height / each.numerics.spacing
        assert (cover.name, cover.ground, cover.thickness) == ("soil", "ground", pytest.approx(2.0)) and not cover.short
        assert rows == pytest.approx(round(rows), 1e-5) and cover.rows >= enough_rows()  # type: ignore[operator]
        below = each.geometry.toe[1] / each.numerics.spacing  # type: ignore[union-attr]
        assert below == pytest.approx(round(below), abs=1e-3), "whole rows below the toe, too"
    assert study["second_fidelity"] == "coarse" and cover.rows < enough_rows() + 3 * 2.0 / height  # type: ignore[operator]
    assert "in the cover" in Path("own/scene.yaml").read_text() and scene.damping is not None
    assert scene.damping.frequencies[0] == pytest.approx(float(natural_frequencies(column_at(scene, scene.geometry.crest))[0]), rel=5e-3)  # type: ignore[union-attr]
    checked = CliRunner().invoke(app, ["check", "own/scene.yaml", "--json"])
    found = {each["code"] for each in json.loads(checked.stdout)["findings"] if each["severity"] != "note"}
    assert found == {"soil-not-replaced"}
    thick = load_scene(write_new(GROUND, RECORD, Path("thick"), cover=6.0)[0])
    assert thick.geometry.slope_height / thick.numerics.spacing == pytest.approx(20, 1e-5)  # type: ignore[union-attr]


def test_a_cover_that_costs_much_has_no_rows_to_spare_and_one_that_costs_too_much_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A study then compares no coarser particles, which would hold the cover."""
    command = ["new", str(GROUND), str(RECORD), "--out", str(tmp_path / "own"), "--cover", "1.5"]
    monkeypatch.setattr("sph.command.new.MAX_COMPARED", 60.0)
    told = CliRunner().invoke(app, command)
    scene, study = load_scene(tmp_path / "own" / "scene.yaml"), yaml.safe_load((tmp_path / "own" / "study.yaml").read_text())
    (cover,) = covers(scene)
    assert not cover.short and cover.rows < enough_rows() + 4 * 1.5 / scene.geometry.slope_height  # type: ignore[operator,union-attr]
    assert study["second_fidelity"] is None and f"A run takes {duration(cost(scene).seconds)} on one core" in told.stderr
    monkeypatch.setattr("sph.command.new.MAX_RUN", 30.0)
    shutil.rmtree(tmp_path / "own")
    refused = CliRunner().invoke(app, command)
    assert (
        refused.exit_code == 2 and "--cover 1.5: 3 rows" in refused.stderr and "seam" in refused.stderr and not (tmp_path / "own").exists()
    )


@pytest.mark.parametrize("thickness", ["0", "-1", "40", "nan"])
def test_a_cover_that_is_none_is_refused(tmp_path: Path, thickness: str) -> None:
    told = CliRunner().invoke(app, ["new", str(GROUND), str(RECORD), "--out", str(tmp_path / "own"), f"--cover={thickness}"])
    assert told.exit_code == 2 and "--cover" in told.stderr and "24.7 m" in told.stderr and not (tmp_path / "own").exists()


def test_what_decides_the_answer_is_written_out(tmp_path: Path) -> None:
    scene, study = write_new(GROUND, RECORD, tmp_path)
    keys = yaml.safe_load(scene.read_text(encoding="utf-8"))
    assert keys["walls"] == {"base": "absorbing", "sides": "absorbing", "bedrock": None} and keys["soil"]["dilation_angle"] == 0.0
    assert set(keys["coupling"]["softening"]) == {"slip_at_peak", "slip_at_residual", "width"}
    for line in ("walls:", "dilation_angle:", "softening:"):
        at = next(number for number, text in enumerate(scene.read_text(encoding="utf-8").splitlines()) if text.strip().startswith(line))
        assert "#" in "".join(scene.read_text(encoding="utf-8").splitlines()[at - 1 : at + 1]), f"{line} has a comment"


def test_the_damping_fits_the_column_that_sph_info_names(tmp_path: Path) -> None:
    written = load_scene(write_new(GROUND, RECORD, tmp_path)[0])
    told = CliRunner().invoke(app, ["info", str(tmp_path / "scene.yaml")]).output
    assert written.damping is not None and f"{written.damping.frequencies[0]:.3g} Hz below the crest edge" in told
    assert written.damping.frequencies[1] == pytest.approx(5.0 * written.damping.frequencies[0])


def test_rock_below_is_described_as_the_comment_says(tmp_path: Path) -> None:
    path, _ = write_new(GROUND, RECORD, tmp_path)
    (rock,) = (line.strip("# ") for line in path.read_text(encoding="utf-8").splitlines() if "s_wave_speed: 800" in line)
    bedrock = load_scene(path, {"walls": yaml.safe_load(rock)}).walls.bedrock
    assert bedrock is not None and (bedrock.density, bedrock.s_wave_speed, bedrock.p_wave_speed) == (2300.0, 800.0, 1500.0)


def test_editors_find_the_schemas(tmp_path: Path) -> None:
    for path in write_new(GROUND, RECORD, tmp_path):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema=")
        schema = json.loads((tmp_path / first.partition("$schema=")[2]).read_text(encoding="utf-8"))
        assert set(yaml.safe_load(path.read_text(encoding="utf-8"))) <= set(schema["properties"])


def test_the_side_to_which_the_slope_falls_is_found(tmp_path: Path) -> None:
    scene, _ = write_new(STEEP, RECORD, tmp_path / "steep")
    assert load_scene(scene).geometry.downhill == "right"  # type: ignore[union-attr]


def test_a_hillside_that_rises_to_the_end_of_the_line_is_told(tmp_path: Path) -> None:
    """Beside the key by which the crest of its steeper face is chosen."""
    line = tmp_path / "ground.csv"
    line.write_text("x,z\n0,100\n40,100\n60,120\n140,150\n")
    text = write_new(line, RECORD, tmp_path / "own")[0].read_text(encoding="utf-8")
    assert "  # the slope goes on to the side of the model" in text and "change geometry.crest_at=[60, 120]" in text
    assert "goes on" not in write_new(GROUND, RECORD, tmp_path / "other")[0].read_text(encoding="utf-8")


def test_nothing_is_overwritten_and_bad_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text("mine")
    for arguments, message in (
        ([GROUND, RECORD, "--out", tmp_path], "study.yaml is there already; name another folder"),
        ([tmp_path / "absent.csv", RECORD, "--out", tmp_path / "a"], "absent.csv"),
        ([GROUND, GROUND, "--out", tmp_path / "a"], "gentle_layered.csv"),
    ):
        told = CliRunner().invoke(app, ["new", *map(str, arguments)])
        assert told.exit_code == 2 and message in told.stderr
    assert (tmp_path / "study.yaml").read_text() == "mine" and not (tmp_path / "a").exists()


NAMES = (
    "Site #3.csv",
    "A: B.csv",
    "007.csv",
    "it's.csv",
    'a "quoted" \\ one.csv',
    "{braces}.csv",
    "Böschung, Süd.csv",
    "- [x] & *y.csv",
    "%TAG !.csv",
    " blank .csv",
    "n" * 200 + ".csv",
)


@pytest.mark.parametrize("name", NAMES)
def test_names_come_back_as_they_were(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Of the ground, of the record and of the folder."""
    monkeypatch.chdir(tmp_path)
    survey, motion, folder = Path("survey") / name, Path("motion") / name, Path("out") / name
    for path, source in ((survey, GROUND), (motion, RECORD)):
        path.parent.mkdir()
        shutil.copy(source, path)
    scene, study = write_new(survey, motion, folder)
    keys, planned = (yaml.safe_load(path.read_text(encoding="utf-8")) for path in (scene, study))
    assert (folder / keys["geometry"]["file"]).samefile(survey) and (folder / keys["motion"]["file"]).samefile(motion)
    assert Path(planned["scene"]) == scene and name[:100] in keys["title"] and PLACEHOLDER in load_scene(scene).title
    assert len(load_study(planned, [tmp_path]).study.runs) == 9
    command = next(line for line in scene.read_text(encoding="utf-8").splitlines() if "sph check" in line)
    assert shlex.split(command)[1:4] == ["sph", "check", str(scene)]


def test_the_study_has_the_name_of_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two studies from two files of one name do not write to one folder of results."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for folder in ("north", "south-2", "007", "true", "...", "Süd"):
        scene, study = write_new(GROUND, RECORD, Path(folder))
        names[folder] = yaml.safe_load(study.read_text(encoding="utf-8"))["study"]
        assert load_scene(scene).name == names[folder] == load_study(yaml.safe_load(study.read_text()), [tmp_path]).study.study
    assert names == {"north": "north", "south-2": "south-2", "007": "007", "true": "true", "...": "slope...", "Süd": "S_d"}
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    assert load_scene(write_new(GROUND, RECORD, Path())[0]).name == "here"


def test_a_refusal_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> None:
        raise ValueError("refused after it was written")

    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    (tmp_path / "line\nbreak.csv").write_text(GROUND.read_text())
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ValueError, match="cannot be printed"):
        write_new(tmp_path / "line\nbreak.csv", RECORD, tmp_path / "a")
    monkeypatch.setattr("sph.command.new.load_scene", refuse)
    for folder in (tmp_path / "a" / "b" / "c", tmp_path / "mine" / "new", tmp_path / "mine"):
        with pytest.raises(ValueError, match="refused after"):
            write_new(GROUND, RECORD, folder)
    assert sorted(tmp_path.rglob("*")) == before


def test_the_version_is_printed() -> None:
    assert CliRunner().invoke(app, ["--version"]).stdout == f"sph {sph.__version__}\n"
    assert CliRunner().invoke(app, ["-h"]).stdout == CliRunner().invoke(app, ["--help"]).stdout
