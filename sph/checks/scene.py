"""Findings of a scene before it is run: what may spoil its results, with the measured and the wanted value and the key to change.

``sph.checks.finding`` lists all that can be found.  What takes runs of the scene, its stability, is in ``sph.study.preflight``.
"""

from __future__ import annotations

import math

import numpy as np

from sph.checks.finding import Finding, finding, off_by
from sph.checks.layers import of_layers
from sph.checks.loss import of_loss, of_softening
from sph.checks.motion import not_rigid, of_damping, of_motion
from sph.checks.soil import of_rest, of_soils
from sph.scene.geometry import Slope
from sph.scene.ground_line import GroundLine, largest_climb
from sph.scene.ground_motion.record import Record, processed
from sph.scene.loading import loading_of
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.scene.units import in_both
from sph.scene.walls import wall_words
from sph.scene.water import standing_water
from sph.solver.initial_stress import check_at_rest
from sph.solver.particles import QUANTITIES, Particles, peak_strength, place_particles, varying_layer
from sph.solver.time_step import limits, wave_speed_ratio
from sph.stability.standing import dividing

FEWEST_IN_HEIGHT = 12
"""Fewest particles across a slope's height: with 10 and 15 the cost-accuracy studies have right classes, run-outs up to 40 and 36 % off."""
LARGEST_HEIGHT_ERROR = 0.01
"""Of a slope between level ground that is made of whole rows: 4 % too low it may go a third less far, 2 % too high a twentieth further."""
LEVEL = 0.25
"""Spacings that level ground may rise or fall within a slope's height of the slope."""
FEWEST_IN_WAVE = 8
"""Smoothing lengths (or spacings, where they are longer) in the shortest wavelength: one eighth is the largest element that Kuhlemeyer
and Lysmer (1973) allow; at it the lattice carries waves some 9 % too slowly at any h, at a tenth 6 %."""
ENERGY = 0.95
"""Part of the motion's energy (Arias intensity) below its highest significant frequency."""
SAMPLES_IN_PERIOD = 8
"""Samples in the shortest period of a motion from which its spectrum is made."""
FEWEST_IN_SERIES = 10
"""Samples of the series in a period of the highest significant frequency, of which straight lines miss the peak by at most 5 %."""
ROOM_BEHIND, ROOM_AHEAD = 1.0, 2.0
"""Least soil behind the crest and before the toe, over the slope's height; weak debris runs further (``reach``)."""
THIN, SPREAD = 7.0, 5.8
"""Of ``reach``: the height over the depth of its debris, and twice the area of the debris over H^2.  Fitted to run-outs that no wall
stopped: of ``measured/resolution.csv`` at 0.5 m, S_R 0.25, 0.35 and 0.50 (0.96, 0.54 and 0.13 H), S_R 0.10 at rest (2.7 H,
docs/evidence/cost-accuracy.md), and a slope of 8 m with S_R 0.05 to 0.40 (8.3 to 1.3 H; tests/study/test_room.py).  Its reach is 0 to 25 %
more than theirs."""
DROWNED = 0.5
"""Part of the friction that debris keeps where the scene has water: that of saturated soil under water, whose weight is about half."""
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
    found = []
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
        found.append((name, f"peak {peak}; residual {residual} ({', '.join([f'S_R = {material.S_R:g}'] * material.uses_S_R + lost)})"))
    for name, seam in scene.seams.items():
        words = f"peak c = {seam.cohesion:.4g} kPa, phi = {seam.friction_angle:.4g} degree"
        if seam.slip_at_residual is not None:
            cohesion, friction = seam.residual
            angle = math.degrees(math.atan(friction))
            words += (
                f"; residual c = {1e-3 * cohesion:.4g} kPa, phi = {angle:.4g} degree (after {1e3 * seam.slip_at_residual:g} mm of slip)"
            )
        found.append((f"seam {name}", words if seam.slip_at_residual is not None else f"{words}, not lost"))
    return found


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
    found = []
    same = all(math.isclose(getattr(scene.soil, name), value, rel_tol=1e-6) for name, value in PLACEHOLDER_SOIL.items())
    if same or scene.title.endswith(PLACEHOLDER):
        wanted = "your soil and a title of your own"
        values = ", ".join(f"{name} {value:g}" for name, value in PLACEHOLDER_SOIL.items())
        measured = values if same else scene.title
        found.append(finding("soil-not-replaced", "the soil is still the placeholder of sph new", measured, wanted, "soil, title"))
    if _is_rigid(scene) and highest_frequency(scene):
        wanted = "absorbing, where waves radiate away"
        what = "a rigid box reflects waves, so the slope is shaken harder than on a site where they radiate away"
        found.append(finding("rigid-box", what, _box(scene), wanted, "walls.base and walls.sides"))
    if any(soil.friction_angle > 0 and soil.dilation_angle == 0 for soil in scene.soils):
        wanted = "the angle from a shear test: 0 in loose soil, a fraction of the friction angle in dense soil"
        found.append(finding("no-dilation", "frictional soil does not dilate", "0 degrees", wanted, "soil.dilation_angle"))
    return found


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
    found = (
        of_choices(scene)
        + of_soils(scene)
        + of_rest(scene, particles)
        + of_layers(scene, particles)
        + [each for name, soil in zip(("soil", *scene.layers), scene.soils, strict=True) for each in _waves(scene, name, soil)]
        + (_slope(scene, scene.geometry) + of_rows(scene, particles) if isinstance(scene.geometry, (Slope, GroundLine)) else [])
        + thin_box(scene)
        + of_softening(scene)
        + of_loss(scene)
        + of_variation(scene)
        + of_motion(scene)
        + not_rigid(scene)
        + of_damping(scene)
        + of_level_ground(scene, particles)
        + _series(scene)
        + _step(scene)
    )
    return sorted(found, key=lambda each: each.rank)


