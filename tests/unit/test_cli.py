"""The command: what it prints, writes, refuses, and the exit codes it documents."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner, Result

from sph import trajectory
from sph.command.cli import DIVERGED, REFUSED, app, parse_settings
from sph.scene import Scene


@pytest.fixture
def scene_file(tmp_path: Path, small_slope: Callable[[dict[str, Any]], Scene]) -> Path:
    path = tmp_path / "slope.yaml"
    path.write_text(yaml.safe_dump(small_slope({}).model_dump(mode="json")))
    return path


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments])


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
    assert "failed_fraction" in call("metrics", out).stdout


def test_stages_join_on_the_command_line(scene_file: Path, tmp_path: Path) -> None:
    gravity, rest, whole = (tmp_path / f"{name}.nc" for name in ("gravity", "rest", "whole"))
    assert "paused" in call("run", scene_file, "--until", "gravity", "--out", gravity).stdout
    assert call("run", scene_file, "--restart", gravity, "--out", rest).exit_code == 0
    assert call("run", scene_file, "--out", whole).exit_code == 0
    assert trajectory.read(rest).equals(trajectory.read(whole))


def test_info_warns_of_a_thin_box(scene_file: Path) -> None:
    assert "walls.layers=4" in call("info", scene_file).stdout
    assert "warning" not in call("info", scene_file, "--set", "walls.layers=4").stdout


def test_info_shows_limits_and_terms(scene_file: Path) -> None:
    shown = call("info", scene_file, "--set", "walls.sides=free_slip", "--set", "walls.layers=4").stdout
    for wanted in (
        "85 soil",
        "V_p = 1159.9 m/s",
        "limit: acoustic",
        "free_slip [walls.base, walls.sides, walls.top]",
        "not compiled",
        "estimated cost",
    ):
        assert wanted in shown


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (("--set", "soil.cohesin=3"), ("slope.yaml: soil.cohesin", "no such key", "3")),
        (("--set", "motion.amplitude=-1"), ("slope.yaml: motion.amplitude", "greater than or equal to 0", "-1")),
        (("--set", "walls.sides=free_slip"), ("walls.layers", "2 layers", "needs 4")),
        (("--set", "coupling.S_R"), ("KEY=VALUE",)),
        (("--set", "numerics.time_step=0.05", "--set", "outputs.series_interval=0.25"), ("numerics.time_step", "limit", "acoustic")),
        (("--until", "tomorrow"), ("--until", "first_failure")),
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


def test_a_diverged_run_is_written_and_has_its_own_exit_code(scene_file: Path, tmp_path: Path) -> None:
    """Soil so soft that it falls faster than its wave speed cannot be followed."""
    out = tmp_path / "out.nc"
    result = call("run", scene_file, "--set", "soil.youngs_modulus=1", "--out", out)
    assert result.exit_code == DIVERGED, result.output
    ds = trajectory.read(out)
    assert ds.attrs["status"] == "diverged" and ds.attrs["status_reason"]


def test_settings_nest_and_keep_yaml_types() -> None:
    assert parse_settings(["a.b=1", "a.c=null", "d=[1, 2]"]) == {"a": {"b": 1, "c": None}, "d": [1, 2]}


def test_help_has_examples() -> None:
    for command in ("run", "info", "plot", "metrics"):
        assert "Example" in call(command, "--help").stdout
