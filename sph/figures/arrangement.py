"""The input of a simulation: geometry, motion, initial particles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Patch, Polygon, Rectangle
from matplotlib.patheffects import withStroke

from sph.checks.equilibrium import found_equilibrium
from sph.figures.history import shade_shaking
from sph.figures.labels import NAME
from sph.figures.profile import (
    HALO,
    PER_INCH,
    by_place,
    draw_circles,
    draw_places,
    layer_colours,
    layer_outlines,
    mark_place,
    probe_places,
    stack_of_profiles,
    surface_line,
    survey_axes,
    with_room,
)
from sph.figures.style import GREY, WIDTH, add_note, also_in_g, plain, styled, written
from sph.measures.metrics import AREA_THRESHOLDS
from sph.measures.places import PlaceAt, foot_of
from sph.output.run import Run
from sph.scene.geometry import SLOPES, Slope
from sph.scene.layers import LayerMaterial
from sph.scene.motion import NoMotion, reference_amplitude
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.scene.units import in_both
from sph.stability.slip_search import LimitEquilibrium
from sph.study.dimensions import named

SEAM_COLOUR = "#8c2d04"
SURFACE_COLOUR = "#6a0d83"
FAILED_COLOUR = "#b2182b"
MOVED = AREA_THRESHOLDS["area_moved_50cm"]
"""Displacement of failed soil that has slid, m."""
DOT = 0.5
"""Diameter of the dots of failed soil that stays, over the spacing."""
GREYS, PALE = (0.30, 0.59, 0.11), 0.5
"""Weights of a colour in its grey, and the grey from which on they are black."""
TOLD = 0.01
"""Share of a layer from which it is told that it fails and stays."""
LEGEND_LINE = 0.17
"""Inches of a line of the legend of layers."""
COLUMN, NAMES = 4.5, 3.0
"""Inches of a column of it, and of one that only names soils."""
NAMED = 0.12
"""Least part of the time axis of the gravity stage at which its name has room."""
ASIDE, CLEAR = (0.04, 0.06, 0.08, 0.1, 0.12), 0.02
"""Where the height of the slope stands before its toe, the nearest first, and its distance from a post, over the width of the box."""
TITLE = 80
"""Most characters in a line of a title."""


@styled
def figure_geometry(run: Run, fidelity: str = "", places: Mapping[str, PlaceAt] | None = None) -> Figure:
    """Section of the slope with its layers and their properties, the critical slip surfaces, and the box that holds it; A is the particle
    at the crest edge whose motion is followed.  Posts stand at the places that debris may reach.  What the study varies has the values of
    its first run.

    ``run`` is any of the scene, ``places`` are as in ``metrics.places``.  Raises ValueError for a shape without a slope.
    """
    scene = run.scene
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        raise ValueError(f"geometry.shape: {geometry.shape!r}; the figure of the geometry is for 'slope' and 'ground_line'")
    dimensioned = isinstance(geometry, Slope)
    reach, bottom = 0.09 * geometry.width, (-0.22 if dimensioned else -0.11) * geometry.height
    limits = with_room((-reach, geometry.width + reach, bottom, 1.1 * geometry.height), scene, places or {}, WIDTH)
    equilibrium = found_equilibrium(scene)
    lines = len(scene.soils) + sum(surface.x.size > 0 for surface in equilibrium or ())
    height = WIDTH * (limits[3] - bottom) / (geometry.width + 2 * reach) + (0.4 if dimensioned else 0.75) + LEGEND_LINE * lines
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    ax = figure.subplots()
    draw_box(ax, scene)
    draw_layers(ax, scene)
    draw_ground(ax, scene)
    draw_seams(ax, scene)
    draw_water(ax, scene)
    surfaces = draw_surfaces(ax, equilibrium)
    survey_axes(ax, scene, limits)
    mark_places(ax, scene, probe_places(run, 0), height=not dimensioned, places=places)
    draw_places(ax, scene, places or {})
    if isinstance(geometry, Slope):
        _draw_dimensions(ax, geometry)
        ax.axis("off")
    layer_legend(figure, scene, more=surfaces)
    add_note(figure, [scene], fidelity)
    return figure


def layer_legend(
    figure: FigureBase, scene: Scene, shown: Iterable[int] | None = None, more: Sequence[Artist] = (), named: bool = False
) -> None:
    """Colour, name and properties of the scene's own soil and its layers, or of those ``shown``, a line each, above a figure; below them
    what ``more`` is drawn.  They are only ``named`` in a figure that has no room for properties."""
    names, colours, properties = scene.soil_names, layer_colours(scene), _material(scene)
    handles = [
        Patch(
            facecolor=colours[n], edgecolor="0.3", linewidth=0.4, label=plain(names[n]) if named else f"{plain(names[n])}: {properties[n]}"
        )
        for n in (range(len(names)) if shown is None else shown)
    ]
    columns = legend_columns(figure.get_figure(root=True).get_figwidth(), named)
    figure.legend(handles=[*handles, *more], loc="outside upper left", fontsize=7.5, borderaxespad=0.0, ncols=columns, columnspacing=0.8)


def legend_columns(width: float, named: bool = False) -> int:
    """Columns of the legend of layers in a figure of a width in inches."""
    return max(1, int(width / (NAMES if named else COLUMN)))


def draw_layers(ax: Axes, scene: Scene) -> None:
    """The soil below the ground line, layer over layer as the scene gives them."""
    x, y = surface_line(scene)
    ground = Polygon([*zip(x, y, strict=True), (scene.geometry.width, 0.0), (0.0, 0.0)], visible=False)
    ax.add_patch(ground)
    regions = [np.array([(0.0, 0.0), (0.0, 2.0 * y.max()), (x[-1], 2.0 * y.max()), (x[-1], 0.0)])]
    regions += layer_outlines(scene)
    for outline, colour in zip(regions, layer_colours(scene), strict=True):
        ax.add_patch(Polygon(outline, facecolor=colour, edgecolor="0.3", linewidth=0.5, clip_path=ground))


def draw_surfaces(ax: Axes, equilibrium: LimitEquilibrium | None) -> list[Line2D]:
    """The critical slip surfaces by Bishop's and Spencer's methods and that of the yield acceleration, where there are any; the lines."""
    drawn = list[Line2D]()
    for name, style in (("bishop", (0, (4, 1.5))), ("spencer", "-"), ("critical", (0, (1, 1)))):
        surface = getattr(equilibrium, name, None)
        if surface is not None and surface.x.size:
            label = f"critical surface, {name.capitalize()}: F = {surface.value:.2f}"
            if name == "critical":
                label = f"that of the yield acceleration, {surface.value:.2g} g"
            halo = [withStroke(linewidth=2.2, foreground="white")]  # on failed soil
            drawn += ax.plot(
                surface.x, surface.y, color=SURFACE_COLOUR, linewidth=1.1, linestyle=style, zorder=3, label=label, path_effects=halo
            )
    return drawn


def failed_soil(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Which particles (n,) have failed by the end of a run and slid away, and which have failed and stay: soil and rock may reach their
    strength, and lose it, without a slip surface."""
    failed = run.soil & (run["failed"][-1] == 1)
    moved = np.hypot(*run.displacement()) > MOVED
    return failed & moved, failed & ~moved


