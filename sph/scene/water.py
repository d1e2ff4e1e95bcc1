"""Water in the pores: a phreatic line, or a ratio r_u of pore pressure to overburden, and whose pressure it is.

Below the line the pore pressure is hydrostatic, the unit weight of water times the vertical depth below it.  Standing water before the
slope is a line above the ground, level there.  How water enters the equations: ``sph.solver.physics.seepage`` and
``sph.solver.physics.pore_pressure``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from sph.scene.configuration import Section, key, without_unnamed
from sph.scene.geometry import Geometry
from sph.scene.liquefaction import LARGEST_KRAMER_WANG, clean_sand_residual
from sph.scene.places import Coordinate, Point, Shape
from sph.scene.survey import SurveyLine, check_line, read_line

if TYPE_CHECKING:
    from sph.scene.schema import Scene

PRESSURES = {
    "by_place": "soil has the pressure of its present place: drained soil, sand and gravel, whose water flows as fast as it moves",
    "carried": "soil keeps the pressure that it has at the start: undrained soil, silt and clay, which moves faster than its water drains",
}
"""Whose the pore pressure is, and which soil that suits."""
Ratio = Annotated[float, Field(ge=0, lt=1)]


class Liquefaction(Section):
    """When sand has liquefied, and the strength that it then keeps, whatever its stress: min(S_r, drained strength)."""

    r_u: float = key(
        "excess pore pressure over the initial vertical effective stress from which on sand is liquefied", gt=0, le=1, default=0.7
    )
    shear_strain: float = key(
        "shear strain since the gravity stage, 2 sqrt(e_xy^2 + (e_xx - e_yy)^2/4), that also makes it so", gt=0, le=1, default=0.08
    )
    strength: Literal["idriss_boulanger", "idriss_boulanger_no_redistribution", "kramer_wang"] = key(
        "residual strength S_r by the blow count, where the soil gives no number: idriss_boulanger, a ratio to the initial vertical "
        "effective stress; no_redistribution, the same where void redistribution cannot matter, without a less pervious layer on top; "
        "kramer_wang, up to (N1)60 = 15",
        source="Idriss and Boulanger 2008; Kramer and Wang 2015",
        default="idriss_boulanger",
    )


class ExcessPressure(Section):
    """Excess pore pressure of undrained sand by cyclic shear, where its soil has a blow count or a relative density."""

    stiffness_exponent: float = key(
        "shear and rebound modulus fall as (1 - r_u) to this power; 0: they stay", source="Finn et al. 1977", ge=0, le=1, default=0.5
    )
    least_stiffness: float = key("least share of these moduli that is left", gt=0, le=1, default=0.1)
    liquefaction: Liquefaction | None = key(
        "sand that liquefies fails then and only then, and keeps its residual strength; null: it fails as other soil does", default=None
    )


class Water(SurveyLine):
    """Pore pressure of the soil: by ``level``, by ``points`` or ``file``, or by ``r_u``."""

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
    excess_pressure: ExcessPressure | None = key(
        "pore pressure that cyclic shear raises in loose sand, which carries it along; null: none", default=None
    )

    @classmethod
    def read_content(cls, path: Path, keys: Mapping[str, Any]) -> dict[str, Any]:
        """The points of a file."""
        return {"points": read_line(path, steps=False, section=keys.get("section"))}

    @model_validator(mode="before")
    @classmethod
    def _drained_or_not(cls, keys: Any) -> Any:
        if isinstance(keys, Mapping) and keys.get("pressure") is None:
            choices = "; or ".join(f"pressure: {name} ({text})" for name, text in PRESSURES.items())
            raise ValueError(f"pressure: must be given, since it decides the strength of moving soil: {choices}")
        return keys

    @model_serializer(mode="wrap")
    def _stored(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without an excess pressure that nobody named, so that what is stored of other scenes stays as it was."""
        return without_unnamed(self, handler(self), ("excess_pressure",))

    @model_validator(mode="after")
    def _sound(self) -> Water:
        given = [name for name in ("level", "points", "r_u") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                f"level, points (or file), r_u: {' and '.join(given) or 'none'} given; write one of them, and null for others below it"
            )
        if self.points is not None:
            check_line(self.points, [f"points.{number}" for number in range(len(self.points))], steps=False)
        return self

    @property
    def is_carried(self) -> bool:
        """Whether soil carries a pore pressure along, all of it or what cyclic shear raises."""
        return self.pressure == "carried" or self.excess_pressure is not None

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


