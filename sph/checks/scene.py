"""Findings of a scene before it is run: what may spoil its results.

What takes runs of the scene, its stability, is in ``sph.study.preflight``.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from sph.checks.finding import Finding, called, finding
from sph.checks.layers import of_layers
from sph.checks.loss import of_loss, of_softening
from sph.checks.motion import not_rigid, of_damping, of_motion, soft_bedrock
from sph.checks.soil import of_rest, of_soils
from sph.checks.step_limits import step_limits
from sph.scene.geometry import Slope
from sph.scene.ground_line import GroundLine, largest_climb
from sph.scene.ground_motion.record import Record, processed
from sph.scene.loading import Loading, loading_of
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.places import ABOVE, shifted
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.scene.walls import wall_words
from sph.scene.water import standing_water
from sph.solver.initial_stress import check_at_rest
from sph.solver.particles import QUANTITIES, Particles, peak_strength, place_particles, varying_layer
from sph.solver.time_step import wave_speed_ratio
from sph.stability.extrapolation import at_spacing

MIN_IN_HEIGHT = 12
"""Fewest particles across a slope's height: with 10 and 15 the cost-accuracy studies have right classes, run-outs up to 40 and 36 % off."""
MAX_HEIGHT_ERROR = 0.01
"""Of a slope between level ground that is made of whole rows: 4 % too low it may go a third less far, 2 % too high a twentieth further."""
LEVEL = 0.25
"""Spacings that level ground may rise or fall within a slope's height of the slope."""
MIN_IN_WAVE = 8
"""Smoothing lengths (or spacings, where they are longer) in the shortest wavelength: one eighth is the largest element that Kuhlemeyer
and Lysmer (1973) allow; at it the lattice carries waves some 9 % too slowly at any h, at a tenth 6 %."""
ENERGY = 0.95
"""Part of the motion's energy (Arias intensity) below its highest significant frequency."""
SAMPLES_IN_PERIOD = 8
"""Samples in the shortest period of a motion from which its spectrum is made."""
MIN_IN_SERIES = 10
"""Samples of the series in a period of the highest significant frequency, of which straight lines miss the peak by at most 5 %."""
ROOM_BEHIND, ROOM_AHEAD = 1.0, 2.0
"""Least soil behind the crest and before the toe, over the slope's height; weak debris runs further (``reach``)."""
THIN, SPREAD = 7.0, 6.0
"""Of ``reach``: the height over the depth of its debris, and twice the area of the debris over H^2.  Fitted to run-outs that no wall
stopped: of ``measured/resolution.csv`` at 0.5 m, S_R 0.25, 0.35 and 0.50 (0.96, 0.54 and 0.13 H), S_R 0.10 at rest (2.7 H,
docs/evidence/cost-accuracy.md), and a slope of 8 m with S_R 0.05 to 0.40 (8.3 to 1.3 H; tests/checks/test_room.py).  Its reach is up to
27 % more than theirs; where it is closest, a run whose sums are rounded otherwise goes 1 % further or less far."""
DROWNED = 0.5
"""Part of the friction that debris keeps where the scene has water: that of saturated soil under water, whose weight is about half."""
HOLDS, MARGIN = 1.22, 0.02
"""Smoothing length of the cubic spline over the spacing with which ground that has failed stays on its lattice under pressure, and how far
below it does so as well (docs/model/choices.md, tests/physics/test_lattice_under_pressure.py)."""
SHARE_OF_LIMIT = 0.8
"""Largest part of the lattice's limit for a fixed time step: debris is 1.2 times as stiff (``sph.solver.time_step``)."""

PLACEHOLDER = "(the soil is not replaced yet)"
"""What the title of a scene ends with that ``sph new`` has written."""
PLACEHOLDER_SOIL = {"density": 1900.0, "s_wave_speed": 250.0, "poisson_ratio": 0.3, "cohesion": 20.0, "friction_angle": 30.0}
"""The soil that it writes, to be replaced, in the units of the scene's keys."""


