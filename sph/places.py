"""Places, and the box that a scene's soil stands in."""

from __future__ import annotations

from typing import Annotated, TypeVar

import numpy as np
from pydantic import Field

from sph.configuration import Section

Coordinate = Annotated[float, Field(ge=-1e8, le=1e8)]

Point = tuple[Coordinate, Coordinate]

Place = TypeVar("Place", float, np.ndarray)


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

    def in_box(self, x: Place, y: Place) -> tuple[Place, Place]:
        """The program's coordinates of the user's places."""
        return self.direction * (x - self.origin[0]), y - self.origin[1]

    def in_survey(self, x: Place, y: Place) -> tuple[Place, Place]:
        """The user's coordinates of the program's."""
        return self.origin[0] + self.direction * x, self.origin[1] + y
