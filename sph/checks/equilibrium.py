"""Findings of limit equilibrium, beside the searches with particles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import scipy  # type: ignore[import-untyped]

from sph.checks.cover_rows import covers
from sph.checks.finding import Finding, finding
from sph.checks.layers import MIN_IN_LAYER, layers_of
from sph.scene.geometry import SLOPES
from sph.scene.gravity import GRAVITY
from sph.scene.ground_line import GroundLine
from sph.scene.loading import motion_of
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.natural_periods import column_at, impedance_below
from sph.scene.schema import Scene
from sph.solver.particles import place_particles
from sph.solver.physics.interface import soil_numbers
from sph.stability.newmark import sliding_block
from sph.stability.slip_search import MAX_FACTOR, LimitEquilibrium, Surface, applies, limit_equilibrium, spencer_factor
from sph.stability.slip_surface import soil_along
from sph.stability.standing import slope_height, weakened, with_strength

MAX_DIFFERENCE = {"factor-of-safety": 0.05, "yield-acceleration": 0.2}
"""Of a limit by SPH from Spencer's, over that, which is told; a few per cent of strength are much of a small yield acceleration."""
DEEPER, UNBREAKABLE = 1.2, 1e6
"""Depth of a slip surface over the thickness of a cover from which on it is one through the ground, too; and a cohesion that no surface
passes, kPa."""
STIFFER = 1.5
"""Impedance of bedrock over that of the lowest soil from which on a slip surface ends at it."""
STABLE = 0.3
"""Cohesion over unit weight and height with which any slope stands; of a vertical cut 0.261 (Taylor 1937)."""
STEEP, RAD = 60.0, math.radians(1.0)
"""Largest friction angle with which a slope is tried, degrees."""
NEEDED = 0.002
"""Of the largest strength tried, to which that for a factor of 1 is sought."""
MIN_GROUND = 0.5
"""Of ground behind the crest over the slope's height; with less, there may be no surface as large as a failure."""


def found_equilibrium(scene: Scene) -> LimitEquilibrium | None:
    """Limit equilibrium of a scene's slope; None where it does not apply, or finds no surface."""
    equilibrium = limit_equilibrium(scene) if applies(scene) else None
    return equilibrium if equilibrium is not None and equilibrium.spencer.value < float("inf") else None


def equilibrium_numbers(equilibrium: LimitEquilibrium) -> dict[str, Any]:
    """Factors of safety ``bishop`` and ``spencer`` and the yield acceleration ``critical`` (m/s2), where there are any, each with the kind
    of its surface, its largest depth and that of its tension crack (m)."""
    numbers: dict[str, Any] = {}
    for name, scale in (("bishop", 1.0), ("spencer", 1.0), ("critical", GRAVITY)):
        surface: Surface = getattr(equilibrium, name)
        if surface.where and math.isfinite(surface.value):
            value = surface.value if name != "critical" else max(surface.value, 0.0)
            numbers |= {
                name: scale * value,
                f"{name}_surface": surface.where,
                f"{name}_crack": surface.crack,
                f"{name}_depth": surface.depth,
            }
    return numbers


def within_cover(scene: Scene, equilibrium: LimitEquilibrium) -> dict[str, Any]:
    """Factor of safety ``cover_spencer`` and yield acceleration ``cover_critical`` (m/s2) of surfaces that stay in the weak soil ``cover``
    on stronger ground, by Spencer's method, where the worst surface goes deeper; of several such soils the one with the least factor."""
    found, kinds, names = list[tuple[float, dict[str, Any]]](), soil_numbers(scene), ["soil", *scene.layers]
    for cover in covers(scene):
        if max(equilibrium.spencer.depth, equilibrium.critical.depth) <= DEEPER * cover.thickness:
            continue
        alone = scene
        for number, kind in enumerate(kinds):
            if kind != kinds[names.index(cover.name)]:
                alone = with_strength(alone, number, cohesion=UNBREAKABLE)
        if (own := found_equilibrium(alone)) is not None:
            limits = {f"cover_{name}": value for name, value in equilibrium_numbers(own).items() if name in ("spencer", "critical")}
            called = scene.soil.name if cover.name == "soil" else None
            found.append((own.spencer.value, {"cover": called or cover.name, **limits}))
    return min(found, key=lambda each: each[0])[1] if found else {}


