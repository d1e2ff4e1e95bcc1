"""What goes into a simulation: geometry, motion, initial particles."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon, Rectangle

from sph.figures.history import shade_shaking
from sph.figures.profile import mark_probes, stack_of_profiles, surface_line, survey_axes
from sph.figures.style import GREY, WIDTH, add_note, styled
from sph.scene.geometry import SLOPES, Slope
from sph.scene.ground_line import GroundLine
from sph.scene.motion import NoMotion, reference_amplitude
from sph.scene.schema import Scene
from sph.storage.trajectory import scene_of

SOIL_COLOUR = "#d9c9a8"


@styled
def figure_geometry(trajectory: xr.Dataset, fidelity: str = "") -> Figure:
    """Geometry of the slope, its material and the box that holds it; A is the particle at the crest edge whose motion is followed.

    ``trajectory`` of any run of the scene.  Raises ValueError for a shape without a slope.
    """
    scene = scene_of(trajectory)
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        raise ValueError(f"geometry.shape: {geometry.shape!r}; the figure of the geometry is for 'slope' and 'ground_line'")
    reach, top, bottom = 0.09 * geometry.width, 1.1 * geometry.height, -0.22 * geometry.height
    figure = Figure(
        figsize=(WIDTH, WIDTH * (top - bottom) / (geometry.width + 2 * reach) + (0.25 if isinstance(geometry, Slope) else 0.9)),
        layout="constrained",
    )
    ax = figure.subplots()
    draw_box(ax, scene)
    draw_ground(ax, scene, facecolor=SOIL_COLOUR)
    mark_probes(ax, trajectory, 0)
    ax.set_aspect("equal")
    if isinstance(geometry, Slope):
        place = 0.03 * geometry.width, 1.0 * geometry.height
        ax.text(*place, "\n".join(_material(scene)), va="top", linespacing=1.5)
        _draw_dimensions(ax, geometry)
        ax.set(xlim=(-reach, geometry.width + reach), ylim=(bottom, top))
        ax.axis("off")
    else:
        mark_slope(ax, geometry)
        ax.set_title("\n".join(" · ".join(lines) for lines in (_material(scene)[:2], _material(scene)[2:])), loc="left", linespacing=1.5)
        ax.set(xlim=(-reach, geometry.width + reach), ylim=(0.5 * bottom, top), xlabel="horizontal position (m)")
        survey_axes(ax, scene)
    add_note(figure, [scene], fidelity)
    return figure


def draw_ground(ax: Axes, scene: Scene, facecolor: str = "none") -> None:
    """Outline of the soil down to the base."""
    x, y = surface_line(scene)
    outline = [*zip(x, y, strict=True), (scene.geometry.width, 0.0), (0.0, 0.0)]
    ax.add_patch(Polygon(outline, facecolor=facecolor, edgecolor="black", linewidth=1.0))


def mark_slope(ax: Axes, geometry: Slope | GroundLine) -> None:
    """Toe and crest edge, and the height between them."""
    (toe_x, toe_y), (crest_x, crest_y) = geometry.toe, geometry.crest
    ax.plot([toe_x, crest_x], [toe_y, crest_y], linestyle="none", marker="^", markersize=5, color="black", zorder=4)
    halo = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8}
    ax.annotate("toe", (toe_x, toe_y), xytext=(0, -7), textcoords="offset points", ha="center", va="top", bbox=halo)
    ax.annotate("crest", (crest_x, crest_y), xytext=(7, 5), textcoords="offset points", ha="left", va="bottom")
    x = toe_x - 0.04 * geometry.width
    ax.plot([x, crest_x], [crest_y, crest_y], color=GREY, linewidth=0.4)
    ax.plot([x, toe_x], [toe_y, toe_y], color=GREY, linewidth=0.4)
    _dimension(ax, (x, toe_y), (x, crest_y), "")
    middle = (x, 0.5 * (toe_y + crest_y))
    text = f"H = {geometry.slope_height:.3g} m"
    ax.annotate(text, middle, xytext=(-5, 0), textcoords="offset points", ha="right", va="center")


def draw_box(ax: Axes, scene: Scene) -> None:
    """Walls as hatched strips of their layers of particles; a free-slip wall is a thin line on rollers' side."""
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
    for x, side in ((-1.6 * thick, "right"), (width + 1.6 * thick, "left")):
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
    """Tables 1 and 2 in four lines."""
    soil = scene.soil
    return [
        f"ρ = {soil.density:g} kg/m³",
        f"E = {1e-3 * soil.youngs_modulus:g} MPa, ν = {soil.poisson_ratio:g}",
        f"solid: c = {soil.cohesion:g} kPa, φ = {soil.friction_angle:g}°",
        f"fluid: $S_R$ c, $S_R$ φ, η = {soil.viscosity:g} Pa·s",
    ]


@styled
def figure_motion(trajectory: xr.Dataset, fidelity: str = "") -> Figure:
    """Horizontal acceleration of the box against time; gravity is brought on before the shaking starts, and the run goes on
    after it has ended.

    ``trajectory`` of any run of the scene.
    """
    scene = scene_of(trajectory)
    figure = Figure(figsize=(WIDTH, 2.5), layout="constrained")
    ax = figure.subplots()
    ax.plot(trajectory["sample_time"].values, trajectory["ground_acceleration"].values, color="black", linewidth=0.9)
    shade_shaking(ax, scene)
    ax.axhline(0.0, color="0.6", linewidth=0.5, zorder=1)
    peak = abs(reference_amplitude(scene.motion)) or 1.0
    ax.set(xlim=(0.0, scene.duration), ylim=(-1.3 * peak, 1.45 * peak), xlabel="time (s)", ylabel="acceleration (m/s²)")
    _name_stages(ax, scene)
    add_note(figure, [scene], fidelity)
    return figure


def _name_stages(ax: Axes, scene: Scene) -> None:
    stages = [("gravity", 0.0, scene.gravity.duration)]
    if not isinstance(scene.motion, NoMotion) and scene.motion.end < scene.duration:
        stages.append(("no shaking", scene.motion.end, scene.duration))
    for name, start, end in stages:
        middle = 0.5 * (start + end)
        ax.annotate(
            name, (middle, 1.0), xycoords=("data", "axes fraction"), xytext=(0, -3), textcoords="offset points", ha="center", va="top"
        )


@styled
def figure_arrangement(trajectory: xr.Dataset, fidelity: str = "") -> Figure:
    """Initial arrangement of the particles, coloured by height; the particles of the box are white.  A is the particle at the
    crest edge.

    ``trajectory`` of any run of the scene; its first frame is drawn.
    """
    soil, box = (int((trajectory["kind"].values == 0).sum()), int((trajectory["kind"].values != 0).sum()))
    figure = stack_of_profiles({f"{soil} soil particles, {box} particles of the box": trajectory}, 0, "initial_height")
    add_note(figure, [scene_of(trajectory)], fidelity)
    return figure
