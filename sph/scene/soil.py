"""The material: the soil, and the coupling of its solid and fluid states."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from sph.scene.configuration import Section, key, without_unnamed
from sph.scene.liquefaction import blow_count_of_density, clean_sand
from sph.scene.places import Coordinate

LIQUEFIES = ("blow_count", "relative_density", "fines_content", "rebound_modulus", "liquefied_strength", "liquefied_strength_ratio")
"""Keys of sand that can liquefy."""


class CohesionGrowth(Section):
    """Growth of the cohesion with depth, vertically below the top of the soil or of its layer as it lies at the start."""

    gradient: float = key("increase of the cohesion per metre of depth", "kPa/m", ge=0, le=1e4)
    datum: Coordinate | None = key(
        "elevation from which the depth counts, such as that of the ground before a cut; null: the top of the soil, below "
        "the layers that lie on it, or of its layer",
        "m",
        default=None,
    )


class UndrainedStrength(CohesionGrowth):
    """Undrained strength that grows with depth z: s_u = at_top + gradient z."""

    at_top: float = key("undrained strength at the top of the soil or of its layer, or at the datum and above it", "kPa", ge=0, le=1e6)

    @model_validator(mode="after")
    def _some(self) -> UndrainedStrength:
        if self.at_top == 0.0 and self.gradient == 0.0:
            raise ValueError("at_top: 0 kPa with gradient: 0 kPa/m is no strength; one of them must be above 0")
        return self


class Soil(Section):
    """Tables 1 and 2 of the paper."""

    name: str | None = key(
        "what the scene's own soil is called in figures and tables; layers have the names of their keys; null: soil",
        source="ours",
        default=None,
        min_length=1,
        max_length=40,
    )
    density: float = key("density", "kg/m3", "Table 1", ge=1e-3, le=1e5, default=1964.0)
    youngs_modulus: float = key("Young's modulus", "kPa", "Table 1", ge=1e-6, le=1e9, default=1.675e6)
    poisson_ratio: float = key("Poisson's ratio", source="Table 1", ge=0, le=0.499, default=0.346)
    cohesion: float = key("peak cohesion, that of the solid state", "kPa", "Table 1", ge=0, le=1e6, default=150.0)
    friction_angle: float = key("peak angle of internal friction, that of the solid state", "degree", "Table 1", ge=0, le=50, default=20.0)
    dilation_angle: float = key(
        "dilation angle of the solid state, at most the friction angle; if both are equal the flow is associated, as in limit analysis",
        "degree",
        "ours",
        ge=0,
        le=50,
        default=0.0,
    )
    residual_cohesion: float | None = key(
        "residual cohesion of failed soil, from a ring shear test; null: S_R times the cohesion",
        "kPa",
        "Eq. 15",
        ge=0,
        le=1e6,
        default=None,
    )
    residual_friction_angle: float | None = key(
        "residual friction angle of failed soil, from a ring shear test; null: S_R times the friction angle",
        "degree",
        "Eq. 14",
        ge=0,
        le=50,
        default=None,
    )
    shear_wave_speed: float | None = key(
        "speed of shear waves, instead of Young's modulus, which is then 2 (1 + nu) rho V_s^2 of this soil",
        "m/s",
        "ours",
        gt=0,
        le=1e4,
        default=None,
        exclude=True,
    )
    undrained_strength: Annotated[float, Field(gt=0, le=1e6)] | UndrainedStrength | None = key(
        "undrained shear strength of saturated clay, instead of cohesion and friction angle: a cohesion without friction; one number, or "
        "at_top and gradient where it grows with depth",
        "kPa",
        "ours",
        default=None,
        exclude=True,
    )
    cohesion_growth: CohesionGrowth | None = key(
        "growth of the cohesion with depth, cohesion being that at the top; null: none",
        "kPa/m",
        "Gibson and Morgenstern 1962",
        default=None,
    )
    viscosity: float = key("viscosity coefficient of the fluid state", "Pa s", "Table 2", ge=0, le=1e9, default=2.0)
    K0: float | None = key(
        "coefficient of earth pressure at rest: horizontal over vertical effective stress at the start, in and across the section, "
        "within the active and the passive limit; if given, the scene starts with geostatic stress (gravity.initial_stress); null: that"
        " of elastic soil, nu / (1 - nu)",
        source="Jaky 1944",
        ge=0,
        le=20,
        default=None,
    )
    blow_count: float | None = key(
        "(N1)60, the blow count of the standard penetration test at 60 % energy and 1 atm, of sand below water whose pore pressure cyclic "
        "shear raises (water.excess_pressure); null: no such soil",
        source="Byrne 1991",
        ge=1,
        le=60,
        default=None,
    )
    relative_density: float | None = key(
        "relative density of such sand, instead of a blow count", "%", "Byrne 1991", ge=15, le=120, default=None
    )
    fines_content: float | None = key(
        "fines of such sand, which count as more blows, at their own rate for pore pressure and for residual strength; null: none",
        "%",
        "Idriss and Boulanger 2008; Seed 1987",
        ge=0,
        le=100,
        default=None,
    )
    rebound_modulus: float | None = key(
        "constrained modulus of such sand in unloading, at its initial stress: excess pore pressure per volumetric strain of drained "
        "cycles; null: that of its elastic skeleton, K + 4/3 G",
        "kPa",
        "Martin et al. 1975",
        gt=0,
        le=1e9,
        default=None,
    )
    liquefied_strength: float | None = key(
        "residual strength of such sand once liquefied; null: by water.excess_pressure.liquefaction.strength",
        "kPa",
        gt=0,
        le=1e6,
        default=None,
    )
    liquefied_strength_ratio: float | None = key("the same as a ratio to the initial vertical effective stress", gt=0, le=1, default=None)

    @model_validator(mode="after")
    def _computed(self) -> Soil:
        if self.shear_wave_speed is not None:
            raise ValueError(f"shear_wave_speed: {self.shear_wave_speed:g} m/s needs density and poisson_ratio beside it")
        if self.undrained_strength is not None:
            raise ValueError(f"undrained_strength: {self.undrained_strength} kPa is read by a scene alone; here write cohesion")
        return self

    @model_serializer(mode="wrap")
    def _stored(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without what later versions added and nobody named, so that what is stored of other scenes stays as it was."""
        stored: dict[str, Any] = handler(self)
        return without_unnamed(self, stored, ("name", "cohesion_growth", *LIQUEFIES))

    @model_validator(mode="after")
    def _one_density(self) -> Soil:
        if self.blow_count is not None and self.relative_density is not None:
            raise ValueError(
                f"relative_density: {self.relative_density:g} % beside blow_count: {self.blow_count:g}; write one of them, and null for "
                "the other where a layer takes it over"
            )
        unused = [name for name in LIQUEFIES[2:] if getattr(self, name) is not None]
        if unused and not self.can_liquefy:
            raise ValueError(f"{unused[0]}: {getattr(self, unused[0]):g} needs a blow_count or a relative_density beside it")
        if self.liquefied_strength is not None and self.liquefied_strength_ratio is not None:
            raise ValueError(
                f"liquefied_strength_ratio: {self.liquefied_strength_ratio:g} beside liquefied_strength: {self.liquefied_strength:g} kPa; "
                "write one of them"
            )
        if self.can_liquefy and self.friction_angle == 0:
            raise ValueError("blow_count, relative_density: of soil without friction_angle, whose strength no pore pressure changes")
        return self

    @property
    def can_liquefy(self) -> bool:
        """Whether cyclic shear raises its pore pressure, below water."""
        return self.blow_count is not None or self.relative_density is not None

    @property
    def equivalent_blow_count(self) -> float:
        """(N1)60 as it is written, or for the relative density."""
        if self.blow_count is not None:
            return self.blow_count
        assert self.relative_density is not None
        return blow_count_of_density(self.relative_density)

    @property
    def clean_sand_blow_count(self) -> float:
        """(N1)60 of the clean sand that liquefies as easily: fines count as more blows."""
        blows = self.equivalent_blow_count
        return blows if self.fines_content is None else clean_sand(blows, self.fines_content)

    @model_validator(mode="after")
    def _at_rest(self) -> Soil:
        if self.K0 is not None and self.cohesion == 0 and self.gradient == 0:
            self.check_at_rest("K0", 1.0)  # without cohesion the limits are those of any depth
        return self

    @model_validator(mode="after")
    def _flow(self) -> Soil:
        if self.dilation_angle > self.friction_angle:
            raise ValueError(f"dilation_angle: {self.dilation_angle} degrees, at most the friction_angle: {self.friction_angle}")
        for name, unit in (("cohesion", "kPa"), ("friction_angle", "degrees")):
            peak, residual = getattr(self, name), getattr(self, f"residual_{name}")
            if residual is not None and residual > peak:
                raise ValueError(f"residual_{name}: {residual} {unit}, at most the {name}: {peak}; a layer takes what it does not name")
        return self

    @property
    def gradient(self) -> float:
        """Growth of the cohesion with depth, kPa/m."""
        return 0.0 if self.cohesion_growth is None else self.cohesion_growth.gradient

    def at_depth(self, depth: float) -> Soil:
        """The soil at a depth (m) below its top, whose cohesion does not grow; the soil itself where it grows nowhere."""
        return (
            self.model_copy(update={"cohesion": self.cohesion + self.gradient * depth, "cohesion_growth": None}) if self.gradient else self
        )

    @property
    def at_rest(self) -> float:
        """Horizontal over vertical effective stress of level ground before the gravity stage: K0, or that of elastic soil."""
        return self.poisson_ratio / (1.0 - self.poisson_ratio) if self.K0 is None else self.K0

    def limits_at_rest(self, vertical: float) -> tuple[float, float]:
        """Least and largest horizontal over vertical effective stress that the peak strength holds at a vertical one, Pa; tension is none.

        Active and passive limit of Rankine (1857): K_a - 2 c sqrt(K_a) / sigma_v, not below 0, and K_p + 2 c sqrt(K_p) / sigma_v.
        """
        sine = math.sin(self.friction_angle_si)
        active, passive = (1.0 - sine) / (1.0 + sine), (1.0 + sine) / (1.0 - sine)
        low, high = (2.0 * self.cohesion_si * math.sqrt(ratio) / vertical for ratio in (active, passive))
        return max(active - low, 0.0), passive + high

    def check_at_rest(self, name: str, vertical: float, where: str = "") -> None:
        """ValueError, which gives K0 as ``name``, where the peak strength does not hold it at a vertical effective stress, Pa."""
        low, high = self.limits_at_rest(vertical)
        if self.K0 is not None and not low - 1e-9 <= self.K0 <= high + 1e-9:
            raise ValueError(
                f"{name}: {self.K0:g} lies outside the active and the passive limit, {low:.3g} to {high:.3g} for "
                f"cohesion: {self.cohesion:g} kPa and friction_angle: {self.friction_angle:g} degrees{where}; choose a K0 between them, "
                "such as 1 - sin(phi) of normally consolidated soil, or null"
            )

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


