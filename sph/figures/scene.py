"""A scene before it is run (``sph check``): ground, materials, walls, probes, toe and crest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from sph.figures.arrangement import SOIL_COLOUR, draw_box, draw_ground, mark_slope
from sph.figures.profile import draw_circles, mark_place, survey_axes
from sph.figures.style import WIDTH, add_note, colour_map, plain, styled
from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene
from sph.solver.particles import Particles

FEW = 4000
"""Soil particles up to which each is drawn; more are an image of the lattice."""
SHOWN_WIDTH = 600
"""Columns of the lattice up to which particles are drawn, for they would be smaller than a line."""


@styled
def figure_scene(scene: Scene, particles: Particles, probes: Mapping[str, int]) -> Figure:
    """Soil coloured by the layer of each particle, walls, ground, toe and crest; ``probes`` are particles."""
    layer, names = particles.layer[: particles.n_soil], ("soil", *scene.layers)
    width, height = scene.geometry.width, scene.geometry.height
    thick = scene.walls.layers * scene.numerics.spacing
    reach, below, top = thick + 0.06 * width, thick + 0.03 * height, 1.12 * height
    figure = Figure(figsize=(WIDTH, max((WIDTH - 0.7) * (top + below) / (width + 2 * reach), 0.8) + 1.1), layout="constrained")
    ax = figure.subplots()
    draw_box(ax, scene)
    present = np.unique(layer)
    others = len(names) - 1
    colours = ListedColormap([to_rgba(SOIL_COLOUR), *(colour_map()(0.15 + 0.5 * n / max(others - 1, 1)) for n in range(others))])
    _draw_soil(ax, scene, particles, layer, colours, BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names)))
    draw_ground(ax, scene)
    if isinstance(scene.geometry, SLOPES):
        mark_slope(ax, scene.geometry)
    for name, particle in probes.items():
        mark_place(ax, name, float(particles.x[particle]), float(particles.y[particle]))
    ax.set(xlim=(-reach, width + reach), ylim=(-below, top), xlabel="horizontal position (m)")
    ax.set_aspect("equal")
    survey_axes(ax, scene)
    ax.set_title(plain(scene.title or scene.name), loc="left")
    handles = [Patch(facecolor=colours(int(number)), edgecolor="0.3", linewidth=0.4, label=plain(names[number])) for number in present]
    figure.legend(handles=handles, loc="outside upper right", ncols=4)
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
