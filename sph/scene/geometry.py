"""Shapes of the soil, and the places on them that figures and probes name."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from sph.scene.configuration import Section, key
from sph.scene.ground_line import GroundLine
from sph.scene.places import Point, Shape


class Slope(Shape):
    """A plane slope on a base layer in a rigid box: toe on the left, crest on the right."""

    shape: Literal["slope"] = key("plane slope on a base layer", source="Fig. 1")
    slope_angle: float = key("inclination of the face", "degree", "Sec. 3.1", ge=0.01, le=90, default=60.0)
    slope_height: float = key("height from toe to crest", "m", "ours: Fig. 1 is missing", gt=0, le=500, default=25.0)
    base_depth: float = key("thickness of the layer below the toe", "m", "ours: Fig. 1 is missing", ge=0, le=500, default=10.0)
    apron_length: float = key("length from the front wall to the toe", "m", "ours: gives 2,404 particles", ge=0, le=2000, default=55.0)
    crest_length: float = key(
        "length from the crest edge to the back wall", "m", "ours: gives 2,404 particles", gt=0, le=2000, default=34.0
    )

    @property
    def width(self) -> float:
        """Inner width of the box, m."""
        return self.crest[0] + self.crest_length

    @property
    def height(self) -> float:
        """Height of the soil at the crest, m."""
        return self.base_depth + self.slope_height

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        (toe_x, toe_y), (crest_x, crest_y) = self.toe, self.crest
        return (0.0, toe_x, crest_x, self.width), (toe_y, toe_y, crest_y, crest_y)

    @property
    def toe(self) -> tuple[float, float]:
        """Toe of the slope, m."""
        return self.apron_length, self.base_depth

    @property
    def crest(self) -> tuple[float, float]:
        """Crest edge, m; never before the toe, so that the ground of a vertical face does not turn back."""
        return self.apron_length + self.slope_height / math.tan(math.radians(self.slope_angle)), self.height


class Block(Shape):
    """A rectangular block, for columns and test problems."""

    shape: Literal["block"] = key("rectangular block")
    width: float = key("width", "m", gt=0, le=2000)
    height: float = key("height", "m", gt=0, le=1000)

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        return (0.0, self.width), (self.height, self.height)

    @property
    def toe(self) -> tuple[float, float]:
        """Lower left corner of the free face, m."""
        return 0.0, 0.0

    @property
    def crest(self) -> tuple[float, float]:
        """Upper left corner, m."""
        return 0.0, self.height


class PolygonBody(Section):
    """A body of soil inside a polygon."""

    kind: Literal["polygon"] = key("inside of a polygon", default="polygon")
    points: tuple[Point, ...] = key("corners [x, y] in order, the last joined to the first", "m", min_length=3, max_length=10000)

    @property
    def outline(self) -> np.ndarray:
        """Corners (n, 2), m."""
        return np.array(self.points)

    def contains(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Which of the places (n,) lie inside."""
        return inside(self.outline, x, y)


def inside(outline: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which of the places (n,) lie inside a polygon of corners (m, 2), by the number of sides to their right."""
    odd = np.zeros(np.shape(x), bool)
    for (x1, y1), (x2, y2) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if y1 != y2:
            odd ^= ((y1 <= y) != (y2 <= y)) & (x < x1 + (y - y1) / (y2 - y1) * (x2 - x1))
    return odd


class RingBody(Section):
    """A body of soil between two circles."""

    kind: Literal["ring"] = key("inside of a ring, or of a disc where the inner radius is 0")
    centre: Point = key("centre [x, y]", "m")
    outer_radius: float = key("outer radius", "m", gt=0, le=1000)
    inner_radius: float = key("inner radius", "m", ge=0, le=1000, default=0.0)

    @model_validator(mode="after")
    def _hollow(self) -> RingBody:
        if not self.inner_radius < self.outer_radius:
            raise ValueError(f"inner_radius: {self.inner_radius} m must be smaller than outer_radius: {self.outer_radius} m")
        return self

    @property
    def outline(self) -> np.ndarray:
        """Points (n, 2) of the outer circle, m."""
        angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
        return np.array(self.centre) + self.outer_radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def contains(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Which of the places (n,) lie inside."""
        r = np.hypot(x - self.centre[0], y - self.centre[1])
        return (self.inner_radius <= r) & (r < self.outer_radius)


def _upper_side(outline: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Height (n,) of the top of a body at the places x (n,), m; 0 beside it."""
    y = np.zeros(x.size)
    for (x1, y1), (x2, y2) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if x1 != x2:
            over = (min(x1, x2) <= x) & (x <= max(x1, x2))
            y[over] = np.maximum(y[over], y1 + (x[over] - x1) / (x2 - x1) * (y2 - y1))
    return y


class Bodies(Shape):
    """Bodies of any shape in a box, for columns that collapse, plates, rings and blocks that slide."""

    shape: Literal["bodies"] = key("bodies of any shape in a box")
    width: float = key("inner width of the box", "m", gt=0, le=2000)
    height: float = key("height of the box's side walls", "m", gt=0, le=1000)
    bodies: tuple[Annotated[PolygonBody | RingBody, Field(discriminator="kind")], ...] = key("the bodies", min_length=1, max_length=100)

    @model_validator(mode="after")
    def _inside(self) -> Bodies:
        for number, body in enumerate(self.bodies):
            low, high = body.outline.min(axis=0), body.outline.max(axis=0)
            if min(low) < 0 or high[0] > self.width * (1 + 1e-9) or high[1] > self.height * (1 + 1e-9):
                raise ValueError(
                    f"bodies.{number}: reaches from ({low[0]:g}, {low[1]:g}) to ({high[0]:g}, {high[1]:g}) m, "
                    f"out of the box of {self.width:g} x {self.height:g} m"
                )
        return self

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Upper envelope (x, y) of the bodies from left to right, m; at height 0 beside them."""
        outlines = [body.outline for body in self.bodies]
        corners = np.unique(np.concatenate([outline[:, 0] for outline in outlines]))
        beside = 1e-9 * self.width
        x = np.unique(np.clip(np.concatenate([[0.0, self.width], corners - beside, corners + beside]), 0.0, self.width))
        crossings = [x]
        for one, other in combinations([_upper_side(outline, x) for outline in outlines], 2):
            above = one - other
            cross = (above[:-1] * above[1:] < 0.0) & (np.diff(x) > 3.0 * beside)
            crossings.append((x[:-1] + np.diff(x) * above[:-1] / np.where(cross, above[:-1] - above[1:], 1.0))[cross])
        x = np.unique(np.concatenate(crossings))
        y = np.max([_upper_side(outline, x) for outline in outlines], axis=0)
        return tuple(x.tolist()), tuple(y.tolist())

    @property
    def toe(self) -> Point:
        """Lowest corner, the leftmost of several, m."""
        return min(self._corners, key=lambda point: (point[1], point[0]))

    @property
    def crest(self) -> Point:
        """Highest corner, the leftmost of several, m."""
        return min(self._corners, key=lambda point: (-point[1], point[0]))

    @property
    def _corners(self) -> list[Point]:
        return [(float(x), float(y)) for body in self.bodies for x, y in body.outline]


SLOPES = (Slope, GroundLine)
"""Shapes with a slope: a toe, a crest edge and a height between them."""

Geometry = Annotated[Slope | GroundLine | Block | Bodies, Field(discriminator="shape")]
