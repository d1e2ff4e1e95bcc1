"""Limit equilibrium of a scene in words: rows of a summary and findings, beside the searches with particles."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from sph.checks.finding import Finding, finding, off_by
from sph.checks.layers import FEWEST_IN_LAYER, layers_of
from sph.scene.gravity import GRAVITY
from sph.scene.ground_line import GroundLine
from sph.scene.schema import Scene
from sph.scene.units import in_both
from sph.solver.particles import place_particles
from sph.stability.slip_search import LARGEST_FACTOR, LimitEquilibrium, Surface, applies, limit_equilibrium
from sph.stability.standing import slope_height, weakened

LARGEST_DIFFERENCE = 0.05
"""Of a factor of safety by SPH from Spencer's, over that, which is told."""
CODE, DIFFERS, RESIDUAL = "limit-equilibrium", "limit-equilibrium-differs", "limit-equilibrium-residual"
UNKNOWN = "stability-unknown"
LEAST_GROUND = 0.5
"""Of ground behind the crest over the slope's height; with less, there may be no surface as large as a failure."""


def found_equilibrium(scene: Scene) -> LimitEquilibrium | None:
    """Limit equilibrium of a scene's slope; None where it does not apply, or finds no surface."""
    found = limit_equilibrium(scene) if applies(scene) else None
    return found if found is not None and found.spencer.value < float("inf") else None


def factor_words(found: LimitEquilibrium) -> str:
    """Both factors of safety, and where the surfaces lie."""
    bishop = f"{found.bishop.value:.2f} (circle)" if found.bishop.where else "not found"
    return f"Bishop {bishop}, Spencer {found.spencer.value:.2f} ({_where(found.spencer)})"


def yield_words(found: LimitEquilibrium) -> str:
    """The yield acceleration by Spencer's method; 0 for a slope that does not stand."""
    if found.spencer.value <= 1.0:
        return f"Spencer {in_both(0.0)}: the slope does not stand"
    if found.critical.value == float("inf"):
        return "Spencer: not found"
    return f"Spencer {in_both(max(found.critical.value, 0.0) * GRAVITY)} ({_where(found.critical)})"


def _where(surface: Surface) -> str:
    words = {"line": "not circular"}.get(surface.where, surface.where)
    return words if surface.crack == 0.0 else f"{words}, with a tension crack of {surface.crack:.2g} m"


