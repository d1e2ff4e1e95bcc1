"""The scene: everything a run needs, validated before any work and immutable.

A scene file (YAML) holds the sections below.  Users write kPa and degrees; the
properties ending in ``_si`` give pascals and radians to the solver.  Every key is
declared here once, with its unit, allowed range, default and source, and
``config/README.md`` is generated from these declarations (``sph reference scene``).

A term of physics that a scene does not want is ``null``; a term it wants is a small
record of its own coefficients.  There are no on/off flags beside coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations, pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from sph.configuration import Section, key, merge, read_yaml, validated

GRAVITY = 9.81
"""Gravitational acceleration, m/s2."""

MOST_PARTICLES = 5_000_000
"""Most particles of a scene: lattice points of the box and its walls."""
MOST_PAIRS = 1_000_000_000
"""Most pairs of neighbours, whose lists take some 30 bytes each."""
MOST_STEPS = 20_000_000
"""Most time steps of a run; the loads of every step are kept, 32 bytes each."""
MOST_SAMPLES = 1_000_000
"""Most samples of the series of a run."""
MOST_STORED = 200_000_000
"""Most frames times particles of a run, whose fields take 58 bytes each."""

Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Velocity = Annotated[float, Field(ge=-1e6, le=1e6)]
Frequency = Annotated[float, Field(ge=1e-3, le=1e4)]


# ---------------------------------------------------------------- geometry


class Slope(Section):
    """A plane slope on a base layer in a rigid box: toe on the left, crest on the right."""

    shape: Literal["slope"] = key("plane slope on a base layer", source="Fig. 1")
    slope_angle: float = key("inclination of the face", "degree", "Sec. 3.1", ge=0.01, le=90, default=60.0)
    slope_height: float = key("height from toe to crest", "m", "ours: Fig. 1 is missing", gt=0, le=500, default=25.0)
    base_depth: float = key("thickness of the layer below the toe", "m", "ours: Fig. 1 is missing", ge=0, le=500, default=10.0)
    apron_length: float = key("length from the front wall to the toe", "m", "ours: gives 2,404 particles", ge=0, le=2000, default=55.0)
    crest_length: float = key(
        "length from the crest edge to the back wall", "m", "ours: gives 2,404 particles", gt=0, le=2000, default=34.0
    )

    @property
    def width(self) -> float:
        """Inner width of the box, m."""
        run = self.slope_height / math.tan(math.radians(self.slope_angle))
        return self.apron_length + run + self.crest_length

    @property
    def height(self) -> float:
        """Height of the soil at the crest, m."""
        return self.base_depth + self.slope_height

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        (toe_x, toe_y), (crest_x, crest_y) = self.toe, self.crest
        return (0.0, toe_x, crest_x, self.width), (toe_y, toe_y, crest_y, crest_y)

    @property
    def toe(self) -> tuple[float, float]:
        """Toe of the slope, m."""
        return self.apron_length, self.base_depth

    @property
    def crest(self) -> tuple[float, float]:
        """Crest edge, m."""
        return self.width - self.crest_length, self.height


class Block(Section):
    """A rectangular block, for columns and test problems."""

    shape: Literal["block"] = key("rectangular block")
    width: float = key("width", "m", gt=0, le=2000)
    height: float = key("height", "m", gt=0, le=1000)

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Corners (x, y) of the ground from left to right, m."""
        return (0.0, self.width), (self.height, self.height)

    @property
    def toe(self) -> tuple[float, float]:
        """Lower left corner of the free face, m."""
        return 0.0, 0.0

    @property
    def crest(self) -> tuple[float, float]:
        """Upper left corner, m."""
        return 0.0, self.height


Point = tuple[Coordinate, Coordinate]


