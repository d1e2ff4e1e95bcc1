"""The box around the soil."""

from __future__ import annotations

import warnings
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, model_validator

from sph.scene.configuration import Section, key


class Kind(NamedTuple):
    """What a kind of wall does; the rest of the program asks this and never the name."""

    label: str = ""
    """beside a side wall in figures; empty where none is drawn"""
    open: bool = False
    """soil may leave there"""
    holds_soil: bool = False
    """its particles stand still, and soil hangs on them"""
    reflects: bool = False
    """its particles have no state: soil sees its own velocity reversed there, and its own stress"""
    slips: bool = False
    """its particles stand still, and soil slides along them"""
    absorbs: bool = False
    """its particles move, and let waves out"""
    periodic: bool = False
    """soil that leaves comes in on the other side"""
    unilateral: bool = False
    """soil comes off it: it bears no more tension than ``walls.tension``"""
    face: float = 0.0
    """distance to its face, over the spacing, below which the face pushes soil back; the lattice begins at 0.5"""

    @property
    def stands(self) -> bool:
        """Whether it stands still and nothing passes it."""
        return self.holds_soil or self.slips or self.reflects

    @property
    def has_particles(self) -> bool:
        """Whether it is made of particles."""
        return self.stands or self.absorbs


KINDS = {
    "fixed": Kind("fixed side wall", holds_soil=True),
    "no_slip": Kind("no-slip side wall", holds_soil=True, reflects=True),
    "contact": Kind("contact side wall", reflects=True, unilateral=True),
    "free_slip": Kind("free-slip side wall", slips=True, face=0.4),
    "absorbing": Kind("absorbing side", absorbs=True),
    "periodic": Kind(periodic=True),
    "none": Kind(open=True),
}


def wall_words(kind: str) -> str:
    """Name of a kind of wall as it is read: ``free-slip``."""
    return kind.replace("_", "-")


class Kinds(NamedTuple):
    """The kinds of a box's walls."""

    base: Kind
    sides: Kind
    top: Kind


def _former_name(kind: Any) -> Any:
    """Fixed walls were called sticky; taken, with a FutureWarning, until the next release."""
    if kind == "sticky":
        warnings.warn("walls: write fixed for sticky, which ends with the next release", FutureWarning, 2)
        return "fixed"
    return kind


FORMER = BeforeValidator(_former_name)


class WallFriction(Section):
    """Strength of the interface between soil and free-slip walls: c + mu sigma where the wall presses, nothing elsewhere."""

    base: float = key("coefficient of friction (tangent of the angle) at base and top", ge=0, le=10, default=0.0)
    sides: float = key("coefficient of friction at the side walls", ge=0, le=10, default=0.0)
    base_cohesion: float = key("cohesion at base and top", "kPa", ge=0, le=1e6, default=0.0)
    sides_cohesion: float = key("cohesion at the side walls", "kPa", ge=0, le=1e6, default=0.0)


class Bedrock(Section):
    """Elastic half-space below an absorbing base."""

    density: float = key("density", "kg/m3", ge=1e-3, le=1e5)
    s_wave_speed: float = key("speed of shear waves", "m/s", gt=0, le=1e5)
    p_wave_speed: float = key("speed of pressure waves, at least sqrt(4/3) that of shear waves", "m/s", gt=0, le=1e5)

    @model_validator(mode="after")
    def _stable(self) -> Bedrock:
        if not 3.0 * self.p_wave_speed**2 >= 4.0 * self.s_wave_speed**2 * (1.0 - 1e-9):
            raise ValueError(f"p_wave_speed: {self.p_wave_speed} m/s is smaller than sqrt(4/3) times s_wave_speed: {self.s_wave_speed} m/s")
        return self


class Walls(Section):
    """How the box holds the soil."""

    base: Annotated[Literal["fixed", "no_slip", "contact", "free_slip", "absorbing", "none"], FORMER] = key(
        "bottom of the box: fixed 'dynamic boundary' particles (the paper), a no-slip floor, one that soil may leave and slide on as its "
        "own strength allows, a frictionless floor, a half-space that absorbs waves (the motion is then its outcrop motion), or nothing",
        source="Sec. 2.4; no_slip, contact, free_slip ours; absorbing: Joyner and Chen 1975",
        default="fixed",
    )
    sides: Annotated[Literal["fixed", "no_slip", "contact", "free_slip", "absorbing", "periodic", "none"], FORMER] = key(
        "side walls: fixed particles that hold the soil (the paper), a no-slip wall, one that soil may leave and slide on as its own "
        "strength allows, a frictionless wall, level ground that continues and absorbs waves (free field), soil that repeats periodically, "
        "or nothing",
        source="Sec. 2.4; no_slip, contact, free_slip and periodic ours; absorbing: Zienkiewicz et al. 1989",
        default="fixed",
    )
    top: Annotated[Literal["fixed", "no_slip", "contact", "free_slip", "none"], FORMER] = key(
        "lid of the box, for flows between plates", default="none"
    )
    friction: WallFriction | None = key("strength of the interface to free-slip walls: friction and cohesion", default=None)
    tension: float = key("tension that contact walls bear", "kPa", ge=0, le=1e6, default=0.0)
    bedrock: Bedrock | None = key("what an absorbing base stands on, below its boundary particles; null: the soil goes on", default=None)
    layers: int = key(
        "layers of boundary particles; all but fixed walls need as many as fill the kernel's support but for one spacing",
        source="Sec. 4 (2,404 particles)",
        ge=1,
        le=8,
        default=2,
    )

    @property
    def kinds(self) -> Kinds:
        """What each wall does."""
        return Kinds(*(KINDS[getattr(self, name)] for name in Kinds._fields))
