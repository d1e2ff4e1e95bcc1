"""Placing particles: soil on a lattice, the box around it, probes (Secs. 2.4, 3.1 and 4)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene import Scene, Slope

SOIL, BASE, SIDE = 0, 1, 2


class Particles(NamedTuple):
    """Initial particles; the soil comes first, then the walls."""

    x: np.ndarray  # (n,) m
    y: np.ndarray  # (n,) m
    kind: np.ndarray  # (n,) int8: SOIL, BASE, SIDE
    mass: np.ndarray  # (n,) kg for a metre of thickness

    @property
    def n_soil(self) -> int:
        """Number of soil particles."""
        return int(np.count_nonzero(self.kind == SOIL))


def place_particles(scene: Scene) -> Particles:
    """Lattice at half offsets filling the geometry, with boundary layers below and beside it.

    Columns of soil run from wall to wall; the box is as wide as the whole number of columns that fit.
    """
    dx = scene.numerics.spacing
    columns = math.ceil(scene.geometry.width / dx - 0.5 - 1e-9)
    rows = math.ceil(scene.geometry.height / dx - 0.5 - 1e-9)
    column, row = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    inside = _below_surface(scene, (column + 0.5) * dx, (row + 0.5) * dx)
    blocks = [(column[inside], row[inside], SOIL)]

    layers = np.arange(scene.walls.layers)
    with_sides = scene.walls.sides != "none"
    if scene.walls.base != "none":
        overhang = scene.walls.layers if with_sides else 0
        blocks.append((*_grid(np.arange(-overhang, columns + overhang), -1 - layers), BASE))
    if with_sides:
        blocks.append((*_grid(-1 - layers, np.arange(rows)), SIDE))
        blocks.append((*_grid(columns + layers, np.arange(rows)), SIDE))

    x = np.concatenate([(c + 0.5) * dx for c, _, _ in blocks])
    y = np.concatenate([(r + 0.5) * dx for _, r, _ in blocks])
    kind = np.concatenate([np.full(len(c), k, np.int8) for c, _, k in blocks])
    return Particles(x, y, kind, np.full(x.size, scene.soil.density * dx * dx))


def _grid(columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    grid = np.meshgrid(columns, rows, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def _below_surface(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    geometry = scene.geometry
    if not isinstance(geometry, Slope):
        return np.ones(x.size, bool)
    face = (x - geometry.apron_length) * math.tan(math.radians(geometry.slope_angle))
    return (y < geometry.base_depth) | (y - geometry.base_depth <= face)


def locate_probes(scene: Scene, particles: Particles) -> dict[str, int]:
    """Index of the soil particle nearest to each probe's place; ValueError for a place away from the soil."""
    places = {"crest_edge": scene.geometry.crest, "toe": scene.geometry.toe}
    soil_x, soil_y = particles.x[: particles.n_soil], particles.y[: particles.n_soil]
    found = {}
    for name, place in scene.probes.items():
        px, py = places[place] if isinstance(place, str) else place
        distance = np.hypot(soil_x - px, soil_y - py)
        found[name] = int(np.argmin(distance))
        if distance.min() > 2.0 * scene.numerics.spacing:
            raise ValueError(f"probes.{name}: ({px:g}, {py:g}) m lies {distance.min():.3g} m from the nearest soil particle")
    return found