class PolygonBody(Section):
    """A body of soil inside a polygon."""

    kind: Literal["polygon"] = key("inside of a polygon", default="polygon")
    points: tuple[Point, ...] = key("corners [x, y] in order, the last joined to the first", "m", min_length=3, max_length=10000)

    @property
    def outline(self) -> np.ndarray:
        """Corners (n, 2), m."""
        return np.array(self.points)

    def contains(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Which of the places (n,) lie inside, by the number of sides to their right."""
        inside = np.zeros(np.shape(x), bool)
        for (x1, y1), (x2, y2) in zip(self.points, np.roll(self.outline, -1, axis=0), strict=True):
            if y1 != y2:
                inside ^= ((y1 <= y) != (y2 <= y)) & (x < x1 + (y - y1) / (y2 - y1) * (x2 - x1))
        return inside


class RingBody(Section):
    """A body of soil between two circles."""

    kind: Literal["ring"] = key("inside of a ring, or of a disc where the inner radius is 0")
    centre: Point = key("centre [x, y]", "m")
    outer_radius: float = key("outer radius", "m", gt=0, le=1000)
    inner_radius: float = key("inner radius", "m", ge=0, le=1000, default=0.0)

    @model_validator(mode="after")
    def _hollow(self) -> RingBody:
        if not self.inner_radius < self.outer_radius:
            raise ValueError(f"inner_radius: {self.inner_radius} m must be smaller than outer_radius: {self.outer_radius} m")
        return self

    @property
    def outline(self) -> np.ndarray:
        """Points (n, 2) of the outer circle, m."""
        angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
        return np.array(self.centre) + self.outer_radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def contains(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Which of the places (n,) lie inside."""
        r = np.hypot(x - self.centre[0], y - self.centre[1])
        return (self.inner_radius <= r) & (r < self.outer_radius)


def _upper_side(outline: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Height (n,) of the top of a body at the places x (n,), m; 0 beside it."""
    y = np.zeros(x.size)
    for (x1, y1), (x2, y2) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if x1 != x2:
            over = (min(x1, x2) <= x) & (x <= max(x1, x2))
            y[over] = np.maximum(y[over], y1 + (x[over] - x1) / (x2 - x1) * (y2 - y1))
    return y


class Bodies(Section):
    """Bodies of any shape in a box, for columns that collapse, plates, rings and blocks that slide."""

    shape: Literal["bodies"] = key("bodies of any shape in a box")
    width: float = key("inner width of the box", "m", gt=0, le=2000)
    height: float = key("height of the box's side walls", "m", gt=0, le=1000)
    bodies: tuple[Annotated[PolygonBody | RingBody, Field(discriminator="kind")], ...] = key("the bodies", min_length=1, max_length=100)

    @model_validator(mode="after")
    def _inside(self) -> Bodies:
        for number, body in enumerate(self.bodies):
            low, high = body.outline.min(axis=0), body.outline.max(axis=0)
            if min(low) < 0 or high[0] > self.width * (1 + 1e-9) or high[1] > self.height * (1 + 1e-9):
                raise ValueError(
                    f"bodies.{number}: reaches from ({low[0]:g}, {low[1]:g}) to ({high[0]:g}, {high[1]:g}) m, "
                    f"out of the box of {self.width:g} x {self.height:g} m"
                )
        return self

    @property
    def surface(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Upper envelope (x, y) of the bodies from left to right, m; at height 0 beside them."""
        outlines = [body.outline for body in self.bodies]
        corners = np.unique(np.concatenate([outline[:, 0] for outline in outlines]))
        beside = 1e-9 * self.width
        x = np.unique(np.clip(np.concatenate([[0.0, self.width], corners - beside, corners + beside]), 0.0, self.width))
        crossings = [x]
        for one, other in combinations([_upper_side(outline, x) for outline in outlines], 2):
            above = one - other
            cross = (above[:-1] * above[1:] < 0.0) & (np.diff(x) > 3.0 * beside)
            crossings.append((x[:-1] + np.diff(x) * above[:-1] / np.where(cross, above[:-1] - above[1:], 1.0))[cross])
        x = np.unique(np.concatenate(crossings))
        y = np.max([_upper_side(outline, x) for outline in outlines], axis=0)
        return tuple(x.tolist()), tuple(y.tolist())

    @property
    def toe(self) -> Point:
        """Lowest corner, the leftmost of several, m."""
        return min(self._corners, key=lambda point: (point[1], point[0]))

    @property
    def crest(self) -> Point:
        """Highest corner, the leftmost of several, m."""
        return min(self._corners, key=lambda point: (-point[1], point[0]))

    @property
    def _corners(self) -> list[Point]:
        return [(float(x), float(y)) for body in self.bodies for x, y in body.outline]


Geometry = Annotated[Slope | Block | Bodies, Field(discriminator="shape")]


class WallFriction(Section):
    """Coulomb friction between soil and free-slip walls; a wall without a coefficient has none."""

    base: float = key("coefficient of friction (tangent of the angle) at base and top", ge=0, le=10, default=0.0)
    sides: float = key("coefficient of friction at the side walls", ge=0, le=10, default=0.0)


class Walls(Section):
    """How the box holds the soil."""

    base: Literal["sticky", "free_slip", "none"] = key(
        "bottom of the box: fixed 'dynamic boundary' particles (the paper), a frictionless floor, or nothing",
        source="Sec. 2.4; free_slip ours",
        default="sticky",
    )
    sides: Literal["sticky", "free_slip", "periodic", "none"] = key(
        "side walls: fixed particles that hold the soil (the paper), a frictionless wall, soil that goes on periodically, or nothing",
        source="Sec. 2.4; free_slip and periodic ours",
        default="sticky",
    )
    top: Literal["sticky", "free_slip", "none"] = key("lid of the box, for flows between plates", default="none")
    friction: WallFriction | None = key("friction on free-slip walls", default=None)
    layers: int = key(
        "layers of boundary particles; free-slip walls need as many as fill the kernel's support but for one spacing",
        source="Sec. 4 (2,404 particles)",
        ge=1,
        le=8,
        default=2,
    )

    @property
    def hold(self) -> bool:
        """Whether there is a wall at all."""
        return any(how in ("sticky", "free_slip") for how in (self.base, self.sides, self.top))


# ---------------------------------------------------------------- material


class Soil(Section):
    """Tables 1 and 2 of the paper."""

    density: float = key("density", "kg/m3", "Table 1", ge=1e-3, le=1e5, default=1964.0)
    youngs_modulus: float = key("Young's modulus", "kPa", "Table 1", ge=1e-6, le=1e9, default=1.675e6)
    poisson_ratio: float = key("Poisson's ratio", source="Table 1", ge=0, le=0.499, default=0.346)
    cohesion: float = key("cohesion of the solid state", "kPa", "Table 1", ge=0, le=1e6, default=150.0)
    friction_angle: float = key("internal friction angle of the solid state", "degree", "Table 1", ge=0, le=50, default=20.0)
    viscosity: float = key("viscosity coefficient of the fluid state", "Pa s", "Table 2", ge=0, le=1e9, default=2.0)

    @property
    def shear_modulus_si(self) -> float:
        """G, Pa."""
        return 1e3 * self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def bulk_modulus_si(self) -> float:
        """K, Pa."""
        return 1e3 * self.youngs_modulus / (3 * (1 - 2 * self.poisson_ratio))

    @property
    def p_wave_speed(self) -> float:
        """V_p, m/s."""
        return math.sqrt((self.bulk_modulus_si + 4 / 3 * self.shear_modulus_si) / self.density)

    @property
    def s_wave_speed(self) -> float:
        """V_s, m/s."""
        return math.sqrt(self.shear_modulus_si / self.density)

    @property
    def cohesion_si(self) -> float:
        """c_s, Pa."""
        return 1e3 * self.cohesion

    @property
    def friction_angle_si(self) -> float:
        """phi_s, rad."""
        return math.radians(self.friction_angle)


class ElasticViscoplastic(Section):
    """Bingham fluid with elastic strain below yield: no creep, no viscous time-step limit."""

    law: Literal["elastic_viscoplastic"] = key("closed-form elastic-viscoplastic Bingham law", default="elastic_viscoplastic")


class CappedViscosity(Section):
    """Bingham fluid as a viscous fluid of capped viscosity (common in the literature); it creeps."""

    law: Literal["capped_viscosity"] = key("viscous fluid with min(eta + tau_y / shear rate, max_viscosity)")
    max_viscosity: float = key("largest viscosity; limits the time step", "Pa s", gt=0, le=1e12, default=3e6)


FluidLaw = Annotated[ElasticViscoplastic | CappedViscosity, Field(discriminator="law")]


class Coupling(Section):
    """The paper's coupling of the solid and the fluid state (Eqs. 8, 9, 14, 15)."""

    S_R: float = key(
        "strength ratio: c_f = S_R c_s and phi_f = S_R phi_s (not the factor that divides c and tan phi)",
        source="Eqs. 14-15",
        ge=0,
        le=1,
        default=0.25,
    )
    gamma: float = key("rate of the loss of strength after failure", "1/s", "Eq. 9", ge=0, le=1e6, default=100.0)
    fluid: FluidLaw = key("constitutive law of the fluid state", source="Eq. 13", default=ElasticViscoplastic())
    initial_state: Literal["solid", "fluid"] = key(
        "solid: particles fail when their stress reaches the surface (the paper); fluid: all have failed long before the start",
        default="solid",
    )
    fluid_tension_limit: float | None = key(
        "largest mean tension the fluid state carries; null: the apex of its Mohr-Coulomb surface (412 kPa in the paper's soil at any S_R)",
        "kPa",
        ge=0,
        le=1e6,
        default=0.0,
    )


# ---------------------------------------------------------------- loading


class TaperedSine(Section):
    """A sine with a linear ramp up and down (Sec. 3.2)."""

    kind: Literal["tapered_sine"] = key("sine with linear ramps", source="Sec. 3.2")
    amplitude: float = key("peak acceleration of the box, horizontal", "m/s2", "Sec. 3.2", ge=0, le=100, default=6.0)
    frequency: float = key("frequency", "Hz", "ours (not in the text)", gt=0, le=100, default=1.0)
    start: float = key("start of the shaking", "s", "Sec. 3.2", ge=0, le=1e4, default=3.0)
    ramp: float = key("duration of the increase", "s", "ours ('gradually')", ge=0, le=1e4, default=3.0)
    decay_start: float = key("start of the decrease", "s", "Sec. 3.2", ge=0, le=1e4, default=9.0)
    end: float = key("end of the shaking", "s", "Sec. 3.2", ge=0, le=1e4, default=10.0)

    @model_validator(mode="after")
    def _in_order(self) -> TaperedSine:
        if not self.start + self.ramp <= self.decay_start <= self.end:
            raise ValueError(
                f"motion: start + ramp ({self.start + self.ramp} s) <= decay_start ({self.decay_start} s) "
                f"<= end ({self.end} s) does not hold"
            )
        return self

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        rise = linear_ramp(time - self.start, self.ramp)
        fall = 1.0 - linear_ramp(time - self.decay_start, self.end - self.decay_start)
        phase = 2.0 * np.pi * self.frequency * (time - self.start)
        return np.where(time < self.start, 0.0, self.amplitude * rise * fall * np.sin(phase))


class Ricker(Section):
    """A Ricker wavelet: a pulse with all frequencies up to some three times its own (Ricker 1953)."""

    kind: Literal["ricker"] = key("Ricker wavelet")
    amplitude: float = key("peak acceleration of the box, horizontal", "m/s2", ge=0, le=1e4)
    frequency: float = key("frequency with the largest amplitude", "Hz", gt=0, le=1e4)
    peak: float = key("time of the peak, at least 1.5 / frequency after the gravity stage", "s", ge=0, le=1e4)

    @property
    def start(self) -> float:
        """Time before which the wavelet is below 1e-8 of its peak and taken as nothing, s."""
        return self.peak - 1.5 / self.frequency

    @property
    def end(self) -> float:
        """Time after which it is, s."""
        return self.peak + 1.5 / self.frequency

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        square = (np.pi * self.frequency * (time - self.peak)) ** 2
        return np.where(np.abs(time - self.peak) > 1.5 / self.frequency, 0.0, self.amplitude * (1.0 - 2.0 * square) * np.exp(-square))


class ConstantAcceleration(Section):
    """An acceleration that is brought on and stays: the pseudo-static earthquake load."""

    kind: Literal["constant"] = key("constant acceleration")
    amplitude: float = key("acceleration of the box, horizontal; positive drives the soil towards the toe", "m/s2", ge=-1e3, le=1e3)
    start: float = key("start of the linear increase", "s", ge=0, le=1e4)
    ramp: float = key("duration of the increase", "s", ge=0, le=1e4)

    @property
    def end(self) -> float:
        """Time from which on the load is constant, s."""
        return self.start + self.ramp

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        return np.where(time < self.start, 0.0, self.amplitude * linear_ramp(time - self.start, self.ramp))


class NoMotion(Section):
    """No shaking."""

    kind: Literal["none"] = key("no shaking", default="none")

    def acceleration(self, time: np.ndarray) -> np.ndarray:
        """Horizontal acceleration of the box at times (s), m/s2."""
        return np.zeros_like(time)


def linear_ramp(time: np.ndarray, length: float) -> np.ndarray:
    """0 before time 0, 1 after ``length`` (s), linear between."""
    with np.errstate(over="ignore"):  # of a length next to nothing
        return np.clip(time / length, 0.0, 1.0) if length > 0 else np.where(time < 0.0, 0.0, 1.0)


Motion = Annotated[TaperedSine | Ricker | ConstantAcceleration | NoMotion, Field(discriminator="kind")]


class UniformStress(Section):
    """The same stress everywhere."""

    pressure: float = key("mean pressure, smaller than the bulk modulus", "kPa", ge=-1e6, le=1e6)


class InitialVelocity(Section):
    """Velocity of the soil at the start, linear between places."""

    along: Literal["x", "y"] = key("coordinate on which the velocity depends")
    position: tuple[Coordinate, ...] = key("places, increasing; beyond the ends the velocity is that at the end", "m", min_length=1)
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


class VelocityGradient(Section):
    """A homogeneous deformation that moves the soil instead of forces: an element test."""

    xx: float = key("dv_x/dx", "1/s", ge=-1e4, le=1e4, default=0.0)
    xy: float = key("dv_x/dy", "1/s", ge=-1e4, le=1e4, default=0.0)
    yx: float = key("dv_y/dx", "1/s", ge=-1e4, le=1e4, default=0.0)
    yy: float = key("dv_y/dy", "1/s", ge=-1e4, le=1e4, default=0.0)


class GravityStage(Section):
    """How gravity is brought on before the failure criterion is armed."""

    ramp: float = key("duration of the linear increase of gravity; 0 applies it at once", "s", ge=0, le=100, default=1.0)
    duration: float = key("length of the stage; failure is armed at its end", "s", "Sec. 3.2", gt=0, le=1000, default=3.0)
    damping: float = key("extra mass-proportional damping, faded out over the last third", "1/s", ge=0, le=1e4, default=20.0)
    acceleration: float = key("gravity", "m/s2", "Sec. 3.2", ge=0, le=100, default=GRAVITY)
    inclination: float = key(
        "angle by which gravity is turned towards the toe: the box stands on an incline", "degree", ge=-90, le=90, default=0.0
    )
    initial_stress: Literal["none", "geostatic"] | UniformStress = key(
        "stress at the start: none, that of level ground at rest at the depth below the surface (needs ramp: 0), or a uniform pressure",
        default="none",
    )


class RayleighDamping(Section):
    """Rayleigh damping from one damping ratio met at two frequencies (Sec. 2.5)."""

    ratio: float = key("damping ratio at both frequencies", source="ours", ge=0, le=0.5, default=0.02)
    frequencies: tuple[Frequency, Frequency] = key("the two frequencies, from 0.001 to 10000 Hz", "Hz", default=(1.0, 5.6))

    @model_validator(mode="after")
    def _increasing(self) -> RayleighDamping:
        if not self.frequencies[0] < self.frequencies[1]:
            raise ValueError(f"damping: frequencies {list(self.frequencies)} must be increasing")
        return self

    @property
    def mass_coefficient(self) -> float:
        """alpha, 1/s."""
        w1, w2 = (2 * math.pi * f for f in self.frequencies)
        return 2 * self.ratio * w1 * w2 / (w1 + w2)

    @property
    def stiffness_coefficient(self) -> float:
        """beta_R, s."""
        w1, w2 = (2 * math.pi * f for f in self.frequencies)
        return 2 * self.ratio / (w1 + w2)


class EarlyStop(Section):
    """When a run may end before its duration: after the shaking, once the soil has stood still and its loss of strength is over."""

    speed: float = key(
        "the soil (root mean square over its mass) and every probe are slower than this through the window",
        "m/s",
        gt=0,
        le=100,
        default=0.02,
    )
    window: float = key("length of the interval at rest, after the shaking, at whose end the run ends", "s", gt=0, le=1000, default=1.0)
    solid_weight: float = key(
        "no failed particle has a larger weight of its solid state (beta), or the slope may stand now and fail later",
        ge=0,
        lt=1,
        default=0.05,
    )


# ---------------------------------------------------------------- numerics


class ArtificialViscosity(Section):
    """Pairwise dissipation of approaching particles, signal-speed form (Monaghan 1997)."""

    alpha: float = key("coefficient, on V_p", ge=0, le=10, default=0.1)


class ArtificialStress(Section):
    """Repulsion of particles under tension, against their clumping: numerical fracture (Gray, Monaghan and Swift 2001)."""

    factor: float = key("share of the principal tension that is taken back at the initial spacing", gt=0, le=1, default=0.3)
    exponent: float = key("power of W(r) / W(spacing)", ge=1, le=10, default=4.0)


class GradientCorrection(Section):
    """First-order consistent velocity gradients (Randles and Libersky 1996)."""

    min_determinant: float = key(
        "below this determinant of the moment matrix a particle keeps the plain gradient", ge=1e-6, le=1, default=0.3
    )


class ShortRangeRepulsion(Section):
    """A conservative spring between particles that come closer than a fraction of the spacing."""

    range: float = key("range over the spacing", ge=0.01, le=1, default=0.8)
    pressure: float = key("pressure-like stiffness of the spring", "kPa", gt=0, le=1e7, default=500.0)


class AdaptiveStep(Section):
    """The time step divided by a whole number, as the stiffest mode of the particles' present arrangement demands."""

    courant: float = key("largest step over the limit measured during the run", ge=0.01, lt=1, default=0.8)


class Numerics(Section):
    """Resolution, integration and stabilisers."""

    spacing: float = key("initial particle spacing", "m", "Sec. 4", ge=1e-6, le=100, default=1.0)
    kernel: Literal["cubic_spline", "wendland_c2"] = key("smoothing kernel", source="Sec. 4", default="cubic_spline")
    smoothing_ratio: float = key(
        "smoothing length over spacing; the kernel must reach 1.2 spacings", source="Sec. 4 (h = 2.3 m)", ge=0.6, le=5, default=2.3
    )
    smoothing_length_is: Literal["half_support", "support"] = key(
        "reading of the smoothing length: the kernel ends at 2 h (literal) or at h", source="Sec. 4", default="half_support"
    )
    time_step: float = key(
        "time increment; with adaptive_step the largest one, which may lie above the limits", "s", "Sec. 2.6", ge=1e-9, le=1, default=1e-4
    )
    adaptive_step: AdaptiveStep | None = key("divide the time step where the limit demands it", default=None)
    neighbour_skin: float = key("margin of the neighbour list over the spacing", gt=0, le=2, default=0.3)
    gradient_tolerance: float = key(
        "kernel gradients are kept until a particle has moved this far, over the spacing; 0 renews them every step",
        ge=0,
        le=0.1,
        default=0.01,
    )
    precision: Literal["mixed", "double"] = key(
        "mixed: kernel gradients are kept in single precision, all fields and sums in double; double: all in double", default="mixed"
    )
    artificial_viscosity: ArtificialViscosity | None = key("pairwise artificial viscosity", default=ArtificialViscosity())
    artificial_stress: ArtificialStress | None = key("cure of numerical fracture of solids under tension", default=None)
    gradient_correction: GradientCorrection | None = key("corrected velocity gradients", default=None)
    short_range_repulsion: ShortRangeRepulsion | None = key("cure of particle pairing", default=ShortRangeRepulsion())

    @property
    def smoothing_length(self) -> float:
        """h with the kernel ending at 2 h, m."""
        h = self.smoothing_ratio * self.spacing
        return h if self.smoothing_length_is == "half_support" else 0.5 * h


class Outputs(Section):
    """What a run stores, and how often."""

    frame_interval: float = key("interval of the particle fields", "s", gt=0, le=1e4, default=0.25)
    series_interval: float = key("interval of probes, energies and other series", "s", gt=0, le=1e4, default=0.01)


Place = Literal["crest_edge", "toe"] | Point


class Scene(Section):
    """One simulation."""

    name: str = key("name used in file names and titles", pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")
    title: str = key("one line for figures and tables", default="", max_length=200)
    duration: float = key("simulated time", "s", "Sec. 4 (15 s)", gt=0, le=1e4, default=15.0)
    geometry: Geometry = key("shape of the soil", source="Fig. 1")
    walls: Walls = key("the box", source="Sec. 2.4", default=Walls())
    soil: Soil = key("material", source="Tables 1-2", default=Soil())
    coupling: Coupling = key("solid-fluid coupling", source="Sec. 2.3", default=Coupling())
    motion: Motion = key("ground motion", source="Sec. 3.2", default=NoMotion())
    gravity: GravityStage = key("gravity stage", default=GravityStage())
    initial_velocity: InitialVelocity | None = key("velocity at the start", default=None)
    prescribed_velocity_gradient: VelocityGradient | None = key("motion of the soil in an element test, throughout the run", default=None)
    damping: RayleighDamping | None = key("Rayleigh damping", source="Sec. 2.5", default=RayleighDamping())
    early_stop: EarlyStop | None = key("end of a run whose soil has come to rest, before its duration", default=None)
    numerics: Numerics = key("discretisation", source="Secs. 2.6, 4", default=Numerics())
    outputs: Outputs = key("stored data", default=Outputs())
    probes: dict[Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$")], Place] = key(
        "particles followed closely, by name: a place ('crest_edge', 'toe') or [x, y] in m; the nearest particle is taken",
        source="particle A: Figs. 6-7",
        default={"A": "crest_edge"},
    )

    @field_validator("title")
    @classmethod
    def _one_line(cls, title: str) -> str:
        if not title.isprintable():
            raise ValueError("must be one line of printable characters")
        return title

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        self._check_size()
        dt = self.numerics.time_step
        for name in ("series_interval", "frame_interval"):
            _whole_multiple(getattr(self.outputs, name), dt, f"outputs.{name}", "numerics.time_step")
        _whole_multiple(self.outputs.frame_interval, self.outputs.series_interval, "outputs.frame_interval", "outputs.series_interval")
        _whole_multiple(self.duration, self.outputs.series_interval, "duration", "outputs.series_interval")
        _whole_multiple(self.gravity.duration, self.outputs.series_interval, "gravity.duration", "outputs.series_interval")
        if self.early_stop is not None:
            _whole_multiple(self.early_stop.window, self.outputs.series_interval, "early_stop.window", "outputs.series_interval")
        if not isinstance(self.motion, NoMotion) and self.motion.start < self.gravity.duration * (1 - 1e-9):
            where = "motion.peak: the start of the wavelet," if isinstance(self.motion, Ricker) else "motion.start:"
            raise ValueError(f"{where} {self.motion.start:g} s lies inside the gravity stage (gravity.duration: {self.gravity.duration} s)")
        if self.gravity.ramp > self.gravity.duration:
            raise ValueError(f"gravity.ramp: {self.gravity.ramp} s is longer than gravity.duration: {self.gravity.duration} s")
        if self.gravity.initial_stress == "geostatic" and self.gravity.ramp > 0:
            raise ValueError(
                f"gravity.ramp: {self.gravity.ramp} s with gravity.initial_stress: geostatic, "
                "which balances gravity in full from the start; set gravity.ramp: 0"
            )
        if self.gravity.initial_stress == "geostatic" and self.gravity.inclination != 0:
            raise ValueError(
                f"gravity.inclination: {self.gravity.inclination} degree with gravity.initial_stress: geostatic, that of level ground"
            )
        if self.gravity.duration > self.duration:
            raise ValueError(f"gravity.duration: {self.gravity.duration} s is longer than duration: {self.duration} s")
        if isinstance(self.gravity.initial_stress, UniformStress):
            pressure, bulk_modulus = self.gravity.initial_stress.pressure, 1e-3 * self.soil.bulk_modulus_si
            if not abs(pressure) < bulk_modulus:
                raise ValueError(
                    f"gravity.initial_stress.pressure: {pressure} kPa is not smaller than the bulk modulus, {bulk_modulus:g} kPa"
                )
        if 2 * self.numerics.smoothing_length < 1.2 * self.numerics.spacing * (1 - 1e-9):
            raise ValueError(
                f"numerics.smoothing_ratio: {self.numerics.smoothing_ratio} with smoothing_length_is: {self.numerics.smoothing_length_is} "
                "ends the kernel within 1.2 spacings, where it holds too few neighbours"
            )
        self._check_walls()
        if self.numerics.spacing * 2 > min(self.geometry.height, self.geometry.width):
            raise ValueError(f"numerics.spacing: {self.numerics.spacing} m leaves fewer than two particles across the soil")
        return self

    def _check_size(self) -> None:
        """Refuse what no machine at hand can hold or finish, before anything is made of it."""
        numerics, outputs, layers = self.numerics, self.outputs, self.walls.layers
        columns, rows = self.lattice
        particles, steps = (columns + 2 * layers) * (rows + 2 * layers), self.steps(self.duration)
        box = f"in the box of {self.geometry.width:g} x {self.geometry.height:g} m"
        if particles > MOST_PARTICLES:
            raise ValueError(
                f"numerics.spacing: {numerics.spacing} m makes {particles:,} particles {box}, walls included, at most {MOST_PARTICLES:,}; "
                "choose a larger spacing or a smaller geometry"
            )
        pairs = particles * math.pi * (2 * numerics.smoothing_length / numerics.spacing + numerics.neighbour_skin) ** 2
        if pairs > MOST_PAIRS:
            raise ValueError(
                f"numerics.smoothing_ratio: {numerics.smoothing_ratio} makes {pairs:.3g} pairs of {particles:,} particles {box}, "
                f"at most {MOST_PAIRS:,}; choose a smaller one or a larger numerics.spacing"
            )
        if steps > MOST_STEPS:
            raise ValueError(
                f"numerics.time_step: {numerics.time_step} s makes {steps:,} steps of duration: {self.duration} s, at most {MOST_STEPS:,}; "
                "choose a larger step or a shorter duration"
            )
        if self.duration > MOST_SAMPLES * outputs.series_interval:
            raise ValueError(
                f"outputs.series_interval: {outputs.series_interval} s makes more than {MOST_SAMPLES:,} samples of duration: "
                f"{self.duration} s; choose a longer interval or a shorter duration"
            )
        if particles * self.duration > MOST_STORED * outputs.frame_interval:
            raise ValueError(
                f"outputs.frame_interval: {outputs.frame_interval} s stores {particles:,} particles more than {MOST_STORED:,} times in "
                f"duration: {self.duration} s; choose a longer interval, a shorter duration or a larger numerics.spacing"
            )

    def _check_walls(self) -> None:
        walls, support, needed = self.walls, 2 * self.numerics.smoothing_length, self.layers_filling_support
        slip = {"base": "free_slip" in (walls.base, walls.top), "sides": walls.sides == "free_slip"}
        if any(slip.values()) and walls.layers < needed:
            raise ValueError(
                f"walls.layers: {walls.layers} layers do not fill the kernel's support of {support:g} m; "
                f"a free-slip wall needs {needed}, or soil beside it fails without shaking"
            )
        for name, slips in slip.items():
            if walls.friction is not None and getattr(walls.friction, name) > 0 and not slips:
                raise ValueError(f"walls.friction.{name}: {getattr(walls.friction, name)} needs a free_slip wall there")
        if walls.sides == "periodic":
            _whole_multiple(self.geometry.width, self.numerics.spacing, "geometry.width", "numerics.spacing", "m")
            least = 2 * (support + self.numerics.neighbour_skin * self.numerics.spacing)
            if self.geometry.width < least:
                raise ValueError(f"geometry.width: {self.geometry.width} m; periodic sides need twice the kernel's reach, {least:g} m")

    @property
    def lattice(self) -> tuple[int, int]:
        """Columns and rows of the lattice at half offsets that fills the box."""
        columns, rows = (math.ceil(side / self.numerics.spacing - 0.5 - 1e-9) for side in (self.geometry.width, self.geometry.height))
        return columns, rows

    @property
    def layers_filling_support(self) -> int:
        """Layers of boundary particles that fill the kernel's support but for one spacing, where the gradient fades."""
        return math.ceil(2 * self.numerics.smoothing_length / self.numerics.spacing - 1 - 1e-9)

    def steps(self, time: float) -> int:
        """Number of time steps to a time (s)."""
        return round(time / self.numerics.time_step)


def _whole_multiple(value: float, unit: float, name: str, unit_name: str, of: str = "s") -> None:
    ratio = value / unit
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{name}: {value} {of} must be a whole multiple of {unit_name} ({unit} {of})")


# ---------------------------------------------------------------- reading


def make_scene(data: Mapping[str, Any], origin: str = "scene") -> Scene:
    """Validate a mapping; raises ValueError with one line per bad key: where, value, what is allowed."""
    return validated(Scene, data, origin)


def load_scene(path: Path | str, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Scene of a YAML file with nested overrides laid over it; raises ValueError before any work."""
    return make_scene(merge(read_yaml(path), overrides or {}), str(path))