def _waves(scene: Scene, name: str, soil: Soil) -> list[Finding]:
    found = []
    frequency = highest_frequency(scene)
    lengths = in_wave(scene, soil, frequency)
    if lengths < FEWEST_IN_WAVE:
        ratio = wave_speed_ratio(scene, soil.s_wave_speed / frequency)
        found.append(
            finding(
                "short-waves",
                f"shear waves of {frequency:.3g} Hz are too short for the particles in {name}",
                f"{lengths:.2g} smoothing lengths per wave ({soil.s_wave_speed / frequency:.3g} m), carried {1 - ratio:.0%} too slowly",
                f"at least {FEWEST_IN_WAVE} (Kuhlemeyer and Lysmer 1973)",
                "numerics.spacing or numerics.smoothing_ratio",
                subject=name,
                off_by=off_by(lengths, FEWEST_IN_WAVE),
            )
        )
    return found


def _slope(scene: Scene, geometry: Slope | GroundLine) -> list[Finding]:
    found = []
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    if height < FEWEST_IN_HEIGHT * scene.numerics.spacing * (1 - 1e-9):
        across = f"{height / scene.numerics.spacing:.1f} particles in {height:g} m"
        found.append(
            finding(
                "few-particles",
                "few particles across the slope's height",
                across,
                f"at least {FEWEST_IN_HEIGHT}",
                "numerics.spacing",
                off_by=off_by(height / scene.numerics.spacing, FEWEST_IN_HEIGHT),
            )
        )
    behind = geometry.width - crest_x
    if behind < ROOM_BEHIND * height:
        key = "geometry.crest_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(
            finding(
                "back-wall",
                "the side of the model behind the crest is near",
                f"{behind:.3g} m",
                f"at least H = {ROOM_BEHIND * height:.3g} m",
                key,
                off_by=off_by(behind, ROOM_BEHIND * height),
            )
        )
    room = room_ahead(scene)
    if toe_x < room * (1 - 1e-9):
        key = "geometry.apron_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(
            finding(
                "little-room",
                "little room for the run-out between the toe and the side of the model",
                f"{toe_x:.3g} m",
                f"at least {room:.3g} m, {room / height:.2g} H, for the residual strength of the soil",
                key,
                off_by=off_by(toe_x, room),
            )
        )
    if isinstance(geometry, GroundLine):
        found += to_side(geometry)
        x, y = (np.array(side) for side in geometry.surface)
        (_, low), (_, high) = largest_climb(np.column_stack([-x, y])[::-1], 0.0)
        if high - low > height:
            other = "right" if geometry.downhill == "left" else "left"
            found.append(
                finding(
                    "other-slope",
                    f"the ground falls further to the {other} than to the {geometry.downhill}",
                    f"{high - low:.3g} m and {height:.3g} m",
                    "the other way round, unless the smaller slope is the one that may fail",
                    f"geometry.downhill={other}, or a narrower geometry.window",
                    off_by=off_by(height, high - low),
                )
            )
    return found


