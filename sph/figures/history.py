"""Motion of a probe against time (Figs. 6-7)."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sph.figures.style import LINE_STYLES, SHAKING, WIDTH, add_note, curve_colours, label_panels, styled
from sph.measures.fields import probe_history, with_end
from sph.scene.motion import NoMotion
from sph.scene.schema import Scene
from sph.storage.trajectory import Status, scene_of


def shade_shaking(ax: Axes, scene: Scene, label: str = "shaking") -> None:
    """Grey band from the start to the end of the shaking, named at its top."""
    if isinstance(scene.motion, NoMotion):
        return
    start, end = scene.motion.start, scene.motion.end
    ax.axvspan(start, end, color=SHAKING, linewidth=0, zorder=0)
    ax.annotate(
        label,
        (0.5 * (start + end), 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, -3),
        textcoords="offset points",
        ha="center",
        va="top",
    )


def draw_vertical_histories(ax: Axes, trajectories: Mapping[str, xr.Dataset], probe: str) -> list[Line2D]:
    """Vertical displacement of a probe since the end of the gravity stage, a curve a trajectory, named by the keys."""
    colours = curve_colours(len(trajectories))
    lines = []
    for number, (name, trajectory) in enumerate(trajectories.items()):
        history = probe_history(trajectory, probe)
        style = LINE_STYLES[number % len(LINE_STYLES)]
        lines += ax.plot(history.time, history.vertical, color=colours[number], linestyle=style, label=with_end(name, trajectory))
        if trajectory.attrs["status"] == Status.DIVERGED:
            ax.plot(history.time[-1:], history.vertical[-1:], color=colours[number], marker="x", markersize=7, markeredgewidth=2.0)
    scenes = [scene_of(trajectory) for trajectory in trajectories.values()]
    shade_shaking(ax, scenes[0])
    ax.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
    ax.set(xlim=(0.0, max(scene.duration for scene in scenes)), xlabel="time (s)")
    return lines


def _histories(panels: Mapping[str, Mapping[str, xr.Dataset]], probe: str, fidelity: str) -> Figure:
    if not panels or not all(panels.values()):
        raise ValueError("trajectories: a figure of histories needs at least one in every panel")
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for ax, trajectories in zip(axes, panels.values(), strict=True):
        lines = draw_vertical_histories(ax, trajectories, probe)
        ax.margins(y=0.14)
        if len(panels) > 1:
            ax.legend(handles=lines, loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=len(lines), handlelength=3.2, borderaxespad=0)
    if len(panels) == 1:
        axes[0].legend(handles=lines, loc="center left", bbox_to_anchor=(1.01, 0.5), handlelength=3.2)
    axes[0].set_ylabel(f"vertical displacement of {probe} (m)")
    if len(panels) > 1:
        label_panels(axes, panels)
    add_note(figure, [scene_of(ds) for trajectories in panels.values() for ds in trajectories.values()], fidelity)
    return figure


@styled
def figure_strength_histories(trajectories: Mapping[str, xr.Dataset], probe: str = "A", fidelity: str = "") -> Figure:
    """Vertical displacement of particle A at the original crest edge for several strength ratios, since the end of the gravity
    stage and relative to the box; the band is the interval of shaking.

    ``trajectories`` by curve name, e.g. ``{"S_R = 0.10": ds, ...}`` (Fig. 6).  Raises ValueError without trajectories and for
    an unknown probe.
    """
    return _histories({"": trajectories}, probe, fidelity)


@styled
def figure_gamma_histories(panels: Mapping[str, Mapping[str, xr.Dataset]], probe: str = "A", fidelity: str = "") -> Figure:
    """Vertical displacement of particle A at the original crest edge for fast and slow loss of strength (γ), since the end of the
    gravity stage and relative to the box; the band is the interval of shaking.  The paper's text gives S_R = 0.25, its caption 0.35.

    ``panels`` by title, e.g. ``{"S_R = 0.25": {"γ = 100": ds, "γ = 1": ds}, ...}`` (Fig. 7).  Raises ValueError for an empty
    panel and an unknown probe.
    """
    return _histories(panels, probe, fidelity)
