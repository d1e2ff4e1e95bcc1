"""``sph new``: a scene and a study that can be run as they are written, and say that their soil is not the user's."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

import sph
from sph.checks.cover_rows import covers, enough_rows
from sph.checks.scene import PLACEHOLDER, findings
from sph.command.cli import app
from sph.command.known import Known
from sph.command.new import AFTER, SPRING, Written, write_new
from sph.scene.gravity import GRAVITY
from sph.scene.natural_periods import column_at, natural_frequencies
from sph.scene.schema import load_scene
from sph.scene.scheme import SOFTENING
from sph.study.cost import cost
from sph.study.machine import duration
from sph.study.plan import load_study

ROOT = Path(__file__).parents[2]
GROUND = ROOT / "config" / "ground" / "gentle_layered.csv"
STEEP = ROOT / "config" / "ground" / "steep_cut.geojson"
RECORD = ROOT / "config" / "motions" / "synthetic.csv"


def written(folder: Path, ground: Path = GROUND, record: Path = RECORD, **known: Any) -> Written:
    return write_new(Known(ground, [record], **known), folder)


def test_what_is_written_can_be_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    told = CliRunner().invoke(app, ["new", str(GROUND), str(RECORD), "--out", "own"])
    assert told.exit_code == 0, told.output
    scene = load_scene("own/scene.yaml")
    assert scene.scheme == "resolved" and scene.coupling.softening is not None
    assert scene.geometry.slope_height / scene.numerics.spacing == pytest.approx(20, 1e-5)  # type: ignore[union-attr]
    assert scene.motion.start + 16.0 < scene.duration  # type: ignore[union-attr]
    assert "not replaced" in scene.title and (tmp_path / "own" / "scene.yaml").read_text().count("ASSUMED") >= 9
    plan = load_study(yaml.safe_load((tmp_path / "own" / "study.yaml").read_text()), [tmp_path])
    assert len(plan.study.runs) == 18 and plan.study.names == ["S_R", "amplitude", "motion.factor"]
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
    assert told.exit_code == 0 and "fails too late" in told.stderr and "on one core of the reference machine" in told.stderr
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
    assert found == {"soil-not-replaced", "cover-late", "probes-off-slide"}, "fifteen rows would take some fifty times as long"
    assert scene.coupling.softening is not None and scene.coupling.softening.width == 2.0, "no soil beside it softens with it"
    assert scene.coupling.softening.width >= 3.0 * coarse.numerics.spacing
    thick = load_scene(written(Path("thick"), cover=6.0).scene)
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
    assert refused.exit_code == 2 and "--cover 1.5: the rows" in refused.stderr and "seam" in refused.stderr
    assert not (tmp_path / "own").exists()


@pytest.mark.parametrize("thickness", ["0", "-1", "40", "nan"])
def test_a_cover_that_is_none_is_refused(tmp_path: Path, thickness: str) -> None:
    told = CliRunner().invoke(app, ["new", str(GROUND), str(RECORD), "--out", str(tmp_path / "own"), f"--cover={thickness}"])
    assert told.exit_code == 2 and "--cover" in told.stderr and "24.7 m" in told.stderr and not (tmp_path / "own").exists()


def test_what_decides_the_answer_is_written_out(tmp_path: Path) -> None:
    scene, study, _ = written(tmp_path)
    keys = yaml.safe_load(scene.read_text(encoding="utf-8"))
    assert keys["walls"] | {"bedrock": {}} == {"base": "absorbing", "sides": "absorbing", "bedrock": {}}
    assert keys["soil"]["dilation_angle"] == 0.0
    assert set(keys["coupling"]["softening"]) == {"slip_at_peak", "slip_at_residual", "width"}
    for line in ("walls:", "dilation_angle:", "softening:"):
        at = next(number for number, text in enumerate(scene.read_text(encoding="utf-8").splitlines()) if text.strip().startswith(line))
        assert "#" in "".join(scene.read_text(encoding="utf-8").splitlines()[at - 1 : at + 1]), f"{line} has a comment"


def test_a_wet_slope_has_the_kernel_that_keeps_its_ground_in_place(tmp_path: Path) -> None:
    wet, dry = (written(tmp_path / name, water=depth).scene for name, depth in (("wet", 3.0), ("dry", None)))
    assert "\n  smoothing_ratio: 1.22 #" in wet.read_text() and load_scene(wet).numerics.smoothing_ratio == 1.22
    assert "smoothing_ratio" not in dry.read_text()


def test_the_damping_fits_the_column_that_sph_info_names(tmp_path: Path) -> None:
    scene = load_scene(written(tmp_path).scene)
    told = CliRunner().invoke(app, ["info", str(tmp_path / "scene.yaml")]).output
    assert scene.damping is not None and f"{scene.damping.frequencies[0]:.3g} Hz below the crest edge" in told
    assert scene.damping.frequencies[1] == pytest.approx(5.0 * scene.damping.frequencies[0])


def test_the_bedrock_is_as_the_lowest_soil_and_bears_what_comes_on_it(tmp_path: Path) -> None:
    scene = load_scene(written(tmp_path).scene)
    rock, lowest = scene.walls.bedrock, scene.soils[-1]
    assert rock is not None and rock.spring_frequency == SPRING
    assert (rock.density, rock.s_wave_speed) == pytest.approx((lowest.density, lowest.s_wave_speed))
    assert rock.p_wave_speed == pytest.approx(lowest.p_wave_speed, rel=1e-3)
    assert "soft-bedrock" not in {each.code for each in findings(scene)}


def test_rock_below_is_described_as_the_comment_says(tmp_path: Path) -> None:
    path = written(tmp_path).scene
    (rock,) = (line.strip("# ") for line in path.read_text(encoding="utf-8").splitlines() if "s_wave_speed: 800" in line)
    bedrock = load_scene(path, {"walls": yaml.safe_load(rock)}).walls.bedrock
    assert bedrock is not None and (bedrock.density, bedrock.s_wave_speed, bedrock.p_wave_speed) == (2300.0, 800.0, 1500.0)


def test_editors_find_the_schemas(tmp_path: Path) -> None:
    for path in written(tmp_path)[:2]:
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema=")
        schema = json.loads((tmp_path / first.partition("$schema=")[2]).read_text(encoding="utf-8"))
        assert set(yaml.safe_load(path.read_text(encoding="utf-8"))) <= set(schema["properties"])


def test_the_side_to_which_the_slope_falls_is_found(tmp_path: Path) -> None:
    assert load_scene(written(tmp_path / "steep", STEEP).scene).geometry.downhill == "right"  # type: ignore[union-attr]


def test_a_hillside_that_rises_to_the_end_of_the_line_is_told(tmp_path: Path) -> None:
    """Beside the key by which the crest of its steeper face is chosen."""
    line = tmp_path / "ground.csv"
    line.write_text("x,z\n0,100\n40,100\n60,120\n140,150\n")
    text = written(tmp_path / "own", line).scene.read_text(encoding="utf-8")
    assert "  # the slope goes on to the side of the model" in text and "change geometry.crest_at=[60, 120]" in text
    assert "the slope goes on" not in written(tmp_path / "other").scene.read_text(encoding="utf-8")


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
    scene, study, _ = written(folder, survey, motion)
    keys, planned = (yaml.safe_load(path.read_text(encoding="utf-8")) for path in (scene, study))
    assert (folder / keys["geometry"]["file"]).samefile(survey) and (folder / keys["motion"]["file"]).samefile(motion)
    assert Path(planned["scene"]) == scene and name[:100] in keys["title"] and PLACEHOLDER in load_scene(scene).title
    assert len(load_study(planned, [tmp_path]).study.runs) == 18
    command = next(line for line in scene.read_text(encoding="utf-8").splitlines() if "sph check" in line)
    assert shlex.split(command.partition("look at it:")[2])[:3] == ["sph", "check", str(study)]


def test_the_study_has_the_name_of_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two studies from two files of one name do not write to one folder of results."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for folder in ("north", "south-2", "007", "true", "...", "Süd"):
        scene, study, _ = written(Path(folder))
        names[folder] = yaml.safe_load(study.read_text(encoding="utf-8"))["study"]
        assert load_scene(scene).name == names[folder] == load_study(yaml.safe_load(study.read_text()), [tmp_path]).study.study
    assert names == {"north": "north", "south-2": "south-2", "007": "007", "true": "true", "...": "slope...", "Süd": "S_d"}
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    assert load_scene(written(Path()).scene).name == "here"


def test_a_refusal_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise ValueError("refused after it was written")

    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    (tmp_path / "line\nbreak.csv").write_text(GROUND.read_text())
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ValueError, match="cannot be printed"):
        written(tmp_path / "a", tmp_path / "line\nbreak.csv")
    monkeypatch.setattr("sph.command.new.load_study", refuse)
    for folder in (tmp_path / "a" / "b" / "c", tmp_path / "mine" / "new", tmp_path / "mine"):
        with pytest.raises(ValueError, match="refused after"):
            written(folder)
    assert sorted(tmp_path.rglob("*")) == before


def test_the_tutorial_knows_what_is_simulated_after_the_shaking() -> None:
    text = (ROOT / "docs" / "tutorials" / "own-slope.md").read_text(encoding="utf-8")
    assert f"adds {AFTER:g} √H s" in text and f"{AFTER * 25.0**0.5:g} s for 25 m" in text


def test_the_version_is_printed() -> None:
    assert CliRunner().invoke(app, ["--version"]).stdout == f"sph {sph.__version__}\n"
    assert CliRunner().invoke(app, ["-h"]).stdout == CliRunner().invoke(app, ["--help"]).stdout


KNOWN = shlex.split(
    "--slope 28,32 --cover 4 --water 2.5 --record A.csv --record B.csv --scale-to 0.35g --place path=8,house=40 "
    "--soil unit_weight=19,cohesion=6,friction_angle=32,residual_cohesion=0,residual_friction_angle=20"
)


@pytest.fixture
def records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two in the working folder."""
    monkeypatch.chdir(tmp_path)
    for name in ("A.csv", "B.csv"):
        shutil.copy(RECORD, name)


