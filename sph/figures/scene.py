"""A scene before it is run (``sph check``): ground, materials, walls, probes, toe and crest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure

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


@styled
def figure_scene(
    scene: Scene,
    particles: Particles,
    probes: Mapping[str, int],
    places: Mapping[str, PlaceAt] | None = None,
    equilibrium: LimitEquilibrium | None = None,
    run: Run | None = None,
) -> Figure:
    """Soil coloured by the layer of each particle, walls, ground, phreatic line (dashed), toe and crest; ``probes`` are particles.

    Posts stand at the ``places`` of a study that debris may reach, as in ``metrics.places``.  The critical slip surfaces are those of
    ``equilibrium``, the soil that has failed that of a ``run`` of the scene.

    A panel each for cohesion and friction angle follows where they vary in space.
    """
    layer = particles.layer[: particles.n_soil]
    width, height = scene.geometry.width, scene.geometry.height
    thick = scene.walls.layers * scene.numerics.spacing
    reach, below = thick + 0.06 * width, thick + 0.03 * height
    top = height + max(0.12 * height, NAMES * (width + 2 * reach) / (WIDTH - 0.7))
    varying = [quantity for quantity in QUANTITIES if varying_layers(scene, quantity)]
    panel = max((WIDTH - 0.7) * (top + below) / (width + 2 * reach), 0.8)
    high = panel + 1.0 + (panel + BAR) * len(varying)
    figure = Figure(figsize=(WIDTH, high), layout="constrained")
    ax, *maps = figure.subplots(1 + len(varying), squeeze=False).ravel()
    draw_box(ax, scene)
    colours = layer_colours(scene)
    _draw_soil(ax, scene, particles, layer, ListedColormap(colours), BoundaryNorm(np.arange(len(colours) + 1) - 0.5, len(colours)))
    draw_ground(ax, scene)
    draw_seams(ax, scene)
    draw_water(ax, scene)
    failed = [] if run is None else draw_failed(ax, run)
    surfaces = [*failed, *draw_surfaces(ax, equilibrium)]
    figure.set_figheight(high + LEGEND_LINE * (len(scene.soils) + len(surfaces)))
    at = {name: (float(particles.x[particle]), float(particles.y[particle])) for name, particle in probes.items()}
    mark_places(ax, scene, at, before_the_toe=bool(places))
    draw_places(ax, scene, places or {})
    survey_axes(ax, scene, (-reach, width + reach, -below, top))
    ax.set_title(plain(scene.title or scene.name), loc="left")
    for quantity, below_it in zip(varying, maps, strict=True):
        _draw_strength(below_it, scene, particles, quantity)
        survey_axes(below_it, scene, (-reach, width + reach, -below, top))
    layer_legend(figure, scene, np.unique(layer), surfaces)
    add_note(figure, [scene])
    return figure


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
