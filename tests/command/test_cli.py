"""The command: what it prints, writes, refuses, and the exit codes it documents."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import yaml
from calling import call
from comparison import same_variables
from killing import TIMINGS
from PIL import Image
from small_scenes import SceneBuilder
from typer.testing import CliRunner

import sph.command.terminal
from sph.command.cli import app
from sph.command.options import parse_settings
from sph.command.run import above_limit
from sph.jobs.exit_codes import DIVERGED, REFUSED
from sph.scene.loading import motion_of
from sph.scene.schema import load_scene
from sph.scene.strict_json import parse_json
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Progress, Run
from sph.stability.newmark import sliding_block
from sph.stability.record import search_group
from sph.stability.search import Search
from sph.storage import trajectory


@pytest.fixture
def scene_file(tmp_path: Path, small_slope: SceneBuilder) -> Path:
    path = tmp_path / "slope.yaml"
    path.write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    return path


def test_run_writes_what_plot_and_metrics_read(scene_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    result = call("run", scene_file, "--set", "coupling.S_R=0.10", "--out", out)
    assert result.exit_code == 0, result.output
    assert "complete" in result.stdout and "particle-steps/s" in result.stdout
    assert "of 3 s" in result.stderr and "particle-steps/s" in result.stderr, "plain progress lines where there is no terminal"
    assert trajectory.scene_of(trajectory.read(out)).coupling.S_R == 0.10

    picture = tmp_path / "out.png"
    assert call("plot", out).exit_code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")

    measured = json.loads(call("metrics", out, "--json").stdout)
    assert measured["status"] == "complete" and 0 < measured["failed_fraction"] <= 1
    short, whole = (call("metrics", out, *options).stdout for options in ((), ("--all",)))
    assert "failed_fraction" in short and len(short.splitlines()) < 24
    assert "definition" in whole and "time_step_ratio" in whole and "time_step_ratio" not in short
    diverged = tmp_path / "diverged.nc"
    trajectory.write(diverged, trajectory.read(out).assign_attrs(status="diverged"))
    assert parse_json(call("metrics", diverged, "--json").stdout)["runout"] is None, "null, not NaN"


def test_metrics_say_that_debris_was_braked(scene_file: Path, tmp_path: Path) -> None:
    """By its scene alone, so that runs stored by earlier versions are told as well."""
    out = tmp_path / "cover.nc"
    weak = "layers.weak={region: {kind: depth, bottom: 10}, soil: {cohesion: 20, friction_angle: 20}}"
    assert call("run", scene_file, "--set", weak, *quick(), "--out", out).exit_code == 0
    told = call("metrics", out)
    assert "its run-out is too short" in told.stderr and "[weak-on-strong]" in told.stderr, told.output


def test_stages_join_on_the_command_line(scene_file: Path, tmp_path: Path) -> None:
    gravity, rest, whole = (tmp_path / f"{name}.nc" for name in ("gravity", "rest", "whole"))
    assert "paused" in call("run", scene_file, "--until", "gravity", "--out", gravity).stdout
    assert call("run", scene_file, "--restart", gravity, "--out", rest).exit_code == 0
    assert call("run", scene_file, "--out", whole).exit_code == 0
    assert trajectory.read(rest).dataset().equals(trajectory.read(whole).dataset())


def quick(**changes: Any) -> list[str]:
    """Options for a run of a second in which soil fails."""
    settings = {"duration": 2.0, "motion.decay_start": 1.5, "motion.end": 1.75} | changes
    return [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]


def test_a_trajectory_repeats_its_run(scene_file: Path, tmp_path: Path) -> None:
    """To the last bit, whichever stages it was made in, and to the same stage."""
    gravity, pre_failure, branch, again = (tmp_path / f"{name}.nc" for name in ("gravity", "pre_failure", "branch", "again"))
    made_by = {
        gravity: ["--until", "gravity", *quick(**{"coupling.S_R": 0.9})],
        pre_failure: ["--until", "first_failure", "--restart", gravity, *quick(**{"coupling.S_R": 0.5})],
        branch: ["--restart", pre_failure, *quick(**{"coupling.S_R": 0.1, "coupling.gamma": 10.0, "name": "branch"})],
    }
    for path, options in made_by.items():
        assert call("run", scene_file, *options, "--out", path).exit_code == 0
    for path in made_by:
        result = call("run", path, "--out", again, "--overwrite")
        assert result.exit_code == 0, result.output
        assert f"sph: every variable is identical to that of {path}, bit for bit" in result.stderr
        for group in (trajectory.read, trajectory.read_restart):
            same_variables(group(again).dataset(), group(path).dataset())
        assert trajectory.read(again).attrs["scene"] == trajectory.read(path).attrs["scene"]
    one, other = (json.loads(call("metrics", file, "--json").stdout) for file in (again, branch))
    assert [name for name in one if json.dumps(one[name]) != json.dumps(other[name]) and name not in TIMINGS] == []
    assert trajectory.read(branch)["failed"].values.any() and trajectory.read(pre_failure).attrs["status"] == "paused"


def test_a_repeated_run_tells_other_bits(scene_file: Path, tmp_path: Path) -> None:
    out, again = tmp_path / "out.nc", tmp_path / "again.nc"
    assert call("run", scene_file, *quick(), "--until", "gravity", "--out", out).exit_code == 0
    other = trajectory.read(out).dataset()
    other["y"][-1, 0] += 1e-6
    other.attrs["versions"] = json.dumps(json.loads(other.attrs["versions"]) | {"numba": "0.0"})
    trajectory.write(out, other)
    result = call("run", out, "--out", again)
    assert result.exit_code == 0
    assert f"sph: differs from {out} in y: numba 0.0 there and " in result.stderr


def test_a_trajectory_is_a_scene(scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, changed = tmp_path / "out.nc", tmp_path / "changed.nc"
    assert call("run", scene_file, *quick(**{"soil.cohesion": 140.0}), "--until", "gravity", "--out", out).exit_code == 0
    assert call("info", out).stdout == call("info", scene_file, *quick(**{"soil.cohesion": 140.0})).stdout
    result = call("run", out, "--set", "coupling.S_R=0.2", "--until", "gravity", "--out", changed)
    assert result.exit_code == 0 and "bits" not in result.stderr
    scene = trajectory.scene_of(trajectory.read(changed))
    assert (scene.coupling.S_R, scene.soil.cohesion) == (0.2, 140.0)
    before = out.read_bytes()
    refused = call("run", out, "--out", out)
    assert refused.exit_code == REFUSED and "name another file" in refused.stderr and out.read_bytes() == before
    refused = call("run", out, "--set", "soil.cohesin=3")
    assert refused.exit_code == REFUSED and "out.nc: soil.cohesin" in refused.stderr


def test_a_run_beyond_its_time_step_is_repeated_but_not_changed(scene_file: Path, tmp_path: Path) -> None:
    """A study of robustness makes such runs, which the command would refuse to begin."""
    scene = load_scene(scene_file, {"numerics": {"time_step": 0.05}, "outputs": {"series_interval": 0.25}, "motion": {"kind": "none"}})
    run_to_file(scene, tmp_path / "fast.nc", enforce_limit=False)
    result = call("run", tmp_path / "fast.nc", "--out", tmp_path / "again.nc")
    assert result.exit_code in (0, DIVERGED) and "every variable is identical" in result.stderr, result.output
    refused = call("run", tmp_path / "fast.nc", "--set", "coupling.S_R=0.2", "--out", tmp_path / "other.nc")
    assert refused.exit_code == REFUSED and "numerics.time_step" in refused.stderr


def test_the_run_of_another_scene_is_replaced_only_if_that_is_asked_for(scene_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    options = (*quick(), "--until", "gravity", "--out", out)
    assert call("run", scene_file, *options).exit_code == 0
    assert call("run", scene_file, *options).exit_code == 0, "the same scene again"
    before = out.read_bytes()
    refused = call("run", scene_file, *options, "--set", "coupling.S_R=0.2")
    assert refused.exit_code == REFUSED and out.read_bytes() == before
    assert "--out " in refused.stderr and "coupling.S_R: " in refused.stderr and "0.2 planned); name another file" in refused.stderr
    assert call("run", scene_file, *options, "--set", "coupling.S_R=0.2", "--overwrite").exit_code == 0
    assert trajectory.scene_of(trajectory.read(out)).coupling.S_R == 0.2


@pytest.mark.parametrize("columns", [40, 60, 200])
def test_the_list_of_commands_is_not_cut(columns: int) -> None:
    shown = CliRunner().invoke(app, ["--help"], env={"COLUMNS": str(columns)}, terminal_width=columns).stdout
    shown = shown[shown.index("Commands:") :]
    assert "..." not in shown and "and the time left" in " ".join(shown.split()).replace("- ", "-")


def test_what_takes_long_says_what_it_does(scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sph.command.terminal, "PATIENCE", 1e3)
    assert "placing the particles" not in call("info", scene_file).stderr
    monkeypatch.setattr(sph.command.terminal, "PATIENCE", 0.0)
    assert "sph: placing the particles ..." in call("info", scene_file).stderr


@pytest.mark.parametrize("name", ["file", "points", "data", "kind", "shape", "law"])
def test_a_probe_cannot_have_the_name_of_what_names_a_file(scene_file: Path, tmp_path: Path, name: str) -> None:
    result = call("run", scene_file, "--set", f"probes.{name}=toe", "--out", tmp_path / "out.nc")
    assert result.exit_code == REFUSED and f"probes.{name}: " in result.stderr and "choose another name" in result.stderr


@pytest.fixture
def interruptible() -> Iterator[None]:
    """As on a terminal: workers of the tests ignore Ctrl-C."""
    earlier = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, earlier)


def test_ctrl_c_leaves_a_checkpoint_from_which_the_same_command_goes_on(scene_file: Path, tmp_path: Path, interruptible: None) -> None:
    scene, out, told = load_scene(scene_file, {"duration": 2.0, "motion": {"decay_start": 1.5, "end": 1.75}}), tmp_path / "out.nc", []
    run_to_file(scene, tmp_path / "whole.nc")

    def interrupt(progress: Progress) -> None:
        if progress.time > 1.0:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run_to_file(scene, out, report=interrupt, say=told.append)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert [path.name for path in tmp_path.iterdir() if "out" in path.name] == [".out.nc.checkpoint"]
    assert len(told) == 1 and told[0].startswith("interrupted at 1.0") and told[0].endswith("the same command goes on from there")
    run_to_file(scene, out, say=told.append)
    assert "goes on from this checkpoint, at 1.0" in told[1]
    same_variables(trajectory.read(out).dataset(), trajectory.read(tmp_path / "whole.nc").dataset())


def test_ctrl_c_before_the_first_step_ends_at_once(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interruptible: None
) -> None:
    monkeypatch.setattr(Run, "go", lambda *_: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        run_to_file(load_scene(scene_file), tmp_path / "out.nc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["slope.yaml"]


def test_other_netcdf_files_are_no_scenes(tmp_path: Path, scene_file: Path) -> None:
    foreign, search = tmp_path / "foreign.nc", tmp_path / "search.nc"
    xr.Dataset({"x": ("n", np.zeros(2))}).to_netcdf(foreign)
    trials = search_group(load_scene(scene_file), "yield_acceleration", Search(1.0, 2.0, ()))
    trajectory.write(search, trials)
    for path, wanted in ((foreign, "not a trajectory"), (search, "trials of a search (yield_acceleration)")):
        result = call("run", path, "--out", tmp_path / "out.nc")
        assert result.exit_code == REFUSED and wanted in result.stderr and path.name in result.stderr


def test_films_and_files_for_paraview(scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.nc"
    assert call("run", scene_file, *quick(), "--until", "gravity", "--out", out).exit_code == 0
    result = call("animate", out, "--field", "beta", "--every", "2", "--speed", "2", "--motion", "--dpi", "50")
    assert result.exit_code == 0, result.output
    with Image.open(tmp_path / "out.gif") as film:
        assert film.info["duration"] == 250, "of frames 0.5 s apart, at twice the real speed"
    assert call("export", out, "--vtk", tmp_path / "vtk").stdout.strip() == str(tmp_path / "vtk" / "out.pvd")
    frames = trajectory.read(out).sizes["frame"]
    assert len(list((tmp_path / "vtk").glob("out_*.vtu"))) == frames == 5
    for name, wanted in ((scene_file, "is a file"), ("", "--vtk '': is an empty name; name a folder")):
        refused = call("export", out, "--vtk", name)
        assert refused.exit_code == REFUSED and wanted in refused.stderr
    monkeypatch.setenv("PATH", str(tmp_path))
    for options, wanted in (
        (("--out", "x.mp4"), "apt-get install ffmpeg"),
        (("--fps", "5", "--speed", "1"), "give one of them"),
        (("--fps", "0"), "0 frames per second"),
        (("--field", "colour"), "'colour' is not one of layer, failed, initial_height"),
        (("--out", tmp_path / "absent" / "x.gif"), "does not exist"),
    ):
        # Before any work: the trajectory is not even looked for.
        refused = call("animate", tmp_path / "absent.nc", *options)
        assert refused.exit_code == REFUSED and wanted in refused.stderr, refused.output


def test_info_warns_of_a_thin_box(scene_file: Path) -> None:
    assert "walls.layers=4 or numerics.smoothing_ratio [thin-box]" in call("info", scene_file).stdout
    assert "thin-box" not in call("info", scene_file, "--set", "walls.layers=4").stdout


def test_info_shows_limits_and_terms(scene_file: Path) -> None:
    shown = call("info", scene_file, "--set", "walls.sides=free_slip", "--set", "walls.layers=4").stdout
    for wanted in (
        "85 soil",
        "V_p = 1159.9 m/s",
        "limit: acoustic",
        "free_slip [walls.base, walls.sides, walls.top]",
        "wall_faces [walls: no soil passes between their particles]",
        "not compiled",
        "estimated cost",
    ):
        assert wanted in shown


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (("--set", "soil.cohesin=3"), ("slope.yaml: soil.cohesin: there is no such key here; did you mean cohesion? (found 3)",)),
        (("--set", "motion.amplitude=-1"), ("slope.yaml: motion.amplitude", "greater than or equal to 0", "-1")),
        (("--set", "walls.sides=free_slip"), ("walls.layers", "2 layers", "needs 4")),
        (("--set", "coupling.S_R"), ("KEY=VALUE",)),
        (("--set", "numerics.time_step=0.05", "--set", "outputs.series_interval=0.25"), ("numerics.time_step", "limit", "acoustic")),
        (("--until", "gravty"), ("--until: 'gravty' is not one of end, gravity, first_failure; did you mean gravity?",)),
        (("--restart", "absent.nc"), ("absent.nc",)),
        (("--out", "absent/folder/out.nc"), ("--out", "does not exist")),
    ],
)
def test_refusals_name_the_key_and_write_nothing(
    scene_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], wanted: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    result = call("run", scene_file, *arguments)
    assert result.exit_code == REFUSED
    for text in wanted:
        assert text in result.stderr
    assert "Traceback" not in result.stderr
    assert not list(tmp_path.glob("*.nc"))


def test_a_scene_that_is_not_there_is_refused(tmp_path: Path) -> None:
    result = call("info", tmp_path / "absent.yaml")
    assert result.exit_code == REFUSED and "absent.yaml" in result.stderr


@pytest.fixture
def record_file(tmp_path: Path) -> Path:
    """A rectangular pulse of 0.6 g over 0.2 s."""
    path = tmp_path / "pulse.csv"
    path.write_text("time,acceleration (m/s2)\n0,5.886\n0.2,5.886\n")
    return path


def test_newmark_slides_a_block_on_a_record(record_file: Path) -> None:
    shown = call("newmark", record_file, "--ay", "0.3g").stdout
    assert shown.splitlines() == [
        "peak ground acceleration  0.6 g (5.886 m/s2), driving downslope",
        "yield acceleration        0.3 g (2.943 m/s2), upslope unlimited",
        "yield over peak           0.5",
        "permanent displacement    0.1177 m",
        "time sliding              0.4 s",
    ]
    scaled = json.loads(call("newmark", record_file, "--ay", "2.943 m/s2", "--scale-to", "1.2g", "--upslope", "0.5g", "--json").stdout)
    assert (scaled.pop("direction"), scaled.pop("other_displacement")) == ("recorded", None)
    assert scaled == pytest.approx(
        {
            "peak_acceleration": 11.772,
            "yield_acceleration": 2.943,
            "upslope_yield_acceleration": 4.905,
            "ratio": 0.25,
            "permanent_displacement": 0.5 * 11.772 * 0.2**2 * 3,  # Newmark (1965): A t^2 (A / N - 1) / 2
            "sliding_time": 0.8,
        },
        rel=1e-12,
    )


def test_newmark_takes_upslope_pulses_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "pulse.csv"
    path.write_text("time (s),a (m/s2)\n0,-5.886\n0.2,-5.886\n")
    assert "driving upslope" in call("newmark", path, "--ay", "0.3g").stdout
    assert json.loads(call("newmark", path, "--ay", "0.3g", "--json").stdout)["permanent_displacement"] == 0
    two_way = json.loads(call("newmark", path, "--ay", "9m/s2", "--upslope", "0.3g", "--json").stdout)
    assert two_way["permanent_displacement"] == pytest.approx(-0.5 * 5.886 * 0.2**2, rel=1e-12)


def test_newmark_slides_a_block_on_the_motion_of_a_scene(scene_file: Path) -> None:
    motion = motion_of(load_scene(scene_file, {"motion": {"amplitude": 5.0}}))
    answer = json.loads(call("newmark", scene_file, "--set", "motion.amplitude=5", "--ay", "2 m/s2", "--json").stdout)
    assert answer["permanent_displacement"] == sliding_block(*motion, 2.0).permanent > 0.01
    assert answer["upslope_yield_acceleration"] is None


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (("--ay", "abc"), ("--ay 'abc': must be an acceleration",)),
        (("--ay", "0.15"), ("--ay '0.15': has no unit; write 0.15g",)),
        (("--ay", "1_0g"), ("--ay '1_0g': must be an acceleration",)),
        (("--ay", "0.2 km/s2"), ("--ay '0.2 km/s2'",)),
        (("--ay", "-1g"), ("--ay '-1g': must be positive",)),
        (("--ay", "nan"), ("--ay 'nan': must be an acceleration",)),
        (("--ay", "1g", "--upslope", "0g"), ("--upslope '0g': must be positive",)),
        (("--ay", "1g", "--scale-to", "g"), ("--scale-to 'g'",)),
        (("--ay", "1g", "--scale-to", "2"), ("--scale-to '2': has no unit",)),
        (("--ay", "1g", "--direction", "left"), ("--direction: 'left'", "recorded, turned, both")),
        (("--ay", "1g", "--band-pass", "1"), ("--band-pass '1': write two corner frequencies",)),
        (("--ay", "1g", "--unit", "ft"), ("--unit: 'ft'", "m/s2, cm/s2, gal, g")),
        (("--ay", "1g", "--baseline", "1"), ("motion", "baseline")),
        (("--ay", "1m/s2", "--set", "motion.amplitud=1"), ("slope.yaml: motion.amplitud", "no such key")),
        (("--ay", "1m/s2", "--set", "motion.amplitude=0"), ("slope.yaml: the ground does not move",)),
        (("--ay", "1m/s2", "--set", "motion={kind: constant, amplitude: 2.0, start: 1.0, ramp: 0.5}"), ("constant is a sustained load",)),
    ],
)
def test_newmark_refuses(scene_file: Path, arguments: tuple[str, ...], wanted: tuple[str, ...]) -> None:
    result = call("newmark", scene_file, *arguments)
    assert result.exit_code == REFUSED and not result.stdout
    for text in wanted:
        assert text in result.stderr
    assert "Traceback" not in result.stderr


def test_newmark_refuses_keys_of_a_record(record_file: Path) -> None:
    result = call("newmark", record_file, "--ay", "1 m/s2", "--set", "motion.amplitude=1")
    assert result.exit_code == REFUSED and "pulse.csv: is a record" in result.stderr


def test_a_diverged_run_is_written_and_has_its_own_exit_code(scene_file: Path, tmp_path: Path) -> None:
    """Soil so soft that it falls faster than its wave speed cannot be followed."""
    out = tmp_path / "out.nc"
    result = call("run", scene_file, "--set", "soil.youngs_modulus=1", "--out", out)
    assert result.exit_code == DIVERGED, result.output
    ds = trajectory.read(out).dataset()
    assert ds.attrs["status"] == "diverged" and ds.attrs["status_reason"]


def test_settings_nest_and_keep_yaml_types() -> None:
    assert parse_settings(["a.b=1", "a.c=null", "d=[1, 2]"]) == {"a": {"b": 1, "c": None}, "d": [1, 2]}


def test_help_has_examples() -> None:
    for command in ("run", "info", "plot", "animate", "export", "status", "metrics", "newmark"):
        assert "Example" in call(command, "--help").stdout


class Stepped(dict[str, Any]):
    """What a run stores of its steps."""

    time_step_ratio = 1.25

    def __init__(self, scene: Any) -> None:
        super().__init__(time=np.arange(4), time_step=np.full(4, 1e-3), time_step_limit=np.array([2e-3, 8e-4, 1e-3, 1.5e-3]))
        self.scene = scene


def test_a_step_above_its_limit_is_told_with_what_remedies_it(small_slope: SceneBuilder) -> None:
    """A step that adapts is not told to adapt."""
    fixed, adaptive = (above_limit(Stepped(small_slope({"numerics.adaptive_step": keys}))) for keys in (None, {}))  # type: ignore[arg-type]
    assert "1.25 times" in fixed and "let it adapt (numerics.adaptive_step={})" in fixed
    assert "1.25 times its limit in 1 of 4 frames" in adaptive and "adaptive_step.courant=0.64" in adaptive