def failed_words(run: Run) -> str:
    """How much of the layers moves away, and how much has failed and stays, where it is more than ``TOLD`` of one, in sentences; nothing
    where there is none."""
    slides, stays = failed_soil(run)
    layers = {name: run.soil & (run["layer"] == number) for number, name in enumerate(run.scene.soil_names)}
    moves = [
        f"{float(f'{area:.2g}'):g} m² of the {name.replace('_', ' ')}"
        for name, layer in layers.items()
        if (area := float((slides & layer).sum()) * run.scene.numerics.spacing**2) > 0.0
    ]
    shares = {name: float(stays[layer].mean()) for name, layer in layers.items() if layer.any()}
    told = [f"{100.0 * share:.0f} % of the {name.replace('_', ' ')}" for name, share in shares.items() if share > TOLD]
    said = [f"Has failed and moved by more than {MOVED:g} m: {', '.join(moves)}."] if moves else []
    said += [f"Has reached its strength for an instant at least, but moved by less: {', '.join(told)}."] if told else []
    return " ".join(said)


def draw_failed(ax: Axes, run: Run) -> list[Artist]:
    """The soil that has failed by the end of a run, where it lies before the shaking: filled where it slides away, dots where it stays,
    which differ in print and at any size.  Returns their entries of a legend, of what there is."""
    slides, stays = failed_soil(run)
    fill: Any = {"facecolor": FAILED_COLOUR, "alpha": 0.75, "linewidth": 0.0}
    entries: list[Artist] = []
    if slides.any():
        _draw_particles(ax, run, slides, 1.0, fill)
        entries.append(Patch(label=f"SPH: failed, and moved by more than {MOVED:g} m", **fill))
    if stays.any():
        dark = np.array([np.dot(colour[:3], GREYS) < PALE for colour in layer_colours(run.scene)])[run["layer"]]
        for there, colour in ((stays & dark, "white"), (stays & ~dark, "black")):
            if there.any():
                _draw_particles(ax, run, there, DOT, {"facecolor": colour, "linewidth": 0.0})
        entries.append(Line2D([], [], color="black", linestyle=":", linewidth=2.0, label="SPH (dots): reached its strength, moved less"))
    return entries


