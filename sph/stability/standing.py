"""Does a slope stand?  The static test of a scene, and the written rule that decides whether it does.

The test is the classical one of strength reduction (Griffiths and Lane 1999): elastic, perfectly plastic soil with non-associated flow
under gravity.  It is a run of the scene's own soil, box and spacing with

* ``gamma: 0`` and no ``slip_at_residual``, in layers and seams too: the solid state keeps its Mohr-Coulomb strength and nothing softens;
* no ground motion, or a constant acceleration after the gravity stage: the pseudo-static load;
* no Rayleigh damping: its stiffness part would be a viscosity of beta_R G (0.6 MPa s in the paper's soil), by which a slope that has
  lost its balance only creeps, and seems to stand; the gravity stage keeps its own damping, which fades before observation;
* h of at most 1.3 spacings, since particles with wider kernels rearrange by more than the displacement at which sliding begins;
* artificial viscosity of 0.3: with 0.1 noise in the stress takes up strength, and nothing moves fast that it could hold up;
* the longest time step that is stable (``numerics.adaptive_step``);
* a sample of the series, and so a look of the guard, at every frame only: nothing reads them, and at every 0.01 s they took half the time
  of a coarse test;
* one shear modulus for all soil, by which it moves elastically by a tenth of what the rule allows.  A limit does not depend on the
  stiffness (Griffiths and Lane 1999 take a nominal one), and soft soil that only bends has not failed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from sph.scene.configuration import Section, dotted, key, merge
from sph.scene.gravity import FAILED_AREA, MOVED
from sph.scene.layers import LayerMaterial
from sph.scene.motion import NoMotion
from sph.scene.schema import Scene, make_scene
from sph.scene.scheme import RESOLVED
from sph.scene.seams import Seam
from sph.scene.soil import Soil
from sph.scene.walls import WallFriction
from sph.solver.initial_stress import greatest_stress, soils_at_greatest_stress
from sph.solver.particles import QUANTITIES, place_particles
from sph.solver.run import Result, run
from sph.stability.search import Trial
from sph.storage.netcdf import Group
from sph.storage.trajectory import Status

if TYPE_CHECKING:
    import xarray as xr

COURANT = 0.8
"""Part of the measured limit that the time step of a static test takes."""
FRAME_INTERVAL = 0.25
"""Interval of the frames of a static test, from which displacements are taken and at which the time step adapts, s, about."""
MAX_OBSERVATION = 1e4
"""Longest free observation, s."""
SMOOTHING_RATIO = 1.3
"""Smoothing length of a static test over the spacing, with which V9, V17 and V22 are met; with a wider kernel the lattice rearranges."""
WALL_LAYERS = 2
"""Layers of boundary particles that fill the support of that kernel."""
VISCOSITY = 0.3
"""Coefficient of artificial viscosity of a static test."""
REARRANGEMENT = 0.1
"""Distance over the spacing within which particles of a standing slope move (measured: 0.03 at most well below the limit of V17)."""
SEAM_LOSS = ("slip_at_residual", "residual_cohesion", "residual_friction_angle")
"""Keys by which a seam loses strength."""
MIN_ROWS = 10
"""Rows of particles over the height of a slope that a static test needs."""
ELASTIC_SHARE = 0.1
"""Elastic movement of the ground in a static test over the rule's displacement."""


class FailureRule(Section):
    """When a slope has failed, in numbers that hold for any size of slope and box."""

    displacement: float = key("displacement, over the slope's height H, beyond which soil counts as displaced", gt=0, le=1, default=MOVED)
    area: float = key("area of displaced soil, over H^2, beyond which the slope has failed", ge=0, le=1, default=FAILED_AREA)
    observation: float = key(
        "duration of free observation after the gravity stage, and after the load, over sqrt(H / g)", gt=0, le=1000, default=10.0
    )
    ramp: float = key("duration over which the pseudo-static acceleration is ramped up", "s", ge=0, le=100, default=1.0)

    def sentence(self) -> str:
        """The rule in words."""
        return (
            f"failed: soil displaced by more than {self.displacement:g} H since the end of the ramp of gravity (or since the start of the "
            f"pseudo-static load) covers more than {self.area:g} H^2 after {self.observation:g} sqrt(H/g) of free observation, "
            "or before the run diverged"
        )


