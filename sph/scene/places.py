"""Places, and the box that a scene's soil stands in."""

from __future__ import annotations

import math
from typing import Annotated, TypeVar

import numpy as np
from pydantic import Field

from sph.scene.configuration import Section

Coordinate = Annotated[float, Field(ge=-1e8, le=1e8)]

Point = tuple[Coordinate, Coordinate]

Place = TypeVar("Place", float, np.ndarray)


RIGHT, ABOVE = 1e-4, math.sqrt(2.0) * 1e-6
"""Spacings to the right and upwards by which a particle is shifted where it is asked on which side of a boundary it lies: a particle on the
boundary, up to rounding, belongs to what is right of it, or above it where it is level.  The same holds for every shape, layer and probe.
No line that is drawn has the gradient of the shift."""


def shifted(x: np.ndarray, y: np.ndarray, spacing: float, lattice_shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Places (n,) of particles in the box, m, for the question on which side of a boundary they lie.

    The soil's shape is moved ``lattice_shift`` spacings to the left over the lattice, which stays where it is in the box.
    """
    return x + (RIGHT + lattice_shift) * spacing, y + ABOVE * spacing


class Shape(Section):
    """A shape of soil in a box.

    The program's coordinates begin at the box's lower left corner and have the toe of a slope on the left; a scene's
    places are the user's, in m, and differ from them where the shape is a survey.
    """

    @property
    def origin(self) -> Point:
        """The user's coordinates of the box's corner at the program's (0, 0), m."""
        return 0.0, 0.0

    @property
    def direction(self) -> int:
        """-1 where the user's x decreases along the program's, or else 1."""
        return 1

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        raise NotImplementedError

    def ground(self, x: np.ndarray) -> np.ndarray:
        """Height (n,) of the ground at places (n,) in the box, m; at a vertical step that right of it."""
        return np.interp(x, *self.surface)

    def in_box(self, x: Place, y: Place) -> tuple[Place, Place]:
        """The program's coordinates of the user's places."""
        return self.direction * (x - self.origin[0]), y - self.origin[1]

    def in_survey(self, x: Place, y: Place) -> tuple[Place, Place]:
        """The user's coordinates of the program's."""
        return self.origin[0] + self.direction * x, self.origin[1] + y
