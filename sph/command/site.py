"""Strain-compatible stiffness of a column of a scene (``sph site``): equivalent-linear site response for the scene's own motion.

A column of level ground at one place is shaken at its base.  Modulus and damping of each layer fall and rise with the shear strain by the
curves of Darendeli (2001), until they fit 0.65 times the largest strain (Schnabel, Lysmer and Seed 1972), by the library pystrata.  A base
that absorbs waves has the motion as its outcrop motion: that of ``walls.bedrock``, or of the lowest soil where there is none.  Any other
base is rigid and has the motion itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from sph.scene.configuration import merge
from sph.scene.extras import of_extra
from sph.scene.geometry import SLOPES
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.schema import Scene, make_scene
from sph.scene.units import GRAVITY, in_both
from sph.solver.initial_stress import effective_overburden
from sph.solver.particles import layer_index

LARGEST_STRAIN = 0.05
"""Shear strain beyond which the method says nothing."""
STRAINS = np.geomspace(1e-6, LARGEST_STRAIN, 200)
"""Shear strains of a curve, linear in their logarithms between them; the library's 20 end at 3.2 % and miss the damping by up to 2 %."""
TOLERANCE, ROUNDS = 0.01, 40
"""Relative change of modulus and damping at which the iteration ends, and its most rounds."""
PARTS = 2000
"""Parts of a column in which its layers are found."""
SHORTEST = 5.0
"""Parts of the shortest wave into which a layer is divided."""
COLUMNS = ("layer", "from (m)", "to (m)", "strain (%)", "G/Gmax", "damping (%)", "V_s (m/s)", "compatible V_s")

SoilOf = Callable[["Stratum"], Any]
"""Makes the library's soil type of a stratum."""


class Stratum(NamedTuple):
    """Part of a column within one of the scene's soils."""

    number: int  # 0 for the scene's own soil, k for its k-th layer
    top: float  # depth below the ground, m
    bottom: float  # m
    speed: float  # of shear waves at small strain, m/s
    weight: float  # kN/m3
    stress: float  # mean effective, in the middle, kPa


class Response(NamedTuple):
    """A stratum's strain-compatible properties."""

    stratum: Stratum
    strain: float  # largest effective shear strain
    reduction: float  # G / Gmax
    damping: float


class Site(NamedTuple):
    """The response of a column."""

    x: float  # in the coordinates of the scene, m
    layers: list[Response]
    peak: float  # of the surface, m/s2
    peak_small: float  # with the stiffness at small strain, m/s2
    peak_base: float  # of the motion, m/s2


def column(scene: Scene, x: float | None = None) -> list[Stratum]:
    """The strata below the ground at x (m, in the coordinates of the scene; None: the crest edge), from the top; ValueError outside."""
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        raise ValueError(f"{scene.name}: geometry.shape: {geometry.shape}; sph site needs slope or ground_line")
    at = geometry.crest[0] if x is None else geometry.in_box(x, 0.0)[0]
    if not 0.0 <= at <= geometry.width:
        ends = sorted(geometry.in_survey(end, 0.0)[0] for end in (0.0, geometry.width))
        raise ValueError(f"--at {x:g}: must lie in the model, from {ends[0]:.10g} to {ends[1]:.10g} m")
    height = float(geometry.ground(np.array([at]))[0])
    depth = (np.arange(PARTS) + 0.5) * height / PARTS
    places = np.full(PARTS, at - scene.numerics.lattice_shift * scene.numerics.spacing), height - depth
    numbers, stress, found, first = layer_index(scene, *places), effective_overburden(scene, *places), list[Stratum](), 0
    for number, same in groupby(numbers.tolist()):
        last, soil = first + len(list(same)), scene.soils[number]
        mean = 1e-3 * float(stress[first:last].mean()) * (1.0 + 2.0 * soil.at_rest) / 3.0
        weight = 1e-3 * soil.density * GRAVITY
        found.append(Stratum(number, first * height / PARTS, last * height / PARTS, soil.s_wave_speed, weight, max(mean, 1.0)))
        first = last
    return found


def darendeli(plasticity: float, overconsolidation: float) -> SoilOf:
    """Soil types by the curves of Darendeli (2001), for a plasticity index (%) and an overconsolidation ratio."""
    library = of_extra("pystrata.site", "site")

    def soil(stratum: Stratum) -> Any:
        given = {"plas_index": plasticity, "ocr": overconsolidation, "stress_mean": stratum.stress, "strains": STRAINS}
        return library.DarendeliSoilType(stratum.weight, **given)

    return soil


def respond(scene: Scene, soil_of: SoilOf, x: float | None = None) -> Site:
    """The response of a column to the scene's motion; ValueError without shaking, beyond ``LARGEST_STRAIN``, and without convergence."""
    if isinstance(scene.motion, (NoMotion, ConstantAcceleration)):
        raise ValueError(f"{scene.name}: motion.kind: {scene.motion.kind}; a site response needs shaking")
    strata, step = column(scene, x), scene.numerics.time_step
    shaken = scene.motion.acceleration(np.arange(scene.motion.start, min(scene.motion.end, scene.duration), step))
    motion = of_extra("pystrata.motion", "site").TimeSeriesMotion("", "", step, np.pad(shaken / GRAVITY, (0, shaken.size)))
    small, _ = _calculated(scene, strata, soil_of, motion, "LinearElasticCalculator")
    peak, parts = _calculated(scene, strata, soil_of, motion, "EquivalentLinearCalculator", TOLERANCE, ROUNDS)
    found, first = list[Response](), 0
    for stratum, count in zip(strata, map(_divisions, strata), strict=True):
        inside = parts[first : first + count]
        strain = max(float(np.max(each.strain)) for each in inside)
        mean = (float(np.mean([getattr(each, name) for each in inside])) for name in ("shear_mod_reduc", "damping"))
        found.append(Response(stratum, strain, *mean))
        first += count
    worst = max(found, key=lambda each: each.strain)
    if not worst.strain < LARGEST_STRAIN:
        where, most = ("soil", *scene.layers)[worst.stratum.number], f"{100 * worst.strain:.2g} %"
        words = f"beyond {100 * LARGEST_STRAIN:g} % equivalent-linear analysis is not valid: the soil fails, so run the scene"
        raise ValueError(f"{scene.name}: {where} is strained by {most}, and {words}")
    if not max(each.max_error for each in parts) < TOLERANCE:
        raise ValueError(
            f"{scene.name}: modulus and damping do not converge in {ROUNDS} iterations; the shaking is too strong for the method"
        )
    at = scene.geometry.in_survey(scene.geometry.crest[0], 0.0)[0] if x is None else x
    return Site(at, found, peak, small, float(np.abs(shaken).max()))