def slope_height(scene: Scene) -> float:
    """H: height of the highest corner above the toe, m."""
    return scene.geometry.crest[1] - scene.geometry.toe[1]


def dividing(spacing: float, height: float) -> float:
    """The largest spacing (m), no coarser than one, that divides a height (m): whole rows then make a slope as high as it is."""
    return height / math.ceil(height / spacing * (1.0 - 1e-9))


def coarsest_spacing(scene: Scene, rule: FailureRule) -> float:
    """Largest spacing that gives the slope enough rows and keeps the particles' own motion below the rule's displacement, m."""
    return slope_height(scene) * min(rule.displacement / REARRANGEMENT, 1.0 / MIN_ROWS)


def stiffness(scene: Scene, rule: FailureRule, acceleration: float = 0.0) -> float:
    """Shear modulus G of a static test, Pa.

    A column as deep as the soil, D, moves sideways by rho a D^2 / 2G at its top under a, here g and the acceleration (m/s2) together:
    ``ELASTIC_SHARE`` of the displacement by which the rule fails the slope.
    """
    depth, density = max(scene.geometry.surface[1]), max(soil.density for soil in scene.soils)
    load = density * (scene.gravity.acceleration + abs(acceleration))
    return 0.5 * load * depth**2 / (ELASTIC_SHARE * rule.displacement * slope_height(scene))


def static_scene(scene: Scene, rule: FailureRule, acceleration: float = 0.0, softens: bool = False, own_stiffness: bool = False) -> Scene:
    """The static test of a scene under a constant horizontal acceleration of the box (m/s2); positive drives the soil to the toe.

    Its soil has the shear modulus of ``stiffness`` and its own Poisson's ratio, or its ``own_stiffness``, for what is said of the gravity
    stage of runs; with ``softens`` it loses its strength as in the scene.  Absorbing walls hold no load that stays; a no-slip base and
    free-slip sides stand in their place.
    """
    if scene.gravity.acceleration == 0:
        raise ValueError("gravity.acceleration: 0 m/s2: without gravity every slope stands")
    if scene.prescribed_velocity_gradient is not None:
        raise ValueError("prescribed_velocity_gradient: an element test has no stability")
    height, spacing = slope_height(scene), scene.numerics.spacing
    if spacing > coarsest_spacing(scene, rule) * (1.0 + 1e-9):
        raise ValueError(
            f"numerics.spacing: {spacing:g} m is too coarse to see a slope of {height:.3g} m slide by {rule.displacement:g} of its height; "
            f"take {coarsest_spacing(scene, rule):.3g} m at most"
        )
    stage, interval = scene.gravity.duration, scene.outputs.series_interval
    steps = max(round(FRAME_INTERVAL / interval), 1)
    frame = steps * interval
    load: dict[str, Any] = {"kind": "none"}
    loaded = stage
    if acceleration != 0:
        load = {"kind": "constant", "amplitude": acceleration, "start": stage, "ramp": rule.ramp}
        loaded += rule.ramp
    observed = rule.observation * math.sqrt(height / scene.gravity.acceleration)
    if observed > MAX_OBSERVATION:
        raise ValueError(
            f"gravity.acceleration: {scene.gravity.acceleration:g} m/s2 with the rule's observation: {rule.observation:g} sqrt(H/g) "
            f"asks for {observed:.3g} s, at most {MAX_OBSERVATION:g} s"
        )
    changes = {
        "duration": math.ceil((loaded + observed) / frame) * frame,
        "motion": load,
        **({} if softens else _without_loss(scene)),
        "initial_velocity": None,
        "damping": None,
        "early_stop": None,
        "outputs.frame_interval": frame,
        "outputs.series_interval": math.gcd(steps, round(stage / interval)) * interval,
        "numerics.time_step": interval,
        "numerics.adaptive_step.courant": COURANT,
        "numerics.artificial_viscosity.alpha": VISCOSITY,
        "numerics.smoothing_ratio": SMOOTHING_RATIO,
        "numerics.smoothing_length_is": "half_support",
        "walls.layers": max(scene.walls.layers, WALL_LAYERS),
    }
    if any(kind.absorbs for kind in scene.walls.kinds):  # holds no load that stays: a rigid base and sides on rollers instead
        changes |= {"walls.base": RESOLVED["walls"]["base"], "walls.sides": RESOLVED["walls"]["sides"], "walls.bedrock": None}
    if not own_stiffness:
        modulus = 2e-3 * stiffness(scene, rule, acceleration)  # 2 G, kPa
        changes["soil.youngs_modulus"] = modulus * (1.0 + scene.soil.poisson_ratio)
        for name, layer in scene.layers.items():
            changes[f"layers.{name}.soil.youngs_modulus"] = modulus * (1.0 + layer.soil.poisson_ratio)
    return make_scene(merge(scene.model_dump() | {"motion": {}}, dotted(changes)), scene.name)


