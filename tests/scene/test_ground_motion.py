"""Ground motions from files: records, scenes, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.ground_motion import GroundMotion, read_record
from sph.scene.loading import motion_of


@pytest.mark.parametrize(
    "text",
    [
        "t,a (m/s2)\n0,0\n0.5,-2e0\n2,1\n",
        "t\ta (m/s2)\n0\t0\n0,5\t-2,0\n2\t1\n",
        "time (s)  acc (m/s2)\n0 0\n0.5   -2\n 2 1\n",
        "t;a (m/s2)\n0;0\n0,5;-2,0\n2;1\n",
        "time (s),acceleration (m/s2)\n0,0\n0.5,-2\n2,1",
        "\ufefft;a (m/s2)\n 0 , 0\r\n0.50, -2.0\r\n\r\n2, 1\r\n\r\n",
    ],
)
def test_a_record_with_and_without_names(tmp_path: Path, text: str) -> None:
    path = tmp_path / "record.csv"
    path.write_bytes(text.encode())
    time, acceleration = read_record(path)
    np.testing.assert_array_equal(time, [0, 0.5, 2])
    np.testing.assert_array_equal(acceleration, [0, -2, 1])


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("t,a (m/s2)\n0,0\n1\n", ("line 3", "2 columns", "has 1", "'1'")),
        ("0,0,0\n1,0,0\n", ("line 1", "2 columns", "has 3")),
        ("0,0\n1,0\n", ("line 1 (no names of columns): does not say its unit", "--unit of a command")),
        ("t,a (m/s2)\n0,0\n1,1_0\n", ("line 3", "two finite numbers", "1_0")),
        ("t a (m/s2)\n0 0\n1,5 2,5\n", ("line 3", "2 columns", "has 3")),
        ("t,a (m/s2)\n0,0\n1,nan\n", ("line 3", "two finite numbers", "'1,nan'")),
        ("t,a (m/s2)\nnan,0\n1,0\n", ("line 2", "two finite numbers")),
        ("t,a (m/s2)\n0,0\ninf,0\n", ("line 3", "two finite numbers")),
        ("0,zero\n1,0\n", ("line 1", "two finite numbers", "'0,zero'")),
        ("t,a (m/s2)\ns,m/s2\n0,0\n", ("line 2", "two finite numbers")),
        ("t,a (m/s2)\n0,0\n1,\n", ("line 3", "2 columns", "has 1")),
        ("t,a (m/s2)\n0,0\n1,0\n\n1,5\n", ("line 5", "time 1.0 s must be greater than 1.0 s")),
        ("t,a (m/s2)\n0,0\n", ("at least two samples", "found 1")),
        ("", ("at least two samples", "found 0")),
    ],
)
def test_bad_records_are_refused_with_file_and_line(tmp_path: Path, text: str, wanted: tuple[str, ...]) -> None:
    path = tmp_path / "record.csv"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        read_record(path)
    for part in (str(path), *wanted):
        assert part in str(error.value)


def test_files_that_hold_no_motion_are_refused(tmp_path: Path) -> None:
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    for path, wanted in ((tmp_path / "absent.csv", "cannot be read"), (binary, "cannot be read"), (tmp_path / "a.dat", "must be a record")):
        with pytest.raises(ValueError, match=wanted) as error:
            read_record(path)
        assert path.name in str(error.value)


@pytest.mark.parametrize(("time_step", "interval"), [(1e-4, 1e-4), (1e-3, 1e-3), (2e-3, 1e-3), (2.5e-3, 2.5e-3 / 3)])
def test_a_scene_is_sampled_at_its_steps_or_parts_of_them(small_slope: SceneBuilder, time_step: float, interval: float) -> None:
    scene = small_slope({"numerics.time_step": time_step})
    time, acceleration = motion_of(scene)
    assert time[0] == 0 and time[-1] == pytest.approx(scene.duration)
    np.testing.assert_allclose(np.diff(time), interval)
    np.testing.assert_array_equal(acceleration, scene.motion.acceleration(time))


def test_scaling_keeps_shape_and_sign() -> None:
    motion = GroundMotion(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, -4.0]))
    assert motion.peak == 4
    np.testing.assert_array_equal(motion.scaled(2.0).acceleration, [0, 0.5, -2])


@pytest.mark.parametrize(("acceleration", "peak"), [(0.0, 2.0), (1.0, 0.0), (1.0, -1.0), (1.0, np.nan), (1.0, np.inf)])
def test_what_cannot_be_scaled(acceleration: float, peak: float) -> None:
    motion = GroundMotion(np.array([0.0, 1.0]), np.array([0.0, acceleration]))
    with pytest.raises(ValueError, match=f"^peak: {peak} m/s2"):
        motion.scaled(peak)
