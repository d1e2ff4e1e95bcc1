"""Rows of particles in weak soil on stronger ground: how late it fails with them and how far its debris goes, for findings and the page."""

from __future__ import annotations

from itertools import count, groupby
from typing import NamedTuple

import numpy as np

from sph.scene.geometry import SLOPES, Bodies
from sph.scene.places import RIGHT
from sph.scene.schema import Scene
from sph.solver.physics.interface import soil_numbers
from sph.stability.slip_surface import sides_of
from sph.stability.standing import leaves_solid_state

RUN_OUT_BY_ROWS: dict[str, dict[float, float]] = {
    "weaker": {1: 0.0, 2: 0.73, 3: 0.98, 4: 1.0},
    "both": {2: 0.0, 3: 0.29, 4: 0.56, 6: 0.71, 12: 0.81},
}
"""Run-out of a weak cover over the converged one, by ``numerics.interfaces`` and rows of particles across the cover.

Of the two hillsides of docs/model/interfaces.md always the smaller.  ``weaker``: with one row the benched hillside runs 0.14 of the way and
the shallow slide 0, with two 0.73 and 0.99, with three 0.98 and 1.12 (1.07 with a spacing that differs in the eleventh digit), with four
the slide 1.07.  These scatter: at 1.4 rows the benched hillside runs 13.9 and 12.0 m with spacings of 2.130 and 2.1307 m.  ``both``: 0,
0.32 and 0.55 with 1.4, 1.9 and 2.8 rows, and 0, 0.29 and 0.56 with 2, 3 and 4.  With 6 and 12 rows no run-out was measured; those are
the acceleration of an endless incline over that which its strength allows, which is larger than the run-out where both are known (0.28
and 0.49 with two and three rows).
"""
FACTOR_BY_ROWS = {2: 2.00, 3: 1.41, 4: 1.26, 6: 1.24}
"""Factor of safety of a static test over Spencer's, by rows of particles across the cover, the larger of two covers
(docs/model/interfaces.md); with six it lies between 1.16 and this.  With either of
``numerics.interfaces``, which are the same before failure."""
FACTOR_ERROR = 0.1
"""Error of the factor of safety up to which the rows suffice to show what sets a cover off."""
EARLY_ON_SEAM = 0.16
"""By how much the factor of safety is too low, at most, where the base of a cover is a seam with its strength, with two and three rows."""
SHORT_ON_SEAM, FAR_ON_SEAM = 0.29, 0.51
"""By how much its run-out was then too short and too long, at most, on the slopes of docs/model/interfaces.md."""
CLOSE = 0.05
"""Error of the run-out up to which the rows suffice."""
SCATTER = 0.12
"""Largest difference of a run-out with so many rows from that with the most rows on the two hillsides: 21.8 m with three, 19.5 m with six.
The debris before the toe is then 2.96 particles thick on average with three rows."""
HELD_BELOW = 2
"""Rows below which a layer between two stronger soils is held, since the kernel reaches across it: a block on one row moved a quarter of
its way, on two 98 % (``tests/physics/test_weak_on_strong.py``)."""
STRONGER = 1.5
"""Strength of the ground over that of weak soil on it from which on the weak soil takes nearly all of the slip: its weight is then 1.67 of
2 (``sph.solver.physics.interface``).  Below it a slip surface passes through both."""


class Bed(NamedTuple):
    """Weak soil on stronger ground in a column."""

    thickness: float  # m
    ground: int  # number of the stronger soil
    between: bool  # stronger soil lies on it, too
    x: float  # of its base, in the coordinates of the survey, m
    y: float


class Cover(NamedTuple):
    """Weak soil on stronger ground, within the slope."""

    name: str
    ground: str  # the stronger soil below it
    thickness: float  # vertically, that three quarters of its columns exceed, m
    rows: float  # of particles in that thickness
    law: str  # of the interface: that of ``numerics.interfaces``, or "both" where soil never loses its solid state
    between: bool  # stronger soil lies on it, too
    seamed: bool = False  # a seam runs along its base, on which it does not stand too long with any number of rows

    @property
    def held(self) -> bool:
        """Whether it cannot slide, whatever its strength."""
        return self.between and self.rows < HELD_BELOW * (1.0 - 1e-9)

    @property
    def run_out(self) -> float:
        """Run-out over the converged one."""
        return 0.0 if self.held else 1.0 if self.between and self.law == "weaker" else run_out(self.law, self.rows)

    @property
    def factor(self) -> float:
        """Factor of safety over Spencer's."""
        return 1.0 if self.seamed else factor_with(self.rows)

    @property
    def late(self) -> bool:
        """Whether it stands, for lack of rows, where it should fail."""
        return is_late(self.factor)

    @property
    def short(self) -> bool:
        """Whether a run-out, or that nothing moves, is a lower bound for lack of rows."""
        return self.run_out < 1.0 - CLOSE - 1e-9


def run_out(law: str, rows: float) -> float:
    """``RUN_OUT_BY_ROWS`` between the measured rows; that of the nearest beyond them."""
    table = RUN_OUT_BY_ROWS[law]
    return float(np.interp(rows, [*table], [*table.values()]))