def growth_words(soil: Soil, part: float = 1.0) -> str:
    """How a part of the cohesion grows with depth, in words; nothing where it does not."""
    if not soil.gradient * part or soil.cohesion_growth is None:
        return ""
    datum = soil.cohesion_growth.datum
    return f" at {'the top' if datum is None else f'{datum:.10g} m'} and {soil.gradient * part:.4g} kPa more with each metre below"


def strengths(scene: Scene) -> list[tuple[str, str]]:
    """Name and strength of the scene's own soil, every layer and every seam: at the peak and what is left, with S_R and gamma or slip."""
    rows = []
    for material in scene.materials:
        name, soil, rate, softening = material.name, material.soil, material.gamma, material.softening
        lost = [f"gamma = {rate:g} 1/s"]
        if softening is not None and softening.slip_at_residual is not None:
            lost = [f"after {1e3 * softening.slip_at_residual:g} mm of slip", *(lost if rate > 0 else ())]
        told = ((soil.cohesion, soil.friction_angle), material.residual)
        kept = (1.0, material.S_R if soil.residual_cohesion is None else 0.0)
        peak, residual = (
            f"c = {cohesion:.4g} kPa{growth_words(soil, part)}, phi = {angle:.4g} degree"
            for (cohesion, angle), part in zip(told, kept, strict=True)
        )
        rows.append((name, f"peak {peak}; residual {residual} ({', '.join([f'S_R = {material.S_R:g}'] * material.uses_S_R + lost)})"))
    for name, seam in scene.seams.items():
        words = f"peak c = {seam.cohesion:.4g} kPa, phi = {seam.friction_angle:.4g} degree"
        if seam.slip_at_residual is not None:
            cohesion, friction = seam.residual
            angle = math.degrees(math.atan(friction))
            words += (
                f"; residual c = {1e-3 * cohesion:.4g} kPa, phi = {angle:.4g} degree (after {1e3 * seam.slip_at_residual:g} mm of slip)"
            )
        rows.append((f"seam {name}", words if seam.slip_at_residual is not None else f"{words}, not lost"))
    return rows


def choices(scene: Scene) -> list[tuple[str, str]]:
    """Name and value of what decides the answer and has a default: the initial stress, the onset of failure, what failed soil carries,
    dilation and the walls."""
    softening, walls = scene.coupling.softening, scene.walls
    begins = "as soon as the stress reaches the strength (coupling.softening: null)"
    if softening is not None:
        spacings = softening.width / scene.numerics.spacing
        begins = f"after {1e3 * softening.slip_at_peak:g} mm of slip over {softening.width:g} m ({spacings:.2g} spacings)"
    angles = dict(zip(("soil", *scene.layers), (soil.dilation_angle for soil in scene.soils), strict=True))
    same = len(set(angles.values())) == 1
    dilation = (
        f"{scene.soil.dilation_angle:g} degree" if same else ", ".join(f"{angle:g} degree in {name}" for name, angle in angles.items())
    )
    box = _box(scene) + (f", lid {wall_words(walls.top)}" if walls.top != "none" else "")
    failed = {
        "elastic": "elastic, without a yield surface, as printed in the paper",
        "elastic_plastic": "elastic-plastic, never beyond the peak strength",
    }[scene.coupling.solid_after_failure]
    return [
        ("initial stress", _at_rest(scene)),
        ("onset of failure", begins),
        ("solid state of failed soil", failed),
        ("dilation angle", dilation),
        ("walls", box + (": a rigid box" if _is_rigid(scene) else "")),
    ]


def _at_rest(scene: Scene) -> str:
    """Horizontal over vertical effective stress of level ground before the shaking, and whence."""
    if scene.gravity.initial_stress not in ("none", "geostatic"):
        return "a uniform pressure (gravity.initial_stress)"
    told = {
        name: f"{soil.at_rest:.3g}{' = nu / (1 - nu)' if soil.K0 is None else ''}"
        for name, soil in zip(("soil", *scene.layers), scene.soils, strict=True)
    }
    same = len(set(told.values())) == 1
    start = "gravity ramped up in elastic soil" if scene.gravity.initial_stress == "none" else "geostatic"
    return f"{start}, K0 = {told['soil'] if same else ', '.join(f'{text} in {name}' for name, text in told.items())}"


