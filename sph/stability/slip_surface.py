"""Slip surfaces in a scene, and the slices above them: strength, weight and water from the scene's own ground, layers, seams and water.

Water that stands before the toe enters as Bishop (1955) takes it: below its level the soil is weighed less its buoyancy, and the pore
pressure counts beyond that of this water.  A slope under water then has the factor of a dry one of the buoyant weight, whatever the method.
Other standing water is a load on the ground.

A surface begins on the ground at the left, where the soil comes out, and ends on the ground at the right.  Ends are given by their way
along the ground from its left end (m), so that a vertical face has places too.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from sph.scene.gravity import FAILED_AREA
from sph.scene.layers import DepthRegion, ElevationRegion, Region
from sph.scene.places import ABOVE, shifted
from sph.scene.schema import Scene
from sph.solver.particles import strength_at
from sph.stability.limit_equilibrium import Slices
from sph.stability.standing import slope_height

POINTS = np.array([-0.375, -0.125, 0.125, 0.375])
"""Places on a base, from its middle, at which its strength is taken where a base may lie in several soils."""
COLUMNS, PARTS = 400, 200
"""Columns, and parts of their height, in which layers are weighed."""
NEAR = 1e-6
"""Part of H that is nothing."""
INSIDE = 1e-3
"""Part of the thickness of a layer by which a surface along its lower side lies above that."""
SHORTEST, SHALLOW = 0.01, 8
"""Length over H of a guide, at least, and the places on it nearest below the ground at which surfaces join and leave it, at most."""
STEEPEST = np.tan(np.radians([-60.0, 88.0]))
"""Gradients between which bases lie."""


class Edges(NamedTuple):
    """Surfaces as the ends of the bases of their slices, in the box."""

    x: np.ndarray
    """(surfaces, slices + 1) m, from the toe's side to the crest's"""
    y: np.ndarray
    """(surfaces, slices + 1) m"""
    seam: np.ndarray
    """(surfaces, slices) number of the seam along which a base lies, from 1 on; 0 in the soil; -1 - n along the lower side of soil n"""

    def divided(self, parts: int) -> Edges:
        """The same surfaces with so many slices for each."""
        return Edges(_divided(self.x, parts), _divided(self.y, parts), np.repeat(self.seam, parts, axis=1))


class Section(NamedTuple):
    """What slices need of a scene."""

    scene: Scene
    x: np.ndarray  # corners of the ground, m
    y: np.ndarray
    way: np.ndarray  # along the ground to them, m
    toe: float  # way to the toe, m
    crest: float
    height: float  # of the slope, m
    level: float  # of the water that stands before the toe, m; -inf without
    surplus: np.ndarray  # (COLUMNS, PARTS + 1, 2) density beyond the own soil's above a part's lower end, and its first moment

    @classmethod
    def of(cls, scene: Scene) -> Section:
        """The section of a scene with a slope."""
        geometry = scene.geometry
        x, y = (np.array(side) for side in geometry.surface)
        way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        toe, crest = (_way_to(place, x, y, way) for place in (geometry.toe, geometry.crest))
        level, water = -np.inf, scene.water
        if water is not None and water.r_u is None:
            at_toe = float(water.surface(geometry, np.array([geometry.toe[0]]))[0])
            level = at_toe if at_toe > geometry.toe[1] else -np.inf
        surplus = np.zeros((0, 0, 2))
        if scene.layers:
            column = (np.arange(COLUMNS) + 0.5) * geometry.width / COLUMNS
            top = np.interp(column, x, y)
            part = (np.arange(PARTS) + 0.5) / PARTS
            place = np.repeat(column, PARTS), (top[:, None] * part).ravel()
            layers = _layer_at(scene, *place).reshape(COLUMNS, PARTS)
        if len({soil.density for soil in scene.soils}) > 1:
            density = np.array([soil.density - scene.soil.density for soil in scene.soils])[layers] * top[:, None] / PARTS
            moment = density * top[:, None] * part
            below = np.pad(np.stack([density, moment], axis=-1), ((0, 0), (0, 1), (0, 0)))
            surplus = np.cumsum(below[:, ::-1], axis=1)[:, ::-1]
        return cls(scene, x, y, way, toe, crest, slope_height(scene), level, surplus)

    def ground(self, x: np.ndarray) -> np.ndarray:
        """Height of the ground at places of any shape, m."""
        height: np.ndarray = np.interp(x, self.x, self.y)
        return height

    def crack(self, way: float, factor: float) -> float:
        """Depth to which the soil at a place on the ground is in tension with its strength divided by a factor, m.

        2 c tan(45 + phi/2) / gamma (Rankine); at most half the slope's height (Terzaghi 1943).
        """
        x, y = self.place(np.array([[[way]]]))
        y = y - NEAR * self.height
        cohesion, friction, _ = self._strength(x, y, np.zeros((1, 1), int))
        layer = int(_layer_at(self.scene, x[0, 0], y[0, 0])[0])
        weight = self.scene.soils[layer].density * self.scene.gravity.acceleration
        tangent = friction[0, 0] / factor
        return min(float(2.0 * cohesion[0, 0] / factor * (tangent + np.hypot(1.0, tangent)) / weight), 0.5 * self.height)

    def place(self, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places x and y on the ground, m, by the way to them."""
        return np.interp(way, self.way, self.x), np.interp(way, self.way, self.y)

    def possible(self, edges: Edges) -> np.ndarray:
        """Which surfaces (n,) run from left to right between the ground and the base, below as much soil as a slope that has failed."""
        tolerance = NEAR * self.height
        ground = self.ground(edges.x[:, 1:-1])
        within = (edges.y >= -tolerance).all(axis=1) & (edges.y[:, 1:-1] <= ground + tolerance).all(axis=1)
        width, rise = np.diff(edges.x, axis=1), np.diff(edges.y, axis=1)
        forwards = (width >= -tolerance) & (rise >= STEEPEST[0] * width - tolerance) & (rise <= STEEPEST[1] * width + tolerance)
        depth = self.ground(edges.x[:, :-1] + 0.5 * width) - edges.y[:, :-1] - 0.5 * rise
        area = (depth * width).sum(axis=1)
        sound: np.ndarray = within & forwards.all(axis=1) & (area >= FAILED_AREA * self.height**2)
        return sound

    def slices(self, edges: Edges) -> Slices:
        """The slices above surfaces."""
        scene, gravity = self.scene, self.scene.gravity.acceleration
        width, rise = np.diff(edges.x, axis=1), np.diff(edges.y, axis=1)
        x, y = edges.x[:, :-1] + 0.5 * width, edges.y[:, :-1] + 0.5 * rise
        chord = np.arctan2(rise.sum(axis=1, keepdims=True), width.sum(axis=1, keepdims=True))
        inclination = np.where(width > NEAR * self.height, np.arctan2(rise, width), chord)
        top = self.ground(x)
        mass, moment = self._above(x, y, top)
        unit = 0.0 if scene.water is None else 1e3 * scene.water.unit_weight
        drowned = unit * np.maximum(np.minimum(top, self.level) - y, 0.0)
        parts = POINTS if scene.layers or scene.varying else np.zeros(1)
        cohesion, friction, ratio = self._strength(
            x[..., None] + width[..., None] * parts, y[..., None] + rise[..., None] * parts, edges.seam
        )
        pressure, load = np.zeros(x.shape), np.zeros((*x.shape, 2))
        if scene.water is not None and scene.water.r_u is None:
            line = scene.water.surface(scene.geometry, x.ravel()).reshape(x.shape)
            pressure = unit * (np.maximum(line - y, 0.0) - np.maximum(self.level - y, 0.0))
            press = unit * (np.maximum(line - top, 0.0) - np.maximum(self.level - top, 0.0))
            load = press[..., None] * np.stack([np.diff(self.ground(edges.x), axis=1), -width], axis=-1)
        elif scene.water is not None:
            pressure = ratio * gravity * mass
        return Slices(
            x=x,
            y=y,
            width=width,
            inclination=inclination,
            weight=width * (gravity * mass - drowned),
            full_weight=width * gravity * mass,
            centroid=moment / np.maximum(mass, 1e-9) - y,
            cohesion=cohesion,
            friction=friction,
            pressure=pressure,
            load=load,
            height=top - y,
        )

    def _above(self, x: np.ndarray, y: np.ndarray, top: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mass of soil above places, kg/m2, and its first moment in height, kg/m."""
        density = self.scene.soil.density
        mass, moment = density * (top - y), 0.5 * density * (top**2 - y**2)
        if not self.surplus.size:
            return mass, moment
        column = np.clip(x / self.scene.geometry.width * COLUMNS, 0.0, COLUMNS - 1.0).astype(int)
        part = np.clip(y / np.maximum(top, 1e-9), 0.0, 1.0) * PARTS
        j = np.minimum(part.astype(int), PARTS - 1)
        low, high = self.surplus[column, j], self.surplus[column, j + 1]
        more = low + (part - j)[..., None] * (high - low)
        return mass + more[..., 0], moment + more[..., 1]

    def _strength(self, x: np.ndarray, y: np.ndarray, seam: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Means of peak cohesion (Pa), tan(phi) and r_u over places (surfaces, slices, places) on bases along seams (surfaces, slices)."""
        scene, at, n = self.scene, _particle(self.scene, x.ravel()), x.size
        layer = _layer_at(scene, x.ravel(), y.ravel()) if scene.layers else np.zeros(n, int)
        layer = np.where(seam[..., None] < 0, -1 - seam[..., None], layer.reshape(x.shape)).ravel()
        cohesion, angle = strength_at(scene, at, y.ravel(), layer, n)
        cohesion, friction, ratio = (each.reshape(x.shape).mean(axis=-1) for each in (cohesion, np.tan(angle), _ratios(scene)[layer]))
        for number, own in enumerate(scene.seams.values(), 1):
            cohesion, friction = (np.where(seam == number, *pair) for pair in zip(own.peak, (cohesion, friction), strict=True))
        return cohesion, friction, ratio


def _particle(scene: Scene, x: np.ndarray) -> np.ndarray:
    """Places (n,) of particles, over whose lattice the shape may be shifted, from those of the shape, m."""
    return x - scene.numerics.lattice_shift * scene.numerics.spacing


def _ratios(scene: Scene) -> np.ndarray:
    """r_u of the scene's own soil and of its layers."""
    return np.array([material.r_u for material in scene.materials])


def _layer_at(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Layer (n,) at places (n,) in the box, m; as that of particles, but also where none lies, within half a spacing of base and sides."""
    spacing, geometry = scene.numerics.spacing, scene.geometry
    x, y = shifted(x, y, spacing)
    ground = geometry.ground(x)
    places = geometry.in_survey(x, np.minimum(y, np.maximum(ground - ABOVE * spacing, 0.0)))
    index = np.zeros(x.shape, int)
    for number, layer in enumerate(scene.layers.values(), 1):
        index[layer.region.contains(*places, geometry.in_survey(x, ground)[1])] = number
    return index


def soil_along(scene: Scene, x: np.ndarray, y: np.ndarray) -> int:
    """Number of the soil in which most of a line through places (points,) lies, m."""
    at = [np.interp(np.arange(x.size * PARTS) / PARTS, np.arange(x.size), along) for along in (x, y)]
    middle = [0.5 * (along[1:] + along[:-1]) for along in at]
    return int(np.bincount(_layer_at(scene, *middle), weights=np.hypot(*(np.diff(along) for along in at))).argmax())


def _strata(section: Section, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heights (n, k + 1) of the sides of all layers in columns at places x (n,), from the base to the ground, m; the layer (n, k) between
    each two."""
    geometry, ground = section.scene.geometry, section.ground(x)
    away, datum = geometry.in_survey(x, np.zeros(x.shape))
    sides = [side for layer in section.scene.layers.values() for side in sides_of(layer.region, away, ground, datum)]
    sides = [0.0 * ground, ground, *map(np.nan_to_num, sides)]
    edges = np.sort(np.clip(sides, 0.0, ground).T, axis=1)
    edges = edges[:, max(edges.shape[1] - 1 - int((edges > 0.0).sum(axis=1).max()), 0) :]
    middle = 0.5 * (edges[:, :-1] + edges[:, 1:])
    return edges, _layer_at(section.scene, np.repeat(x, middle.shape[1]), middle.ravel()).reshape(middle.shape)


def sides_of(region: Region, x: np.ndarray, ground: np.ndarray, datum: np.ndarray | float = 0.0) -> list[np.ndarray]:
    """Heights (n,) over a datum at which a region begins or ends, at places x (n,) in the survey, m; NaN where a side of a polygon is not.

    The ``ground`` (n,) is given over the datum.
    """
    if isinstance(region, DepthRegion):
        return [ground - depth for depth in (region.top, region.bottom) if depth is not None]
    if isinstance(region, ElevationRegion):
        return [np.full_like(x, height) - datum for height in (region.bottom, region.top) if height is not None]
    sides = []
    for (x1, y1), (x2, y2) in zip(region.outline, np.roll(region.outline, -1, axis=0), strict=True):
        if x1 != x2:
            share = (x - x1) / (x2 - x1)
            sides.append(np.where((share >= 0.0) & (share <= 1.0), y1 + share * (y2 - y1) - datum, np.nan))
    return sides


def _way_to(place: tuple[float, float], x: np.ndarray, y: np.ndarray, way: np.ndarray) -> float:
    """Way along the ground to the nearest place on it, m."""
    start, step = np.column_stack([x, y])[:-1], np.column_stack([np.diff(x), np.diff(y)])
    length = np.maximum(np.hypot(*step.T), 1e-12)
    share = np.clip(((np.array(place) - start) * step).sum(axis=1) / length**2, 0.0, 1.0)
    distance = np.hypot(*(start + share[:, None] * step - np.array(place)).T)
    nearest = int(np.argmin(distance))
    return float(way[nearest] + share[nearest] * length[nearest])


def circles(section: Section, given: np.ndarray, slices: int) -> tuple[Edges, np.ndarray]:
    """Arcs of circles and their centres (n, 2), m, by the ways to their ends (m) and half the angle of the arc (rad), (n, 3).

    An arc that would pass below the base touches it instead.
    """
    (left, low), (right, high) = section.place(given[:, 0]), section.place(given[:, 1])
    length, chord = np.hypot(right - left, high - low), np.arctan2(high - low, right - left)
    above = (low + high) / np.maximum(length, 1e-12)  # of the middle of the chord over the base, by half the chord
    touching = 2.0 * np.arctan((above + np.sqrt(np.maximum(above**2 - np.sin(chord) ** 2, 0.0))) / np.maximum(1.0 + np.cos(chord), 1e-12))
    half = np.maximum(np.minimum(given[:, 2], touching), 1e-6)
    radius = 0.5 * length / np.sin(half)
    angle = chord[:, None] + half[:, None] * np.linspace(-1.0, 1.0, slices + 1)
    up = radius * np.cos(half)
    centre = np.column_stack([0.5 * (left + right) - up * np.sin(chord), 0.5 * (low + high) + up * np.cos(chord)])
    x, y = centre[:, :1] + radius[:, None] * np.sin(angle), centre[:, 1:] - radius[:, None] * np.cos(angle)
    steep = angle[:, -1] > 0.5 * np.pi
    return Edges(x, np.where(steep[:, None], np.nan, y), np.zeros((len(x), slices), int)), centre


VERTICES = np.array([0.05, 0.14, 0.26, 0.4, 0.55, 0.7, 0.85])
"""Of a convex line, parts of its width."""
CORNERS = np.concatenate([[0.0], VERTICES, [1.0]])
"""These and its ends."""


def lines(section: Section, given: np.ndarray, parts: int) -> Edges:
    """Convex lines by the ways to their ends (m), the depth of a crack at the right one (m), and by how much their gradient grows at the
    ``VERTICES`` (n, 3 + vertices)."""
    (left, low), (right, high) = section.place(given[:, 0]), section.place(given[:, 1])
    width, high = right - left, high - given[:, 2]
    sag = np.minimum(CORNERS[:, None], VERTICES) * (1.0 - np.maximum(CORNERS[:, None], VERTICES))
    x = left[:, None] + width[:, None] * CORNERS
    y = low[:, None] + (high - low)[:, None] * CORNERS - width[:, None] * (given[:, 3:] @ sag.T)
    x, y = (_divided(each, parts) for each in (x, y))
    return Edges(x, y, np.zeros((len(x), x.shape[1] - 1), int))


def as_lines(section: Section, edges: Edges, ways: np.ndarray, cracks: np.ndarray) -> np.ndarray:
    """What ``lines`` takes for convex surfaces that begin at ways (n,), m, each ended where it is as deep as each of some cracks, m."""
    made = []
    for x, y, way in zip(edges.x, edges.y, ways, strict=True):
        depth = section.ground(x) - y
        for crack in cracks:
            last = int(np.flatnonzero(depth >= crack)[-1]) if (depth >= crack).any() else int(depth.argmax())
            after = min(last + 1, x.size - 1)
            share = (depth[last] - crack) / max(depth[last] - depth[after], 1e-12)
            end = float(x[last] + np.clip(share, 0.0, 1.0) * (x[after] - x[last])) if crack > 0.0 else float(x[-1])
            corners = x[0] + (end - x[0]) * CORNERS
            gradient = np.diff(np.interp(corners, x, y)) / np.diff(corners)
            way_to_end = float(np.interp(end, section.x, section.way))
            made.append(np.concatenate([[way, way_to_end, crack], np.maximum(np.diff(gradient), 0.0)]))
    return np.array(made)


class Guide(NamedTuple):
    """A line in the soil along which a surface may run, from left to right."""

    name: str
    seam: np.ndarray  # (n - 1,) as in ``Edges``, between each two places
    x: np.ndarray  # (n,) m
    y: np.ndarray  # m
    nodes: np.ndarray = np.zeros(
        0
    )  # places x at which a surface may have to join or leave it: its ends, where it meets the ground or a seam

    def seam_at(self, x: np.ndarray) -> np.ndarray:
        """Number of the seam at places x, m."""
        number: np.ndarray = self.seam[np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, self.seam.size - 1)]
        return number


def along(section: Section, guide: Guide, given: np.ndarray, parts: int) -> Edges:
    """Lines that run along a guide and on both sides through the soil to the ground.

    By the ways to both ends (m), the depth of a crack at the right one (m), the places x at which the line joins and leaves the guide (m),
    and by how much the gradient grows in the middle of the two other parts (n, 7).
    """
    (left, low), (right, high) = section.place(given[:, 0]), section.place(given[:, 1])
    high, join, leave = high - given[:, 2], given[:, 3], given[:, 4]
    at_join, at_leave = (np.interp(x, guide.x, guide.y) for x in (join, leave))
    share = np.linspace(0.0, 1.0, 2 * parts + 1)
    x = join[:, None] + (leave - join)[:, None] * share
    y = np.interp(x, guide.x, guide.y)

    def wedge(x1: np.ndarray, y1: np.ndarray, x2: np.ndarray, y2: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        middle = 0.5 * (y1 + y2) - 0.25 * bend * (x2 - x1)
        return _divided(np.column_stack([x1, 0.5 * (x1 + x2), x2]), parts), _divided(np.column_stack([y1, middle, y2]), parts)

    first, last = wedge(left, low, join, at_join, given[:, 5]), wedge(leave, at_leave, right, high, given[:, 6])
    on_it = guide.seam_at(0.5 * (x[:, :-1] + x[:, 1:]))
    beside = np.zeros_like(on_it)
    x, y = (np.column_stack([a[:, :-1], b, c[:, 1:]]) for a, b, c in zip(first, (x, y), last, strict=True))
    return Edges(x, y, np.column_stack([beside, on_it, beside]))


def _divided(corners: np.ndarray, parts: int) -> np.ndarray:
    """Each stretch between corners (n, corners) in so many equal parts (n, parts (corners - 1) + 1)."""
    share = np.arange(parts) / parts
    between = corners[:, :-1, None] + np.diff(corners, axis=1)[..., None] * share
    return np.column_stack([between.reshape(len(corners), -1), corners[:, -1]])


def guides(section: Section) -> list[Guide]:
    """The seams, and the lower sides of soils where a stronger one lies below, as far as each lies in the soil."""
    scene, kept = section.scene, list[Guide]()
    for joint in _chained(_joints(scene), scene.numerics.spacing):
        kept += _within(
            section, joint._replace(name=f"along the {'seams' if joint.seam.min() < joint.seam.max() else 'seam'} {joint.name}")
        )
    if not scene.layers:
        return kept
    column = np.unique([*(np.arange(COLUMNS) + 0.5) * scene.geometry.width / COLUMNS, *section.x])
    edges, layers = _strata(section, column)
    thick, contact = np.diff(edges, axis=1), np.zeros(layers.shape, bool)
    weaker, below = _weaker(scene), np.full(column.size, -1)
    for k, here in enumerate((thick > NEAR * section.height).T):
        contact[:, k] = here & weaker[layers[:, k], below]
        below = np.where(here, layers[:, k], below)
    for number, name in enumerate(("", *scene.layers)):
        there = contact & (layers == number)
        crossed = np.flatnonzero(there.any(axis=1))
        at = crossed, layers.shape[1] - 1 - there[crossed, ::-1].argmax(axis=1)  # the uppermost
        x, y = column[crossed], edges[at] + INSIDE * thick[at]
        apart = (np.diff(crossed) > 1) | (np.abs(np.diff(y)) > STEEPEST[1] * np.diff(x))
        words = f"along the layer {name}" if name else "along the scene's own soil"
        for run in np.split(np.arange(x.size), np.flatnonzero(apart) + 1):
            if run.size > 1:
                # A column further, since the soil may come out of the ground there.
                line = [np.pad(side[run], 1, mode="reflect", reflect_type="odd") for side in (x, y)]
                kept += _within(section, Guide(words, np.full(run.size + 1, -1 - number), *line))
    return kept


def _weaker(scene: Scene) -> np.ndarray:
    """Which soils (n, n + 1) may be weaker than each of the soils; last, than the rigid base: those that may be weaker than any soil."""
    cohesion, angle, growth = np.array([[soil.cohesion, soil.friction_angle, soil.gradient] for soil in scene.soils]).T
    ratios = _ratios(scene)
    # A soil whose strength grows may be stronger deep down than any that it is compared with here.
    pairs = (growth > 0.0) | (ratios[:, None] > ratios) | (cohesion[:, None] < cohesion) | (angle[:, None] < angle)
    np.fill_diagonal(pairs, False)
    return np.column_stack([pairs, pairs.any(axis=1)])


def _joints(scene: Scene) -> list[Guide]:
    """The seams from left to right, without parts that are vertical or turn back."""
    joints = []
    for number, (name, seam) in enumerate(scene.seams.items(), 1):
        x, y = scene.geometry.in_box(*np.array(seam.points).T)
        x, y = (x, y) if x[-1] > x[0] else (x[::-1], y[::-1])
        runs = np.split(np.arange(x.size), np.flatnonzero(np.diff(x) <= 0.0) + 1)
        joints += [Guide(name, np.full(run.size - 1, number), x[run], y[run]) for run in runs if run.size > 1]
    return joints


def _chained(joints: list[Guide], reach: float) -> list[Guide]:
    """Seams, and each as far as another one that crosses it or meets it at an end, at most ``reach`` (m) away, followed by that one."""

    def joined(one: Guide, other: Guide) -> Iterator[Guide]:
        for place in _meeting(one, other, reach) if other.seam[0] not in one.seam else ():
            before, after = one.x < place, other.x > place
            if not before.any() or not after.any():
                continue
            seam = np.concatenate([one.seam_at(one.x[before]), other.seam_at(other.x[after] - NEAR * reach)])
            x = np.concatenate([one.x[before], [place], other.x[after]])
            y = np.concatenate([one.y[before], [np.interp(place, one.x, one.y)], other.y[after]])
            yield Guide(f"{one.name} and {other.name}", seam, x, y, np.concatenate([one.nodes[one.nodes < place], [place]]))

    chains = last = joints
    while last:
        last = [chain for one in last for other in joints for chain in joined(one, other)]
        chains = chains + last
    return chains


def _meeting(one: Guide, other: Guide, reach: float) -> list[float]:
    """Places x at which a line may go on along another: where that one crosses it and is steeper, and where either ends within ``reach``
    (m) of the other, at their crossing if that is as near."""
    shared = np.unique(np.concatenate([one.x, other.x]))
    shared = shared[(shared >= max(one.x[0], other.x[0])) & (shared <= min(one.x[-1], other.x[-1]))]
    above = np.interp(shared, one.x, one.y) - np.interp(shared, other.x, other.y)
    at = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    crossings = shared[at] + above[at] / (above[at] - above[at + 1]) * (shared[at + 1] - shared[at])
    places = set(crossings[above[at] > 0.0].tolist())
    for place in (one.x[-1], other.x[0]):
        apart = np.interp(place, one.x, one.y) - np.interp(place, other.x, other.y)
        near = crossings[np.abs(crossings - place) <= reach]
        if near.size:
            places |= set(near.tolist())
        elif np.hypot(apart, max(place - one.x[-1], other.x[0] - place, 0.0)) <= reach:
            places.add(float(place))
    return sorted(places)


def _within(section: Section, line: Guide) -> list[Guide]:
    """The guides along a line: its stretches in the soil, which end exactly where the line comes out of the ground."""
    width = section.scene.geometry.width
    low, high = max(line.x[0], 0.0), min(line.x[-1], width)
    places = np.unique(np.concatenate([line.x, line.nodes, section.x, np.linspace(low, high, 2001)]))
    places = places[(places >= low) & (places <= high)]
    height = np.interp(places, line.x, line.y)
    cover = section.ground(places) - height
    room = np.minimum(cover, height)
    inside = np.flatnonzero(room >= 0.0)
    parts = []
    for stretch in np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1):
        ends = []
        for last, beyond in ((stretch[:1], stretch[:1] - 1), (stretch[-1:], stretch[-1:] + 1)):
            if last.size and 0 <= beyond[0] < places.size:
                ends.append(places[last] + room[last] / (room[last] - room[beyond]) * (places[beyond] - places[last]))
        x = np.unique(np.concatenate([*ends, places[stretch]]))
        if x.size < 2 or np.ptp(x) < SHORTEST * section.height:
            continue
        falls = np.diff(cover[stretch]) / (NEAR * section.height)
        shallow = stretch[1:-1][(falls[:-1] <= 1.0) & (falls[1:] >= -1.0) & ((falls[:-1] < -1.0) | (falls[1:] > 1.0))]
        shallow = shallow[np.argsort(cover[shallow], kind="stable")[:SHALLOW]]
        nodes = np.concatenate([x[[0, -1]], line.nodes[(line.nodes > x[0]) & (line.nodes < x[-1])], places[shallow]])
        parts.append(Guide(line.name, line.seam_at(0.5 * (x[:-1] + x[1:])), x, np.interp(x, line.x, line.y), np.unique(nodes)))
    return parts
