"""The slip surface with the least factor of safety, or the least critical coefficient, of a scene's slope by limit equilibrium.

Circles are tried on a coarse grid of their ends and of their depth, by Bishop's method, and the best of them are moved until no smaller
step betters them.  Spencer's method goes on from the best circles with convex lines of any shape, and with lines that follow a seam, or
the lower side of a soil on stronger soil, and leave it through the soil.  Nothing is drawn at random: the same scene has the same answer.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from sph.scene.geometry import SLOPES
from sph.scene.schema import Scene
from sph.stability.limit_equilibrium import MAX_TENSION, Balance, Slices, bishop, spencer, spencer_coefficient
from sph.stability.slip_surface import NEAR, STEEPEST, VERTICES, Edges, Guide, Section, along, as_lines, circles, guides, lines

SLICES, FINER = 40, 5
"""Slices of a surface in the search, about, and slices into which each is cut for the answer."""
ENDS, HALVES = 13, np.radians([1.5, 4.0, 9.0, 15.0, 21.0, 27.0, 34.0, 42.0, 50.0, 58.0, 66.0])
"""Places of either end in the grid of circles, and halves of their arcs, rad."""
APART = 0.05
"""Distance over H between the ends of two starts of a descent, at least."""
WIDER, MORE = 0.35, 6
"""The same along a guide, whose lines come to more and other ends, and how many of them are moved."""
PLACES = 11
"""Places on a guide where the first lines join and leave it, below the face and again on the whole of it."""
REACH = 3.0
"""Heights of the slope before the toe and behind the crest within which surfaces of the grid end."""
CIRCLES, STARTS = 6, 3
"""Circles of the grid that are moved, and lines."""
FIRST, LAST = 0.1, 4e-3
"""Steps of a descent over H, at first and at the end; of angles and gradients likewise."""
STEPS = 40
"""Most steps of a descent."""
WORTH = 1e-3
"""Relative gain of a step below which the next one is half as long."""
PROMISING = 1.25
"""Factor of a guide's first surface over the best so far up to which it is followed."""

PENALTY = 5.0
"""Added in the search for the share of a surface in tension beyond that."""
CRACKS = np.array([0.0, 0.3, 0.6, 1.0])
"""Parts of the depth in tension to which cracks are tried."""
OTHERS, NEARBY = 30, 1.3
"""Further circles of the grid from which lines may begin, and their value over the least."""
CRACKED = 0.185
"""Share of Bishop's circle in tension above which the crest has a crack, if Spencer's forces do not balance on it."""
ENOUGH = 1.06
"""Factor of safety over that of Bishop's circle up to which an answer without a crack is taken."""
HUGE = 1e6
"""More than any factor of safety."""
MAX_FACTOR = 20.0
"""Factor of safety above which nothing slides: a surface in level ground, which balances by rounding alone, or hardly any slope."""
EXITS, ENTRIES = np.tan(np.radians([15.0, 30.0, 45.0])), np.tan(np.radians([40.0, 55.0, 70.0]))
"""Gradients with which the first lines along a guide leave it towards the toe and the crest."""

Values = Callable[[np.ndarray], np.ndarray]


class Surface(NamedTuple):
    """The worst slip surface of a method."""

    value: float
    """factor of safety, at most ``MAX_FACTOR``, or critical coefficient; infinite where none was found"""
    where: str
    """``circle``, ``line``, or what it runs along"""
    x: np.ndarray
    """(points,) in the box, m"""
    y: np.ndarray
    """(points,) m"""
    seam: np.ndarray
    """(points - 1,) along which a base lies, as in ``Edges``"""
    tension: float
    """share of its length in tension"""
    crack: float
    """depth of the vertical crack at its upper end, m"""
    depth: float = 0.0
    """largest depth below the ground, m"""


NONE = Surface(np.inf, "", np.zeros(0), np.zeros(0), np.zeros(0, int), 0.0, 0.0)


class LimitEquilibrium(NamedTuple):
    """Limit equilibrium of a scene's slope."""

    bishop: Surface
    """factor of safety of the worst circle, Bishop's simplified method"""
    spencer: Surface
    """factor of safety of the worst surface of any shape, Spencer's method"""
    critical: Surface
    """least critical coefficient by Spencer's method, the yield acceleration over g; infinite where F is not above 1"""


def applies(scene: Scene) -> bool:
    """Whether limit equilibrium applies: a slope of solid soil under vertical gravity."""
    return (
        isinstance(scene.geometry, SLOPES)
        and scene.gravity.acceleration > 0.0
        and scene.gravity.inclination == 0.0
        and scene.prescribed_velocity_gradient is None
        and scene.coupling.initial_state == "solid"
    )