def enough_rows(law: str = "weaker") -> int | None:
    """The least whole number of rows whose run-out is ``CLOSE`` to the converged one; None where that many were not measured."""
    rows = RUN_OUT_BY_ROWS[law]
    return next((each for each in range(1, int(max(rows)) + 1) if run_out(law, each) >= 1.0 - CLOSE - 1e-9), None)


def factor_with(rows: float) -> float:
    """``FACTOR_BY_ROWS`` between the measured rows and below them; beyond them an error in proportion to the spacing."""
    most = max(FACTOR_BY_ROWS)
    measured = float(np.interp(rows, [*FACTOR_BY_ROWS], [*FACTOR_BY_ROWS.values()]))
    return measured if rows <= most else 1.0 + (measured - 1.0) * most / rows


def is_late(factor: float) -> bool:
    """Whether a factor of safety over Spencer's is too high to show what sets a cover off."""
    return factor > 1.0 + FACTOR_ERROR + 1e-9


def rows_in_time() -> int:
    """The least number of rows with which a cover does not fail too late."""
    return next(rows for rows in count(1) if not is_late(factor_with(rows)))


def covers(scene: Scene) -> list[Cover]:
    """The weak soils that lie on stronger ground in most of their columns between the toe and a height behind the crest, in order.

    Strengths are those before failure, at the weight of what lies on the interface, without water, which weakens both soils alike.
    """
    if not isinstance(scene.geometry, SLOPES) or len(set(soil_numbers(scene))) == 1:
        return []
    geometry, names, kinds, soils = scene.geometry, ("soil", *scene.layers), soil_numbers(scene), scene.soils

    def strength(number: int, depth: float, weight: float) -> float:
        soil = soils[number].at_depth(depth)
        return float(soil.cohesion_si * np.cos(soil.friction_angle_si) + weight * np.sin(soil.friction_angle_si))

    column, thickness, number = strata(scene)
    (toe, _), (crest, _) = geometry.toe, geometry.crest
    inside = (column > toe) & (column < crest + geometry.slope_height)
    there = [int(np.count_nonzero(((number == each) & (thickness > 0.0)).any(axis=0) & inside)) for each in range(len(soils))]
    columns: dict[int, list[Bed]] = {}
    places = np.transpose(geometry.in_survey(column, geometry.ground(column)))[inside]
    for parts, numbers, (x, y) in zip(thickness.T[inside], number.T[inside], places, strict=True):
        column_parts = [(part, each) for part, each in zip(parts[::-1], numbers[::-1], strict=True) if part > 0.0]  # from the ground down
        beds = [list(bed) for _, bed in groupby(column_parts, key=lambda pair: kinds[pair[1]])]
        weight, above = 0.0, None
        for bed, below in zip(beds, [*beds[1:], None], strict=True):
            depth, (first, last) = sum(part for part, _ in bed), (bed[0][1], bed[-1][1])
            under = above is not None and strength(above, 0.0, weight) >= STRONGER * strength(first, 0.0, weight)
            weight += scene.gravity.acceleration * sum(part * soils[each].density for part, each in bed)
            y -= depth
            if below is not None and strength(below[0][1], 0.0, weight) >= STRONGER * strength(last, depth, weight):
                columns.setdefault(last, []).append(Bed(depth, below[0][1], under, x, y))
            above = last
    return [_cover(scene, names, each, columns[each]) for each in sorted(columns) if 2 * len(columns[each]) > there[each]]


def _cover(scene: Scene, names: tuple[str, ...], number: int, columns: list[Bed]) -> Cover:
    depths, grounds, between, x, base = map(np.array, zip(*columns, strict=True))
    near = scene.numerics.spacing
    seamed = any(2 * np.count_nonzero(seam.under(x, base + near) > base - near) > len(columns) for seam in scene.seams.values())
    thickness = float(np.percentile(depths, 25))
    ground = names[int(np.bincount(grounds).argmax())]
    law = scene.numerics.interfaces if leaves_solid_state(scene, scene.materials[number]) else "both"
    return Cover(names[number], ground, thickness, thickness / scene.numerics.spacing, law, 2 * sum(between) > len(between), seamed)


def strata(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of the lattice: their x (columns,), m, and thickness (m) and soil (parts, columns) of their parts, from the base upwards.

    The soil is 0 for the scene's own and k for its k-th layer, the later one where two overlap.
    """
    assert not isinstance(scene.geometry, Bodies), "bodies have no section"
    geometry, dx = scene.geometry, scene.numerics.spacing
    column = (np.arange(scene.lattice[0]) + 0.5 + RIGHT + scene.numerics.lattice_shift) * dx
    ground = geometry.ground(column)
    x, top = geometry.in_survey(column, ground)
    base = geometry.in_survey(column, np.zeros_like(column))[1]
    crossed = [side for layer in scene.layers.values() for side in sides_of(layer.region, x, top)]
    heights = np.sort([base, top, *(np.clip(np.nan_to_num(side, nan=base[0]), base, top) for side in crossed)], axis=0)
    middle = 0.5 * (heights[1:] + heights[:-1])
    number = np.zeros(middle.shape, int)
    for index, layer in enumerate(scene.layers.values(), 1):
        number[layer.region.contains(np.broadcast_to(x, middle.shape), middle, np.broadcast_to(top, middle.shape))] = index
    return column, np.diff(heights, axis=0), number
