"""Films of a trajectory: one scale and size for all pictures, the frames asked for, and players' limits; looks are judged by eye."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from overprint import overprints
from PIL import Image
from synthetic import synthetic, translation

from sph.figures.film import check_film, draw_film, rate, save_film
from sph.measures.fields import FIELDS, LAYER
from sph.output.run import Run
from sph.solver.particles import SOIL

FRAMES = range(0, 31, 10)  # of 0, 5, 10 and 15 s

needs_ffmpeg = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed: apt-get install ffmpeg")


def soil_circles(figure: Any) -> Any:
    return [item for item in figure.axes[0].collections if isinstance(item, EllipseCollection)][1]


@pytest.mark.parametrize("field", FIELDS)
def test_every_frame_is_shown_at_its_time_on_one_scale(slid: Run, field: str) -> None:
    figure, show = draw_film(slid, FRAMES, field, motion=False, dpi=60)
    soil = slid["kind"] == SOIL
    shown = [FIELDS[field].of(slid, frame)[soil] for frame in FRAMES]
    scales, limits = set(), set()
    for frame, values in zip(FRAMES, shown, strict=True):
        show(frame)
        circles = soil_circles(figure)
        np.testing.assert_allclose(circles.get_offsets(), np.column_stack([slid[axis][frame][soil] for axis in "xy"]))
        np.testing.assert_allclose(circles.get_array(), values)
        scales.add((circles.norm.vmin, circles.norm.vmax))
        limits.add((figure.axes[0].get_xlim(), figure.axes[0].get_ylim()))
        assert figure.axes[0].get_aspect() == 1.0
        assert f"t = {slid['time'][frame]:5.2f} s" in figure.axes[0].get_title(loc="left")
        assert len(figure.axes[0].lines) == 2, "the initial surface and the ring at A, of this frame alone"
    (low, high), *others = scales
    assert not others and len(limits) == 1
    assert low <= min(values.min() for values in shown) and high >= max(values.max() for values in shown)
    label = " ".join(figure.axes[0].child_axes[0].get_ylabel().split())
    assert label == FIELDS[field].label + (f" ({FIELDS[field].units})" if field != LAYER else "")


def test_places_of_a_study_stand_in_every_picture_with_room_for_their_names(slid: Run) -> None:
    figure, show = draw_film(slid, FRAMES, "displacement", motion=False, dpi=60, places={"bench": 69.0, "road": "12 beyond the toe"})
    for frame in FRAMES:
        show(frame)
        posts = {text.get_text(): text.xy[0] for text in figure.axes[0].texts if text.get_rotation() == 90}
        assert posts == {"bench": 69.0, "road": 43.0}
    assert overprints(figure) == []


def test_the_box_holds_what_any_frame_shows() -> None:
    open_box = {"geometry": {"shape": "block", "width": 10.0, "height": 5.0}, "walls": {"base": "none", "sides": "none"}}
    moving = synthetic(translation(-30.0), overrides=open_box)
    figure, _ = draw_film(moving, range(31), "speed", motion=False, dpi=60)
    left, right = figure.axes[0].get_xlim()
    assert left < -30.0 and right > 10.0


def test_the_motion_is_shown_with_the_time(slid: Run) -> None:
    figure, show = draw_film(slid, FRAMES, "speed", motion=True, dpi=60)
    curve, now = figure.axes[1].lines
    np.testing.assert_array_equal(curve.get_ydata(), slid["ground_acceleration"])
    show(20)
    assert list(now.get_xdata()) == [10.0, 10.0] and "m/s²" in figure.axes[1].get_ylabel()


@pytest.mark.parametrize("dpi", [60, 73, 120])
@pytest.mark.parametrize("motion", [False, True])
def test_pictures_have_an_even_number_of_pixels_each_way(slid: Run, dpi: int, motion: bool) -> None:
    width, height = draw_film(slid, FRAMES, "speed", motion, dpi)[0].canvas.get_width_height()
    assert width % 2 == height % 2 == 0 and width > 400 * dpi / 60


def test_a_gif_holds_the_frames_at_their_rate(tmp_path: Path, slid: Run) -> None:
    path = tmp_path / "slide.gif"
    assert save_film(slid, path, every=10, fps=4, dpi=60) == len(FRAMES)
    assert [item.name for item in tmp_path.iterdir()] == ["slide.gif"]
    with Image.open(path) as film:
        pictures, lengths = [], []
        for number in range(film.n_frames):
            film.seek(number)
            lengths.append(film.info["duration"])
            pictures.append(np.asarray(film.convert("RGB")).astype(int))
    assert lengths == [250] * len(FRAMES)
    # The toe is free at first and covered later; the margin and the colour bar stay as they are, white being white.
    assert all(np.array_equal(picture[:, -40:], pictures[0][:, -40:]) for picture in pictures)
    assert pictures[0][2, 2].tolist() == [255, 255, 255] and np.abs(pictures[-1] - pictures[0]).max() > 100


@needs_ffmpeg
def test_an_mp4_holds_the_frames_at_their_rate(tmp_path: Path, slid: Run) -> None:
    path = tmp_path / "slide.mp4"
    assert save_film(slid, path, "beta", every=10, fps=4, motion=True, dpi=61) == len(FRAMES)
    assert [item.name for item in tmp_path.iterdir()] == ["slide.mp4"]
    wanted = "stream=codec_name,pix_fmt,nb_frames,r_frame_rate"
    shown = subprocess.run(
        ["ffprobe", "-v", "error", "-show_entries", wanted, "-of", "csv=p=0", path], capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == f"h264,yuv420p,4/1,{len(FRAMES)}"


def test_what_cannot_be_written_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ValueError, match=r"run\.mp4.*ffmpeg.*apt-get install ffmpeg.*\.gif"):
        check_film(Path("run.mp4"), 10, 120)
    for path, fps, dpi, wanted in (
        ("run.avi", 10, 120, "must end in .gif or .mp4"),
        ("run.gif", 51, 120, "must be from 0.1 to 50"),
        ("run.gif", float("nan"), 120, "must be from 0.1 to 50"),
        ("run.gif", 10, 10, "10 dots per inch, must be from 30 to 600"),
    ):
        with pytest.raises(ValueError, match=wanted):
            check_film(Path(path), fps, dpi)


def test_a_failing_ffmpeg_is_an_error_of_its_file(tmp_path: Path, slid: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho 'Unknown encoder' >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setitem(matplotlib.rcParams, "animation.ffmpeg_path", str(program))
    with pytest.raises(OSError, match=r"slide\.mp4: .*ffmpeg.*Unknown encoder"):
        save_film(slid, tmp_path / "slide.mp4", every=30, dpi=60)
    assert sorted(item.name for item in tmp_path.iterdir()) == ["ffmpeg"]


def test_speed_is_simulated_time_over_time(slid: Run) -> None:
    assert slid["time"][1] == 0.5
    assert rate(slid, 1, 1.0) == 2.0 and rate(slid, 2, 4.0) == 4.0


def test_drawing_leaves_matplotlibs_settings_alone(tmp_path: Path, slid: Run) -> None:
    before = dict(matplotlib.rcParams)
    save_film(slid, tmp_path / "slide.gif", every=30, dpi=30)
    assert dict(matplotlib.rcParams) == before
