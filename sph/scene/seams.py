"""Seams: weak planes in the soil, thinner than its particles, with a strength of their own (``sph.solver.physics.seams``)."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from pydantic import model_validator

from sph.scene.configuration import Section, key
from sph.scene.places import Point

if TYPE_CHECKING:
    from sph.scene.schema import Scene


class Seam(Section):
    """A weak plane along a line, with the strength that a shear box gives along it."""

    points: tuple[Point, ...] = key(
        "middle line [x, y], in the coordinates of the survey if there is one; it may end in the soil or beyond the ground",
        "m",
        min_length=2,
        max_length=1000,
    )
    thickness: float | None = key(
        "thickness as logged or drawn, for information only: the computation does not use it", "m", gt=0, le=100, default=None
    )
    cohesion: float = key("peak cohesion along the seam, as in a shear box", "kPa", ge=0, le=1e6)
    friction_angle: float = key("peak friction angle along the seam, as in a shear box", "degree", ge=0, le=50)
    residual_cohesion: float | None = key("residual cohesion; null: that at the peak", "kPa", ge=0, le=1e6, default=None)
    residual_friction_angle: float | None = key("residual friction angle; null: that at the peak", "degree", ge=0, le=50, default=None)
    slip_at_peak: float = key("slip (displacement across the seam) at which its strength begins to fall", "m", ge=0, le=10, default=0.0)
    slip_at_residual: float | None = key(
        "slip at which its strength has fallen, linearly, to the residual; null: no loss of strength", "m", gt=0, le=100, default=None
    )

    @model_validator(mode="after")
    def _consistent(self) -> Seam:
        residuals = [name for name in ("residual_cohesion", "residual_friction_angle") if getattr(self, name) is not None]
        for name in residuals:
            own, peak = getattr(self, name), getattr(self, name.removeprefix("residual_"))
            if own > peak:
                raise ValueError(f"{name}: {own:g} must be at most {name.removeprefix('residual_')}: {peak:g}")
            if self.slip_at_residual is None:
                raise ValueError(f"{name}: {own:g} needs slip_at_residual, the slip at which it is reached")
        if self.slip_at_residual is not None and not residuals:
            raise ValueError(f"slip_at_residual: {self.slip_at_residual:g} m needs residual_cohesion or residual_friction_angle")
        if self.slip_at_residual is not None and not self.slip_at_residual > self.slip_at_peak:
            raise ValueError(f"slip_at_residual: {self.slip_at_residual:g} m, must be more than slip_at_peak: {self.slip_at_peak:g} m")
        same = next((number for number, (one, other) in enumerate(pairwise(self.points)) if one == other), None)
        if same is not None:
            raise ValueError(f"points.{same + 1}: {list(self.points[same + 1])} m is the point before it once more; leave it out")
        return self

    @property
    def peak(self) -> tuple[float, float]:
        """Cohesion (Pa) and tan(phi) at the peak."""
        return 1e3 * self.cohesion, math.tan(math.radians(self.friction_angle))

    @property
    def residual(self) -> tuple[float, float]:
        """Cohesion (Pa) and tan(phi) left after slip."""
        cohesion = self.cohesion if self.residual_cohesion is None else self.residual_cohesion
        angle = self.friction_angle if self.residual_friction_angle is None else self.residual_friction_angle
        return 1e3 * cohesion, math.tan(math.radians(angle))

    def middles(self, parts: int) -> tuple[np.ndarray, np.ndarray]:
        """Middles x and y (n,) of so many equal parts of each stretch of the line, m."""
        line, share = np.array(self.points), (np.arange(parts) + 0.5) / parts
        along = (np.arange(len(line) - 1)[:, None] + share).ravel()
        return np.interp(along, np.arange(len(line)), line[:, 0]), np.interp(along, np.arange(len(line)), line[:, 1])

    def under(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Height (n,) at which the line first passes under places (n,), m; minus infinity where it does not."""
        found = np.full(np.shape(x), -np.inf)
        for (x1, y1), (x2, y2) in pairwise(self.points):
            there = (x >= min(x1, x2)) & (x < max(x1, x2))
            height = y1 + (x[there] - x1) * (y2 - y1) / (x2 - x1)
            found[there] = np.where(height < y[there], np.maximum(found[there], height), found[there])
        return found

    def offset(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance (n,) of places (n,) from the line, m, positive on its left, and its direction (n,) at the nearest point, rad.

        Infinite beyond the ends: where the nearest point is an end and the line would have to be longer to pass the place.
        """
        offset, direction = np.full(np.shape(x), np.inf), np.zeros(np.shape(x))
        distance, last = np.full(np.shape(x), np.inf), len(self.points) - 2
        for number, ((x1, y1), (x2, y2)) in enumerate(pairwise(self.points)):
            length = math.hypot(x2 - x1, y2 - y1)
            cosine, sine = (x2 - x1) / length, (y2 - y1) / length
            along, left = (x - x1) * cosine + (y - y1) * sine, (y - y1) * cosine - (x - x1) * sine
            past = along - np.clip(along, 0.0, length)
            beyond = (past < 0.0) & (number == 0) | (past > 0.0) & (number == last)
            nearer = np.hypot(past, left) < distance
            distance[nearer] = np.hypot(past, left)[nearer]
            offset[nearer] = np.where(beyond, np.inf, np.copysign(distance, left))[nearer]
            direction[nearer] = math.atan2(sine, cosine)
        return offset, direction


def check_seams(scene: Scene) -> None:
    """Refuse seams where they would have no effect, and terms that take pairs across them for pairs in one body."""
    if not scene.seams:
        return
    if scene.numerics.gradient_correction is not None:
        raise ValueError("numerics.gradient_correction: treats the soil beside a seam as one body; set it to null in a scene with seams")
    if scene.prescribed_velocity_gradient is not None:
        raise ValueError("prescribed_velocity_gradient: moves the soil as one body, which seams cut; leave one of them out")
    for name, seam in scene.seams.items():
        if scene.length_in_soil(seam) == 0.0:
            raise ValueError(f"seams.{name}.points: the line lies outside the ground of the model; draw it through the soil")
