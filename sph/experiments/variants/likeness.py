"""Whether a scene is like the slope of the cost-accuracy study of its scheme, whose errors are then to be expected of it.

Both studies have one slope: 25 m at 60 degrees in one soil of 150 kPa and 20 degrees.  That of the scheme ``paper`` loses its strength with
time, S_R 0.10 to 0.50, and is of one soil down to its base; that of ``resolved`` loses it by slip, S_R 0.10 to 0.35, and stands on rock.
How an error passes on to another slope was not measured; the ranges below are a judgement (ours), narrow where the answer is known to turn
on a number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.checks.loss import slip_zone
from sph.scene.geometry import SLOPES
from sph.scene.layers import ElevationRegion, Layer
from sph.scene.schema import Scene


class Range(NamedTuple):
    """Values that count as like the measured one."""

    what: str
    least: float
    most: float
    unit: str = ""

    def misses(self, value: float) -> list[str]:
        """What is said of a value outside."""
        inside = self.least * (1 - 1e-9) <= value <= self.most * (1 + 1e-9)
        unit = f" {self.unit}" if self.unit else ""
        wanted = f"within {self.least:g} to {self.most:g}" if self.least < self.most else f"{self.least:g}"
        return [] if inside else [f"{self.what} {value:.3g}{unit} is not {wanted}{unit}"]


HEIGHT = Range("height", 12.5, 50.0, "m")
ANGLE = Range("slope angle", 50.0, 70.0, "degrees")
COHESION = Range("c / (rho g H)", 0.15, 0.65)
FRICTION = Range("friction angle", 10.0, 30.0, "degrees")
STRENGTH_RATIO = {"paper": Range("S_R", 0.10, 0.50), "resolved": Range("S_R", 0.10, 0.40)}
"""A slope of ``resolved`` that keeps more does not run out, and a movement of decimetres has no error in per cent."""
RATE = Range("gamma", 100.0, 100.0, "1/s")
SLIP_ZONE = Range("slip zone over height", 1.0, 10.0)
"""That of the measured slopes is 1.3 to 7.8 (``sph.checks.loss.slip_zone``)."""
BENT = 0.05
"""Of the height, by which a ground line may leave the straight line between toe and crest: benches and berms do."""
ROCK = 1.0
"""c / (rho g H) from which on ground below the toe counts as rock."""
NEAR = 0.1
"""Of the height, by which rock, or the base of the box, may lie below or above the toe."""


def unlike(scene: Scene) -> list[str]:
    """How a scene differs from the measured slope, in words; empty where it is like it."""
    geometry, soil = scene.geometry, scene.soil
    if not isinstance(geometry, SLOPES):
        return ["its shape is not a slope"]
    (toe_x, toe_y), (crest_x, crest_y), height = geometry.toe, geometry.crest, geometry.slope_height
    x = np.linspace(toe_x, crest_x, 201)[1:-1]
    straight = toe_y + (crest_y - toe_y) * (x - toe_x) / (crest_x - toe_x) if crest_x > toe_x else geometry.ground(x)
    weight = soil.density * scene.gravity.acceleration * height
    residual = (soil.residual_cohesion, soil.residual_friction_angle)

    def is_rock(layer: Layer) -> bool:
        region = layer.region
        if not isinstance(region, ElevationRegion) or region.bottom is not None or region.top is None:
            return False
        return abs(region.top - toe_y) <= NEAR * height and 1e3 * layer.soil.cohesion >= ROCK * weight

    own = scene.scheme == "resolved"
    rock = [layer for layer in scene.layers.values() if own and is_rock(layer)]
    return [
        *HEIGHT.misses(height),
        *ANGLE.misses(float(np.degrees(np.arctan2(crest_y - toe_y, crest_x - toe_x)))),
        *(["its face is not plane"] if np.abs(geometry.ground(x) - straight).max() > BENT * height else []),
        *(["it has layers"] if len(scene.layers) > len(rock) else []),
        *(["soil, not rock, lies below its toe"] if own and not scene.layers and toe_y > NEAR * height else []),
        *(["its strength varies from place to place"] if scene.strength_varies else []),
        *(["it has water"] if scene.water is not None else []),
        *COHESION.misses(1e3 * soil.cohesion / weight if weight else np.inf),
        *FRICTION.misses(soil.friction_angle),
        *(
            ["its residual strength is given directly, not by S_R"]
            if residual != (None, None)
            else STRENGTH_RATIO[scene.scheme].misses(scene.coupling.S_R)
        ),
        *_loss(scene, height),
    ]


def _loss(scene: Scene, height: float) -> list[str]:
    """In what its loss of strength is not that of the slope of its scheme."""
    if scene.scheme == "paper":
        return ["its strength is lost with slip"] if scene.coupling.softens_by_slip else RATE.misses(scene.coupling.gamma)
    if not scene.coupling.softens_by_slip or scene.coupling.gamma > 0.0:
        return ["its strength is lost with time"]
    return SLIP_ZONE.misses(slip_zone(scene, scene.materials[0]) / height)
