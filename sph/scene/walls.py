"""The box around the soil."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from pydantic import SerializerFunctionWrapHandler, model_serializer, model_validator

from sph.scene.configuration import Section, key, whole_multiple, without_unnamed
from sph.scene.motion import ConstantAcceleration

if TYPE_CHECKING:
    from sph.scene.schema import Scene


class Kind(NamedTuple):
    """What a kind of wall does; the rest of the program asks this and never the name."""

    label: str = ""
    """beside a side wall in figures; empty where none is drawn"""
    open: bool = False
    """soil may leave there"""
    holds_soil: bool = False
    """its particles stay in place and hold the soil in tension"""
    reflects: bool = False
    """its particles have no state: soil sees its own velocity reversed there, and its own stress"""
    slips: bool = False
    """its particles stand still, and soil slides along them"""
    absorbs: bool = False
    """its particles move, and let waves out"""
    periodic: bool = False
    """soil that leaves comes in on the other side"""
    unilateral: bool = False
    """soil can separate from it: it bears no more tension than ``walls.tension``"""
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
    spring_frequency: float | None = key(
        "frequency below which the bedrock is a spring and no dashpot, so that it carries loads that come after the gravity stage and "
        "stay, as those of soil that has slid; well below the frequencies of the motion; null: none",
        "Hz",
        "ours",
        gt=0,
        le=100,
        default=None,
    )

    @model_serializer(mode="wrap")
    def _stored(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Without a spring that nobody named, so that what is stored of other scenes stays as it was."""
        return without_unnamed(self, handler(self), ("spring_frequency",))

    @model_validator(mode="after")
    def _stable(self) -> Bedrock:
        if not 3.0 * self.p_wave_speed**2 >= 4.0 * self.s_wave_speed**2 * (1.0 - 1e-9):
            raise ValueError(f"p_wave_speed: {self.p_wave_speed} m/s is smaller than sqrt(4/3) times s_wave_speed: {self.s_wave_speed} m/s")
        return self


class Walls(Section):
    """How the box holds the soil."""

    base: Literal["fixed", "no_slip", "contact", "free_slip", "absorbing", "none"] = key(
        "bottom of the box: fixed 'dynamic boundary' particles (the paper), a no-slip floor, a contact that opens and on which soil "
        "slides as its own strength allows, a frictionless floor, a half-space that absorbs waves (the motion is then its outcrop "
        "motion), or nothing",
        source="Sec. 2.4; no_slip, contact, free_slip ours; absorbing: Joyner and Chen 1975",
        default="fixed",
    )
    sides: Literal["fixed", "no_slip", "contact", "free_slip", "absorbing", "periodic", "none"] = key(
        "side walls: fixed particles that hold the soil (the paper), a no-slip wall, a contact that opens and on which soil slides as "
        "its own strength allows, a frictionless wall, level ground that continues and absorbs waves (free field), soil that repeats "
        "periodically, or nothing",
        source="Sec. 2.4; no_slip, contact, free_slip and periodic ours; absorbing: Zienkiewicz et al. 1989",
        default="fixed",
    )
    top: Literal["fixed", "no_slip", "contact", "free_slip", "none"] = key("lid of the box, for flows between plates", default="none")
    friction: WallFriction | None = key("strength of the interface to free-slip walls: friction and cohesion", default=None)
    tension: float = key("tensile strength of contact walls", "kPa", ge=0, le=1e6, default=0.0)
    bedrock: Bedrock | None = key("half-space below an absorbing base and its boundary particles; null: the soil continues", default=None)
    layers: int = key(
        "layers of boundary particles; all walls except fixed ones need enough to fill the kernel's support less one spacing",
        source="Sec. 4 (2,404 particles)",
        ge=1,
        le=8,
        default=2,
    )

    @property
    def kinds(self) -> Kinds:
        """What each wall does."""
        return Kinds(*(KINDS[getattr(self, name)] for name in Kinds._fields))


def check_walls(scene: Scene) -> None:
    """Refuse walls that do not go with each other, the soil or the loads of the scene."""
    walls, support, needed = scene.walls, 2 * scene.numerics.smoothing_length, scene.layers_filling_support
    base, sides, top = walls.kinds
    slip = {"base": base.slips or top.slips, "sides": sides.slips}
    if any(kind.slips or kind.reflects for kind in walls.kinds) and walls.layers < needed:
        raise ValueError(
            f"walls.layers: {walls.layers} layers do not fill the kernel's support of {support:g} m; "
            f"a no-slip, contact or free-slip wall needs {needed}; with fewer, the soil beside it fails without shaking"
        )
    _check_absorbing(scene)
    for name, value in walls.friction or ():
        if value > 0 and not slip[name.removesuffix("_cohesion")]:
            raise ValueError(f"walls.friction.{name}: {value} needs a free_slip wall there")
    if walls.tension > 0 and not any(kind.unilateral for kind in walls.kinds):
        raise ValueError(f"walls.tension: {walls.tension} kPa needs a contact wall")
    if sides.periodic:
        whole_multiple(scene.geometry.width, scene.numerics.spacing, "geometry.width", "numerics.spacing", "m")
        least = 2 * (support + scene.numerics.neighbour_skin * scene.numerics.spacing)
        if scene.geometry.width < least:
            raise ValueError(f"geometry.width: {scene.geometry.width} m; periodic sides need twice the kernel's reach, {least:g} m")


def _check_absorbing(scene: Scene) -> None:
    walls, (base, sides, top) = scene.walls, scene.walls.kinds
    if walls.bedrock is not None and not base.absorbs:
        raise ValueError(f"walls.bedrock: needs walls.base: absorbing, not {walls.base}")
    where = next((f"walls.{name}: {getattr(walls, name)}" for name in walls.kinds._fields if getattr(walls.kinds, name).absorbs), "")
    if not where:
        return
    if walls.layers < scene.layers_filling_support:
        raise ValueError(
            f"walls.layers: {walls.layers} layers do not fill the kernel's support; {where} needs {scene.layers_filling_support}"
        )
    if not top.open:
        raise ValueError(f"walls.top: {walls.top} with {where}; set walls.top: none")
    if scene.prescribed_velocity_gradient is not None:
        raise ValueError(f"prescribed_velocity_gradient: moves the soil, not the boundary of {where}; leave it out")
    if isinstance(scene.motion, ConstantAcceleration):
        raise ValueError(f"motion.kind: constant with {where}, which cannot resist a sustained load; choose rigid walls")
    if sides.absorbs and not (base.holds_soil or base.reflects or base.absorbs):
        raise ValueError(
            f"walls.base: {walls.base} with walls.sides: absorbing, whose free field stands on a fixed, no_slip, contact or absorbing base"
        )
    if sides.absorbs and scene.coupling.initial_state == "fluid":
        raise ValueError("coupling.initial_state: fluid with walls.sides: absorbing, whose free field is a solid")