def loses_strength(material: LayerMaterial) -> bool:
    """Whether soil of a material loses strength once it has failed, with time or with slip."""
    return material.gamma > 0 or (material.softening is not None and material.softening.by_slip)


def leaves_solid_state(scene: Scene, material: LayerMaterial) -> bool:
    """Whether soil of a material moves as debris once it has failed: it loses strength, or has had no solid state from the start."""
    return loses_strength(material) or scene.coupling.initial_state == "fluid"


def _without_loss(scene: Scene) -> dict[str, Any]:
    """Dotted keys with which no soil loses strength."""
    return {
        "coupling.gamma": 0.0,
        "coupling.solid_after_failure": "elastic_plastic",
        **({"coupling.softening.slip_at_residual": None} if scene.coupling.softening else {}),
        **{f"layers.{name}.{rate}": None for name in scene.layers for rate in ("gamma", "slip_at_residual")},
        **{f"seams.{name}.{lost}": None for name in scene.seams for lost in SEAM_LOSS},
        "coupling.initial_state": "solid",
        "coupling.fluid": {"law": "elastic_viscoplastic"},
    }


Strength = tuple[float, float, float, float]
"""Cohesion (kPa), its growth with depth (kPa/m), friction and dilation angle (degree)."""


def divided_strength(scene: Scene, factor: float) -> Scene:
    """A scene whose cohesion, tan(phi) and tan(psi) are divided by a factor: classical strength reduction.

    So are friction and cohesion of the interface to the walls (``walls.friction``), on which soil slides as on any slip surface.
    Not validated: with a factor below 1 the strength may lie above what a scene file may hold.
    """

    def divided(angle: float) -> float:
        return math.degrees(math.atan(math.tan(math.radians(angle)) / factor))

    made = _with_strength(
        scene,
        [
            (soil.cohesion / factor, soil.gradient / factor, divided(soil.friction_angle), divided(soil.dilation_angle))
            for soil in scene.soils
        ],
        lambda seam: (seam.cohesion / factor, divided(seam.friction_angle)),
    )
    if scene.walls.friction is None:
        return made
    interface = WallFriction.model_construct(**{name: value / factor for name, value in scene.walls.friction})
    return made.model_copy(update={"walls": scene.walls.model_copy(update={"friction": interface})})


def weakened(scene: Scene, strength_ratio: float) -> Scene:
    """A scene with the fluid state's strength throughout: cohesion, phi and psi multiplied by the paper's S_R (Eqs. 14 and 15).

    A layer with an S_R of its own, and soil with residual strengths, keep those; psi falls as phi does.  Seams keep their strength as it
    is here, and the interface to the walls, which does not soften, its own.
    """

    def strength(material: LayerMaterial) -> Strength:
        soil, (cohesion, angle) = material.soil, material.residual
        psi = soil.dilation_angle * (angle / soil.friction_angle if soil.friction_angle > 0 else 0.0)
        return cohesion, material.residual_gradient, angle, psi

    at_ratio = scene.model_copy(update={"coupling": scene.coupling.model_copy(update={"S_R": strength_ratio})})
    return _with_strength(scene, map(strength, at_ratio.materials), lambda seam: (seam.cohesion, seam.friction_angle))