def to_side(geometry: GroundLine) -> list[Finding]:
    """A finding where the slope's crest or toe is the end of the ground, with that of a steeper face where there is one."""
    found, face = [], geometry.steeper_face
    ends = (("crest", geometry.crest_at, geometry.crest, geometry.width, 1), ("toe", geometry.toe_at, geometry.toe, 0.0, 0))
    for name, chosen, place, end, side in ends:
        if chosen is not None or place[0] != end:
            continue
        x, y = geometry.in_survey(*place)
        wanted, key = f"an edge with gentler ground beyond it, or {name}_at", "geometry.window or the line"
        if face is not None and face[side][0] != end:
            other_x, other_y = geometry.in_survey(*face[side])
            height = geometry.slope_height - abs(face[side][1] - place[1])
            wanted = (
                f"({other_x:.10g}, {other_y:.10g}) m, that of a steeper face, with H = {height:.4g} m, if it is the slope that is meant"
            )
            key = f"geometry.{name}_at=[{other_x:.10g}, {other_y:.10g}]"
        what = f"the slope goes on to the side of the model, whose end is taken for its {name}"
        measured = f"({x:.10g}, {y:.10g}) m, H = {geometry.slope_height:.4g} m"
        found.append(finding("slope-to-side", what, measured, wanted, key, subject=name))
    return found


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


def height_error(scene: Scene, particles: Particles) -> float:
    """How much higher the rows of particles make the slope than it is, over its height H: the mean over the columns within H behind the
    crest less that over those within H before the toe; 0 where one of them is not level, since steps of rows then average out."""
    geometry, dx = scene.geometry, scene.numerics.spacing
    assert isinstance(geometry, (Slope, GroundLine))
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    x, y = particles.x[: particles.n_soil], particles.y[: particles.n_soil]
    column = np.round(x / dx - 0.5).astype(int)
    top = np.zeros(scene.lattice[0])  # of a column without soil the base
    np.maximum.at(top, column, y + 0.5 * dx)
    place = (np.arange(top.size) + 0.5 + scene.numerics.lattice_shift) * dx
    ground = geometry.ground(place)
    ends = (crest_x + dx < place) & (place < crest_x + height), (toe_x - height < place) & (place < toe_x - dx)
    if any(not there.any() or np.ptp(ground[there]) > LEVEL * dx for there in ends):
        return 0.0
    behind, before = (float((top - ground)[there].mean()) for there in ends)
    return (behind - before) / height


def of_rows(scene: Scene, particles: Particles) -> list[Finding]:
    """A warning if whole rows of particles do not make the height of the slope."""
    geometry, dx = scene.geometry, scene.numerics.spacing
    assert isinstance(geometry, (Slope, GroundLine))
    height, error = geometry.slope_height, height_error(scene, particles)
    if abs(error) <= LARGEST_HEIGHT_ERROR:
        return []
    return [
        finding(
            "rows-misfit",
            "the rows of particles make the slope too " + ("high" if error > 0 else "low"),
            f"{(1 + error) * height:.4g} m for {height:.4g} m ({error:+.1%})",
            f"equal, as with a spacing of {dividing(dx, height):.4g} m, which divides the height",
            "numerics.spacing",
            off_by=off_by(1 + error, 1.0),
        )
    ]