def limit_equilibrium(scene: Scene, coefficient: float = 0.0) -> LimitEquilibrium:
    """Factors of safety of a scene's slope at its peak strength, under a horizontal coefficient, and its critical coefficient.

    In steep cohesive soil much of the worst circle is in tension, and its forces do not balance by Spencer's method: the surface then ends
    in a crack.  One in ``critical`` does so where that of the factor of safety does.  ValueError where ``applies`` says no.
    """
    if not applies(scene):
        raise ValueError(f"{scene.name}: limit equilibrium needs geometry.shape: slope or ground_line, solid soil and vertical gravity")
    section = Section.of(scene)
    circle, near, surface = _least_factors(section, coefficient)
    critical = NONE
    if 1.0 < surface.value < np.inf:
        value, tension = spencer_coefficient(section.slices(Edges(surface.x[None], surface.y[None], surface.seam[None])))
        own = surface._replace(value=float(value[0]), tension=float(tension[0])) if tension[0] <= 2.0 * MAX_TENSION else NONE
        near = worst_circle(section, own.value, near)[1] if own.value < np.inf and len(near) else near
        critical = worst_surface(section, spencer_coefficient, near, own, 0.0 if surface.crack > 0.0 else HUGE, 1.0)
    return LimitEquilibrium(circle if circle.value <= MAX_FACTOR else NONE, surface, critical)


def spencer_factor(scene: Scene) -> float:
    """The factor of safety of ``limit_equilibrium`` by Spencer's method alone, infinite where there is none."""
    return _least_factors(Section.of(scene), 0.0)[2].value


def _least_factors(section: Section, coefficient: float) -> tuple[Surface, np.ndarray, Surface]:
    """The worst circle by Bishop's method with the numbers of others near it, and the worst surface by Spencer's."""
    circle, near = worst_circle(section, coefficient)
    enough, factor = (ENOUGH * circle.value, min(circle.value, MAX_FACTOR)) if len(near) else (0.0, 1.0)
    if circle.tension > CRACKED and not np.isfinite(spencer(section.slices(circles(section, near[:1], SLICES)[0]), coefficient).value[0]):
        enough = 0.0
    surface = worst_surface(section, partial(spencer, k=coefficient), near, NONE, enough, factor)
    return circle, near, surface if surface.value <= MAX_FACTOR else NONE