@pytest.mark.usefixtures("records")
def test_several_levels_of_shaking_and_a_place_behind_the_crest_are_of_the_study() -> None:
    several = ["--scale-to", "0.2g,0.35g", "--scale-to", "4 m/s2", "--place", "track=-60"]
    told = CliRunner().invoke(app, ["new", "--slope", "28,32", "--record", "A.csv", *several, "--out", "own"])
    assert told.exit_code == 0, told.output
    study = load_study(Path("own/study.yaml")).study
    assert study.values["amplitude"] == ("1.962", "3.4335", "4") and study.metrics.places == {"track": -60.0} and study.design is None
    told = CliRunner().invoke(app, ["new", "--slope", "28,32", "--record", "A.csv", *several, "--design", "0.25g", "--out", "third"])
    assert told.exit_code == 0, told.output
    study = load_study(Path("third/study.yaml")).study
    assert study.design == pytest.approx(0.25 * GRAVITY) and "2.4525" in study.values["amplitude"] and len(study.values["amplitude"]) == 4


@pytest.mark.usefixtures("records")
def test_the_soil_below_a_cover_may_be_typed() -> None:
    below = "unit_weight=20,cohesion=14,friction_angle=27,residual_cohesion=1,residual_friction_angle=19,shear_wave_speed=280"
    told = CliRunner().invoke(app, ["new", *KNOWN, "--below", below, "--out", "own"])
    assert told.exit_code == 0, told.output
    scene = load_scene("own/scene.yaml")
    soil, bedrock = scene.layers["ground"].soil, scene.walls.bedrock
    assert bedrock is not None and bedrock.s_wave_speed == 280.0 and bedrock.density == pytest.approx(20e3 / 9.80665, rel=1e-3)
    assert (soil.cohesion, soil.residual_friction_angle, soil.density) == (14.0, 19.0, bedrock.density)
    assert soil.s_wave_speed == pytest.approx(280.0)
    assert load_study(Path("own/study.yaml")).study.assumed["layers.ground"].startswith("the cover is as thick everywhere")
    part = CliRunner().invoke(app, ["new", *KNOWN, "--below", "shear_wave_speed=300", "--out", "part"])
    assert "below the cover density: 2200, cohesion: 200, friction_angle: 38" in part.output and "shear_wave_speed: 450" not in part.output
    weak = CliRunner().invoke(app, ["new", *KNOWN, "--below", "cohesion=14", "--out", "weak"])
    assert weak.exit_code == 2 and "--below cohesion: give residual_cohesion and residual_friction_angle as well" in weak.output


