"""A scene before it is run (``sph check``): ground, materials, walls, probes, toe and crest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure, SubFigure

from sph.figures.arrangement import (
    LEGEND_LINE,
    draw_box,
    draw_failed,
    draw_ground,
    draw_seams,
    draw_surfaces,
    draw_water,
    layer_legend,
    mark_places,
)
from sph.figures.profile import draw_circles, draw_places, layer_colours, survey_axes
from sph.figures.style import WIDTH, add_note, colour_map, plain, styled
from sph.measures.places import PlaceAt
from sph.output.run import Run
from sph.scene.schema import Scene
from sph.solver.particles import QUANTITIES, Particles, peak_strength, varying_layers
from sph.stability.slip_search import LimitEquilibrium

BAR = 0.75
"""Height of the scale and the coordinates below a panel, inch."""
NAMES = 0.3
"""Room for names above the ground, inch."""
FEW = 4000
"""Soil particles up to which each is drawn; more are an image of the lattice."""
SHOWN_WIDTH = 600
"""Columns of the lattice up to which particles are drawn, for they would be smaller than a line."""


class Drawn(NamedTuple):
    """A scene to be drawn."""

    scene: Scene
    particles: Particles
    probes: Mapping[str, int]  # particles
    places: Mapping[str, PlaceAt] = {}  # of a study that debris may reach, as in ``metrics.places``
    equilibrium: LimitEquilibrium | None = None
    name: str = ""  # of an alternative of a study


@styled
def figure_scenes(drawn: Sequence[Drawn], run: Run | None = None) -> Figure:
    """A section for each scene: soil coloured by the layer of each particle, walls, ground, phreatic line (dashed), toe and crest.

    Posts stand at the places.  The critical slip surfaces are those of the limit equilibrium, the soil that has failed that of a ``run``
    of the first scene.  A panel each for cohesion and friction angle follows where they vary in space.
    """
    panels = [_Panel.of(each.scene) for each in drawn]
    figure = Figure(figsize=(WIDTH, 1.0), layout="constrained")
    parts = figure.subfigures(len(drawn), 1, squeeze=False, height_ratios=[each.high for each in panels]).ravel()
    lines = [_draw(*each) for each in zip(parts, drawn, panels, [run, *[None] * (len(drawn) - 1)], strict=True)]
    figure.set_figheight(sum(each.high for each in panels) + LEGEND_LINE * sum(lines))
    add_note(figure, [drawn[0].scene])
    return figure


class _Panel(NamedTuple):
    """Size of the drawing of a scene."""

    limits: tuple[float, float, float, float]  # m
    varying: list[str]  # quantities that vary in space
    high: float  # inch, without the legend

    @classmethod
    def of(cls, scene: Scene) -> _Panel:
        width, height = scene.geometry.width, scene.geometry.height
        thick = scene.walls.layers * scene.numerics.spacing
        reach, below = thick + 0.06 * width, thick + 0.03 * height
        top = height + max(0.12 * height, NAMES * (width + 2 * reach) / (WIDTH - 0.7))
        varying = [quantity for quantity in QUANTITIES if varying_layers(scene, quantity)]
        panel = max((WIDTH - 0.7) * (top + below) / (width + 2 * reach), 0.8)
        return cls((-reach, width + reach, -below, top), varying, panel + 1.0 + (panel + BAR) * len(varying))


def _draw(figure: SubFigure, drawn: Drawn, panel: _Panel, run: Run | None) -> int:
    """Draw a scene; the lines of its legend."""
    scene, particles = drawn.scene, drawn.particles
    layer = particles.layer[: particles.n_soil]
    ax, *maps = figure.subplots(1 + len(panel.varying), squeeze=False).ravel()
    draw_box(ax, scene)
    colours = layer_colours(scene)
    _draw_soil(ax, scene, particles, layer, ListedColormap(colours), BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours)))
    draw_ground(ax, scene)
    draw_seams(ax, scene)
    draw_water(ax, scene)
    failed = [] if run is None else draw_failed(ax, run)
    surfaces = [*failed, *draw_surfaces(ax, drawn.equilibrium)]
    at = {name: (float(particles.x[particle]), float(particles.y[particle])) for name, particle in drawn.probes.items()}
    survey_axes(ax, scene, panel.limits)
    mark_places(ax, scene, at, places=drawn.places)
    draw_places(ax, scene, drawn.places)
    ax.set_title(plain(drawn.name.replace("_", " ") or scene.title or scene.name), loc="left")
    for quantity, below_it in zip(panel.varying, maps, strict=True):
        _draw_strength(below_it, scene, particles, quantity)
        survey_axes(below_it, scene, panel.limits)
    shown = np.unique(layer)
    layer_legend(figure, scene, shown, surfaces)
    return len(scene.soils) + len(surfaces)


def _draw_strength(ax: Axes, scene: Scene, particles: Particles, quantity: str) -> None:
    """Peak cohesion or friction angle of the soil particles in which it varies, with its scale; the others are left blank."""
    text, factor = {"cohesion": ("peak cohesion (kPa)", 1e-3), "friction_angle": ("peak friction angle (degree)", 180.0 / np.pi)}[quantity]
    values = factor * peak_strength(scene, particles)[QUANTITIES.index(quantity), : particles.n_soil]
    values = np.where(np.isin(particles.layer[: particles.n_soil], varying_layers(scene, quantity)), values, np.nan)
    norm = Normalize(np.nanmin(values), np.nanmax(values)) if np.isfinite(values).any() else Normalize(0.0, 1.0)
    draw_box(ax, scene)
    _draw_soil(ax, scene, particles, values, colour_map(), norm)
    draw_ground(ax, scene)
    ax.figure.colorbar(ScalarMappable(norm, colour_map()), ax=ax, label=text, orientation="horizontal", aspect=50, shrink=0.6, pad=0.02)


def _draw_soil(ax: Axes, scene: Scene, particles: Particles, values: np.ndarray, colours: Colormap, norm: Normalize) -> None:
    spacing, n = scene.numerics.spacing, particles.n_soil
    x, y = particles.x[:n], particles.y[:n]
    columns, rows = scene.lattice
    if n <= FEW and columns <= SHOWN_WIDTH:
        draw_circles(ax, x, y, spacing, array=values, cmap=colours, norm=norm, edgecolor="0.3", linewidth=0.1)
        return
    image = np.full((rows, columns), np.nan)
    image[np.round(y / spacing - 0.5).astype(int), np.round(x / spacing - 0.5).astype(int)] = values
    ax.imshow(
        image,
        origin="lower",
        extent=(0, columns * spacing, 0, rows * spacing),
        cmap=colours,
        norm=norm,
        aspect="equal",
        interpolation="none",
    )