def _box(scene: Scene) -> str:
    return f"base {wall_words(scene.walls.base)}, sides {wall_words(scene.walls.sides)}"


def _is_rigid(scene: Scene) -> bool:
    """Whether base and sides stand still, so that they reflect waves."""
    return scene.walls.kinds.base.stands and scene.walls.kinds.sides.stands


def of_choices(scene: Scene) -> list[Finding]:
    """Findings of what stands in a scene until somebody decides it; the paper's scheme takes its choices from the paper."""
    if scene.scheme == "paper":
        return []
    result = []
    same = all(math.isclose(getattr(scene.soil, name), value, rel_tol=1e-6) for name, value in PLACEHOLDER_SOIL.items())
    if same or scene.title.endswith(PLACEHOLDER):
        result.append(finding("soil-not-replaced", "soil", "title", values=same))
    if _is_rigid(scene) and highest_frequency(scene):
        result.append(finding("rigid-box", "walls.base", "walls.sides", base=scene.walls.base, sides=scene.walls.sides))
    if any(soil.friction_angle > 0 and soil.dilation_angle == 0 for soil in scene.soils):
        result.append(finding("no-dilation", "soil.dilation_angle"))
    return result


def water_rows(scene: Scene) -> list[tuple[str, str]]:
    """Label and text of the water, for summaries; none for a dry scene."""
    if scene.water is None:
        return []
    ratios = [f"layer {name} r_u = {layer.r_u:g}" for name, layer in scene.layers.items() if layer.r_u is not None]
    standing = standing_water(scene.water, scene.geometry)
    stands = [f"stands up to {standing[0]:.3g} m above the ground"] if standing else []
    return [("water", "; ".join([scene.water.sentence(), *ratios, *stands]))]


def uncertain_rows(scene: Scene, particles: Particles) -> list[tuple[str, str]]:
    """Label and text of each key that is drawn, for summaries; none for a scene without."""
    if scene.uncertain is None:
        return []
    rows, drawn = [], scene.uncertain.values()
    for name, variable in scene.uncertain.variables.items():
        value = f"{drawn[variable.of]:.4g}"
        if variable.field is not None:
            there = (particles.layer == varying_layer(scene, variable)) & (np.arange(particles.x.size) < particles.n_soil)
            strength = peak_strength(scene, particles)[QUANTITIES.index(variable.quantity), there]
            values = strength / 1e3 if variable.quantity == "cohesion" else np.degrees(strength)
            value = f"{values.min():.4g} to {values.max():.4g}, mean {values.mean():.4g}" if values.size else "no particle"
        rows.append((f"drawn {name}", f"{variable.of} = {value} ({variable.sentence()}), seed {scene.uncertain.seed}"))
    return rows


def highest_frequency(scene: Scene) -> float:
    """Frequency (Hz) below which ``ENERGY`` of the motion's energy lies; 0 without shaking, and for a load that stays."""
    motion = scene.motion
    if isinstance(motion, (NoMotion, ConstantAcceleration)):
        return 0.0
    # At samples of its own, whatever the time step: fewer would show high frequencies as low ones.
    interval = float(processed(motion).time[1]) if isinstance(motion, Record) else motion.shortest_period / SAMPLES_IN_PERIOD
    acceleration = motion.acceleration(np.arange(motion.start, min(motion.end, scene.duration), interval))
    size = max(acceleration.size, 2**14)  # zeros after a short motion, so that its frequencies lie close
    power = np.abs(np.fft.rfft(acceleration, size)) ** 2 if acceleration.size else np.zeros(1)
    if not power.any():
        return 0.0
    return float(np.fft.rfftfreq(size, interval)[np.searchsorted(np.cumsum(power), ENERGY * power.sum())])


