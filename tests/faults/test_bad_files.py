"""Files and paths handed to the command: folders, junk, missing and foreign files end in one message and exit code 2."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from calling import call
from small_scenes import SceneBuilder

from sph.jobs.exit_codes import REFUSED
from sph.scene.ground_motion import read_record
from sph.scene.ground_motion.text import MAX_RECORD
from sph.solver.run import Run, run
from sph.storage import trajectory


def refused(*arguments: object) -> str:
    """Message of a refusal."""
    result = call(*arguments)
    assert isinstance(result.exception, SystemExit) and result.exit_code == REFUSED, result.output
    assert "Traceback" not in result.stderr and result.stderr.strip()
    return result.stderr


@pytest.fixture(scope="module")
def gravity_file(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    """A run paused at the end of the gravity stage, with its scene beside it."""
    folder = tmp_path_factory.mktemp("runs")
    scene = small_slope({})
    (folder / "slope.yaml").write_text(yaml.safe_dump(scene.model_dump(mode="json")))
    result = run(scene, "gravity")
    trajectory.write(folder / "gravity.nc", result.trajectory, result.restart)
    return folder / "gravity.nc"


FILES: dict[str, Callable[[Path, Path], object]] = {
    "missing": lambda path, good: None,
    "empty": lambda path, good: path.write_bytes(b""),
    "a folder": lambda path, good: path.mkdir(),
    "junk": lambda path, good: path.write_bytes(bytes(range(256)) * 40),
    "text": lambda path, good: path.write_text("just words\n"),
    "a few bytes": lambda path, good: path.write_bytes(good.read_bytes()[:10]),
    "cut": lambda path, good: path.write_bytes(good.read_bytes()[: good.stat().st_size // 2]),
    "nearly whole": lambda path, good: path.write_bytes(good.read_bytes()[:-10]),
    "spoilt": lambda path, good: path.write_bytes(good.read_bytes()[:20_000] + bytes(20_000) + good.read_bytes()[40_000:]),
    "foreign": lambda path, good: xr.Dataset({"a": ("b", [1, 2])}).to_netcdf(path),
    "a search": lambda path, good: xr.Dataset(attrs={"scene": "{}", "by": "factor_of_safety"}).to_netcdf(path),
    "a spoilt scene": lambda path, good: trajectory.read(good).dataset().assign_attrs(scene="{").to_netcdf(path),
    "no restart": lambda path, good: trajectory.read(good).dataset().to_netcdf(path),
}


DAMAGED = ("a few bytes", "cut", "nearly whole")


@pytest.mark.parametrize("what", FILES)
@pytest.mark.parametrize("command", ["metrics", "plot", "run"])
def test_a_file_that_is_no_trajectory_is_named(gravity_file: Path, tmp_path: Path, what: str, command: str) -> None:
    path = tmp_path / "broken.nc"
    FILES[what](path, gravity_file)
    if command == "plot" and what == "no restart":
        assert call("plot", path).exit_code == 0
    elif command == "run":
        scene = gravity_file.with_name("slope.yaml")
        said = refused("run", scene, "--restart", path, "--out", tmp_path / "out.nc")
        assert "broken.nc" in said and (what not in DAMAGED or "delete it" in said)
    else:
        assert ("paused" if what == "no restart" else "broken.nc") in refused(command, path)
    assert not (tmp_path / "out.nc").exists()


RESTARTS: dict[str, Callable[[xr.Dataset], xr.Dataset]] = {
    "no step": lambda state: state.drop_attrs(),
    "another step": lambda state: state.assign_attrs(step=7),
    "a step beyond the end": lambda state: state.assign_attrs(step=10**9),
    "no substeps": lambda state: state.assign_attrs(substeps=0),
    "a negative number of substeps": lambda state: state.assign_attrs(substeps=-3),
    "substeps that are no number": lambda state: state.assign_attrs(substeps=np.nan),
    "half a substep": lambda state: state.assign_attrs(substeps=1.5),
    "a word for substeps": lambda state: state.assign_attrs(substeps="two"),
    "a list of substeps": lambda state: state.assign_attrs(substeps=[1, 2]),
    "substeps of a scene without": lambda state: state.assign_attrs(substeps=2),
    "a step that is no number": lambda state: state.assign_attrs(step=np.nan),
    "a step before the start": lambda state: state.assign_attrs(step=-1),
    "too few particles": lambda state: state.isel(particle=slice(0, 5)),
    "no positions": lambda state: state.drop_vars("x"),
    "an earlier version": lambda state: state.drop_vars("mode_x"),
}


@pytest.mark.parametrize("what", RESTARTS)
def test_a_restart_state_of_another_run_is_refused(gravity_file: Path, tmp_path: Path, small_slope: SceneBuilder, what: str) -> None:
    # Believed, the wrong ones would let the compiled loops read beyond their arrays.
    path = tmp_path / "broken.nc"
    trajectory.write(path, trajectory.read(gravity_file), RESTARTS[what](trajectory.read_restart(gravity_file).dataset()))
    with pytest.raises(ValueError, match=r"broken\.nc: its restart state"):
        Run(small_slope({})).resume(path)


def test_a_run_that_diverged_to_nowhere_is_taken_over_as_it_is(gravity_file: Path, tmp_path: Path, small_slope: SceneBuilder) -> None:
    path = tmp_path / "diverged.nc"
    state = trajectory.read_restart(gravity_file).dataset()
    state["x"][:3] = [np.nan, np.inf, 1e300]
    trajectory.write(path, trajectory.read(gravity_file).assign_attrs(status="diverged", status_reason="not a number"), state)
    result = run(small_slope({}), restart=path)
    assert result.status == "diverged" and result.trajectory.attrs["status_reason"] == "not a number"


@pytest.mark.parametrize("out", ["", ".", "absent/out.nc", "slope.yaml/out.nc", "n" * 300, "n" * 300 + "/out.nc"])
@pytest.mark.parametrize("command", ["run", "fos", "yield-acceleration"])
def test_what_cannot_be_written_is_refused_before_the_work(
    gravity_file: Path, monkeypatch: pytest.MonkeyPatch, command: str, out: str
) -> None:
    monkeypatch.chdir(gravity_file.parent)
    before = sorted(os.listdir())
    message = refused(command, "slope.yaml", "--set", "numerics.spacing=1", "--set", "numerics.time_step=1e-4", "--out", out)
    assert "--out" in message or "name too long" in message
    assert sorted(os.listdir()) == before


@pytest.mark.parametrize("content", [b"", b"name,value\n1,2\n", bytes(range(256)), b'"'])
def test_a_table_that_is_none_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "cost-accuracy.csv"
    path.write_bytes(content)
    assert "cost-accuracy.csv" in refused("advise", "--error", "0.1", "--table", path)
    assert str(tmp_path) in refused("advise", "--error", "0.1", "--table", tmp_path)


@pytest.mark.parametrize(
    ("content", "wanted"),
    [
        ("t,a (m/s2)\n0,1e200\n1,0\n", "line 2: must not exceed"),
        ("t,a (m/s2)\n-1e300,1\n1e300,1\n", "line 2: must not exceed"),
        ("t,a (m/s2)\n0,1\n5e-324,2\n", "line 3: time 5e-324 s"),
        ("t,a (m/s2)\n0,1\n" + "1," * 100_000, "line 3"),
    ],
)
def test_a_record_beyond_all_measure_is_refused(tmp_path: Path, content: str, wanted: str) -> None:
    path = tmp_path / "record.csv"
    path.write_text(content)
    message = refused("newmark", path, "--ay", "1 m/s2")
    assert wanted in message and len(message) < 1000


def test_a_record_without_end_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    path.symlink_to("/dev/zero")
    with pytest.raises(ValueError, match=f"larger than {MAX_RECORD:,} bytes"):
        read_record(path)


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (("newmark", "slope.yaml", "--ay", "1e-300g"), "--ay '1e-300g'"),
        (("newmark", "slope.yaml", "--ay", "1 gal", "--scale-to", "1e300g"), "--scale-to '1e300g'"),
        (("fos", "slope.yaml", "--tolerance", "1e-300"), "tolerance: 1e-300"),
        (("run", "slope.yaml", "--threads", "100000"), "--threads"),
    ],
)
def test_numbers_of_options_beyond_all_measure_are_refused(
    gravity_file: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], wanted: str
) -> None:
    # Without a smallest tolerance the bisection never ends; threads that cannot be started leave the others at their barrier for ever.
    monkeypatch.chdir(gravity_file.parent)
    fine = ("--set", "numerics.spacing=1", "--set", "numerics.time_step=1e-4") if arguments[0] == "fos" else ()
    assert wanted in refused(*arguments, *fine)


def test_too_little_memory_is_a_message(monkeypatch: pytest.MonkeyPatch, gravity_file: Path) -> None:
    def starve(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("sph.solver.simulation.place_particles", starve)
    assert "not enough memory" in refused("run", gravity_file.with_name("slope.yaml"))


def test_a_title_is_no_formula(gravity_file: Path, tmp_path: Path) -> None:
    ds = trajectory.read(gravity_file).dataset()
    path = tmp_path / "titled.nc"
    ds.assign_attrs(scene=ds.attrs["scene"].replace('"title":""', '"title":"$\\\\frac$ 5 % {x}"')).to_netcdf(path)
    assert call("plot", path).exit_code == 0
