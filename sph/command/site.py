"""Strain-compatible stiffness of a column of a scene (``sph site``): equivalent-linear site response for the scene's own motion.

A column of level ground at one place is shaken at its base.  Modulus and damping of each layer fall and rise with the shear strain by the
curves of Darendeli (2001), until they fit 0.65 times the largest strain (Schnabel, Lysmer and Seed 1972), by the library pystrata.  A base
that absorbs waves has the motion as its outcrop motion: that of ``walls.bedrock``, or of the lowest soil where there is none.  Any other
base is rigid and has the motion itself.  The scene with this stiffness is made in ``sph.command.compatible``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sph.scene.extras import of_extra
from sph.scene.geometry import SLOPES
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.natural_periods import strata_at
from sph.scene.places import Point
from sph.scene.schema import Scene
from sph.scene.units import GRAVITY, in_both
from sph.solver.physics.pore_pressure import effective_overburden

MAX_STRAIN = 0.05
"""Shear strain beyond which the method says nothing."""
STRAINS = np.geomspace(1e-6, MAX_STRAIN, 200)
"""Shear strains of a curve, linear in their logarithms between them; the library's 20 end at 3.2 % and miss the damping by up to 2 %."""
TOLERANCE, ROUNDS = 0.01, 100
"""Relative change of modulus and damping at which the iteration ends, and its most rounds."""
SHORTEST = 5.0
"""Parts of the shortest wave into which a layer is divided."""
SAMPLES = 50
"""Places in a layer from which its mean stress is taken."""
COLUMNS = ("layer", "from (m)", "to (m)", "V_s (m/s)", "", "strain (%)", "G/Gmax", "damping (%)", "compatible V_s")

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


class Part(NamedTuple):
    """Strain-compatible properties of a sublayer."""

    top: float  # depth below the ground, m
    bottom: float  # m
    strain: float  # effective shear strain
    reduction: float  # G / Gmax
    damping: float


class Response(NamedTuple):
    """A stratum's sublayers, of equal thickness, from the top."""

    stratum: Stratum
    parts: list[Part]

    def mean(self, name: str) -> float:
        """Mean of a property; of the reduction that of a modulus with the same travel time of waves."""
        values = np.array([getattr(part, name) for part in self.parts])
        return float(np.mean(values**-0.5) ** -2 if name == "reduction" else np.mean(values))

    @property
    def worst(self) -> Part:
        """The sublayer that is strained most: that of the least modulus and the largest damping."""
        return max(self.parts, key=lambda part: part.strain)


class Site(NamedTuple):
    """The response of a column."""

    x: float  # in the coordinates of the scene, m
    layers: list[Response]
    peak: float  # of the surface, m/s2
    peak_small: float  # with the stiffness at small strain, m/s2
    peak_base: float  # of the motion, m/s2


def place_of(scene: Scene, x: float | None = None) -> Point:
    """The place on the ground at x (m, in the coordinates of the scene; None: the crest edge), in the box; ValueError outside."""
    geometry = scene.geometry
    if not isinstance(geometry, SLOPES):
        raise ValueError(f"{scene.name}: geometry.shape: {geometry.shape}; sph site needs slope or ground_line")
    if x is None:
        return geometry.crest
    at = geometry.in_box(x, 0.0)[0]
    if not 0.0 <= at <= geometry.width:
        ends = sorted(geometry.in_survey(end, 0.0)[0] for end in (0.0, geometry.width))
        raise ValueError(f"--at {x:g}: must lie in the model, from {ends[0]:.10g} to {ends[1]:.10g} m")
    return at, float(geometry.ground(np.array([at]))[0])


def column(scene: Scene, x: float | None = None) -> list[Stratum]:
    """The strata below the ground at x, as ``place_of``, from the top; ValueError outside."""
    at, ground = place_of(scene, x)
    strata = []
    for number, top, bottom in strata_at(scene, (at, ground)):
        depth, soil = top + (np.arange(SAMPLES) + 0.5) * (bottom - top) / SAMPLES, scene.soils[number]
        stress = effective_overburden(scene, np.full(SAMPLES, at - scene.numerics.lattice_shift * scene.numerics.spacing), ground - depth)
        mean = 1e-3 * float(stress.mean()) * (1.0 + 2.0 * soil.at_rest) / 3.0
        strata.append(Stratum(number, top, bottom, soil.s_wave_speed, 1e-3 * soil.density * GRAVITY, max(mean, 1.0)))
    return strata