def without_surface(scene: Scene, equilibrium: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a slope in which no surface slides: too strong, or with too little ground for one to end on."""
    if equilibrium is not None or not applies(scene):
        return []
    if scene.geometry.width - scene.geometry.crest[0] >= MIN_GROUND * slope_height(scene):
        return [finding("stability-unknown", subject="limit-equilibrium")]
    crest = "geometry.points" if isinstance(scene.geometry, GroundLine) else "geometry.crest_length"
    return [finding("stability-unknown", crest, subject="limit-equilibrium", heights=MIN_GROUND)]


def of_equilibrium(scene: Scene) -> list[Finding]:
    """A note of both methods, and a warning of a surface that ends at the base."""
    equilibrium = found_equilibrium(scene)
    if equilibrium is None:
        return without_surface(scene, equilibrium)
    numbers = equilibrium_numbers(equilibrium) | within_cover(scene, equilibrium)
    return [finding("limit-equilibrium", **numbers), *slip_at_base(scene, equilibrium), *probes_off_slide(scene, equilibrium)]


def that_differ(scene: Scene, limits: Iterable[Finding]) -> list[Finding]:
    """A finding for each of ``limits`` that differs from Spencer's by more than its error."""
    equilibrium = found_equilibrium(scene) if limits else None
    if equilibrium is None:
        return []
    told = []
    spencer = {"factor-of-safety": equilibrium.spencer.value, "yield-acceleration": GRAVITY * equilibrium.critical.value}
    for limit in limits:
        bound = spencer.get(limit.code, math.inf)
        if not 0.0 < bound < math.inf:
            continue
        value, error = limit.numbers["value"], limit.numbers["error"]
        if abs(value - bound) > max(MAX_DIFFERENCE[limit.code] * bound, error):
            reasons = _reasons(scene, equilibrium, limit.code, value / bound - 1.0)
            differs = finding("limit-equilibrium-differs", limit=limit.code, value=value, error=error, bound=bound, **reasons)
            told.append(replace(differs, keys=("numerics.spacing",)) if differs.counts else differs)
    return told


def factor_below_1(scene: Scene, equilibrium: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a slope whose factor of safety by Spencer is below 1, with the strength of the soil in which most of its surface lies
    that makes it 1: the cohesion (Pa), or where it has none the friction angle (rad).  No such number where this soil alone does not
    decide, or the surface follows seams."""
    if equilibrium is None or equilibrium.spencer.value >= 1.0:
        return []
    number = soil_along(scene, equilibrium.spencer.x, equilibrium.spencer.y)
    layer = list(scene.layers)[number - 1] if number else ""
    path, soil = f"layers.{layer}.soil" if layer else "soil", scene.soils[number]
    name, unit, high = ("cohesion", 1e3, soil.cohesion + 1e-3 * STABLE * weight(scene)) if soil.cohesion else ("friction_angle", RAD, STEEP)

    def excess(value: float) -> float:
        return min(spencer_factor(with_strength(scene, number, **{name: value})), MAX_FACTOR) - 1.0

    needed = dict[str, float]()
    if not (equilibrium.spencer.seam > 0).any() and getattr(soil, name) < high and excess(high) > 0.0:
        needed[name] = unit * float(scipy.optimize.brentq(excess, getattr(soil, name), high, xtol=NEEDED * high))
    keys = f"{path}.cohesion", f"{path}.friction_angle", "geometry"
    return [finding("factor-below-1", *keys, subject=layer or "soil", value=equilibrium.spencer.value, bound=1.0, **needed)]


def weight(scene: Scene) -> float:
    """Weight of the heaviest soil over the height of the slope, Pa."""
    return max(soil.density for soil in scene.soils) * scene.gravity.acceleration * slope_height(scene)


def slip_at_base(scene: Scene, equilibrium: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a slip surface that ends at an absorbing base with, by the scene, ground below it like the lowest soil."""
    if equilibrium is None:
        return []
    assert isinstance(scene.geometry, SLOPES)
    column = column_at(scene, scene.geometry.crest)
    if impedance_below(scene, column) > STIFFER * float(column.impedance[-1]):
        return []
    lowest = {name: float(surface.y.min()) for name, surface in equilibrium._asdict().items() if surface.y.size}
    reach: dict[str, Any] = {name: height for name, height in lowest.items() if height < scene.numerics.spacing}
    base = "geometry.base" if isinstance(scene.geometry, GroundLine) else "geometry.base_depth"
    return [finding("slip-at-base", base, "walls.bedrock", **reach)] if reach else []


def probes_off_slide(scene: Scene, equilibrium: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a critical surface, Spencer's, on whose body no probe lies: runs are graded by what a probe does."""
    if equilibrium is None or not equilibrium.spencer.x.size:
        return []
    geometry, surface = scene.geometry, equilibrium.spencer
    assert isinstance(geometry, SLOPES)
    edges = {"crest_edge": geometry.crest, "toe": geometry.toe}
    at = [edges[place][0] if isinstance(place, str) else geometry.in_box(*place)[0] for place in scene.probes.values()]
    if any(surface.x.min() <= x <= surface.x.max() for x in at):
        return []
    low, high = sorted(float(geometry.in_survey(float(surface.x[end]), float(surface.y[end]))[0]) for end in (0, -1))
    return [finding("probes-off-slide", "probes", probes=", ".join(scene.probes), low=low, high=high)]


def of_residual(scene: Scene) -> list[Finding]:
    """A note of both methods' factors at the strength that failed soil and slipped seams keep."""
    seams = {}
    for name, seam in scene.seams.items():
        cohesion, friction = seam.residual if seam.slip_at_residual is not None else seam.peak
        kept = {"cohesion": 1e-3 * cohesion, "friction_angle": math.degrees(math.atan(friction))}
        seams[name] = seam.model_copy(update=kept)
    equilibrium = found_equilibrium(weakened(scene, scene.coupling.S_R).model_copy(update={"seams": seams}))
    if equilibrium is None:
        return []
    return [finding("limit-equilibrium-residual", **equilibrium_numbers(equilibrium), **strength_ratios(scene))]


def runs_away(scenes: Mapping[str, Scene], strength: float) -> dict[str, Finding]:
    """A note for each scene of one slope and one residual strength, by name, that fails in its shaking by limit equilibrium: a rigid block
    with Spencer's yield ``strength`` (m/s2) slips farther than its soils and seams need to lose theirs, without which it does not stand.

    Only where strength is lost by slip, under shaking that ends.
    """
    first = next(iter(scenes.values()))
    ends = [of.softening.slip_at_residual for of in first.materials if of.softening is not None]
    ends += [seam.slip_at_residual for seam in first.seams.values()]
    slips = [end for end in ends if end is not None]
    if not slips or not strength > 0.0 or isinstance(first.motion, (NoMotion, ConstantAcceleration)):
        return {}
    needed, slipped = max(slips), dict[str, float]()
    for name, scene in scenes.items():
        motion = motion_of(scene)
        slipped[name] = sliding_block(motion.time, motion.acceleration, strength).permanent
    if max(slipped.values()) <= needed:
        return {}
    left = next((each.numbers["spencer"] for each in of_residual(first)), math.inf)
    away = {name: slip for name, slip in slipped.items() if slip > needed and left < 1.0}
    return {name: finding("block-runs-away", value=slip, bound=needed, strength=strength, residual=left) for name, slip in away.items()}


def strength_ratios(scene: Scene) -> dict[str, Any]:
    """The strength ratios S_R that decide residual strengths, the scene's and those of layers, by their keys."""
    using = [material for material in scene.materials if material.uses_S_R]
    own = {f"layers.{each.name}.S_R": each.S_R for each in using if each.name in scene.layers and scene.layers[each.name].S_R is not None}
    return ({"S_R": scene.coupling.S_R} if len(using) > len(own) else {}) | own


def _reasons(scene: Scene, equilibrium: LimitEquilibrium, limit: str, difference: float) -> dict[str, Any]:
    """Names of why the two can differ in a limit as they do (``sph.checks.messages.REASONS``), and the layers that are thin."""
    loose = any(soil.friction_angle > soil.dilation_angle for soil in scene.soils)
    thin = [layer.name for layer in layers_of(scene, place_particles(scene)) if 0 < layer.thickness < MIN_IN_LAYER]
    surface = equilibrium.spencer if limit == "factor-of-safety" else equilibrium.critical
    bent = surface.where != "circle" and surface.crack == 0.0 and all(soil.friction_angle == 0.0 for soil in scene.soils)
    reasons = {
        "dilation": difference < 0 and loose,
        "crack": difference > 0 and surface.crack > 0,
        "thin": difference > 0 and bool(thin),
        "spacing": difference > 0,
        "deforms": difference > 0 and bent,
        "walls": scene.walls.friction is not None,
        "lever": limit == "yield-acceleration",
    }
    return {"reasons": " ".join(name for name, applies_here in reasons.items() if applies_here), "thin": ", ".join(thin)}