@pytest.mark.usefixtures("records")
def test_the_loss_of_strength_may_be_typed() -> None:
    """Then only its width is assumed, if that was not typed as well, and the page does not ask for shear tests."""
    slips = "slip_at_peak=0.003,slip_at_residual=0.07,shape=exponential"
    for typed, width, assumed in ((slips, None, {f"{SOFTENING}.width"}), (f"{slips},width=2.5", 2.5, set())):
        told = CliRunner().invoke(app, ["new", *KNOWN, "--softening", typed, "--out", "own"])
        assert told.exit_code == 0, told.output
        softening = load_scene("own/scene.yaml").coupling.softening
        assert (softening.slip_at_peak, softening.slip_at_residual, softening.shape) == (0.003, 0.07, "exponential")
        assert width is None or softening.width == width
        assert {key for key in load_study(Path("own/study.yaml")).study.assumed if SOFTENING in key} == assumed
        shutil.rmtree("own")
    for typed, why in (
        ("slip_at_peak=0.003", "give both slip_at_peak and slip_at_residual"),
        ("slip_at_peak=0.1,slip_at_residual=0.07", "must be more than slip_at_peak"),
        (f"{slips},rate=3", "rate"),
    ):
        told = CliRunner().invoke(app, ["new", *KNOWN, "--softening", typed, "--out", "own"])
        assert told.exit_code == 2 and "--softening" in told.output and why in " ".join(told.output.split()), told.output


