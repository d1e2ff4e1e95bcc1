"""Placing particles: soil on a lattice, the box around it, probes (Secs. 2.4, 3.1 and 4)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.geometry import Bodies
from sph.scene.layers import layer_at
from sph.scene.places import ABOVE, RIGHT, shifted
from sph.scene.schema import Scene
from sph.scene.uncertain import Variable
from sph.scene.walls import Kind

SOIL, BASE, SIDE, TOP = 0, 1, 2, 3
QUANTITIES = ("cohesion", "friction_angle")
"""What ``peak_strength`` has, in order."""
PARTS = 4
HALVINGS = 40
"""Parts of a spacing in which the weight of layers is summed."""


class Particles(NamedTuple):
    """Initial particles; the soil comes first, then the walls."""

    x: np.ndarray  # (n,) m
    y: np.ndarray  # (n,) m
    kind: np.ndarray  # (n,) int8: SOIL, BASE, SIDE, TOP
    mass: np.ndarray  # (n,) kg for a metre of thickness
    layer: np.ndarray  # (n,) int: 0 for the scene's own soil, k for its k-th layer
    first_no_slip: int  # from this one on no-slip walls
    first_contact: int  # from this one on contact walls, which are no-slip walls that soil may leave
    first_slip: int  # from this one on free-slip base and top
    first_slip_side: int  # from this one on free-slip side walls
    first_fixed: int  # from this one on walls that stand still; boundary particles before it follow the soil

    @property
    def n_soil(self) -> int:
        """Number of soil particles."""
        return int(np.count_nonzero(self.kind == SOIL))


def place_particles(scene: Scene) -> Particles:
    """Lattice at half offsets filling the geometry, with boundary layers below, beside and above it.

    Columns of soil run from wall to wall; the box is as wide as the whole number of columns that fit.  Absorbing walls come
    first after the soil, their sides as high as the ground beside them, and free-slip walls last, base and top before sides.
    """
    dx = scene.numerics.spacing
    columns, rows = scene.lattice
    column, row = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    inside = _inside(scene, (column + 0.5) * dx, (row + 0.5) * dx)
    soil = [(column[inside], row[inside], SOIL)]
    if not soil[0][0].size:
        raise ValueError(f"geometry: holds no particle of the lattice with numerics.spacing: {dx:g} m")

    walls = scene.walls
    layers = np.arange(walls.layers)
    base, sides, top = walls.kinds
    overhang = walls.layers if sides.has_particles else 0
    left, right = (_ground(scene, row[inside & (column == c)]) for c in (0, columns - 1))
    whole_width = np.arange(-overhang, columns + overhang)
    wanted: list[tuple[Kind, tuple[np.ndarray, np.ndarray, int]]] = [
        (base, (*_grid(whole_width, -1 - layers), BASE)),
        (top, (*_grid(whole_width, rows + layers), TOP)),
        (sides, (*_grid(-1 - layers, left), SIDE)),
        (sides, (*_grid(columns + layers, right), SIDE)),
    ]
    absorbing = [block for kind, block in wanted if kind.absorbs]
    fixed = [block for kind, block in wanted if kind.holds_soil and not kind.reflects]
    no_slip = [block for kind, block in wanted if kind.reflects and not kind.unilateral]
    contact = [block for kind, block in wanted if kind.unilateral]
    slip = [block for kind, block in wanted[:2] if kind.slips]
    slip_sides = [block for kind, block in wanted[2:] if kind.slips]
    first_fixed = sum(len(c) for c, _, _ in soil + absorbing)
    first_no_slip = first_fixed + sum(len(c) for c, _, _ in fixed)
    first_contact = first_no_slip + sum(len(c) for c, _, _ in no_slip)
    first_slip = first_contact + sum(len(c) for c, _, _ in contact)
    first_slip_side = first_slip + sum(len(c) for c, _, _ in slip)
    blocks = soil + absorbing + fixed + no_slip + contact + slip + slip_sides

    x = np.concatenate([(c + 0.5) * dx for c, _, _ in blocks])
    y = np.concatenate([(r + 0.5) * dx for _, r, _ in blocks])
    kinds = np.concatenate([np.full(len(c), k, np.int8) for c, _, k in blocks])
    layer = layer_index(scene, x, y)
    mass = np.array([soil.density * dx * dx for soil in scene.soils])[layer]
    return Particles(x, y, kinds, mass, layer, first_no_slip, first_contact, first_slip, first_slip_side, first_fixed)


def layer_index(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Layer (n,) at places (n,): 0 is the scene's own soil, k its k-th layer.  Walls go on as the soil beside them."""
    return layer_at(scene, *_in_soil(scene, x, y))