def _with_strength(
    scene: Scene,
    strengths: Iterable[Strength],
    of_seam: Callable[[Seam], tuple[float, float]],
) -> Scene:
    """A scene with other strengths of its soils in order and, by a function, of each seam, which has neither growth nor dilation angle.

    A K0 that the other strength does not hold is taken to the nearer limit.
    """

    def changed(soil: Soil, strength: Strength) -> Soil:
        cohesion, gradient, *angles = strength
        new: dict[str, Any] = {"cohesion": cohesion} | dict(zip(("friction_angle", "dilation_angle"), angles, strict=True))
        if soil.cohesion_growth is not None:
            new["cohesion_growth"] = soil.cohesion_growth.model_copy(update={"gradient": gradient})
        return soil.model_copy(update=new | {"residual_cohesion": None, "residual_friction_angle": None})

    seams = {name: seam.model_copy(update=dict(zip(QUANTITIES, of_seam(seam), strict=True))) for name, seam in scene.seams.items()}
    made = _with_soils(scene, map(changed, scene.soils, strengths)).model_copy(update={"seams": seams})
    return made if all(soil.K0 is None for soil in made.soils) else _held(made)


def _held(scene: Scene) -> Scene:
    """A scene with each K0 within the limits at the greatest vertical stress in its soil."""

    particles = place_particles(scene)

    def held(soil: Soil, there: Soil, stress: float) -> Soil:
        if soil.K0 is None or stress == 0.0:
            return soil
        low, high = there.limits_at_rest(stress)
        return soil.model_copy(update={"K0": min(max(soil.K0, low), high)})

    return _with_soils(scene, map(held, scene.soils, soils_at_greatest_stress(scene, particles), greatest_stress(scene, particles)))


def _with_soils(scene: Scene, soils: Iterable[Soil]) -> Scene:
    """A scene with other soils, its own and those of its layers in order."""
    own, *others = soils
    layers = {name: layer.model_copy(update={"soil": soil}) for (name, layer), soil in zip(scene.layers.items(), others, strict=True)}
    return scene.model_copy(update={"soil": own, "layers": layers})


def with_strength(scene: Scene, number: int, **strength: Any) -> Scene:
    """A scene with another ``cohesion`` (kPa), ``friction_angle`` (degree) or ``cohesion_growth`` of one of its soils, by its number; it is
    not validated."""
    return _with_soils(scene, (soil.model_copy(update=strength if i == number else {}) for i, soil in enumerate(scene.soils)))


def stand(scene: Scene, rule: FailureRule, value: float) -> Trial:
    """Run a static test and judge it; ``value`` is what it tries.

    Displacements count from the first frame at or after the end of gravity's ramp, not of the gravity stage: a slope that
    collapses while the stage's damping holds it back has failed too, and the elastic settlement is over by then.  Under a
    pseudo-static load they count from its start.  A run that diverged does not stand; whether its soil had moved before, which makes it
    a failure of the slope and not of the scheme, the displaced area says, of the last frame but one.
    """
    return judged(run(scene), scene, rule, value)


def judged(result: Result, scene: Scene, rule: FailureRule, value: float) -> Trial:
    """The verdict of ``stand`` on a static test that has been run."""
    since = scene.gravity.ramp if isinstance(scene.motion, NoMotion) else scene.gravity.duration
    diverged = result.status == Status.DIVERGED
    displacement = displacements(result.stored, since, max(result.stored["time"].values.size - diverged, 1))
    limit = rule.displacement * slope_height(scene)
    area = np.count_nonzero(displacement > limit) * scene.numerics.spacing**2
    stands = not diverged and not area > rule.area * slope_height(scene) ** 2
    return Trial(value, stands, area, float(displacement.max()), result.status, float(result.stored.attrs["wall_time_s"]))


def displacements(run: Group | xr.Dataset, since: float, frames: int | None = None) -> np.ndarray:
    """How far each soil particle has moved from the first frame at or after a time (s) to the last, or the last of the first ``frames``, m;
    infinite where not a number."""
    soil, time = run["kind"].values == 0, run["time"].values[:frames]
    first, last = min(int(np.searchsorted(time, since - 1e-9)), time.size - 1), time.size - 1
    moved = [run[axis].values[last, soil].astype(float) - run[axis].values[first, soil] for axis in ("x", "y")]
    return np.nan_to_num(np.hypot(*moved), nan=math.inf)