@pytest.mark.usefixtures("records")
def test_what_an_engineer_knows_makes_a_study_that_is_ready_to_run() -> None:
    """All that was typed is in it, nothing of it is assumed, and its checks have nothing against it."""
    told = CliRunner().invoke(app, ["new", *KNOWN, "--alternative", "drained=5,berm=5,reinforced=10", "--out", "own"])
    assert told.exit_code == 0, told.output
    scene, plan = load_scene("own/scene.yaml"), load_study(Path("own/study.yaml"))
    geometry = scene.geometry
    assert (geometry.slope_height, geometry.downhill) == (pytest.approx(28.0), "right")  # type: ignore[union-attr]
    assert scene.soil.density * 9.81e-3 == pytest.approx(19.0, rel=1e-3) and (scene.soil.cohesion, scene.soil.residual_friction_angle) == (
        6,
        20,
    )
    (cover,) = covers(scene)
    assert cover.thickness == pytest.approx(4.0) and not cover.short and scene.early_stop is not None
    assert scene.duration > scene.motion.end + 20.0  # type: ignore[union-attr]
    assert plan.study.values == {
        "amplitude": ("3.4335",),
        "motion.file": ("A.csv", "B.csv"),
        "motion.factor": ("-1", "1"),
        "alternative": ("base", "drained", "berm", "reinforced"),
    }
    nailed = plan.built(**next(each for each in plan.study.runs.values() if each["alternative"] == "reinforced"))
    assert (nailed.soil.cohesion, nailed.soil.residual_cohesion) == (16.0, 10.0), "nails hold soil that has failed, too"
    assert nailed.soils[1] == scene.soils[1] and "alternatives.reinforced" in plan.study.assumed
    assert plan.study.metrics.places == {"path": 8.0, "house": 40.0} and plan.study.second_fidelity == "coarse"
    lines = [line for line in told.stdout.splitlines() if line.startswith("assumed: ")]
    text = Path("own/scene.yaml").read_text()
    assert any(f"{5.0 / scene.numerics.spacing:.2g} rows of particles high" in line for line in lines)
    assert len(lines) >= 7 and lines == [f"assumed: {key}: {words}" for key, words in plan.study.assumed.items()]
    assert next(iter(plan.study.assumed)) == SOFTENING, "what decides most"
    marked = {line.split(":")[0].strip(): line.endswith("ASSUMED") for line in text.splitlines() if not line.startswith("#")}
    assert not marked["density"] and not marked["residual_friction_angle"] and marked["shear_wave_speed"] and marked["softening"]
    checked = CliRunner().invoke(app, ["check", "own/study.yaml", "--json"])
    kinds = json.loads(checked.stdout)
    assert checked.exit_code == 0 and [each["code"] for each in kinds["findings"] if each["severity"] != "note"] == ["cover-late"]
    assert not [each for section in kinds["alternatives"].values() for each in section if each["severity"] == "error"]


