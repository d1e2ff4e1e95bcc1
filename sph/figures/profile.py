"""Particles of a frame, drawn to their physical size."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence
from itertools import zip_longest
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator
from shapely import Polygon

from sph.figures.labels import NAME
from sph.figures.style import WIDTH, add_note, colour_map, label_panels, plain, soil_colours, styled, written
from sph.measures.fields import FIELDS, LAYER, with_end
from sph.measures.places import PlaceAt, foot_of
from sph.output.run import Run
from sph.scene.geometry import SLOPES
from sph.scene.ground_line import GroundLine
from sph.scene.layers import ElevationRegion, OutlinedRegion, Region
from sph.scene.places import Shape
from sph.scene.schema import Scene

OUTSIDE = 0.45
"""Inches beside the axes of a profile that ticks and labels need; only sets the figure's height."""
PLACE_COLOUR = "#8c2d04"
SOIL_COLOUR = "#d9c9a8"
POST, LETTER = 11.0, 5.2
"""Height of the post at a place, and width of a letter of its name, points."""
HALO = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8}
FINE = 400
"""Points along a level side of a layer."""
PER_INCH = 14.0
"""Characters of a label in an inch."""
CHOICE = 110
"""Most characters in a line of the sentence on the choice of runs."""
LONG_TITLE, LINE = 72, 0.17
"""Most characters in a line of a panel's title, and the inches that another line needs."""