def thin_box(scene: Scene) -> list[Finding]:
    """A warning if the box has fewer layers of particles than fill the kernel's support."""
    walls, needed = scene.walls, scene.layers_filling_support
    if any(kind.stands for kind in walls.kinds) and walls.layers < needed:
        return [
            finding(
                "thin-box",
                "the boundary particles do not fill the kernel's support, so stresses beside them alternate from row to row",
                f"{walls.layers} layers",
                f"{needed}",
                f"walls.layers={needed}, or a smaller numerics.smoothing_ratio",
                off_by=off_by(walls.layers, needed),
            )
        ]
    return []


def of_variation(scene: Scene) -> list[Finding]:
    """Random fields over correlation lengths shorter than the kernel's reach, within which particles move as one."""
    found, reach = [], 2 * scene.numerics.smoothing_length
    for variable in scene.varying:
        assert variable.field is not None
        shortest = min(variable.field.horizontal_length, variable.field.vertical_length)
        if shortest < reach * (1 - 1e-9):
            what = f"{variable.of} varies over lengths that the particles do not resolve"
            wanted = f"at least {reach:.3g} m, the kernel's reach"
            measured, key = f"correlation length {shortest:g} m", "numerics.spacing, or the field"
            off = off_by(shortest, reach)
            found.append(finding("short-correlation", what, measured, wanted, key, subject=variable.of, off_by=off))
    return found


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


def of_level_ground(scene: Scene, particles: Particles) -> list[Finding]:
    """A finding if the shaking shears off level ground behind the crest, whose column moves as one: waves that are short beside its height
    shear it less, and amplification more.  Ground with water is left out."""
    if not isinstance(scene.geometry, (Slope, GroundLine)) or scene.water is not None:
        return []
    (enough, depth), peak = level_ground(scene, particles), float(np.abs(loading_of(scene).ground).max())
    if peak < enough:
        return []
    measured = f"{in_both(peak)}, where {in_both(enough)} is enough at a depth of {depth:.3g} m"
    what = "level ground behind the crest, taken as a rigid column, fails in shear as well"
    wanted = "less, unless the ground is meant to fail as a whole"
    return [finding("level-ground-fails", what, measured, wanted, "motion.amplitude")]


def _series(scene: Scene) -> list[Finding]:
    samples = 1.0 / (frequency * scene.outputs.series_interval) if (frequency := highest_frequency(scene)) else np.inf
    if samples >= FEWEST_IN_SERIES:
        return []
    measured = f"{samples:.2g} samples per period at {frequency:.3g} Hz"
    return [
        finding(
            "sparse-series",
            "the stored series have too few samples of the shaking",
            measured,
            f"at least {FEWEST_IN_SERIES}",
            "outputs.series_interval",
            off_by=off_by(samples, FEWEST_IN_SERIES),
        )
    ]


def _step(scene: Scene) -> list[Finding]:
    smallest = min(limits(scene), key=lambda limit: limit.seconds)
    step = scene.numerics.time_step
    if scene.numerics.adaptive_step is not None or step <= SHARE_OF_LIMIT * smallest.seconds:
        return []
    wanted = f"at most {SHARE_OF_LIMIT * smallest.seconds:.2g} s, {SHARE_OF_LIMIT:g} of the limit ({smallest.name})"
    return [
        finding(
            "time-step",
            "the time step is near or above its limit",
            f"{step:.3g} s",
            wanted,
            "numerics.time_step, or numerics.adaptive_step={}",
            off_by=off_by(step, SHARE_OF_LIMIT * smallest.seconds),
        )
    ]
