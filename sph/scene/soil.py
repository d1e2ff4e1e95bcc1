"""The material: the soil, and the coupling of its solid and fluid states."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from sph.scene.configuration import Section, key


class Soil(Section):
    """Tables 1 and 2 of the paper."""

    density: float = key("density", "kg/m3", "Table 1", ge=1e-3, le=1e5, default=1964.0)
    youngs_modulus: float = key("Young's modulus", "kPa", "Table 1", ge=1e-6, le=1e9, default=1.675e6)
    poisson_ratio: float = key("Poisson's ratio", source="Table 1", ge=0, le=0.499, default=0.346)
    cohesion: float = key("cohesion of the solid state", "kPa", "Table 1", ge=0, le=1e6, default=150.0)
    friction_angle: float = key("internal friction angle of the solid state", "degree", "Table 1", ge=0, le=50, default=20.0)
    dilation_angle: float = key(
        "dilation angle of the solid state, at most the friction angle; equal to it the flow is associated, as in limit analysis",
        "degree",
        "ours",
        ge=0,
        le=50,
        default=0.0,
    )
    viscosity: float = key("viscosity coefficient of the fluid state", "Pa s", "Table 2", ge=0, le=1e9, default=2.0)

    @model_validator(mode="after")
    def _flow(self) -> Soil:
        if self.dilation_angle > self.friction_angle:
            raise ValueError(f"dilation_angle: {self.dilation_angle} degrees, at most the friction_angle: {self.friction_angle}")
        return self

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


class Initiation(Section):
    """Plastic slip over a length before a particle fails."""

    slip: float = key(
        "slip, summed over the length, at which strength begins to fall: in a shear test, the displacement from peak to drop in stress",
        "m",
        "Palmer and Rice 1973",
        gt=0,
        le=10,
    )
    length: float = key(
        "length over which plastic strain is averaged, three spacings or more: the width of what yields before a slip surface forms",
        "m",
        "Bazant and Jirasek 2002",
        gt=0,
        le=1e3,
    )


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
    solid_after_failure: Literal["elastic", "elastic_plastic"] = key(
        "solid state of failed soil: elastic, without a yield surface (the paper); elastic_plastic, never beyond its peak strength",
        source="Eq. 10",
        default="elastic",
    )
    fluid: FluidLaw = key("constitutive law of the fluid state", source="Eq. 13", default=ElasticViscoplastic())
    initiation: Initiation | None = key(
        "plastic slip before a particle fails; null: it fails once its stress reaches the yield surface (the paper)", default=None
    )
    initial_state: Literal["solid", "fluid"] = key(
        "solid: particles fail when their stress reaches the yield surface (the paper); fluid: all failed long before the start",
        default="solid",
    )
    fluid_tension_limit: float | None = key(
        "largest mean tension the fluid state carries; null: the apex of its Mohr-Coulomb surface (412 to 430 kPa in the paper's soil)",
        "kPa",
        ge=0,
        le=1e6,
        default=0.0,
    )