@pytest.mark.usefixtures("records")
@pytest.mark.parametrize(("slope", "cover", "high"), [("26,27", 7.0, 4.0), ("22,30", 5.0, 5.0)])
def test_a_berm_is_whole_at_the_coarser_spacing_as_well(slope: str, cover: float, high: float) -> None:
    """Before, these were broken into single particles there, which stopped the study."""
    known = ["--slope", slope, "--cover", str(cover), "--record", "A.csv", "--scale-to", "0.4g", "--alternative", f"berm={high}"]
    assert CliRunner().invoke(app, ["new", *known, "--out", "own"]).exit_code == 0
    plan = load_study(Path("own/study.yaml")).at("coarse")
    with_berm = plan.built(**next(run for run in plan.study.runs.values() if run["alternative"] == "berm"))
    found = {each.code: each.severity for each in findings(with_berm)}
    assert found["thin-layer"] == "warning" and "error" not in found.values()
    assert CliRunner().invoke(app, ["new", *known[:-2], "--out", "without"]).exit_code == 0
    assert with_berm.duration == load_scene("without/scene.yaml").duration, "the rows that a berm needs do not lengthen the run"


@pytest.mark.usefixtures("records")
def test_alternatives_that_nobody_named_are_ready_to_be_added() -> None:
    """Their lines are there, and the comments become keys by taking away the mark."""
    told = CliRunner().invoke(
        app,
        ["new", *KNOWN[: KNOWN.index("--scale-to")], "--scale-to", "0.35 m/s2", *KNOWN[KNOWN.index("--scale-to") + 2 :], "--out", "own"],
    )
    study = Path("own/study.yaml")
    assert told.exit_code == 0 and load_study(study).study.alternatives == {}
    text = study.read_text()
    begin = text.index("# alternatives:")
    study.write_text(text[:begin] + text[begin:].replace("# ", "", 1).replace("\n# ", "\n"))
    plan = load_study(study)
    assert set(plan.study.alternatives) == {"drained", "berm", "reinforced"} and len(plan.study.runs) == 16