def check_water(scene: Scene) -> None:
    """Refuse water that the shape, the walls or the loads of the scene do not go with."""
    water, geometry = scene.water, scene.geometry
    for name, layer in scene.layers.items():
        if layer.r_u is not None and (water is None or water.r_u is None):
            raise ValueError(f"layers.{name}.r_u: {layer.r_u} needs water.r_u, the ratio of the other soil (0 where that is dry)")
    _check_excess_pressure(scene)
    if water is None:
        return
    if scene.gravity.acceleration == 0:
        raise ValueError("gravity.acceleration: 0 m/s2 with water, whose pressure gravity makes; set water: null")
    if scene.prescribed_velocity_gradient is not None:
        raise ValueError("prescribed_velocity_gradient: moves the soil instead of forces, those of water among them; set water: null")
    if scene.gravity.inclination != 0 and (water.r_u is None or geometry.shape != "block"):
        raise ValueError(
            f"gravity.inclination: {scene.gravity.inclination} degree with water needs water.r_u and geometry.shape: block, "
            "since depths count along the vertical"
        )
    carried = "water.pressure: carried" if water.pressure == "carried" else "water.excess_pressure"
    if water.is_carried and any(soil.dilation_angle > 0 for soil in scene.soils):
        raise ValueError(f"soil.dilation_angle: above 0 with {carried}, that of soil that keeps its volume; set it to 0 in all layers")
    if water.is_carried and scene.walls.friction is not None:
        raise ValueError(f"walls.friction: with {carried} it acts on total, not effective, stress; choose contact walls")
    if water.points is not None:
        ends = sorted(float(geometry.in_survey(x, 0.0)[0]) for x in (0.0, geometry.width))
        near = 1e-6 * geometry.width
        if not (water.line[0, 0] <= ends[0] + near and ends[1] - near <= water.line[-1, 0]):
            raise ValueError(
                f"water.points: reach from x = {water.line[0, 0]:.10g} to {water.line[-1, 0]:.10g} m and not from side to side of the "
                f"model, {ends[0]:.10g} to {ends[1]:.10g} m; add points"
            )
        if scene.walls.kinds.sides.periodic and np.ptp(water.line[:, 1]) > 0:
            raise ValueError("water.points: a line that is not level does not go on over walls.sides: periodic; write water.level")
    standing = standing_water(water, geometry)
    if standing is None:
        return
    depth, level = standing
    if not level:
        raise ValueError(
            f"water.points: the line lies up to {depth:.3g} m above the ground and is not level there, as standing water is; "
            "lead it along the ground or below, and level where water stands"
        )
    if water.pressure == "carried":
        raise ValueError(
            f"water.pressure: carried with water that stands up to {depth:.3g} m above the ground, whose load on the ground "
            "is known for by_place only; lower the water to the ground or write pressure: by_place"
        )


def _check_excess_pressure(scene: Scene) -> None:
    """Refuse excess pore pressure that nothing would raise, and keys of sand that can liquefy without it."""
    wanted = None if scene.water is None else scene.water.excess_pressure
    sands = [(path, soil) for path, soil in zip(scene.soil_keys, scene.soils, strict=True) if soil.can_liquefy]
    if wanted is None:
        for path, soil in sands:
            name = "blow_count" if soil.blow_count is not None else "relative_density"
            raise ValueError(
                f"{path}.{name}: {getattr(soil, name):g} needs water.excess_pressure; write it ({{}} for its defaults) or null"
            )
        return
    if not sands:
        raise ValueError("water.excess_pressure: needs a soil or a layer with blow_count or relative_density, whose pressure rises")
    numbers = [path for path, soil in sands if soil.liquefied_strength is not None or soil.liquefied_strength_ratio is not None]
    if wanted.liquefaction is None:
        if numbers:
            raise ValueError(f"{numbers[0]}.liquefied_strength: needs water.excess_pressure.liquefaction; write it ({{}} for its defaults)")
        return
    if scene.coupling.initial_state == "fluid":
        raise ValueError("water.excess_pressure.liquefaction: with coupling.initial_state: fluid all soil has failed; write null")
    for path, soil in sands:
        blows = clean_sand_residual(soil.equivalent_blow_count, soil.fines_content or 0.0)
        if wanted.liquefaction.strength == "kramer_wang" and path not in numbers and blows > LARGEST_KRAMER_WANG:
            raise ValueError(
                f"water.excess_pressure.liquefaction.strength: kramer_wang holds up to (N1)60 = {LARGEST_KRAMER_WANG:g}, and {path} has "
                f"{blows:.3g} with its fines; write idriss_boulanger, or its liquefied_strength or liquefied_strength_ratio"
            )