def in_wave(scene: Scene, soil: Soil, frequency: float) -> float:
    """Smoothing lengths, or spacings where they are longer, in a shear wave's length at a frequency (Hz)."""
    return soil.s_wave_speed / frequency / max(scene.numerics.smoothing_length, scene.numerics.spacing) if frequency else np.inf


def findings(scene: Scene, particles: Particles | None = None) -> list[Finding]:
    """All findings on a scene and its particles that need no run, the most harmful first; takes some 0.03 s.

    ValueError for a K0 that its soil does not hold.
    """
    particles = particles or place_particles(scene)
    check_at_rest(scene, particles)
    loading = loading_of(scene)
    result = (
        of_choices(scene)
        + of_soils(scene)
        + of_rest(scene, particles)
        + of_layers(scene, particles)
        + [each for name, soil in zip(("soil", *scene.layers), scene.soils, strict=True) for each in _waves(scene, name, soil)]
        + (_slope(scene, scene.geometry) + of_rows(scene) if isinstance(scene.geometry, (Slope, GroundLine)) else [])
        + thin_box(scene)
        + _lattice(scene)
        + of_softening(scene)
        + of_loss(scene)
        + of_variation(scene)
        + of_motion(scene, loading)
        + not_rigid(scene, loading)
        + of_damping(scene)
        + soft_bedrock(scene)
        + of_level_ground(scene, particles, loading)
        + _series(scene)
        + _step(scene)
    )
    return sorted(called(result, scene.soil.name), key=lambda each: each.rank)


def _waves(scene: Scene, name: str, soil: Soil) -> list[Finding]:
    frequency = highest_frequency(scene)
    lengths = in_wave(scene, soil, frequency)
    if lengths >= MIN_IN_WAVE:
        return []
    length = soil.s_wave_speed / frequency
    numbers = {"frequency": frequency, "wavelength": length, "slower": 1.0 - wave_speed_ratio(scene, length)}
    keys = ("numerics.spacing", "numerics.smoothing_ratio")
    return [finding("short-waves", *keys, subject=name, value=lengths, bound=MIN_IN_WAVE, **numbers)]


def _lattice(scene: Scene) -> list[Finding]:
    """The finding of wet ground that loses strength by slip, whose particles rearrange with another kernel than one that holds them."""
    numerics = scene.numerics
    ratio = numerics.smoothing_length / numerics.spacing
    holds = numerics.kernel == "cubic_spline" and ratio * (1 + 1e-9) >= HOLDS - MARGIN and ratio <= HOLDS * (1 + 1e-9)
    slips = any(each.softening is not None and each.softening.slip_at_residual is not None for each in scene.materials)
    if holds or scene.water is None or not slips:
        return []
    return [finding("lattice-rearranges", "numerics.smoothing_ratio", value=ratio, bound=HOLDS)]


def _slope(scene: Scene, geometry: Slope | GroundLine) -> list[Finding]:
    result = []
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    survey = ("geometry.window", "geometry.points") if isinstance(geometry, GroundLine) else ()
    across = height / scene.numerics.spacing
    if across < MIN_IN_HEIGHT * (1 - 1e-9):
        result.append(finding("few-particles", "numerics.spacing", value=across, bound=MIN_IN_HEIGHT, height=height))
    behind = geometry.width - crest_x
    if behind < ROOM_BEHIND * height:
        result.append(finding("back-wall", *survey or ["geometry.crest_length"], value=behind, bound=ROOM_BEHIND * height))
    room = room_ahead(scene)
    if toe_x < room * (1 - 1e-9):
        result.append(finding("little-room", *survey or ["geometry.apron_length"], value=toe_x, bound=room, heights=room / height))
    if isinstance(geometry, GroundLine):
        result += to_side(geometry)
        x, y = (np.array(side) for side in geometry.surface)
        (_, low), (_, high) = largest_climb(np.column_stack([-x, y])[::-1], 0.0)
        if high - low > height:
            other = "right" if geometry.downhill == "left" else "left"
            keys = (f"geometry.downhill={other}", "geometry.window")
            result.append(finding("other-slope", *keys, value=height, bound=high - low, downhill=geometry.downhill, other=other))
    return result