@pytest.mark.usefixtures("records")
def test_what_cannot_be_meant_is_refused_by_its_option() -> None:
    for arguments, message in (
        (["--slope", "28,95"], "--slope 28,95: must be a height above 0 m and an angle from 5 to 80 degree"),
        (["--slope", "28"], "write a height (m) and an angle"),
        (["--soil", "c=5"], "--soil: 'c' is not"),
        (["--soil", "residual_cohesion=1"], "give residual_cohesion (0 is usual) and residual_friction_angle, or neither"),
        (["--soil", "unit_weight=1900"], "--soil unit_weight=1900: must be from 10 to 30 kN/m3"),
        (["--soil", "cohesion=high"], "--soil cohesion=high: must be a number"),
        (["--soil", "cohesion"], "--soil 'cohesion': write NAME=VALUE"),
        (["--scale-to", "0.35"], "has no unit; write 0.35g or 0.35 m/s2"),
        (["--place", "house=400,house=30"], "house is given twice"),
        (["--place", "house=-200"], "must lie within the model"),
        (["--below", "strength=3"], "--below: 'strength' is not"),
        (["--alternative", "reinforced=0"], "--alternative reinforced=0: must be above 0 kPa"),
        (["--below", "residual_cohesion=3"], "--below residual_cohesion: give residual_cohesion"),
        (["--below", "unit_weight=3"], "--below unit_weight=3: must be from 10 to 30"),
        (["--scale-to", "0.35g,0.4"], "has no unit; write 0.4g or 0.4 m/s2"),
        (["--alternative", "wall=3"], "--alternative: 'wall' is not"),
        (["--alternative", "drained=3"], "there is no water to drain; give --water"),
        (
            ["--alternative", "drained=1", "--water", "2"],
            "drained=1: must be deeper below the ground than --water, 2 m",
        ),
        (["--alternative", "berm=8", "--place", "path=3"], "--alternative berm=8: would cover path"),
        (["--cover", "30"], "--cover 30: must be above 0 and less than the height of the slope, 28 m"),
        (["--record", str(RECORD)], "of several records, each must lie in this folder or below it"),
        ([str(GROUND)], "give the file of a ground line, or --slope HEIGHT,ANGLE, and not both"),
    ):
        own = [] if "--slope" in arguments else ["--slope", "28,32"]
        told = CliRunner().invoke(app, ["new", *own, *arguments, "--record", "A.csv", "--out", "own"])
        assert told.exit_code == 2 and message in told.stderr, (arguments, told.output)
        assert not Path("own").exists()
    many = ["--slope", "28,95", "--record", "A.csv", "--record", "none.csv", "--soil", "residual_cohesion=0", "--scale-to", "0.3"]
    told = CliRunner().invoke(app, ["new", *many, "--alternative", "drained", "--water", "-1"])
    lines = told.stderr.splitlines()[-6:]
    begin = ("sph: --scale-to", "--alternative 'drained'", "--slope", "--soil residual_cohesion", "--water -1", "--record none.csv")
    assert told.exit_code == 2 and all(line.startswith(each) for line, each in zip(lines, begin, strict=True)), "all at once"
    assert "the depth of the lowered water table, or by how much its line is lowered, and the height of the berm" in lines[1]
    told = CliRunner().invoke(app, ["new", "--slope", "28,32"])
    assert told.exit_code == 2 and "--record: is missing" in told.stderr


@pytest.mark.usefixtures("records")
def test_the_line_of_a_file_is_lowered_and_a_depth_is_one_below_the_ground() -> None:
    """So that a slope whose water is deeper than the number is not made wetter by draining it."""
    Path("water.csv").write_text("x,elevation\n-200,20\n-40,15\n0,-2\n300,-2\n")
    command = ["new", "--slope", "28,32", "--record", "A.csv", "--water", "water.csv"]
    told = CliRunner().invoke(app, [*command, "--alternative", "drained=3", "--out", "line"])
    assert told.exit_code == 0, told.output
    lines = [np.loadtxt(path, delimiter=",", comments=("#", "x")) for path in ("water.csv", "line/drained.csv")]
    assert np.allclose(lines[0] - lines[1], [0.0, 3.0]) and "3 m below the given water table" in Path("line/study.yaml").read_text()
    refused = CliRunner().invoke(app, [*command, "--alternative", "drained=0", "--out", "none"])
    assert "drained=0: must be above 0 m; it is by how much the line of water.csv is lowered" in refused.stderr
    told = CliRunner().invoke(app, [*command[:-1], "2", "--alternative", "drained=3", "--out", "depth"])
    ground, drained = (np.loadtxt(f"depth/{name}.csv", delimiter=",", comments=("#", "x")) for name in ("ground", "drained"))
    assert np.allclose(ground - drained, [0.0, 3.0]) and "# 3 m below the ground" in Path("depth/study.yaml").read_text()
