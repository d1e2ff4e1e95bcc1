"""One trajectory through time, as a GIF or an MP4 (``sph animate``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from subprocess import CalledProcessError
from textwrap import fill

import matplotlib
import numpy as np
from matplotlib.animation import FFMpegWriter, adjusted_figsize
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from PIL import Image

from sph.figures.arrangement import coupling_words
from sph.figures.history import shade_shaking
from sph.figures.labels import spread
from sph.figures.profile import (
    LINE,
    LONG_TITLE,
    OUTSIDE,
    PER_INCH,
    draw_places,
    draw_profile,
    field_bar,
    field_colours,
    field_norm,
    frame_limits,
    mark_probes,
    survey_axes,
    with_room,
)
from sph.figures.style import STYLE, WIDTH, add_note, plain
from sph.measures.fields import check_field
from sph.measures.places import PlaceAt
from sph.output.run import Run
from sph.storage.files import whole

FASTEST = {".gif": 50.0, ".mp4": 120.0}
"""The formats, and the most pictures a second that players of each keep up with."""
STRIP = 1.0
"""Height of the strip with the motion of the ground, inches."""
RESOLUTION = (30, 600)
"""Least and most dots per inch."""


def check_film(path: Path, fps: float, dpi: int) -> None:
    """Refuse what cannot be written before any work: another format, a rate that no player keeps, an MP4 without ffmpeg."""
    if path.suffix not in FASTEST:
        raise ValueError(f"{path}: the name must end in {' or '.join(FASTEST)}")
    if not 0.1 <= fps <= FASTEST[path.suffix]:
        raise ValueError(f"{path}: {fps:g} frames per second, must be from 0.1 to {FASTEST[path.suffix]:g} for {path.suffix}")
    if not RESOLUTION[0] <= dpi <= RESOLUTION[1]:
        raise ValueError(f"{path}: {dpi} dots per inch, must be from {RESOLUTION[0]} to {RESOLUTION[1]}")
    if path.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError(
            f"{path}: MP4 needs the program ffmpeg, which is not installed: install it (apt-get install ffmpeg), or write a .gif"
        )


def rate(run: Run, every: int, speed: float) -> float:
    """Pictures a second at which every n-th frame of the interval shows ``speed`` simulated seconds a second."""
    return speed / (every * run.scene.outputs.frame_interval)


def save_film(
    run: Run,
    path: Path,
    field: str = "displacement",
    every: int = 1,
    fps: float = 10.0,
    motion: bool = False,
    dpi: int = 120,
    places: Mapping[str, PlaceAt] | None = None,
) -> int:
    """Write every n-th frame of ``outputs.frame_interval`` to a GIF or an MP4, whole or not at all; returns the number of pictures.

    The profile is coloured by a name of ``FIELDS`` on one scale for all frames; ``motion`` adds the acceleration of the ground, and posts
    stand at ``places`` as in ``metrics.places``.
    Raises ValueError as ``check_film`` and for an unknown field, OSError for a file that cannot be written.
    """
    check_film(path, fps, dpi)
    check_field(field)
    ratio = run["time"] / run.scene.outputs.frame_interval
    frames = np.flatnonzero(np.isclose(ratio, ratio.round(), rtol=0.0, atol=1e-6))[::every].tolist()
    with matplotlib.rc_context(STYLE):
        figure, show = draw_film(run, frames, field, motion, dpi, places)
        with whole(path) as temporary:
            (_gif if path.suffix == ".gif" else _mp4)(figure, show, frames, temporary, fps)
    return len(frames)


def draw_film(
    run: Run, frames: Sequence[int], field: str, motion: bool, dpi: int, places: Mapping[str, PlaceAt] | None = None
) -> tuple[Figure, Callable[[int], None]]:
    """A figure of an even number of pixels each way, as H.264 wants, and the function that shows a frame in it."""
    scene, norm = run.scene, field_norm({"": run}, field, *frames)
    limits = np.array([frame_limits(run, frame) for frame in frames])
    (left, _, lower, _), (_, right, _, upper) = limits.min(axis=0), limits.max(axis=0)
    left, right, lower, upper = with_room((left, right, lower, upper), scene, places or {}, WIDTH - 1.4)
    panel = (WIDTH - 1.4) * (upper - lower) / (right - left)
    title, coupling = fill(plain(scene.title or scene.name), LONG_TITLE), coupling_words(scene)
    heights = panel + 2.5 * OUTSIDE + LINE * f"{title}{coupling}".count("\n"), (STRIP + OUTSIDE) * motion
    size = adjusted_figsize(WIDTH, sum(heights), dpi, 2)
    figure = Figure(figsize=size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    strips = figure.subplots(1 + motion, 1, height_ratios=[panel + OUTSIDE, STRIP][: 1 + motion], squeeze=False)[:, 0]
    profile = strips[0]
    beside = profile.inset_axes((1.015, 0.0, 0.02, 1.0))
    field_bar(figure, ScalarMappable(norm, field_colours(field, scene)), field, scene, int(PER_INCH * panel), cax=beside)
    now = None
    if motion:
        strips[1].plot(run["sample_time"], run["ground_acceleration"], color="black", linewidth=0.8)
        strips[1].set(xlim=(0.0, scene.duration), xlabel="time (s)", ylabel="acceleration\nof the box (m/s²)")
        strips[1].margins(y=0.4)  # the name of the shaking lies above the curve
        shade_shaking(strips[1], scene)
        now = strips[1].axvline(0.0, color="firebrick", linewidth=1.2)
    add_note(figure, [scene])

    def show(frame: int) -> None:
        for artist in [*profile.collections, *profile.lines, *profile.texts]:
            artist.remove()
        draw_profile(profile, run, frame, field, norm)
        mark_probes(profile, run, frame)
        draw_places(profile, scene, places or {})
        time = float(run["time"][frame])
        profile.set_title(f"{title}\nt = {time:5.2f} s, {coupling}", loc="left")
        survey_axes(profile, scene, (left, right, lower, upper))
        spread(profile)
        if now is not None:
            now.set_xdata([time, time])

    show(frames[-1])
    for _ in range(2):  # the first layout knows nothing of the ticks that the second one leaves room for
        figure.canvas.draw()
    figure.set_layout_engine("none")  # nothing may shift from one picture to the next
    return figure, show


def _pictures(figure: Figure, show: Callable[[int], None], frames: Sequence[int]) -> Iterator[Image.Image]:
    canvas = FigureCanvasAgg(figure)
    for frame in frames:
        show(frame)
        canvas.draw()  # type: ignore[no-untyped-call]
        pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        yield Image.fromarray(pixels[..., :3].copy())


def _gif(figure: Figure, show: Callable[[int], None], frames: Sequence[int], path: Path, fps: float) -> None:
    """One palette for all pictures: with one each, as Pillow would choose, colours flicker."""
    few = list(_pictures(figure, show, [frames[0], frames[len(frames) // 2], frames[-1]]))
    palette = Image.fromarray(np.concatenate([np.asarray(picture) for picture in few])).quantize(method=Image.Quantize.MAXCOVERAGE)
    first, *rest = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in _pictures(figure, show, frames))
    first.save(path, format="gif", save_all=True, append_images=rest, duration=1000 / fps, loop=0)


def _mp4(figure: Figure, show: Callable[[int], None], frames: Sequence[int], path: Path, fps: float) -> None:
    writer = FFMpegWriter(fps=fps, codec="h264", extra_args=["-f", "mp4", "-pix_fmt", "yuv420p", "-crf", "18"])  # type: ignore[arg-type]
    try:
        with writer.saving(figure, str(path.resolve()), figure.dpi):  # ffmpeg takes 'a:b' for an address, '/a:b' for a file
            for frame in frames:
                show(frame)
                writer.grab_frame()
    except CalledProcessError as error:
        raise OSError(f"ffmpeg failed: {(error.stderr or '').strip()[-300:]}") from error