def _divisions(stratum: Stratum) -> int:
    """Sublayers of a stratum: ``SHORTEST`` in a wave of 25 Hz at half its speed."""
    return math.ceil((stratum.bottom - stratum.top) * SHORTEST * 25.0 / (0.5 * stratum.speed))


def _calculated(
    scene: Scene, strata: list[Stratum], soil_of: SoilOf, motion: Any, name: str, tolerance: float = 0.0, rounds: int = 0
) -> tuple[float, list[Any]]:
    """Peak acceleration of the surface (m/s2) and the library's sublayers, by one of its calculators."""
    site, propagation, output = (of_extra(f"pystrata.{each}", "site") for each in ("site", "propagation", "output"))
    layers = []
    for stratum in strata:
        count, soil = _divisions(stratum), soil_of(stratum)
        layers += [site.Layer(soil, (stratum.bottom - stratum.top) / count, stratum.speed) for _ in range(count)]
    rock = scene.walls.bedrock
    weight, speed = (strata[-1].weight, strata[-1].speed) if rock is None else (1e-3 * rock.density * GRAVITY, rock.s_wave_speed)
    profile = site.Profile([*layers, site.Layer(site.SoilType("below", weight, None, 0.0), 0.0, speed)])
    profile.update_layers()
    calculator = getattr(propagation, name)(**({"tolerance": tolerance, "max_iterations": rounds} if rounds else {}))
    calculator(motion, profile, profile.location("outcrop" if scene.walls.kinds.base.absorbs else "within", index=-1))
    surface = output.AccelerationTSOutput(output.OutputLocation("outcrop", index=0))
    surface(calculator)
    return float(np.abs(surface.values).max()) * GRAVITY, layers


def compatible(data: Mapping[str, Any], scene: Scene, found: Site) -> dict[str, Any]:
    """A scene's mapping with the modulus of each layer of the column reduced, and the mean damping of the column as Rayleigh's ratio."""
    means: dict[int, list[tuple[float, float]]] = {}
    for each in found.layers:
        means.setdefault(each.stratum.number, []).append((each.stratum.bottom - each.stratum.top, each.reduction))
    made = merge({}, data)
    for number, parts in means.items():
        thickness, reduction = np.array(parts).T
        modulus = scene.soils[number].youngs_modulus * float(np.average(reduction, weights=thickness))
        stiff = {"soil": {"youngs_modulus": float(f"{modulus:.6g}")}}
        name = list(scene.layers)[number - 1] if number else ""
        made = merge(made, {"layers": {name: stiff}} if name else stiff)
        holder = made["layers"][name] if name else made
        holder["soil"].pop("shear_wave_speed", None)
    thickness = [each.stratum.bottom - each.stratum.top for each in found.layers]
    ratio = float(np.average([each.damping for each in found.layers], weights=thickness))
    travel = sum(part / each.stratum.speed / each.reduction**0.5 for part, each in zip(thickness, found.layers, strict=True))
    frequencies = scene.damping.frequencies if scene.damping else (float(f"{0.25 / travel:.3g}"), float(f"{1.25 / travel:.3g}"))
    made = merge(made, {"damping": {"ratio": round(ratio, 4), "frequencies": list(frequencies)}})
    make_scene(made, f"{scene.name}, strain-compatible")
    return made


def write_compatible(path: Path, data: Mapping[str, Any], scene: Scene, found: Site) -> None:
    """Write the scene of ``compatible``, without the comments of the file that it was."""
    text = yaml.safe_dump(compatible(data, scene, found), sort_keys=False, allow_unicode=True, width=140)
    path.write_text(f"# Stiffness and damping strain-compatible at x = {found.x:.10g} m, by sph site.\n{text}", encoding="utf-8")


def rows(scene: Scene, found: Site) -> list[tuple[str, ...]]:
    """A row of ``COLUMNS`` a layer."""
    made = list[tuple[str, ...]]()
    for (number, top, bottom, speed, *_), strain, reduction, damping in found.layers:
        ratios = f"{100 * strain:.3g}", f"{reduction:.2f}", f"{100 * damping:.1f}"
        name = ("soil", *scene.layers)[number]
        made.append((name, f"{top:.3g}", f"{bottom:.3g}", *ratios, f"{speed:.0f}", f"{speed * math.sqrt(reduction):.0f}"))
    return made


def lines(found: Site) -> list[str]:
    """What the stiffness changes at the surface, in words."""
    return [
        f"column at x = {found.x:.10g} m, shaken by {in_both(found.peak_base)}",
        f"PGA at the surface: {in_both(found.peak_small)} with small-strain, {in_both(found.peak)} with strain-compatible stiffness",
    ]