def darendeli(plasticity: float, overconsolidation: float) -> SoilOf:
    """Soil types by the curves of Darendeli (2001), for a plasticity index (%) and an overconsolidation ratio."""
    library = of_extra("pystrata.site", "site")

    def soil(stratum: Stratum) -> Any:
        given = {"plas_index": plasticity, "ocr": overconsolidation, "stress_mean": stratum.stress, "strains": STRAINS}
        return library.DarendeliSoilType(stratum.weight, **given)

    return soil


def respond(scene: Scene, soil_of: SoilOf, x: float | None = None) -> Site:
    """The response of a column to the scene's motion; ValueError without shaking, beyond ``MAX_STRAIN``, and without convergence."""
    if isinstance(scene.motion, (NoMotion, ConstantAcceleration)):
        raise ValueError(f"{scene.name}: motion.kind: {scene.motion.kind}; a site response needs shaking")
    strata, step, shaken = column(scene, x), scene.numerics.time_step, shaking(scene)
    motion = of_extra("pystrata.motion", "site").TimeSeriesMotion("", "", step, np.pad(shaken / GRAVITY, (0, shaken.size)))
    small, _ = _calculated(scene, strata, soil_of, motion, "LinearElasticCalculator")
    peak, parts = _calculated(scene, strata, soil_of, motion, "EquivalentLinearCalculator", TOLERANCE, ROUNDS)
    responses, first = list[Response](), 0
    for stratum, count in zip(strata, map(_divisions, strata), strict=True):
        ends = np.linspace(stratum.top, stratum.bottom, count + 1).tolist()
        inside = [
            Part(top, bottom, float(np.max(each.strain)), float(each.shear_mod_reduc), float(each.damping))
            for top, bottom, each in zip(ends, ends[1:], parts[first : first + count], strict=False)
        ]
        responses.append(Response(stratum, inside))
        first += count
    worst = max(responses, key=lambda each: each.worst.strain)
    if not worst.worst.strain < MAX_STRAIN:
        where, most = ("soil", *scene.layers)[worst.stratum.number], f"{100 * worst.worst.strain:.2g} %"
        words = f"beyond {100 * MAX_STRAIN:g} % equivalent-linear analysis is not valid: the soil fails, so run the scene"
        raise ValueError(f"{scene.name}: {where} is strained by {most}, and {words}")
    if not max(each.max_error for each in parts) < TOLERANCE:
        raise ValueError(
            f"{scene.name}: modulus and damping do not converge in {ROUNDS} iterations; the shaking is too strong for the method"
        )
    at = scene.geometry.in_survey(scene.geometry.crest[0], 0.0)[0] if x is None else x
    return Site(at, responses, peak, small, float(np.abs(shaken).max()))


def shaking(scene: Scene) -> np.ndarray:
    """The scene's motion (n,) in steps of its time step, m/s2."""
    assert not isinstance(scene.motion, (NoMotion, ConstantAcceleration))
    return scene.motion.acceleration(np.arange(scene.motion.start, min(scene.motion.end, scene.duration), scene.numerics.time_step))


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


def rows(scene: Scene, site: Site) -> list[tuple[str, ...]]:
    """Two rows of ``COLUMNS`` a layer: its means, and its sublayer that is strained most."""
    made = list[tuple[str, ...]]()
    for each in site.layers:
        number, top, bottom, speed, *_ = each.stratum
        layer = ("soil", *scene.layers)[number], f"{top:.3g}", f"{bottom:.3g}", f"{speed:.0f}"
        means = (each.mean("strain"), each.mean("reduction"), each.mean("damping"))
        for name, head, (strain, reduction, damping) in (("mean", layer, means), ("most", ("",) * 4, each.worst[2:])):
            ratios = f"{100 * strain:.3g}", f"{reduction:.2f}", f"{100 * damping:.1f}"
            made.append((*head, name, *ratios, f"{speed * math.sqrt(reduction):.0f}"))
    return made


def record(site: Site) -> dict[str, Any]:
    """The response for programs: means over a layer, ``worst``, its most strained sublayer, and all sublayers."""
    layers = [
        {"stratum": each.stratum._asdict()}
        | {name: each.mean(name) for name in ("strain", "reduction", "damping")}
        | {"worst": each.worst._asdict(), "parts": [part._asdict() for part in each.parts]}
        for each in site.layers
    ]
    return site._asdict() | {"layers": layers}


def lines(site: Site) -> list[str]:
    """What the stiffness changes at the surface, in words."""
    return [
        f"column at x = {site.x:.10g} m, shaken by {in_both(site.peak_base)}",
        f"PGA at the surface: {in_both(site.peak_small)} with small-strain, {in_both(site.peak)} with strain-compatible stiffness",
    ]
