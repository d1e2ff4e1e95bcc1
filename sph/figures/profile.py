"""Particles of a frame, drawn to their physical size."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator

from sph.figures.style import WIDTH, add_note, colour_map, label_panels, plain, styled
from sph.measures.fields import FIELDS, with_end
from sph.measures.places import PlaceAt, beyond_toe
from sph.output.run import Run
from sph.scene.geometry import SLOPES
from sph.scene.ground_line import GroundLine
from sph.scene.schema import Scene

OUTSIDE = 0.45
"""Inches beside the axes of a profile that ticks and labels need; only sets the figure's height."""
PLACE_COLOUR = "#8c2d04"
POST = 11.0
"""Height of the post at a place, points."""
HALO = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8}
PER_INCH = 14.0
"""Characters of a label in an inch."""
LONG_TITLE, LINE = 72, 0.17
"""Most characters in a line of a panel's title, and the inches that another line needs."""


def surface_line(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the initial surface from left to right, m."""
    x, y = scene.geometry.surface
    return np.array(x), np.array(y)


def draw_circles(ax: Axes, x: np.ndarray, y: np.ndarray, diameter: float, **style: Any) -> EllipseCollection:
    """Circles of a diameter in metres at (n,) places; they keep their size under zoom."""
    width = np.full(x.size, diameter)
    circles = EllipseCollection(width, width, np.zeros(x.size), units="xy", offsets=np.column_stack([x, y]), **style)
    circles.set_offset_transform(ax.transData)
    ax.add_collection(circles)
    return circles


def frame_limits(run: Run, frame: int) -> tuple[float, float, float, float]:
    """Left, right, lower and upper end (m) of the box and of the soil in a frame, with a margin; far-flung particles are cut off."""
    scene = run.scene
    spacing, layers = scene.numerics.spacing, scene.walls.layers
    x, y = run["x0"], run["y0"]
    top = max(y.max(), min(float(np.nanmax(run["y"][frame])), 1.5 * scene.geometry.height))
    left, right = (x.min() - spacing, x.max() + spacing) if not scene.walls.kinds.sides.open else _reach(run, frame, layers * spacing)
    return left, right, y.min() - spacing, top + spacing


def _reach(run: Run, frame: int, margin: float) -> tuple[float, float]:
    """Extent of the middle 99 % of the particles in a box without side walls."""
    x, x0 = run["x"][frame], run["x0"]
    low, high = np.nanpercentile(x, [0.5, 99.5])
    return min(float(low), x0.min()) - margin, max(float(high), x0.max()) + margin


def draw_profile(ax: Axes, run: Run, frame: int, field: str, norm: Normalize, colours: str = "batlow") -> EllipseCollection:
    """Soil coloured by a field of ``FIELDS``, box in white, initial surface as a thin line; returns the coloured circles."""
    scene, soil = run.scene, run.soil
    x, y = run["x"][frame], run["y"][frame]
    spacing = scene.numerics.spacing
    draw_circles(ax, x[~soil], y[~soil], spacing, facecolor="white", edgecolor="0.35", linewidth=0.25)
    values = FIELDS[field].of(run, frame)[soil]
    circles = draw_circles(ax, x[soil], y[soil], spacing, array=values, cmap=colour_map(colours), norm=norm, edgecolor="0.3", linewidth=0.1)
    surface_x, surface_y = surface_line(scene)
    end_of_soil = run["x0"][soil].max() + 0.5 * spacing  # whole columns of particles may leave a part of the width empty
    ax.plot(np.minimum(surface_x, end_of_soil), surface_y, color="black", linewidth=0.7)
    survey_axes(ax, scene, frame_limits(run, frame))
    return circles


class SurveyTicks(AutoLocator):
    """Ticks at round numbers of a survey's coordinate, which runs from ``start`` (m) at the box's 0 in a ``direction`` of 1 or -1."""

    def __init__(self, start: float, direction: int) -> None:
        super().__init__()
        self.start, self.direction = start, direction

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Places of the ticks in the box's coordinate."""
        ends = sorted(self.start + self.direction * value for value in (vmin, vmax))
        return sorted(self.direction * (tick - self.start) for tick in super().tick_values(*ends))

    def label(self, value: float, _: float = 0.0) -> str:
        """The survey's coordinate of a place."""
        return f"{round(self.start + self.direction * value, 6) + 0.0:.12g}".replace("-", "\N{MINUS SIGN}")


def survey_axes(ax: Axes, scene: Scene, limits: Sequence[float]) -> None:
    """Axes of a section to scale with ``limits`` (left, right, lower, upper) in the box, m, in the survey's own coordinates and seen
    as it is surveyed: a slope that falls to the right does so."""
    geometry, (left, right, lower, upper) = scene.geometry, limits
    ax.set_aspect("equal")
    ax.set(xlim=(left, right)[:: geometry.direction], ylim=(lower, upper), xlabel="horizontal position (m)", ylabel="height (m)")
    if not isinstance(geometry, GroundLine):
        return
    for axis, ticks in ((ax.xaxis, SurveyTicks(geometry.origin[0], geometry.direction)), (ax.yaxis, SurveyTicks(geometry.origin[1], 1))):
        axis.set_major_locator(ticks)
        axis.set_major_formatter(ticks.label)
    ax.set_ylabel("elevation (m)")


def probe_places(run: Run, frame: int) -> dict[str, tuple[float, float]]:
    """Place of every probe in a frame, m, by name."""
    particles = run["probe_particle"]
    places = zip(*(run[axis][frame, particles].tolist() for axis in ("x", "y")), strict=True)
    return dict(zip(run.probes, places, strict=True))


def mark_probes(ax: Axes, run: Run, frame: int) -> None:
    """A ring and the name at every probe."""
    for name, place in probe_places(run, frame).items():
        mark_place(ax, name, *place)


def mark_place(ax: Axes, name: str, x: float, y: float, above: bool = False) -> None:
    """A ring and a name, on the side to which the slope falls."""
    side = 1 if ax.xaxis_inverted() else -1
    ax.plot(x, y, marker="o", markersize=5, markerfacecolor="white", markeredgecolor="black", markeredgewidth=1.0, zorder=4)
    halo = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    offset, level = ((5 * side, 5), "bottom") if above else ((7 * side, 0), "center")
    align = "left" if side > 0 else "right"
    ax.annotate(name, (x, y), xytext=offset, textcoords="offset points", ha=align, va=level, weight="bold", bbox=halo, zorder=5)


def draw_places(ax: Axes, scene: Scene, places: Mapping[str, PlaceAt]) -> None:
    """A post on the initial ground at each place that debris may reach, with its name upright above it."""
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        return
    post = {"arrowstyle": "-", "color": PLACE_COLOUR, "linewidth": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    look: dict[str, Any] = {"color": PLACE_COLOUR, "size": "small", "weight": "bold", "bbox": HALO, "arrowprops": post, "zorder": 6}
    for name, at in places.items():
        x = geometry.toe[0] - beyond_toe(at, geometry)
        foot = x, float(geometry.ground(np.array([x]))[0])
        above: dict[str, Any] = {"xytext": (0, POST), "textcoords": "offset points", "ha": "center", "va": "bottom", "rotation": 90}
        ax.annotate(plain(name).replace("_", " "), foot, **above, **look)


def field_norm(runs: Mapping[str, Run], field: str, *frames: int) -> Normalize:
    """One scale for the soil of several runs in some frames, the last one by default; a constant field gets a span of 1,
    values that are not finite are left out."""
    values = np.concatenate([FIELDS[field].of(run, frame)[run.soil] for run in runs.values() for frame in frames or (-1,)])
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    zero = min(run.scene.geometry.origin[1] for run in runs.values()) if field == "initial_height" else 0.0
    low = zero if low > zero else low
    return Normalize(low, high if high > low else low + 1.0)


def stack_of_profiles(runs: Mapping[str, Run], frame: int, field: str, places: Mapping[str, PlaceAt] | None = None) -> Figure:
    """Profiles of one frame below each other, a title for each, one colour bar; x axis and scale are common."""
    if not runs:
        raise ValueError("runs: a figure of profiles needs at least one")
    limits = np.array([frame_limits(run, frame) for run in runs.values()])
    left, right, lower, upper = limits[:, 0].min(), limits[:, 1].max(), limits[:, 2].min(), limits[:, 3].max()
    panel = (WIDTH - 1.6) * (upper - lower) / (right - left)
    titles = [textwrap.wrap(with_end(title, run), LONG_TITLE) for title, run in runs.items()]
    more_lines = sum(max(len(lines) - 1, 0) for lines in titles)
    height = len(runs) * (panel + OUTSIDE) + more_lines * LINE + 0.65
    figure = Figure(figsize=(WIDTH, height), layout="compressed")
    axes = figure.subplots(len(runs), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    norm = field_norm(runs, field, frame)
    for ax, run in zip(axes, runs.values(), strict=True):
        circles = draw_profile(ax, run, frame, field, norm)
        mark_probes(ax, run, frame)
        draw_places(ax, run.scene, places or {})
    for ax, run in zip(axes, runs.values(), strict=True):
        survey_axes(ax, run.scene, (left, right, lower, upper))
        ax.label_outer()
    label_panels(axes, ["\n".join(lines) for lines in titles])
    bar = FIELDS[field]
    words = textwrap.fill(f"{bar.label} ({bar.units})", max(12, int(PER_INCH * panel * len(runs))))
    figure.colorbar(circles, ax=list(axes), label=words, pad=0.015, fraction=0.03, aspect=20 * len(runs) ** 0.5)
    return figure


@styled
def figure_profiles(runs: Mapping[str, Run], fidelity: str = "") -> Figure:
    """Profiles of the slope at the end of the run, coloured by the initial elevation of the particles; particles of the box are
    white, the line is the initial surface, A is the particle at the original crest edge.

    ``runs`` by panel title, e.g. ``{"S_R = 0.10, γ = 100": run, ...}``.  Raises ValueError without runs.
    """
    return _profiles(runs, "initial_height", fidelity)


@styled
def figure_displaced(runs: Mapping[str, Run], fidelity: str = "", places: Mapping[str, PlaceAt] | None = None) -> Figure:
    """Profiles of the slope at the end of the run, coloured by the displacement of the particles since the gravity stage, on one scale;
    particles of the box are white, the line is the initial surface, A is the particle at the original crest edge.  Posts stand at the
    places that debris may reach.

    ``runs`` by panel title, ``places`` as in ``metrics.places``.  Raises ValueError without runs.
    """
    return _profiles(runs, "displacement", fidelity, places)


def _profiles(runs: Mapping[str, Run], field: str, fidelity: str, places: Mapping[str, PlaceAt] | None = None) -> Figure:
    figure = stack_of_profiles(runs, -1, field, places)
    add_note(figure, [run.scene for run in runs.values()], fidelity)
    return figure