class Softening(Section):
    """Loss of strength with slip, in the words of a shear test."""

    slip_at_peak: float = key(
        "slip (plastic displacement) at which strength begins to fall: in a shear test, the displacement from yield to the end of the peak",
        "m",
        "Palmer and Rice 1973",
        gt=0,
        le=10,
    )
    slip_at_residual: float | None = key(
        "slip at which the residual strength is reached: in a ring shear test, the displacement from which on the stress no longer "
        "falls; null: strength falls with time after the peak, at the rate gamma",
        "m",
        "Skempton 1985",
        gt=0,
        le=100,
        default=None,
    )
    width: float = key(
        "width over which plastic strain is averaged, three spacings or more: that of the soil that yields before a slip surface forms;"
        " no test gives it",
        "m",
        "Bazant and Jirasek 2002",
        gt=0,
        le=1e3,
    )
    shape: Literal["linear", "exponential"] = key(
        "curve of strength against slip from peak to residual; exponential: fast at first, with 5 % of the loss still to come at "
        "slip_at_residual",
        default="linear",
    )

    @model_validator(mode="after")
    def _falling(self) -> Softening:
        if self.slip_at_residual is not None and not self.slip_at_residual > self.slip_at_peak:
            raise ValueError(f"slip_at_residual: {self.slip_at_residual:g} m, must be more than slip_at_peak: {self.slip_at_peak:g} m")
        return self

    @property
    def by_slip(self) -> bool:
        """Whether strength falls with slip, not with time."""
        return self.slip_at_residual is not None

    @property
    def peak_strain(self) -> float:
        """Mean plastic strain at which strength begins to fall."""
        return self.slip_at_peak / self.width

    @property
    def span(self) -> float:
        """Mean plastic strain from there to the residual strength."""
        assert self.slip_at_residual is not None
        return (self.slip_at_residual - self.slip_at_peak) / self.width


