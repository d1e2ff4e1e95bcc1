"""Motion of a probe against time."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from sph.figures.style import LINE_STYLES, SHAKING, curve_colours
from sph.measures.fields import with_end
from sph.output.run import Run
from sph.scene.motion import NoMotion
from sph.scene.schema import Scene
from sph.storage.trajectory import Status


def shade_shaking(ax: Axes, scene: Scene) -> None:
    """Grey band from the start to the end of the shaking, named at its top."""
    if isinstance(scene.motion, NoMotion):
        return
    start, end = scene.motion.start, scene.motion.end
    ax.axvspan(start, end, color=SHAKING, linewidth=0, zorder=0)
    ax.annotate(
        "shaking",
        (0.5 * (start + end), 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, -3),
        textcoords="offset points",
        ha="center",
        va="top",
    )


def draw_vertical_histories(ax: Axes, runs: Mapping[str, Run], probe: str) -> list[Line2D]:
    """Vertical displacement of a probe since the end of the gravity stage, a curve per run, named by the keys."""
    colours = curve_colours(len(runs))
    lines = []
    for number, (name, run) in enumerate(runs.items()):
        history = run.history(probe)
        style = LINE_STYLES[number % len(LINE_STYLES)]
        lines += ax.plot(history.time, history.displacement_vertical, color=colours[number], linestyle=style, label=with_end(name, run))
        if run.status == Status.DIVERGED:
            ax.plot(
                history.time[-1:], history.displacement_vertical[-1:], color=colours[number], marker="x", markersize=7, markeredgewidth=2.0
            )
    scenes = [run.scene for run in runs.values()]
    shade_shaking(ax, scenes[0])
    ax.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
    ax.set(xlim=(0.0, max(scene.duration for scene in scenes)), xlabel="time (s)")
    return lines