def to_side(geometry: GroundLine) -> list[Finding]:
    """A finding where the slope's crest or toe is the end of the ground, with that of a steeper face where there is one."""
    result, face = [], geometry.steeper_face
    ends = (("crest", geometry.crest_at, geometry.crest, geometry.width, 1), ("toe", geometry.toe_at, geometry.toe, 0.0, 0))
    for name, chosen, place, end, side in ends:
        if chosen is not None or place[0] != end:
            continue
        keys: tuple[str, ...] = ("geometry.window", "geometry.points")
        numbers = dict(zip("xy", geometry.in_survey(*place), strict=True))
        if face is not None and face[side][0] != end:
            x, y = geometry.in_survey(*face[side])
            numbers |= {"other_x": x, "other_y": y, "other_height": geometry.slope_height - abs(face[side][1] - place[1])}
            keys = (f"geometry.{name}_at=[{x:.10g}, {y:.10g}]",)
        result.append(finding("slope-to-side", *keys, subject=name, height=geometry.slope_height, **numbers))
    return result


def reach(scene: Scene) -> float:
    """Horizontal distance (m) from the crest edge at which debris may come to rest, by the weakest residual strength.

    L = min(H / mu, sqrt(2 A / mu)), mu = tan(phi_r) + c_r / (rho g d): a block that slides along the line of energy (Heim 1932), but no
    more than debris of the area A spreads until its surface has the gradient mu, with A and the depth d by ``SPREAD`` and ``THIN``.
    """
    geometry = scene.geometry
    assert isinstance(geometry, (Slope, GroundLine))
    height, weakest = geometry.slope_height, np.inf
    for material in scene.materials:
        soil, (cohesion, angle) = material.soil.at_depth(height / THIN), material.at_depth(height / THIN).residual
        wet = scene.water is not None
        friction = np.tan(np.radians(angle)) * (DROWNED if wet else 1.0)
        weight = soil.density * scene.gravity.acceleration * height
        weakest = min(weakest, friction + (1e3 * cohesion * THIN / weight if weight else np.inf))
    return height * min(1.0 / max(weakest, 1e-3), np.sqrt(SPREAD / max(weakest, 1e-3)))


def room_ahead(scene: Scene) -> float:
    """Apron (m) that debris may need: its reach beyond the toe, and a height H for the soil of the apron that it pushes ahead."""
    geometry = scene.geometry
    assert isinstance(geometry, (Slope, GroundLine))
    height = geometry.slope_height
    return max(ROOM_AHEAD * height, reach(scene) - (geometry.crest[0] - geometry.toe[0]) + height)


def height_error(scene: Scene) -> float:
    """How much higher the rows of particles make the slope than it is, over its height H: the mean over the columns within H behind the
    crest less that over those within H before the toe; 0 where one of them is not level, since steps of rows then average out."""
    geometry, dx = scene.geometry, scene.numerics.spacing
    assert isinstance(geometry, (Slope, GroundLine))
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    place, _ = shifted((np.arange(scene.lattice[0]) + 0.5) * dx, np.zeros(()), dx, scene.numerics.lattice_shift)
    ground = geometry.ground(place)
    top = dx * np.maximum(np.ceil(ground / dx - 0.5 - ABOVE), 0.0)  # of the soil that ``place_particles`` puts there
    ends = (crest_x + dx < place) & (place < crest_x + height), (toe_x - height < place) & (place < toe_x - dx)
    if any(not there.any() or np.ptp(ground[there]) > LEVEL * dx for there in ends):
        return 0.0
    behind, before = (float((top - ground)[there].mean()) for there in ends)
    return (behind - before) / height


