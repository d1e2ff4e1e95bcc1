"""A slope of the user's own: the ground as a surveyed line, from the model's base upwards."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from sph.scene.configuration import key
from sph.scene.places import Coordinate, Point, Shape
from sph.scene.survey import SurveyLine, check_line, read_line

GENTLE = 0.5
"""What is gentler than this part of the slope's mean gradient lies before its toe or behind its crest."""
STANDS_OUT = 0.03
"""Rise of a steeper part of the slope above its mean gradient, over its height, from which on it is a face of its own."""
NARROWEST = 0.1
"""Width and height below which points within 180 of 0 are degrees, m: no model is so small, and as degrees it is 11 km."""
STEEPEST, LONGEST, HIGHEST = 10.0, 500.0, 1000.0
"""Largest height over the width of all ground, and largest width of the model and elevation over the height of the slope: beyond, x and
elevation are of different units, as m and km, or the line lies in plan."""


class GroundLine(SurveyLine, Shape):
    """Soil below a ground line, in the coordinates of its survey; the box turns the toe of the slope to the left."""

    shape: Literal["ground_line"] = key("soil below a surveyed line")
    points: tuple[Point, ...] = key(
        "ground [x, elevation] along the line, with vertical steps but no overhangs; or in a file: CSV, GeoJSON or WKT",
        "m",
        min_length=2,
        max_length=10000,
    )
    base: Coordinate = key("elevation of the model's base, below all ground", "m")
    window: tuple[Coordinate, Coordinate] | None = key(
        "smallest and largest x of the part of the line that is used; null: all of it", "m", default=None
    )
    downhill: Literal["left", "right"] = key("side towards which the slope falls", default="left")
    toe_at: Point | None = key("toe [x, elevation]; null: found from the line", "m", default=None)
    crest_at: Point | None = key("crest edge [x, elevation]; null: found from the line", "m", default=None)

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The points of a file."""
        return {"points": read_line(path, section=keys.get("section"))}

    @model_validator(mode="after")
    def _sound(self) -> GroundLine:
        try:
            self._check()
        except ValueError as error:
            raise ValueError(f"{error} (file: {self.file})" if self.file else str(error)) from error
        return self

    def _check(self) -> None:
        line = np.array(self.points)
        check_line(self.points, [f"points.{number}" for number in range(len(line))])
        (wide, high), highest = np.ptp(line, axis=0), np.abs(line[:, 1]).max()
        wanted = "give distance along the section and elevation, both in m"
        if 0.0 < wide < NARROWEST and high < NARROWEST and np.abs(line).max() <= 180.0:
            raise ValueError(f"points: spread over {wide:.4g} m in x and {high:.4g} m in elevation: they may be degrees; {wanted}")
        if wide > 0.0 and (high > STEEPEST * wide or highest > HIGHEST * high > 0.0):
            raise ValueError(
                f"points: rise by {high:.4g} m over {wide:.4g} m, at elevations up to {highest:.10g} m: a line in plan, or x in "
                f"another unit than the elevation; {wanted}, and the elevation of ground that is so level from a nearer level"
            )
        left, right = sorted(line[[0, -1], 0])
        if self.window and not (left <= self.window[0] < self.window[1] <= right):
            raise ValueError(f"window: {list(self.window)} m must increase and lie within the line, from {left:.10g} to {right:.10g} m")
        if left == right:
            raise ValueError(f"points: all lie at x = {left:.10g} m; expected a line that spreads in x")
        ground = self._line
        low = ground[np.argmin(ground[:, 1])]
        if not self.base < low[1]:
            raise ValueError(f"base: {self.base:.10g} m must lie below the ground, whose lowest point is ({low[0]:.10g}, {low[1]:.10g}) m")
        for name, place in (("toe_at", self.toe_at), ("crest_at", self.crest_at)):
            if place and not (ground[0, 0] <= place[0] <= ground[-1, 0] and self.base <= place[1]):
                raise ValueError(f"{name}: {list(place)} m lies outside the model")
        (toe_x, toe_y), (crest_x, crest_y) = self.toe, self.crest
        if not (toe_x <= crest_x and toe_y < crest_y):
            toe, crest = (self.in_survey(*place) for place in (self.toe, self.crest))
            raise ValueError(
                f"downhill: {self.downhill}: no slope falls to the {self.downhill}: its toe would be ({toe[0]:.10g}, {toe[1]:.10g}) m "
                f"and its crest ({crest[0]:.10g}, {crest[1]:.10g}) m; check downhill, toe_at and crest_at"
            )
        if self.width > LONGEST * self.slope_height:
            raise ValueError(
                f"points: the slope rises by {self.slope_height:.4g} m in {self.width:.4g} m, {LONGEST:g} times as long: x and "
                f"elevation may be of different units; {wanted}, and a window if the line is much longer than the slope"
            )

    @property
    def _line(self) -> np.ndarray:
        """The ground (n, 2) within the window in the user's coordinates, x increasing."""
        line = np.array(self.points)
        line = line if line[-1, 0] >= line[0, 0] else line[::-1]
        if self.window is None:
            return line
        (x, y), (left, right) = line.T, self.window
        # A window may end on a vertical step, of which the side within it counts: np.interp takes the last of several points at one x.
        first, last = (left, np.interp(left, x, y)), (right, np.interp(-right, -x[::-1], y[::-1]))
        return np.vstack([first, line[(left < x) & (x < right)], last])

    @property
    def direction(self) -> int:
        """-1 for a slope that falls to the right: it is turned round."""
        return 1 if self.downhill == "left" else -1

    @property
    def origin(self) -> Point:
        """The user's coordinates of the box's corner below the foot of the slope, m."""
        return float(self._line[0 if self.downhill == "left" else -1, 0]), self.base

    @property
    def _ground(self) -> np.ndarray:
        """The ground (n, 2) in the box, m."""
        line: np.ndarray = np.column_stack(self.in_box(*self._line.T))[:: self.direction]
        return line

    @property
    def width(self) -> float:
        """Inner width of the box, m."""
        return float(self._ground[-1, 0])

    @property
    def height(self) -> float:
        """Height of the highest ground above the base, m."""
        return float(self._ground[:, 1].max())

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        x, y = self._ground.T.tolist()
        return tuple(x), tuple(y)

    @property
    def toe(self) -> Point:
        """Toe of the main slope in the box, m."""
        return self.in_box(*self.toe_at) if self.toe_at else self._main_slope[0]

    @property
    def crest(self) -> Point:
        """Crest edge of the main slope in the box, m."""
        return self.in_box(*self.crest_at) if self.crest_at else self._main_slope[1]

    @property
    def slope_height(self) -> float:
        """Height from toe to crest, m."""
        return self.crest[1] - self.toe[1]

    @property
    def _main_slope(self) -> tuple[Point, Point]:
        """Toe and crest: the two points of the ground between which most rise is left after half the mean gradient between them is taken
        off everywhere, which leaves out gentler ground before and behind and passes over dips and berms; found from the largest climb on.
        """
        slope, gradient = largest_climb(self._ground, 0.0), -np.inf
        while (steeper := (slope[1][1] - slope[0][1]) / max(slope[1][0] - slope[0][0], 1e-9)) > gradient:
            gradient = steeper
            slope = largest_climb(self._ground, GENTLE * gradient)
        return slope

    @property
    def steeper_face(self) -> tuple[Point, Point] | None:
        """Toe and crest in the box of a face between those of the slope that is steeper than its mean gradient, m; None without one."""
        (toe_x, toe_y), (crest_x, crest_y) = self.toe, self.crest
        gradient = (crest_y - toe_y) / max(crest_x - toe_x, 1e-9)
        ground = self._ground
        low, high = largest_climb(ground[(toe_x <= ground[:, 0]) & (ground[:, 0] <= crest_x)], gradient)
        stands_out = high[1] - low[1] - gradient * (high[0] - low[0]) > STANDS_OUT * self.slope_height
        return (low, high) if stands_out else None


def largest_climb(ground: np.ndarray, gradient: float) -> tuple[Point, Point]:
    """The two points of the ground (n, 2), lower first, with the largest ``(y2 - y1) - gradient * (x2 - x1)``; the nearest of equals."""
    excess = ground[:, 1] - gradient * ground[:, 0]
    lowest = np.minimum.accumulate(excess)
    high = int(np.argmax(excess - lowest))
    low = int(np.flatnonzero(excess[: high + 1] == lowest[high])[-1])
    (x1, y1), (x2, y2) = ground[[low, high]].tolist()
    return (x1, y1), (x2, y2)
