"""``sph new``: a scene and a study that can be run as they are written, and say that their soil is not the user's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

import sph
from sph.command.cli import app
from sph.command.new import write_new
from sph.scene.schema import load_scene
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


def test_what_decides_the_answer_is_written_out(tmp_path: Path) -> None:
    scene, study = write_new(GROUND, RECORD, tmp_path)
    keys = yaml.safe_load(scene.read_text(encoding="utf-8"))
    assert keys["walls"] == {"base": "absorbing", "sides": "absorbing"} and keys["soil"]["dilation_angle"] == 0.0
    assert set(keys["coupling"]["softening"]) == {"slip_at_peak", "slip_at_residual", "width"}
    for line in ("walls:", "dilation_angle:", "softening:"):
        at = next(number for number, text in enumerate(scene.read_text(encoding="utf-8").splitlines()) if text.strip().startswith(line))
        assert "#" in "".join(scene.read_text(encoding="utf-8").splitlines()[at - 1 : at + 1]), f"{line} has a comment"


def test_editors_find_the_schemas(tmp_path: Path) -> None:
    for path in write_new(GROUND, RECORD, tmp_path):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema=")
        schema = json.loads((tmp_path / first.partition("$schema=")[2]).read_text(encoding="utf-8"))
        assert set(yaml.safe_load(path.read_text(encoding="utf-8"))) <= set(schema["properties"])


def test_the_side_to_which_the_slope_falls_is_found(tmp_path: Path) -> None:
    scene, _ = write_new(STEEP, RECORD, tmp_path / "steep")
    assert load_scene(scene).geometry.downhill == "right"  # type: ignore[union-attr]


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


def test_the_version_is_printed() -> None:
    assert CliRunner().invoke(app, ["--version"]).stdout == f"sph {sph.__version__}\n"
    assert CliRunner().invoke(app, ["-h"]).stdout == CliRunner().invoke(app, ["--help"]).stdout