def without_surface(scene: Scene, found: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a slope in which no surface slides: too strong, or with too little ground for one to end on."""
    if found is not None or not applies(scene):
        return []
    measured = f"no slip surface found with a factor of safety up to {LARGEST_FACTOR:g} that ends on the ground of the model"
    if scene.geometry.width - scene.geometry.crest[0] >= LEAST_GROUND * slope_height(scene):
        return [finding(UNKNOWN, "limit equilibrium", measured)]
    wanted = f"to have ground behind the crest, {LEAST_GROUND:g} times the slope's height at least"
    return [finding(UNKNOWN, "limit equilibrium", measured, wanted, _crest_key(scene))]


def _crest_key(scene: Scene) -> str:
    return "geometry.points" if isinstance(scene.geometry, GroundLine) else "geometry.crest_length"


def equilibrium_rows(found: LimitEquilibrium | None) -> list[tuple[str, str]]:
    """Label and text for summaries; none for a scene without a slope."""
    return [] if found is None else [("factor of safety", factor_words(found)), ("yield acceleration", yield_words(found))]


def of_equilibrium(scene: Scene, particles: Iterable[tuple[float, float]] = ()) -> list[Finding]:
    """A note of both methods, and a finding where factors of safety by ``particles``, each with its error, differ from Spencer's by more
    than that."""
    found = found_equilibrium(scene)
    if found is None:
        return without_surface(scene, found)
    told = [finding(CODE, "limit equilibrium, without a run", f"{factor_words(found)}; yield acceleration {yield_words(found)}")]
    told += slip_at_base(scene, found)
    for value, error in particles:
        difference = value / found.spencer.value - 1.0
        if abs(difference) > max(LARGEST_DIFFERENCE, error / found.spencer.value):
            what = f"the factor of safety by SPH lies {abs(difference):.0%} {'above' if difference > 0 else 'below'} Spencer's"
            why = "; ".join(_reasons(scene, found, difference)) or "no reason is known: look at both slip surfaces"
            told.append(
                finding(
                    DIFFERS,
                    what,
                    f"{value:.2f} ± {error:.2f} and {found.spencer.value:.2f}: {why}",
                    off_by=off_by(value, found.spencer.value),
                )
            )
    return told


def slip_at_base(scene: Scene, found: LimitEquilibrium | None) -> list[Finding]:
    """The finding of a slip surface that ends at an absorbing base with, by the scene, the same soil below it."""
    if found is None or not scene.walls.kinds.base.absorbs or scene.walls.bedrock is not None:
        return []
    surfaces = {
        "Bishop's factor of safety": found.bishop,
        "Spencer's factor of safety": found.spencer,
        "Spencer's yield acceleration": found.critical,
    }
    reach = [limit for limit, surface in surfaces.items() if surface.y.size and surface.y.min() < scene.numerics.spacing]
    if not reach:
        return []
    what = (
        "a slip surface reaches an absorbing base with the same soil below it; such a base carries no static load applied after the "
        "gravity stage"
    )
    measured = f"the {'surface' if len(reach) == 1 else 'surfaces'} of {_listed(reach)}"
    wanted = "to lie above the base, or end on stiff ground"
    return [finding("slip-at-base", what, measured, wanted, f"{_base_key(scene)}, or walls.bedrock")]


def _listed(names: list[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _base_key(scene: Scene) -> str:
    return "geometry.base" if isinstance(scene.geometry, GroundLine) else "geometry.base_depth"


def of_residual(scene: Scene) -> list[Finding]:
    """A note of both methods' factors at the strength that failed soil and slipped seams keep."""
    seams = {}
    for name, seam in scene.seams.items():
        cohesion, friction = seam.residual if seam.slip_at_residual is not None else seam.peak
        kept = {"cohesion": 1e-3 * cohesion, "friction_angle": math.degrees(math.atan(friction))}
        seams[name] = seam.model_copy(update=kept)
    found = found_equilibrium(weakened(scene, scene.coupling.S_R).model_copy(update={"seams": seams}))
    return [] if found is None else [finding(RESIDUAL, "limit equilibrium at the residual strength", factor_words(found))]


def _reasons(scene: Scene, found: LimitEquilibrium, difference: float) -> list[str]:
    """Why the two can differ as they do in this scene."""
    loose = any(soil.friction_angle > soil.dilation_angle for soil in scene.soils)
    thin = [layer.name for layer in layers_of(scene, place_particles(scene)) if 0 < layer.thickness < FEWEST_IN_LAYER]
    bent = found.spencer.where == "line" and found.spencer.crack == 0.0 and all(soil.friction_angle == 0.0 for soil in scene.soils)
    reasons = [
        (difference < 0 and loose, "with a dilation angle below the friction angle, SPH gives a lower strength (Davis 1968)"),
        (difference > 0 and found.spencer.crack > 0, "Spencer's surface ends in a tension crack, where SPH soil can bear tension"),
        (difference > 0 and bool(thin), f"{', '.join(thin)}: few particles across, which makes a layer too strong"),
        (difference > 0, "SPH searches overestimate the factor at coarse spacings"),
        (
            difference > 0 and bent,
            "without friction, a non-circular surface forces the sliding mass to deform, which the methods of slices ignore",
        ),
        (scene.walls.friction is not None, "soil also slides on the walls (walls.friction), which limit equilibrium does not model"),
    ]
    return [text for applies_here, text in reasons if applies_here]


def weakest_words(findings: Iterable[Finding]) -> str:
    """The factors of safety of the weakest slope by limit equilibrium in notes, or nothing."""
    told = [each.measured.partition("; ")[0] for each in findings if each.code == CODE]
    return min(told, key=spencers, default="")


def spencers(words: str) -> float:
    """Spencer's factor in the words of both methods."""
    return float(re.findall(r"Spencer ([\d.]+)", words)[0])
