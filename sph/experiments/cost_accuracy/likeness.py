"""Whether a scene is like the slope of the cost-accuracy studies, whose errors are then to be expected of it.

Both studies have one slope: 25 m at 60 degrees in one soil of 150 kPa and 20 degrees, S_R 0.10 to 0.50.  How an error passes on to another
slope was not measured; the ranges below are a judgement (ours), narrow where the answer is known to turn on a number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.scene.geometry import SLOPES
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
        return [] if inside else [f"{self.what} {value:.3g}{unit} is not within {self.least:g} to {self.most:g}{unit}"]


HEIGHT = Range("height", 12.5, 50.0, "m")
ANGLE = Range("slope angle", 50.0, 70.0, "degrees")
COHESION = Range("c / (rho g H)", 0.15, 0.65)
FRICTION = Range("friction angle", 10.0, 30.0, "degrees")
STRENGTH_RATIO = Range("S_R", 0.10, 0.50)
RATE = {"paper": Range("gamma", 100.0, 100.0, "1/s"), "resolved": Range("gamma", 1.0, 100.0, "1/s")}
BENT = 0.05
"""Of the height, by which a ground line may leave the straight line between toe and crest: benches and berms do."""


def unlike(scene: Scene) -> list[str]:
    """In what a scene is not like the measured slope, in words; nothing where it is."""
    geometry, soil = scene.geometry, scene.soil
    if not isinstance(geometry, SLOPES):
        return ["its shape is no slope"]
    (toe_x, toe_y), (crest_x, crest_y), height = geometry.toe, geometry.crest, geometry.slope_height
    x = np.linspace(toe_x, crest_x, 201)[1:-1]
    straight = toe_y + (crest_y - toe_y) * (x - toe_x) / (crest_x - toe_x) if crest_x > toe_x else geometry.ground(x)
    weight = soil.density * scene.gravity.acceleration * height
    residual = (soil.residual_cohesion, soil.residual_friction_angle)
    return [
        *HEIGHT.misses(height),
        *ANGLE.misses(float(np.degrees(np.arctan2(crest_y - toe_y, crest_x - toe_x)))),
        *(["its face is not plane"] if np.abs(geometry.ground(x) - straight).max() > BENT * height else []),
        *(["it has layers"] if scene.layers else []),
        *(["its strength varies from place to place"] if scene.varying else []),
        *(["it has water"] if scene.water is not None else []),
        *COHESION.misses(1e3 * soil.cohesion / weight if weight else np.inf),
        *FRICTION.misses(soil.friction_angle),
        *(["its residual strength is written, not by S_R"] if residual != (None, None) else STRENGTH_RATIO.misses(scene.coupling.S_R)),
        *(["strength is lost by slip"] if scene.coupling.softens_by_slip else RATE[scene.scheme].misses(scene.coupling.gamma)),
    ]