def _draw_particles(ax: Axes, run: Run, there: np.ndarray, size: float, look: Mapping[str, Any]) -> None:
    """Particles where they lie before the shaking, in a ``size`` over the spacing."""
    x, y = (run[axis][run.gravity_frame, there] for axis in "xy")
    draw_circles(ax, x, y, size * run.scene.numerics.spacing, zorder=2.5, **look)


def draw_seams(ax: Axes, scene: Scene) -> None:
    """The seams within the soil, with their names."""
    for name, seam in scene.seams.items():
        x, y = (np.array(places) for places in scene.geometry.in_box(*seam.middles(200)))
        inside = (x > 0.0) & (x < scene.geometry.width) & (y > 0.0) & (y < scene.geometry.ground(x))
        ax.plot(np.where(inside, x, np.nan), y, color=SEAM_COLOUR, linewidth=1.2, zorder=3)
        middle = np.flatnonzero(inside)[np.count_nonzero(inside) // 2]
        look: dict[str, Any] = {"color": SEAM_COLOUR, "size": "small", "bbox": HALO, "ha": "center"}
        ax.annotate(plain(name).replace("_", " "), (x[middle], y[middle]), (0, 4), textcoords="offset points", **look)


def draw_ground(ax: Axes, scene: Scene) -> None:
    """Outline of the soil down to the base."""
    x, y = surface_line(scene)
    outline = [*zip(x, y, strict=True), (scene.geometry.width, 0.0), (0.0, 0.0)]
    ax.add_patch(Polygon(outline, facecolor="none", edgecolor="black", linewidth=1.0))


def draw_water(ax: Axes, scene: Scene, named: bool = False) -> None:
    """The phreatic line, over the width of the box, with its name above the ground if wanted; nothing for a dry scene or a ratio r_u."""
    if scene.water is None or scene.water.r_u is not None:
        return
    inside = scene.geometry.in_box(scene.water.line[:, 0], scene.water.line[:, 1])[0]
    x = np.unique(np.clip([0.0, *inside, scene.geometry.width], 0.0, scene.geometry.width))
    surface = scene.water.surface(scene.geometry, x)
    ax.plot(x, surface, color="tab:blue", linewidth=0.9, linestyle="--", zorder=3)
    if named:
        right = -1 if scene.geometry.direction > 0 else 0  # end of the line, as it is drawn
        place = x[right], max(surface[right], float(scene.geometry.ground(x[right : right + 1 or None])[0]))
        ax.annotate("water", place, (-4, 2), textcoords="offset points", ha="right", va="bottom", color="tab:blue", size="small")


def mark_places(
    ax: Axes, scene: Scene, probes: Mapping[str, tuple[float, float]], height: bool = True, places: Mapping[str, PlaceAt] | None = None
) -> None:
    """Probes, toe and crest edge by name, a probe at one of these by both names; with ``height`` the height between them, beside the posts
    at ``places``, above which its number then lies.
    """
    geometry, near = scene.geometry, 2.0 * scene.numerics.spacing
    edges = {"toe": geometry.toe, "crest": geometry.crest} if isinstance(geometry, SLOPES) else {}
    for place, names in by_place(probes).items():
        at, name = [edge for edge, corner in edges.items() if math.dist(place, corner) < near], ", ".join(names)
        mark_place(ax, f"{name} ({at[0]})" if at else name, *place, above=True)
        edges = {edge: corner for edge, corner in edges.items() if edge not in at}
    for edge, corner in edges.items():
        ax.plot(*corner, linestyle="none", marker="^", markersize=5, color="black", zorder=4)
        ax.annotate(edge, corner, xytext=(0, 7), textcoords="offset points", ha="center", va="bottom", bbox=HALO, gid=NAME)
    if height and isinstance(geometry, SLOPES):
        (toe_x, toe_y), (crest_x, crest_y) = geometry.toe, geometry.crest
        posts = [foot_of(at, geometry)[0] for at in (places or {}).values()]
        beside = [toe_x - part * geometry.width for part in ASIDE]
        x = next((x for x in beside if all(abs(x - post) > CLEAR * geometry.width for post in posts)), beside[0])
        for end, level in ((crest_x, crest_y), (toe_x, toe_y)):
            ax.plot([x, end], [level, level], color=GREY, linewidth=0.4)
        _dimension(ax, (x, toe_y), (x, crest_y), "")
        text = f"H = {geometry.slope_height:.3g} m"
        side = geometry.direction
        ax.annotate(
            text,
            (x, crest_y if places else 0.35 * toe_y + 0.65 * crest_y),
            xytext=(-5 * side, 3 if places else 0),
            textcoords="offset points",
            ha="right" if side > 0 else "left",
            va="bottom" if places else "center",
            bbox=HALO,
        )


def draw_box(ax: Axes, scene: Scene) -> None:
    """Walls as hatched strips of their layers of particles, side walls with their names where the section is high enough for these."""
    thick = scene.walls.layers * scene.numerics.spacing
    width, height = scene.geometry.width, scene.geometry.height
    style: dict[str, Any] = {"facecolor": "white", "edgecolor": GREY, "hatch": "/////", "linewidth": 0.5}
    base, sides, _ = scene.walls.kinds
    if not base.open:
        ax.add_patch(Rectangle((-thick, -thick), width + 2 * thick, thick, **style))
    if not sides.label:
        return
    ground = scene.geometry.surface[1] if sides.absorbs else (height, height)
    for left, top in ((-thick, ground[0]), (width, ground[-1])):
        ax.add_patch(Rectangle((left, 0.0), thick, top, **style))
    shown = WIDTH * height / (width + 2.0 * thick)  # inches, about
    if shown * PER_INCH < len(sides.label):  # the note below the figure names the walls, too
        return
    for x, side in zip((-1.6 * thick, width + 1.6 * thick), ("right", "left")[:: scene.geometry.direction], strict=True):
        ax.text(x, 0.5 * height, sides.label, rotation=90, ha=side, va="center", color=GREY)


def _dimension(ax: Axes, start: tuple[float, float], end: tuple[float, float], text: str) -> None:
    """A line with arrow heads at both ends and its length at the middle, on a white ground."""
    ax.annotate("", start, end, arrowprops={"arrowstyle": "<|-|>", "linewidth": 0.7, "color": "black", "shrinkA": 0, "shrinkB": 0})
    middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    ax.text(*middle, text, ha="center", va="center", rotation=0 if start[1] == end[1] else 90, bbox=ground)


def _draw_dimensions(ax: Axes, geometry: Slope) -> None:
    (toe_x, toe_y), (crest_x, crest_y) = geometry.toe, geometry.crest
    below = -0.18 * geometry.height
    marks = [0.0, toe_x, crest_x, geometry.width]
    for start, end in zip(marks[:-1], marks[1:], strict=True):
        _dimension(ax, (start, below), (end, below), f"{end - start:.1f} m")
    for x in marks:
        ax.plot([x, x], [1.15 * below, 0.0], color=GREY, linewidth=0.4, zorder=0.5)
    height_x, base_x = toe_x - 0.04 * geometry.width, 0.1 * geometry.width
    _dimension(ax, (height_x, toe_y), (height_x, crest_y), f"H = {geometry.slope_height:g} m")
    ax.plot([height_x, crest_x], [crest_y, crest_y], color=GREY, linewidth=0.4)
    if geometry.base_depth > 0:
        _dimension(ax, (base_x, 0.0), (base_x, toe_y), f"{geometry.base_depth:g} m")
    size = 0.25 * geometry.slope_height
    ax.add_patch(Arc((toe_x, toe_y), size, size, theta1=0, theta2=geometry.slope_angle, linewidth=0.7))
    ax.plot([toe_x, toe_x + size], [toe_y, toe_y], color="black", linewidth=0.4)
    ax.text(toe_x + 0.6 * size, toe_y + 0.05 * size, f"{geometry.slope_angle:g}°", ha="left", va="bottom")


def _material(scene: Scene) -> list[str]:
    """Properties of the scene's own soil and of every layer in words: solid, then what failed soil keeps."""
    return [
        f"{soil.density:g} kg/m³, Young's modulus {_rounded(1e-3 * soil.youngs_modulus)} MPa, cohesion {_cohesion(soil)}, "
        f"friction angle {soil.friction_angle:g}°; once failed {_failed(material)}"
        for material, soil in zip(scene.materials, scene.soils, strict=True)
    ]


def _rounded(value: float) -> str:
    """A number to three digits, or to a whole one."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


def _failed(material: LayerMaterial) -> str:
    """Cohesion and friction angle that failed soil keeps."""
    (cohesion, angle), gradient = material.residual, material.residual_gradient
    return f"{f'({cohesion:.3g} + {gradient:.3g} z/m)' if gradient else f'{cohesion:.3g}'} kPa, {angle:.3g}°"


def coupling_words(scene: Scene) -> str:
    """What failed soil keeps and how fast it loses the rest, for a title; layers that keep another part are named or counted."""
    own, *others = map(_kept, scene.materials)
    names: dict[str, list[str]] = {}
    for name, kept in zip(scene.layers, others, strict=True):
        names.setdefault(kept, []).append(plain(name).replace("_", " "))
    apart = [f"{kept} in {' and '.join(of) if len(of) < 3 else f'{len(of)} layers'}" for kept, of in names.items() if kept != own]
    rate = f", {named('gamma').equation(scene.coupling.gamma)}" if scene.coupling.gamma > 0.0 else ""
    return fill(f"{'; '.join([own, *apart])}{rate}", TITLE)


def _cohesion(soil: Soil) -> str:
    """The peak cohesion in words, with z the depth below the top of the soil where it grows."""
    return f"({soil.cohesion:g} + {soil.gradient:g} z/m) kPa" if soil.gradient else f"{soil.cohesion:g} kPa"


def _kept(material: LayerMaterial) -> str:
    """What failed soil keeps of its strength: S_R, and residual strengths that are written, which it does not touch."""
    soil, words = material.soil, [written(named("S_R").equation(material.S_R))] * material.uses_S_R
    words += [] if soil.residual_cohesion is None else [f"$c_r$ = {soil.residual_cohesion:g} kPa"]
    words += [] if soil.residual_friction_angle is None else [f"$φ_r$ = {soil.residual_friction_angle:g}°"]
    return ", ".join(words)


@styled
def figure_motion(run: Run, fidelity: str = "", others: str = "") -> Figure:
    """Horizontal acceleration of the box against time, to the end of the shaking; gravity is applied before it starts, and the run goes on
    after it has ended.

    ``run`` is any of the scene, ``others`` says how the shaking of other runs differs.
    """
    scene = run.scene
    figure = Figure(figsize=(WIDTH, 2.5), layout="constrained")
    ax = figure.subplots()
    ax.plot(run["sample_time"], run["ground_acceleration"], color="black", linewidth=0.9)
    shade_shaking(ax, scene)
    ax.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
    peak = abs(reference_amplitude(scene.motion)) or 1.0
    end = scene.duration if isinstance(scene.motion, NoMotion) else min(scene.motion.end, scene.duration)
    ax.set(xlim=(0.0, end), ylim=(-1.3 * peak, 1.45 * peak), xlabel="time (s)", ylabel="acceleration (m/s²)")
    also_in_g(ax, "y")
    if scene.gravity.duration >= NAMED * end:
        middle: Any = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "ha": "center", "va": "top"}
        ax.annotate("gravity", (0.5 * scene.gravity.duration, 1.0), (0, -3), **middle)
    told = f"{motion_name(scene)}, peak {in_both(float(np.abs(run['ground_acceleration']).max())).replace('m/s2', 'm/s²')}"
    ax.set_title(fill(f"{told}; in other runs {plain(others)}" if others else told, TITLE), loc="left")
    add_note(figure, [scene], fidelity)
    return figure


def motion_name(scene: Scene) -> str:
    """The scene's motion in words: its kind, of a record its name, or else the file."""
    file = getattr(scene.motion, "file", None)
    if name := getattr(scene.motion, "name", None):
        return plain(name)
    if (made := getattr(scene.motion, "stochastic", None)) is not None:
        return f"synthetic motion, seed {made.seed}"
    return plain(f"record {Path(file).name}" if file else scene.motion.kind.replace("_", " "))


@styled
def figure_arrangement(run: Run, fidelity: str = "") -> Figure:
    """Initial arrangement of the particles, coloured by elevation; the particles of the box are white.  A is the particle at the
    crest edge.

    ``run`` is any of the scene; its first frame is drawn.
    """
    soil, box = int(run.soil.sum()), int((~run.soil).sum())
    figure = stack_of_profiles({f"{soil} soil particles, {box} particles of the box": run}, 0, "initial_height")
    add_note(figure, [run.scene], fidelity)
    return figure