def surface_line(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the initial surface from left to right, m."""
    x, y = scene.geometry.surface
    return np.array(x), np.array(y)


def layer_outlines(scene: Scene) -> list[np.ndarray]:
    """Corners (n, 2) of every layer's outline in the box as it lies at the start, below the ground, m."""
    x, y = surface_line(scene)
    return [_outline(layer.region, scene.geometry, x, y) for layer in scene.layers.values()]


def _outline(region: Region, geometry: Shape, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Corners (n, 2) of a layer in the box, m, below a ground of these corners."""
    if isinstance(region, OutlinedRegion):
        ground = Polygon([*zip(x, y, strict=True), (x[-1], 0.0), (x[0], 0.0)])
        inside = Polygon(np.column_stack(geometry.in_box(*region.outline.T))).intersection(ground)
        pieces = [piece for piece in getattr(inside, "geoms", [inside]) if isinstance(piece, Polygon) and not piece.is_empty]
        # A ground that cuts it into pieces leaves the largest.
        return np.array(max(pieces, key=lambda piece: piece.area).exterior.coords) if pieces else np.empty((0, 2))
    if isinstance(region, ElevationRegion):
        ends = [
            geometry.in_box(0.0, end)[1] if end is not None else beyond for end, beyond in ((region.top, y.max()), (region.bottom, 0.0))
        ]
        fine = np.union1d(x, np.linspace(x[0], x[-1], FINE))  # a level side ends where it meets the ground
        upper, lower = (np.minimum(end, np.interp(fine, x, y)) for end in ends)
        x = fine
    else:
        upper, lower = y - region.top, np.zeros_like(y) if region.bottom is None else y - region.bottom
    return np.concatenate([np.column_stack([x, upper]), np.column_stack([x, lower])[::-1]])


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


def layer_colours(scene: Scene) -> list[Any]:
    """A colour for the scene's own soil and every layer, from dark to light among the layers."""
    others = len(scene.layers)
    return [to_rgba(SOIL_COLOUR), *(colour_map()(0.15 + 0.5 * n / max(others - 1, 1)) for n in range(others))]


def field_colours(field: str, scene: Scene) -> Colormap:
    """The colours of a field of ``FIELDS``."""
    return ListedColormap(layer_colours(scene)) if field == LAYER else soil_colours()


def field_bar(figure: Figure, drawn: ScalarMappable, field: str, scene: Scene, width: int, **where: Any) -> None:
    """The scale of a field beside what is ``drawn``, its name in lines of at most ``width`` characters; of layers their names."""
    shown = FIELDS[field]
    units = "" if field == LAYER else f" ({shown.units})"
    bar = figure.colorbar(drawn, label=textwrap.fill(shown.label + units, width), **where)
    if field == LAYER:
        names = list(map(plain, scene.soil_names))
        bar.set_ticks(range(len(names)), labels=names)
        bar.ax.tick_params(which="minor", length=0)


def draw_profile(ax: Axes, run: Run, frame: int, field: str, norm: Normalize, colours: Colormap | None = None) -> EllipseCollection:
    """Soil coloured by a field of ``FIELDS``, box in white, initial surface as a thin line, outlines of the layers as they lay at the start
    dotted; returns the coloured circles."""
    scene, soil = run.scene, run.soil
    x, y = run["x"][frame], run["y"][frame]
    spacing = scene.numerics.spacing
    draw_circles(ax, x[~soil], y[~soil], spacing, facecolor="white", edgecolor="0.35", linewidth=0.25)
    values = FIELDS[field].of(run, frame)[soil]
    circles = draw_circles(
        ax, x[soil], y[soil], spacing, array=values, cmap=colours or field_colours(field, scene), norm=norm, edgecolor="0.3", linewidth=0.1
    )
    for colour, style in (("white", "-"), ("black", ":")):  # to be seen on dark soil and beyond it
        ax.add_collection(LineCollection(layer_outlines(scene), colors=colour, linewidths=0.7, linestyles=style))
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
    """A ring and the name at every probe; those of the same particle share one."""
    for place, names in by_place(probe_places(run, frame)).items():
        mark_place(ax, ", ".join(names), *place)


def by_place(probes: Mapping[str, tuple[float, float]]) -> dict[tuple[float, float], list[str]]:
    """The names of probes by their place."""
    names = dict[tuple[float, float], list[str]]()
    for name, place in probes.items():
        names.setdefault(place, []).append(name)
    return names


def mark_place(ax: Axes, name: str, x: float, y: float, above: bool = False) -> None:
    """A ring and a name, on the side to which the slope falls."""
    side = 1 if ax.xaxis_inverted() else -1
    ring: dict[str, Any] = {"markersize": 5, "markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 1.0}
    ax.plot(x, y, marker="o", **ring, clip_on=False, zorder=4)
    halo = {"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    offset, level = ((5 * side, 5), "bottom") if above else ((7 * side, 0), "center")
    align = "left" if side > 0 else "right"
    look: dict[str, Any] = {"ha": align, "va": level, "weight": "bold", "bbox": halo, "zorder": 7, "gid": NAME}
    ax.annotate(name, (x, y), xytext=offset, textcoords="offset points", **look)


def with_room(limits: Sequence[float], scene: Scene, places: Mapping[str, PlaceAt], width: float) -> tuple[float, float, float, float]:
    """Left, right, lower and upper end (m) of a section that is ``width`` inches wide, with room for the names of places above it."""
    left, right, lower, upper = limits
    point = (right - left) / (72.0 * width)  # m
    if isinstance(scene.geometry, SLOPES):
        tops = [foot_of(at, scene.geometry)[1] + point * (POST + LETTER * (len(name) + 1)) for name, at in places.items()]
        upper = max([upper, *tops])
    return left, right, lower, upper


def draw_places(ax: Axes, scene: Scene, places: Mapping[str, PlaceAt]) -> None:
    """A post on the initial ground at each place that debris may reach, with its name upright above it."""
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        return
    post = {"arrowstyle": "-", "color": PLACE_COLOUR, "linewidth": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    look: dict[str, Any] = {
        "color": PLACE_COLOUR,
        "size": "small",
        "weight": "bold",
        "bbox": HALO,
        "arrowprops": post,
        "zorder": 6,
        "gid": NAME,
    }
    for name, at in places.items():
        foot = foot_of(at, geometry)
        above: dict[str, Any] = {"xytext": (0, POST), "textcoords": "offset points", "ha": "center", "va": "bottom", "rotation": 90}
        ax.annotate(plain(name).replace("_", " "), foot, **above, **look)


def field_norm(runs: Mapping[str, Run], field: str, *frames: int) -> Normalize:
    """One scale for the soil of several runs in some frames, the last one by default; a constant field gets a span of 1,
    values that are not finite are left out.  Layers have a step each."""
    if field == LAYER:
        count = max(1 + len(run.scene.layers) for run in runs.values())
        return BoundaryNorm(np.arange(count + 1) - 0.5, count)
    values = np.concatenate([FIELDS[field].of(run, frame)[run.soil] for run in runs.values() for frame in frames or (-1,)])
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    zero = min(run.scene.geometry.origin[1] for run in runs.values()) if field == "initial_height" else 0.0
    low = zero if low > zero else low
    return Normalize(low, high if high > low else low + 1.0)


def moving_farthest(groups: Sequence[Sequence[str]], moved: Callable[[str], float], most: int) -> list[str]:
    """At most so many of some names, in their order: of each group the one that has ``moved`` farthest before a second one."""
    ranked = [sorted(group, key=moved, reverse=True) for group in groups] if sum(map(len, groups)) > most else groups
    first = [name for each in zip_longest(*ranked) for name in each if name is not None][:most]
    return [name for group in groups for name in group if name in first]


def stack_of_profiles(runs: Mapping[str, Run], frame: int, field: str, places: Mapping[str, PlaceAt] | None = None) -> Figure:
    """Profiles of one frame below each other, a title for each, one colour bar; x axis and scale are common."""
    if not runs:
        raise ValueError("runs: a figure of profiles needs at least one")
    limits = np.array([frame_limits(run, frame) for run in runs.values()])
    seen = limits[:, 0].min(), limits[:, 1].max(), limits[:, 2].min(), limits[:, 3].max()
    for run in runs.values():
        seen = with_room(seen, run.scene, places or {}, WIDTH - 1.6)
    left, right, lower, upper = seen
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
        survey_axes(ax, run.scene, seen)
        ax.label_outer()
    label_panels(axes, [written("\n".join(lines)) for lines in titles])
    width, scene = max(12, int(PER_INCH * panel * len(runs))), next(iter(runs.values())).scene
    field_bar(figure, circles, field, scene, width, ax=list(axes), pad=0.015, fraction=0.03, aspect=20 * len(runs) ** 0.5)
    return figure


@styled
def figure_profiles(runs: Mapping[str, Run], fidelity: str = "") -> Figure:
    """Profiles of the slope at the end of the run, coloured by the initial elevation of the particles; particles of the box are
    white, the line is the initial surface, A is the particle at the original crest edge.

    ``runs`` by panel title, e.g. ``{"S_R = 0.10, γ = 100": run, ...}``.  Raises ValueError without runs.
    """
    return _profiles(runs, "initial_height", fidelity)


@styled
def figure_displaced(
    runs: Mapping[str, Run],
    fidelity: str = "",
    places: Mapping[str, PlaceAt] | None = None,
    field: str = "displacement",
    choice: str = "",
) -> Figure:
    """Profiles of the slope at the end of the run, coloured on one scale; particles of the box are white, the line is the initial surface,
    dotted lines are layers as they lay at the start, A is the particle at the original crest edge.  Posts stand at the places that debris
    may reach.

    ``runs`` by panel title, ``places`` as in ``metrics.places``, ``field`` a name of ``FIELDS``; ``choice`` says which of how many
    runs these are.  Raises ValueError without runs.
    """
    figure = _profiles(runs, field, fidelity, places)
    if choice:
        figure.suptitle(textwrap.fill(plain(choice), CHOICE), x=0.01, ha="left", fontsize=8)
    return figure


def _profiles(runs: Mapping[str, Run], field: str, fidelity: str, places: Mapping[str, PlaceAt] | None = None) -> Figure:
    figure = stack_of_profiles(runs, -1, field, places)
    add_note(figure, [run.scene for run in runs.values()], fidelity)
    return figure