def _former_initiation(data: Any) -> Any:
    """``softening`` was ``initiation: {slip, length}``; taken, with a FutureWarning, until the next release."""
    if not isinstance(data, Mapping) or "initiation" not in data:
        return data
    former = data["initiation"]
    kept = {name: value for name, value in data.items() if name != "initiation"}
    if former is None:
        return {"softening": None} | kept
    if not isinstance(former, Mapping) or "softening" in data or set(former) != {"slip", "length"}:
        return data  # refused as an unknown key
    warnings.warn(
        "coupling.initiation: write softening: {slip_at_peak, width} for initiation: {slip, length}, which ends with the next release",
        FutureWarning,
        2,
    )
    return kept | {"softening": {"slip_at_peak": former["slip"], "width": former["length"]}}


class Coupling(Section):
    """The paper's coupling of the solid and the fluid state (Eqs. 8, 9, 14, 15)."""

    S_R: float = key(
        "strength ratio: c_f = S_R c_s and phi_f = S_R phi_s (not the factor that divides c and tan phi)",
        source="Eqs. 14-15",
        ge=0,
        le=1,
        default=0.25,
    )
    gamma: float = key(
        "rate of the loss of strength after failure; with a loss by slip 0 unless given", "1/s", "Eq. 9", ge=0, le=1e6, default=100.0
    )
    solid_after_failure: Literal["elastic", "elastic_plastic"] = key(
        "solid state of failed soil: elastic, without a yield surface (the paper); elastic_plastic, never beyond its peak strength",
        source="Eq. 10",
        default="elastic",
    )
    fluid: FluidLaw = key("constitutive law of the fluid state", source="Eq. 13", default=ElasticViscoplastic())
    softening: Softening | None = key(
        "slips at which strength begins to fall and is lost; null: it falls with time once the stress reaches the yield surface (the "
        "paper)",
        default=None,
    )
    initial_state: Literal["solid", "fluid"] = key(
        "solid: particles fail when their stress reaches the yield surface (the paper); fluid: all soil failed long before the start",
        default="solid",
    )
    fluid_tension_limit: float | None = key(
        "largest mean tension that the fluid state carries; null: the apex of its Mohr-Coulomb surface (412 to 430 kPa in the paper's "
        "soil)",
        "kPa",
        ge=0,
        le=1e6,
        default=0.0,
    )

    @model_validator(mode="before")
    @classmethod
    def _former(cls, data: Any) -> Any:
        return _former_initiation(data)

    @model_validator(mode="after")
    def _consistent(self) -> Coupling:
        if self.solid_after_failure == "elastic" and self.softens_by_slip:
            raise ValueError(
                "solid_after_failure: elastic with softening.slip_at_residual, which counts the plastic slip of the solid state; "
                "write solid_after_failure: elastic_plastic"
            )
        return self

    @property
    def softens_by_slip(self) -> bool:
        """Whether strength falls with slip, not with time."""
        return self.softening is not None and self.softening.by_slip
