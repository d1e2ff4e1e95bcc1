"""The gravity stage and what the soil starts with."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from sph.scene.configuration import Section, key
from sph.scene.places import Coordinate
from sph.scene.units import GRAVITY as GRAVITY
from sph.scene.units import Acceleration

FAILED_AREA = 0.01
"""Part of H^2, H the height of the slope, that failed soil covers where the slope has failed: in a run soil that yields under gravity
alone, in a static test displaced soil."""
FAILED_SHARE = 0.1
"""The same over the soil that has moved: of a mechanism much smaller than H^2, so much need to have failed under gravity alone."""
MIN_MOVED = 10
"""Particles that are a mechanism; fewer have rolled off."""
MOVED = 0.01
"""Displacement, over H, beyond which soil has moved."""
UNSHAKEN = 0.0025
"""Acceleration over gravity up to which ground counts as not shaken: a hundredth of the yield acceleration of slopes that stand well.  It
changes the factor of safety of an infinite slope by 0.0025 (cot(alpha) + tan(alpha)), 1 % at most between 15 and 75 degrees."""
Velocity = Annotated[float, Field(ge=-1e6, le=1e6)]


class UniformStress(Section):
    """The same stress everywhere."""

    pressure: float = key("mean pressure, smaller than the bulk modulus", "kPa", ge=-1e6, le=1e6)


class InitialVelocity(Section):
    """Velocity of the soil at the start, linear between places; axes are a survey's where there is one."""

    along: Literal["x", "y"] = key("coordinate on which the velocity depends")
    position: tuple[Coordinate, ...] = key(
        "places in increasing order, in the coordinates of the survey if there is one; beyond the ends the velocity is that at the end",
        "m",
        min_length=1,
    )
    x: tuple[Velocity, ...] = key("horizontal velocity at the places", "m/s")
    y: tuple[Velocity, ...] = key("vertical velocity at the places", "m/s")

    @model_validator(mode="after")
    def _table(self) -> InitialVelocity:
        for name in ("x", "y"):
            if len(getattr(self, name)) != len(self.position):
                raise ValueError(f"{name}: {len(getattr(self, name))} velocities for {len(self.position)} places")
        if any(after <= before for before, after in pairwise(self.position)):
            raise ValueError(f"position: the places {list(self.position)} m must increase")
        return self

    def at(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocity (n,) along x and y at places (n,), m/s."""
        place = x if self.along == "x" else y
        return np.interp(place, self.position, self.x), np.interp(place, self.position, self.y)


class VelocityGradient(Section):
    """A homogeneous deformation that moves the soil instead of forces: an element test; axes are a survey's where there is one."""

    xx: float = key("dv_x/dx", "1/s", ge=-1e4, le=1e4, default=0.0)
    xy: float = key("dv_x/dy", "1/s", ge=-1e4, le=1e4, default=0.0)
    yx: float = key("dv_y/dx", "1/s", ge=-1e4, le=1e4, default=0.0)
    yy: float = key("dv_y/dy", "1/s", ge=-1e4, le=1e4, default=0.0)


class GravityStage(Section):
    """How gravity is applied before the failure criterion takes effect."""

    ramp: float = key("duration of the linear increase of gravity; 0 applies it at once", "s", ge=0, le=100, default=1.0)
    duration: float = key(
        "length of the stage; failure counts from its end, and soil at yield then counts as failed",
        "s",
        "Sec. 3.2",
        gt=0,
        le=1000,
        default=3.0,
    )
    damping: float = key("extra mass-proportional damping, faded out over the last third", "1/s", ge=0, le=1e4, default=20.0)
    acceleration: Acceleration = key("gravity", "m/s2", "Sec. 3.2", ge=0, le=100, default=GRAVITY)
    inclination: float = key(
        "angle by which gravity is turned towards the toe: the box stands on an incline", "degree", ge=-90, le=90, default=0.0
    )
    initial_stress: Literal["none", "geostatic"] | UniformStress = key(
        "stress at the start: none; geostatic, that of level ground at the same depth, with the K0 of its soil (needs ramp: 0; the "
        "default if a K0 is given); or a uniform pressure",
        default="none",
    )

    def failed(self, t_f: np.ndarray) -> np.ndarray:
        """Which particles (n,) failed under gravity alone, by their times of failure (s): at the end of the stage."""
        return np.isclose(t_f, self.duration, rtol=1e-9, atol=0.0)
