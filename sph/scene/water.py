"""Water in the pores: a phreatic line, or a ratio r_u of pore pressure to overburden, and whose pressure it is.

Below the line the pore pressure is hydrostatic, the unit weight of water times the vertical depth below it.  Standing water before the
slope is a line above the ground, level there.  How water enters the equations: ``sph.solver.physics.seepage`` and
``sph.solver.physics.pore_pressure``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from sph.scene.configuration import FileSection, key
from sph.scene.geometry import Geometry
from sph.scene.places import Coordinate, Point, Shape
from sph.scene.survey import read_line

PRESSURES = {
    "by_place": "soil has the pressure of its present place: drained soil, sand and gravel, whose water flows as fast as it moves",
    "carried": "soil keeps the pressure that it has at the start: undrained soil, silt and clay, which moves faster than its water drains",
}
"""Whose the pore pressure is, and which soil that suits."""
Ratio = Annotated[float, Field(ge=0, lt=1)]


class Water(FileSection):
    """Pore pressure of the soil: by ``level``, by ``points`` or ``file``, or by ``r_u``."""

    content: ClassVar[tuple[str, ...]] = ("points",)

    pressure: Literal["by_place", "carried"] = key("; ".join(f"{name}: {text}" for name, text in PRESSURES.items()))
    level: Coordinate | None = key("elevation of a level phreatic surface, in the coordinates of the ground", "m", default=None)
    points: tuple[Point, ...] | None = key(
        "phreatic line [x, elevation] from side to side of the model, in the coordinates of the ground; or in a file: CSV, GeoJSON or WKT",
        "m",
        min_length=2,
        max_length=10000,
        default=None,
    )
    r_u: Ratio | None = key(
        "pore pressure ratio: u over the total vertical stress in the initial slope; a layer may have its own", "-", default=None
    )
    unit_weight: float = key("unit weight of water, for a level or a line", "kN/m3", gt=0, le=100, default=9.81)

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The points of a file."""
        return {"points": read_line(path)}

    @model_validator(mode="before")
    @classmethod
    def _drained_or_not(cls, keys: Any) -> Any:
        if isinstance(keys, Mapping) and keys.get("pressure") is None:
            choices = "; or ".join(f"pressure: {name} ({text})" for name, text in PRESSURES.items())
            raise ValueError(f"pressure: must be written, since it decides the strength of soil that moves: {choices}")
        return keys

    @model_validator(mode="after")
    def _sound(self) -> Water:
        given = [name for name in ("level", "points", "r_u") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"level, points (or file), r_u: {' and '.join(given) or 'none'} given; write one of them, and null for others below it"
            )
        if self.points is not None:
            x = np.array(self.points)[:, 0]
            if not ((np.diff(x) > 0).all() or (np.diff(x) < 0).all()):
                raise ValueError("points: x must increase, or decrease, from point to point: a phreatic line has one height at every x")
        return self

    @property
    def line(self) -> np.ndarray:
        """Corners (n, 2) of the phreatic line in the user's coordinates, x increasing, m; one corner for a level."""
        line = np.array([(0.0, self.level)] if self.level is not None else self.points or (), float).reshape(-1, 2)
        return line if line.shape[0] < 2 or line[-1, 0] > line[0, 0] else line[::-1]

    def surface(self, geometry: Shape, x: np.ndarray) -> np.ndarray:
        """Height (n,) of the phreatic line at places (n,) in the box of a shape, m."""
        along, height = self.line.T
        found: np.ndarray = np.interp(geometry.in_survey(x, x)[0], along, height) - geometry.origin[1]
        return found

    def sentence(self) -> str:
        """Where the water is and whose its pressure, for summaries."""
        if self.r_u is not None:
            where = f"r_u = {self.r_u:g}"
        else:
            low, high = self.line[:, 1].min(), self.line[:, 1].max()
            where = f"phreatic surface at {low:.10g} m" if low == high else f"phreatic line from {low:.10g} to {high:.10g} m"
            where += f", {self.unit_weight:g} kN/m3"
        return f"{where}; pressure {self.pressure}: {PRESSURES[self.pressure]}"


def standing_water(water: Water, geometry: Geometry) -> tuple[float, bool] | None:
    """Greatest depth of water above the ground (m), and whether its surface is level; None where the line lies below all ground."""
    if water.r_u is not None:
        return None
    ground_x, ground_y = (np.array(values) for values in geometry.surface)
    corners = geometry.in_box(water.line[:, 0], water.line[:, 1])[0]
    x = np.unique(np.concatenate([ground_x, np.clip(corners, ground_x[0], ground_x[-1])]))
    near = 1e-9 * geometry.width  # either side of a vertical step
    left, right = x[:-1] + near, x[1:] - near
    depth = [water.surface(geometry, end) - np.interp(end, ground_x, ground_y) for end in (left, right)]
    above = np.maximum(*depth)
    flooded = above > 1e-6 * geometry.height
    if not flooded.any():
        return None
    rise = np.abs(water.surface(geometry, right) - water.surface(geometry, left))[flooded]
    return float(above.max()), bool((rise <= 1e-6 * geometry.height).all())