def _in_soil(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (n,) in the soil, for those of walls beside them, and heights (n,) of the ground there, m."""
    half = 0.5 * scene.numerics.spacing
    x, y = shifted(np.clip(x, half, scene.geometry.width - half), np.maximum(y, half), *_lattice(scene))
    ground = scene.geometry.ground(x)
    return x, np.minimum(y, np.maximum(ground - ABOVE * scene.numerics.spacing, half)), ground


def peak_strength(scene: Scene, particles: Particles) -> np.ndarray:
    """Cohesion (Pa) and friction angle (rad) of each particle's solid state (2, n), growth with depth and random fields included."""
    return strength_at(scene, particles.x, particles.y, particles.layer, particles.n_soil)


def strength_at(scene: Scene, x0: np.ndarray, y0: np.ndarray, layer: np.ndarray, n_soil: int) -> np.ndarray:
    """The same (2, n) of particles that began at places (n,), m, in these layers (n,), of which the first ``n_soil`` are soil.

    A random field multiplies the strength that has grown.
    """
    strength = np.array([[soil.cohesion_si, soil.friction_angle_si] for soil in scene.soils]).T[:, layer]
    if not scene.strength_varies:
        return strength
    x, y, ground = _in_soil(scene, x0, y0)
    soil = slice(0, n_soil)  # not held off the sides, by a distance that depends on the spacing
    x[soil], y[soil] = shifted(x0[soil], y0[soil], *_lattice(scene))
    for number, its in enumerate(scene.soils):
        there = layer == number
        if its.gradient:
            strength[0, there] += 1e3 * its.gradient * _depth(scene, number, x[there], y[there], ground[there])
    if scene.uncertain is not None and scene.varying:
        ratios = scene.uncertain.ratios(*scene.geometry.in_survey(x, y))
        for variable in scene.varying:
            there = layer == varying_layer(scene, variable)
            strength[QUANTITIES.index(variable.quantity), there] *= ratios[variable.of][there]
    return strength


def _depth(scene: Scene, number: int, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Depth (n,) at which the cohesion of a soil is asked for at places (n,) in it, below a ground (n,), m; never negative."""
    growth = scene.soils[number].cohesion_growth
    assert growth is not None
    places, top = scene.geometry.in_survey(x, y), scene.geometry.in_survey(x, ground)[1]
    if growth.datum is not None:
        top = np.full(x.shape, growth.datum)
    elif number > 0:
        top = list(scene.layers.values())[number - 1].region.upper_side(*places, top)
    elif scene.layers:
        columns, first, of = np.unique(places[0], return_index=True, return_inverse=True)
        top = _below_layers(scene, columns, top[first])[of]
    return np.maximum(top - places[1], 0.0)


def _below_layers(scene: Scene, x: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Elevation (n,) of the top of the scene's own soil, under the layers on it, at x (n,) of the survey, below a ground (n,), m."""

    def layered(y: np.ndarray) -> np.ndarray:
        return np.any([layer.region.contains(x, y, ground) for layer in scene.layers.values()], axis=0)

    step, base = scene.numerics.spacing / PARTS, scene.geometry.in_survey(0.0, 0.0)[1]
    top, covered, y = ground.copy(), np.ones(x.shape, bool), ground - 0.5 * step
    while covered.any() and (y > base).any():
        covered &= layered(y)
        top[covered], y = y[covered], y - step
    bottom = np.where(top < ground, top - step, top)
    for _ in range(HALVINGS):
        middle = 0.5 * (top + bottom)
        inside = layered(middle)
        top, bottom = np.where(inside, middle, top), np.where(inside, bottom, middle)
    return bottom


def varying_layers(scene: Scene, quantity: str) -> list[int]:
    """Numbers of the layers in which a strength varies from place to place; 0 for the scene's own soil."""
    random = [varying_layer(scene, variable) for variable in scene.varying if variable.quantity == quantity]
    growing = [number for number, soil in enumerate(scene.soils) if quantity == "cohesion" and soil.gradient]
    return sorted({*random, *growing})


def varying_layer(scene: Scene, variable: Variable) -> int:
    """Number of the layer whose strength a variable is; 0 for the scene's own soil."""
    return 0 if variable.layer is None else 1 + list(scene.layers).index(variable.layer)


def overburden(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mass of soil (n,) above places (n,), kg/m2; through layers it is summed over parts no longer than a quarter of the spacing."""
    depth = np.maximum(scene.geometry.ground(x + (RIGHT + scene.numerics.lattice_shift) * scene.numerics.spacing) - y, 0.0)
    if not scene.layers:
        return scene.soil.density * depth
    parts = PARTS * max(1, math.ceil(depth.max(initial=0.0) / scene.numerics.spacing))
    density = np.array([soil.density for soil in scene.soils])
    total = np.zeros(x.size)
    for part in range(parts):
        total += density[layer_index(scene, x, y + depth * (part + 0.5) / parts)]
    return total * depth / parts


def _ground(scene: Scene, soil: np.ndarray) -> np.ndarray:
    """Rows of a side wall: all of the box, or those of the soil beside an absorbing one; ValueError if that is not one whole column."""
    if not scene.walls.kinds.sides.absorbs:
        return np.arange(scene.lattice[1])
    if not soil.size or soil.size <= soil.max():
        raise ValueError("walls.sides: absorbing needs soil at both sides, from the base to the ground without a gap (geometry)")
    return np.arange(soil.size)


def _lattice(scene: Scene) -> tuple[float, float]:
    """Spacing of the lattice, m, and its shift in spacings."""
    return scene.numerics.spacing, scene.numerics.lattice_shift


def _grid(columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    grid = np.meshgrid(columns, rows, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def _inside(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    geometry, (x, y) = scene.geometry, shifted(x, y, *_lattice(scene))
    if isinstance(geometry, Bodies):
        return np.any([body.contains(x, y) for body in geometry.bodies], axis=0)
    return y < geometry.ground(x)


def locate_probes(scene: Scene, particles: Particles) -> dict[str, int]:
    """Index of the soil particle nearest to each probe's place; ValueError for a place away from the soil."""
    places = {"crest_edge": scene.geometry.crest, "toe": scene.geometry.toe}
    soil_x, soil_y = shifted(particles.x[: particles.n_soil], particles.y[: particles.n_soil], *_lattice(scene))
    found = {}
    for name, place in scene.probes.items():
        px, py = places[place] if isinstance(place, str) else scene.geometry.in_box(*place)
        distance = np.hypot(soil_x - px, soil_y - py)
        found[name] = int(np.argmin(distance))
        if distance.min() > 2.0 * scene.numerics.spacing:
            px, py = scene.geometry.in_survey(px, py)
            raise ValueError(f"probes.{name}: ({px:g}, {py:g}) m lies {distance.min():.3g} m from the nearest soil particle")
    return found
