"""A scene before it is run (``sph check``): ground, materials, walls, probes, toe and crest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from sph.figures.arrangement import LEGEND_LINE, draw_box, draw_ground, layer_colours, layer_legend, mark_places
from sph.figures.profile import draw_circles, survey_axes
from sph.figures.style import WIDTH, add_note, plain, styled
from sph.scene.schema import Scene
from sph.solver.particles import Particles

FEW = 4000
"""Soil particles up to which each is drawn; more are an image of the lattice."""
SHOWN_WIDTH = 600
"""Columns of the lattice up to which particles are drawn, for they would be smaller than a line."""


@styled
def figure_scene(scene: Scene, particles: Particles, probes: Mapping[str, int]) -> Figure:
    """Soil coloured by the layer of each particle, walls, ground, toe and crest; ``probes`` are particles."""
    layer = particles.layer[: particles.n_soil]
    width, height = scene.geometry.width, scene.geometry.height
    thick = scene.walls.layers * scene.numerics.spacing
    reach, below, top = thick + 0.06 * width, thick + 0.03 * height, 1.12 * height
    high = max((WIDTH - 0.7) * (top + below) / (width + 2 * reach), 0.8) + 1.0 + LEGEND_LINE * len(scene.soils)
    figure = Figure(figsize=(WIDTH, high), layout="constrained")
    ax = figure.subplots()
    draw_box(ax, scene)
    colours = layer_colours(scene)
    _draw_soil(ax, scene, particles, layer, ListedColormap(colours), BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours)))
    draw_ground(ax, scene)
    mark_places(ax, scene, {name: (float(particles.x[particle]), float(particles.y[particle])) for name, particle in probes.items()})
    survey_axes(ax, scene, (-reach, width + reach, -below, top))
    ax.set_title(plain(scene.title or scene.name), loc="left")
    layer_legend(figure, scene, np.unique(layer))
    add_note(figure, [scene])
    return figure


def _draw_soil(ax: Axes, scene: Scene, particles: Particles, layer: np.ndarray, colours: ListedColormap, norm: BoundaryNorm) -> None:
    spacing, n = scene.numerics.spacing, particles.n_soil
    x, y = particles.x[:n], particles.y[:n]
    columns, rows = scene.lattice
    if n <= FEW and columns <= SHOWN_WIDTH:
        draw_circles(ax, x, y, spacing, array=layer, cmap=colours, norm=norm, edgecolor="0.3", linewidth=0.1)
        return
    image = np.full((rows, columns), np.nan)
    image[np.round(y / spacing - 0.5).astype(int), np.round(x / spacing - 0.5).astype(int)] = layer
    ax.imshow(
        image,
        origin="lower",
        extent=(0, columns * spacing, 0, rows * spacing),
        cmap=colours,
        norm=norm,
        aspect="equal",
        interpolation="none",
    )
