"""Layers of other soil than that of the scene, by depth, by elevation or by polygon.

Layers lie over each other in the order in which they are written: where two overlap, the later one counts.  A layer names only the keys of
its soil in which it differs.  How layers enter the equations: ``sph.solver.physics.material``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from sph.scene.configuration import Section, key
from sph.scene.geometry import inside
from sph.scene.places import Coordinate, Point
from sph.scene.soil import Coupling, Softening, Soil
from sph.scene.survey import SurveyLine, check_line, read_line, read_outline

if TYPE_CHECKING:
    from sph.scene.schema import Scene

Depth = Annotated[float, Field(ge=0, le=1e4)]
FAR = 1e5
"""How far a boundary goes on level beyond its ends, and what lies below it downwards, m."""


class DepthRegion(Section):
    """What lies between two depths below the ground: layers that follow the surface."""

    kind: Literal["depth"] = key("between two depths below the ground")
    top: Depth = key("depth of the upper side, vertically below the ground", "m", default=0.0)
    bottom: Depth | None = key("depth of the lower side; null: down to the base", "m", default=None)

    @model_validator(mode="after")
    def _thick(self) -> DepthRegion:
        if self.bottom is not None and not self.top < self.bottom:
            raise ValueError(f"bottom: {self.bottom} m must be deeper than top: {self.top} m")
        return self

    def contains(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
        """Which of the places (n,) under a ground (n,) of these heights lie in it, m."""
        depth = ground - y
        return (self.top <= depth) & (depth < (math.inf if self.bottom is None else self.bottom))

    def upper_side(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
        """Height (n,) of its upper side above places (n,) in it, m."""
        return ground - self.top


class ElevationRegion(Section):
    """What lies between two heights: level strata."""

    kind: Literal["elevation"] = key("between two elevations")
    bottom: Coordinate | None = key("elevation of the lower side; null: down to the base", "m", default=None)
    top: Coordinate | None = key("elevation of the upper side; null: up to the ground", "m", default=None)

    @model_validator(mode="after")
    def _thick(self) -> ElevationRegion:
        if self.bottom is not None and self.top is not None and not self.bottom < self.top:
            raise ValueError(f"bottom: {self.bottom} m must be lower than top: {self.top} m")
        return self

    def contains(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
        """Which of the places (n,) lie in it, m."""
        return ((-math.inf if self.bottom is None else self.bottom) <= y) & (y < (math.inf if self.top is None else self.top))

    def upper_side(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
        """Height (n,) of its upper side above places (n,) in it, the ground where that is lower, m."""
        return ground if self.top is None else np.minimum(ground, self.top)


class OutlinedRegion(SurveyLine):
    """What lies within straight sides."""

    points: tuple[Point, ...]

    @property
    def outline(self) -> np.ndarray:
        """Corners (n, 2), m."""
        return np.array(self.points)

    def contains(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray | None = None) -> np.ndarray:
        """Which of the places (n,) lie in it, m."""
        return inside(self.outline, x, y)

    def upper_side(self, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
        """Height (n,) of the side next above places (n,) in it, the ground where that is lower, m."""
        lowest = np.array(ground, float)
        for (x1, y1), (x2, y2) in zip(self.outline, np.roll(self.outline, -1, axis=0), strict=True):
            if x1 != x2:
                side = y1 + (x - x1) / (x2 - x1) * (y2 - y1)
                above = (min(x1, x2) <= x) & (x <= max(x1, x2)) & (side >= y)
                lowest = np.where(above, np.minimum(lowest, side), lowest)
        return lowest


class PolygonRegion(OutlinedRegion):
    """What lies inside a polygon: lenses, fills, a weathered zone."""

    kind: Literal["polygon"] = key("inside of a polygon")
    points: tuple[Point, ...] = key(
        "corners [x, y] in order, the last joined to the first; or in a file: CSV, GeoJSON or WKT", "m", min_length=3, max_length=10000
    )

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The corners in a file."""
        return {"points": read_outline(path, keys.get("section"))}


class BelowRegion(OutlinedRegion):
    """What lies below a boundary, such as the top of rock between boreholes."""

    kind: Literal["below"] = key("below a boundary between layers")
    points: tuple[Point, ...] = key(
        "boundary [x, elevation], level beyond its ends; or in a file: CSV, GeoJSON or WKT", "m", min_length=2, max_length=10000
    )

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The points of a file."""
        return {"points": read_line(path, steps=False, section=keys.get("section"))}

    @model_validator(mode="after")
    def _sound(self) -> BelowRegion:
        check_line(self.points, [f"points.{number}" for number in range(len(self.points))], steps=False)
        return self

    @property
    def outline(self) -> np.ndarray:
        """Corners (n, 2) of what lies below, m."""
        line = np.array(self.points)
        line = line if line[-1, 0] > line[0, 0] else line[::-1]
        left, right = line[0] - (FAR, 0.0), line[-1] + (FAR, 0.0)
        return np.vstack([left, line, right, right - (0.0, FAR), left - (0.0, FAR)])


Region = DepthRegion | ElevationRegion | PolygonRegion | BelowRegion
"""Place of a layer."""


class Layer(Section):
    """A region of other soil."""

    region: Annotated[Region, Field(discriminator="kind")] = key("place of the layer")
    soil: Soil = key("material of the layer; give only the keys that differ from the scene's soil", default=Soil())
    S_R: float | None = key("strength ratio of the layer; null: that of coupling", ge=0, le=1, default=None)
    r_u: float | None = key("pore pressure ratio of the layer; null: that of water", ge=0, lt=1, default=None)
    gamma: float | None = key("rate of the loss of strength in the layer; null: that of coupling", "1/s", ge=0, le=1e6, default=None)
    slip_at_peak: float | None = key("slip at the peak in the layer; null: that of coupling.softening", "m", gt=0, le=10, default=None)
    slip_at_residual: float | None = key(
        "slip at the residual strength in the layer; null: that of coupling.softening", "m", gt=0, le=100, default=None
    )


def layer_at(scene: Scene, x: np.ndarray, y: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Layer (n,) at places (n,) of the box in the soil, below a ground (n,), m: 0 is the scene's own soil, k its k-th layer."""
    places, top = scene.geometry.in_survey(x, y), scene.geometry.in_survey(x, ground)[1]
    index = np.zeros(np.shape(x), int)
    for number, layer in enumerate(scene.layers.values(), 1):
        index[layer.region.contains(*places, top)] = number
    return index