def worst_circle(section: Section, coefficient: float = 0.0, among: np.ndarray | None = None) -> tuple[Surface, np.ndarray]:
    """The circle with the least factor of safety, and the numbers by which ``circles`` makes it and others that come near, (n, 3).

    It is sought from the best of a grid, or of the circles by the numbers ``among``.
    """
    method = partial(bishop, k=coefficient)

    def values(given: np.ndarray, slices: int = SLICES) -> np.ndarray:
        edges, centre = circles(section, given, slices)
        return _values(section, edges, method, centre)

    grid = _grid(section) if among is None else among
    scale, end = np.array([section.height, section.height, 1.0]), section.way[-1]
    of_grid = values(grid, SLICES // 2)
    starts = _best(of_grid, grid, APART * section.height, CIRCLES)
    ends = descend(values, starts, scale, np.array([0.0, 0.0, 0.01]), np.array([end, end, 1.5]))
    edges, centre = circles(section, ends, SLICES)
    surface, worst = _surface(section, "circle", edges, method, centre, most=1.0)
    if not np.isfinite(surface.value):
        return NONE, np.zeros((0, 3))
    return surface, np.vstack([ends[worst], grid[_spread(of_grid)]])


def _grid(section: Section) -> np.ndarray:
    """Numbers (n, 3) of circles with their ends before the toe, on the face and behind the crest, on the ground that there is."""
    reach, face, apart = REACH * section.height, np.linspace(section.toe, section.crest, ENDS), np.linspace(0.0, 1.0, ENDS)[1:] ** 2
    left = np.concatenate([section.toe - min(reach, section.toe) * apart, face])
    right = np.concatenate([face, section.crest + min(reach, section.way[-1] - section.crest) * apart])
    grid = np.stack(np.meshgrid(left, right, HALVES, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid[grid[:, 1] > grid[:, 0]]


def worst_surface(
    section: Section, method: Callable[[Slices], Balance], near: np.ndarray, known: Surface, enough: float, factor: float
) -> Surface:
    """The surface with the least value: a known one, or one found from the worst circles, by the numbers of ``circles`` (n, 3), and along
    the guides.

    Where none has a value up to ``enough``, which is not even asked if that is 0, it may end in a vertical crack, as deep as soil with its
    strength divided by a factor is in tension, or less.
    """
    if enough > 0.0:
        whole = min(known, _worst(section, method, near, np.zeros(1)), key=lambda each: each.value)
        if whole.value <= enough:
            return whole
    where = float(near[0, 1]) if len(near) else section.crest
    return _worst(section, method, near, section.crack(where, factor) * CRACKS)


def _worst(section: Section, method: Callable[[Slices], Balance], near: np.ndarray, cracks: np.ndarray) -> Surface:
    """The surface with the least value: a convex line begun from circles that cracks of some depths (m) end, or one along a guide."""
    way, height, parts, surfaces = section.way[-1], section.height, SLICES // (VERTICES.size + 1), [NONE]

    def values(given: np.ndarray) -> np.ndarray:
        return _values(section, lines(section, given, parts), method)

    scale = np.concatenate([[height, height, height], np.ones(VERTICES.size)])
    high = np.concatenate([[way, way, cracks[-1]], np.full(VERTICES.size, STEEPEST[1])])
    ends = np.unique(_grid(section)[:, :2], axis=0)
    planes = [np.column_stack([ends, np.full(len(ends), crack), np.zeros((len(ends), VERTICES.size))]) for crack in np.unique(cracks)]
    choices = [np.vstack(planes)]
    if len(near):
        edges = circles(section, near, SLICES)[0]
        starts = as_lines(section, edges, near[:, 0], cracks)
        choices += [starts[: cracks.size], starts[cracks.size :]]
        circle = Edges(*(each[:1] for each in edges))
        if np.isfinite(_values(section, circle, method)[0]):
            surfaces.append(_surface(section, "circle", circle, method)[0])
    starts = np.vstack([_best(values(each), each, APART * height) for each in choices if len(each)])
    ends = descend(values, starts, scale, 0.0 * high, high)
    surfaces.append(_surface(section, "line", lines(section, ends, parts), method)[0])
    for guide in guides(section):
        surfaces.append(_along(section, guide, method, min(each.value for each in surfaces), cracks))
    return min(surfaces, key=lambda each: each.value)


def _along(section: Section, guide: Guide, method: Callable[[Slices], Balance], best: float, cracks: np.ndarray) -> Surface:
    """The worst surface along a guide, if its first ones promise to be worse than the best so far."""
    parts = SLICES // 6

    def values(given: np.ndarray) -> np.ndarray:
        edges = along(section, guide, given, parts)
        return np.where(_turns_up(edges, parts), _values(section, edges, method), np.inf)

    height, reach, end = section.height, REACH * section.height, section.way[-1]
    limits = section.place(np.array([section.toe - reach, section.crest + reach]))[0]
    low_x, high_x = guide.x[[0, -1]]  # which may come out of the ground far behind the crest
    first, last = np.clip(limits, low_x, high_x)
    # A seam that meets the ground, or another seam, is left exactly there: a step beside it stands a bridge of rock, however strong.
    face = np.clip(section.place(np.array([section.toe, section.crest]))[0], low_x, high_x)
    place = np.unique([*guide.nodes, *np.linspace(first, last, PLACES), *np.linspace(face[0], face[1], PLACES)])
    if section.ground(high_x) - guide.y[-1] <= NEAR * height:
        cracks = np.zeros(1)  # the whole body balances on what comes out of the ground behind it
    join, leave = (each.ravel() for each in np.meshgrid(place, place, indexing="ij"))
    join, leave = join[leave > join], leave[leave > join]
    if not join.size:
        return NONE
    depth = [section.ground(x) - np.interp(x, guide.x, guide.y) for x in (join, leave)]
    tried = []
    for out, back, crack in product(EXITS, ENTRIES, np.unique([0.0, 0.5 * cracks[-1]])):
        left, right = (np.interp(x, section.x, section.way) for x in (join - depth[0] / out, leave + depth[1] / back))
        tried.append(np.column_stack([left, right, np.full(join.size, crack), join, leave, np.zeros((join.size, 2))]))
    grid = np.concatenate(tried)
    of_grid = values(grid)
    if not of_grid.min() < PROMISING * best + 0.1:
        return NONE
    scale = np.array([height, height, height, height, height, 1.0, 1.0])
    low, high = np.array([[0.0, end], [0.0, end], [0.0, cracks[-1]], [low_x, high_x], [low_x, high_x], [0.0, 5.0], [0.0, 5.0]]).T
    starts = _best(of_grid, grid, WIDER * height, MORE)
    ends = descend(values, starts, scale, low, high)
    # With the starts, since more slices may show that an end touches what lies beside a thin layer.
    return _surface(section, guide.name, along(section, guide, np.vstack([ends, starts]), parts), method)[0]


def _turns_up(edges: Edges, parts: int) -> np.ndarray:
    """Which lines (n,) along a guide do not turn down where they join or leave it, so that the body can move."""
    gradient = np.diff(edges.y, axis=1) / np.maximum(np.diff(edges.x, axis=1), 1e-12)
    there = np.diff(edges.x, axis=1) > 1e-9
    sound = np.ones(len(edges.x), bool)
    for at in (2 * parts, 4 * parts):
        sound &= (gradient[:, at] >= gradient[:, at - 1] - 1e-6) | ~there[:, at] | ~there[:, at - 1]
    return sound


def descend(values: Values, starts: np.ndarray, scale: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Pattern search (Hooke and Jeeves 1961) from several starts (n, d) within bounds (d,) at once: the ends (n, d).

    Each step tries both directions of every number, then all that bettered it together, once and twice; where nothing is better it halves.
    """
    at, count, rows = np.clip(starts, low, high), starts.shape[1], np.arange(len(starts))
    least, step = values(at), np.full(len(starts), FIRST)
    moves = np.concatenate([np.eye(count), -np.eye(count)]) * scale

    def trial(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        places = np.clip(at[:, None] + moved, low, high)
        return places, values(places.reshape(-1, count)).reshape(len(at), -1)

    for _ in range(STEPS):
        single, result = trial(step[:, None, None] * moves)
        gain = np.where(result < least[:, None], np.minimum(least[:, None], HUGE) - result, 0.0)
        way = np.sign(gain[:, :count] - gain[:, count:]) * scale * step[:, None]
        joint, jointly = trial(way[:, None] * np.array([1.0, 2.0])[:, None])
        places, result = np.concatenate([single, joint], axis=1), np.concatenate([result, jointly], axis=1)
        best = result.argmin(axis=1)
        gain = np.minimum(least, HUGE) - np.minimum(result[rows, best], HUGE)
        moved = gain > 0.0
        at = np.where(moved[:, None], places[rows, best], at)
        least = np.where(moved, result[rows, best], least)
        step = np.where(gain > WORTH * np.abs(least), step, 0.5 * step)
        if (step < LAST).all():
            break
    return at


def _values(section: Section, edges: Edges, method: Callable[..., Balance], *centre: np.ndarray) -> np.ndarray:
    """Values (n,) of surfaces, infinite for those that are not possible."""
    possible = section.possible(edges)
    values = np.full(len(edges.x), np.inf)
    if possible.any():
        slices = section.slices(Edges(*(each[possible] for each in edges)))
        balance = method(slices, *(each[possible] for each in centre))
        values[possible] = balance.value if centre else balance.value + PENALTY * np.maximum(balance.tension - MAX_TENSION, 0.0)
    return values


def _surface(
    section: Section, where: str, edges: Edges, method: Callable[..., Balance], *centre: np.ndarray, most: float = 2.0 * MAX_TENSION
) -> tuple[Surface, int]:
    """The worst of some surfaces (n,), cut into more slices than in the search, which may have found bases that lie well in weak layers.

    And its number.
    """
    coarse, finer = (method(section.slices(each), *centre) for each in (edges, edges.divided(FINER)))
    sound = np.isfinite(finer.value) & (finer.tension <= most)  # others stand on the edge of what balances
    values, tension = (np.where(sound, *pair) for pair in zip(finer, coarse, strict=True))
    values = np.where(coarse.tension <= most, values, np.inf)
    worst = int(values.argmin())
    crack = float(section.ground(edges.x[worst, -1:])[0] - edges.y[worst, -1])
    crack = crack if crack > 1e-3 * section.height else 0.0
    x, y = edges.x[worst], edges.y[worst]
    deepest = float((section.ground(x) - y).max())
    return Surface(float(values[worst]), where, x, y, edges.seam[worst], float(tension[worst]), crack, deepest), worst


def _spread(values: np.ndarray) -> np.ndarray:
    """Indices of ``OTHERS`` values or fewer, evenly through those that come near the least."""
    near = np.argsort(values, kind="stable")[: np.count_nonzero(values < NEARBY * values.min() + 0.1)]
    return near[:: max(1, near.size // OTHERS)]


def _best(values: np.ndarray, grid: np.ndarray, apart: float, count: int = STARTS) -> np.ndarray:
    """The best of a grid (n, d) of which one of the ends, its first two numbers, is ``apart`` (m) from that of each better one."""
    kept = list[int]()
    for each in np.argsort(values, kind="stable").tolist():
        if all(np.abs(grid[each, :2] - grid[other, :2]).max() > apart for other in kept):
            kept.append(each)
        if len(kept) == count:
            break
    return grid[kept]