def of_rows(scene: Scene) -> list[Finding]:
    """A warning if whole rows of particles do not make the height of the slope, with the largest smaller spacing that divides the height
    and whose rows do: where the ground behind the crest is not quite level, not every such spacing does."""
    assert isinstance(scene.geometry, (Slope, GroundLine))
    height, error, dx = scene.geometry.slope_height, height_error(scene), scene.numerics.spacing
    if abs(error) <= MAX_HEIGHT_ERROR:
        return []
    finer = (height / rows for rows in itertools.count(math.floor(height / dx * (1.0 + 1e-9)) + 1))
    fitting = next(each for each in finer if abs(height_error(at_spacing(scene, each))) <= MAX_HEIGHT_ERROR)
    return [finding("rows-misfit", "numerics.spacing", value=(1.0 + error) * height, bound=height, spacing=fitting)]


def thin_box(scene: Scene) -> list[Finding]:
    """A warning if the box has fewer layers of particles than fill the kernel's support."""
    walls, needed = scene.walls, scene.layers_filling_support
    if not any(kind.stands for kind in walls.kinds) or walls.layers >= needed:
        return []
    return [finding("thin-box", f"walls.layers={needed}", "numerics.smoothing_ratio", value=walls.layers, bound=needed)]


def of_variation(scene: Scene) -> list[Finding]:
    """Random fields over correlation lengths shorter than the kernel's reach, within which particles move as one."""
    result, reach = [], 2 * scene.numerics.smoothing_length
    for variable in scene.varying:
        assert variable.field is not None
        shortest = min(variable.field.horizontal_length, variable.field.vertical_length)
        if shortest < reach * (1 - 1e-9):
            keys = ("numerics.spacing", "uncertain.variables")
            result.append(finding("short-correlation", *keys, subject=variable.of, value=shortest, bound=reach))
    return result


def level_ground(scene: Scene, particles: Particles) -> tuple[float, float]:
    """Least acceleration (m/s2) that shears off the column of dry level ground at the wall behind the crest, and at which depth (m).

    The mass m above a depth (kg/m2) takes up no more than (c + m g tan phi) / m.
    """
    x, y, dx = particles.x[: particles.n_soil], particles.y[: particles.n_soil], scene.numerics.spacing
    last = np.flatnonzero(x > x.max() - 0.5 * dx)
    last = last[np.argsort(-y[last])]
    mass = particles.mass[last] / dx
    above = np.cumsum(mass) - 0.5 * mass
    cohesion, angle = peak_strength(scene, particles)[:, last]
    held = (cohesion + above * scene.gravity.acceleration * np.tan(angle)) / above
    weakest = int(np.argmin(held))
    return float(held[weakest]), float(scene.geometry.ground(x[last[:1]])[0] - y[last[weakest]])


def of_level_ground(scene: Scene, particles: Particles, loading: Loading) -> list[Finding]:
    """A finding if the shaking shears off level ground behind the crest, whose column moves as one: waves that are short beside its height
    shear it less, and amplification more.  Ground with water is left out."""
    if not isinstance(scene.geometry, (Slope, GroundLine)) or scene.water is not None:
        return []
    (enough, depth), peak = level_ground(scene, particles), float(np.abs(loading.ground).max())
    if peak < enough:
        return []
    return [finding("level-ground-fails", "motion.amplitude", value=peak, bound=enough, depth=depth)]


def _series(scene: Scene) -> list[Finding]:
    samples = 1.0 / (frequency * scene.outputs.series_interval) if (frequency := highest_frequency(scene)) else np.inf
    if samples >= MIN_IN_SERIES - 0.5:  # in whole samples
        return []
    return [finding("sparse-series", "outputs.series_interval", value=samples, bound=MIN_IN_SERIES, frequency=frequency)]


def _step(scene: Scene) -> list[Finding]:
    smallest = min(step_limits(scene), key=lambda limit: limit.seconds)
    step, bound = scene.numerics.time_step, SHARE_OF_LIMIT * smallest.seconds
    if scene.numerics.adaptive_step is not None or step <= bound:
        return []
    keys = ("numerics.time_step", "numerics.adaptive_step={}")
    return [finding("time-step", *keys, value=step, bound=bound, share=SHARE_OF_LIMIT, limit=smallest.name)]