class LayerMaterial(NamedTuple):
    """A soil with all that holds for it, whether it is written for its layer or for the whole scene (``Scene.materials``)."""

    name: str
    """``soil`` for the scene's own, or the layer's"""
    soil: Soil
    S_R: float
    gamma: float
    """rate of the loss of strength, 1/s"""
    softening: Softening | None
    """loss of strength with slip"""
    r_u: float
    """pore pressure over overburden; 0 without"""

    def at_depth(self, depth: float) -> LayerMaterial:
        """The material at a depth (m) below its top, whose cohesion does not grow."""
        return self._replace(soil=self.soil.at_depth(depth))

    def kept(self, cohesion: float, friction_angle: float, kPa: float = 1.0, degree: float = 1.0) -> tuple[float, float]:
        """Cohesion and friction angle that failed soil keeps of those at the peak, Eqs. 15 and 14; ``kPa`` and ``degree`` in their units.

        A residual strength that is written takes the place of S_R times the peak, which it never exceeds.
        """
        written = (self.soil.residual_cohesion, kPa, cohesion), (self.soil.residual_friction_angle, degree, friction_angle)
        residual = [self.S_R * peak if value is None else min(unit * value, peak) for value, unit, peak in written]
        return residual[0], residual[1]

    @property
    def residual(self) -> tuple[float, float]:
        """Cohesion (kPa) and friction angle (degree) that failed soil keeps."""
        return self.kept(self.soil.cohesion, self.soil.friction_angle)

    @property
    def residual_gradient(self) -> float:
        """Growth of the residual cohesion with depth, kPa/m."""
        return self.soil.gradient * self.S_R if self.soil.residual_cohesion is None else 0.0

    @property
    def uses_S_R(self) -> bool:
        """Whether S_R acts on it; not where both residual strengths are written."""
        return None in (self.soil.residual_cohesion, self.soil.residual_friction_angle)


def materials_of(scene: Scene) -> tuple[LayerMaterial, ...]:
    """The material of the scene's own soil and those of its layers in order; ValueError where slips of a layer are no pair."""
    coupling, r_u = scene.coupling, 0.0 if scene.water is None else scene.water.r_u or 0.0
    own = LayerMaterial("soil", scene.soil, coupling.S_R, coupling.gamma, coupling.softening, r_u)
    return own, *(
        LayerMaterial(
            name,
            layer.soil,
            coupling.S_R if layer.S_R is None else layer.S_R,
            coupling.gamma if layer.gamma is None else layer.gamma,
            _softening(coupling, layer),
            r_u if layer.r_u is None else layer.r_u,
        )
        for name, layer in scene.layers.items()
    )


def _softening(coupling: Coupling, layer: Layer) -> Softening | None:
    if coupling.softening is None:
        return coupling.softening
    own = {name: value for name in ("slip_at_peak", "slip_at_residual") if (value := getattr(layer, name)) is not None}
    return Softening.model_validate(coupling.softening.model_dump() | own) if own else coupling.softening


def check_coupling(scene: Scene) -> None:
    """Refuse failed soil that would be elastic for ever, and so stronger than before it failed, and keys without effect or sense."""
    for name, layer in scene.layers.items():
        _softening(scene.coupling, layer)
        if layer.slip_at_peak is not None and scene.coupling.softening is None:
            raise ValueError(f"layers.{name}.slip_at_peak: needs coupling.softening, with the slip of the other soil")
        if layer.slip_at_residual is not None and not scene.coupling.softens_by_slip:
            raise ValueError(f"layers.{name}.slip_at_residual: needs coupling.softening.slip_at_residual, the slip of the other soil")
        if layer.S_R is not None and None not in (layer.soil.residual_cohesion, layer.soil.residual_friction_angle):
            raise ValueError(f"layers.{name}.S_R: without effect beside residual_cohesion and residual_friction_angle of its soil")
    if scene.coupling.solid_after_failure == "elastic" and scene.coupling.initial_state == "solid":
        rates = {"coupling.gamma": scene.coupling.gamma, **{f"layers.{name}.gamma": layer.gamma for name, layer in scene.layers.items()}}
        for name, rate in rates.items():
            if rate == 0:
                raise ValueError(
                    f"{name}: 0 1/s with coupling.solid_after_failure: elastic, which only gamma bounds, would leave failed soil "
                    "stronger than its peak; write coupling.solid_after_failure: elastic_plastic, or a gamma above 0"
                )
