"""Diagnostics of a scene before it is run: what may spoil its results, with the measured and the wanted value and the key to change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid  # type: ignore[import-untyped]

from sph.scene.geometry import Slope
from sph.scene.gravity import GRAVITY
from sph.scene.ground_line import GroundLine, largest_climb
from sph.scene.ground_motion import GroundMotion, loading_of
from sph.scene.ground_motion.record import Record, processed
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.schema import Scene
from sph.scene.soil import Soil
from sph.solver.particles import Particles
from sph.solver.time_step import limits, wave_speed_ratio

FEWEST_IN_HEIGHT = 12
"""Fewest particles across the height of a slope in the cost-accuracy study (README): its classes are right, its run-outs 60 % off."""
FEWEST_IN_LAYER = 4
"""Particles across a layer: a kernel of h = 1.3 spacings reaches 2.6 to either side, and mixes a thinner one with its neighbours."""
FEWEST_IN_LENGTH = 3
"""Spacings in the length over which plastic strain is averaged before soil fails."""
FEWEST_IN_WAVE = 8
"""Smoothing lengths (or spacings, where they are longer) in the shortest wavelength: one eighth is the largest element that Kuhlemeyer
and Lysmer (1973) allow; at it the lattice carries waves some 9 % too slowly at any h, at a tenth 6 %."""
ENERGY = 0.95
"""Part of the motion's energy (Arias intensity) below its highest significant frequency."""
SAMPLES_IN_PERIOD = 8
"""Samples in the shortest period of a motion from which its spectrum is made."""
FEWEST_IN_SERIES = 10
"""Samples of the series in a period of the highest significant frequency, of which straight lines miss the peak by at most 5 %."""
WEAKEST, STRONGEST = 0.01, 3.0
"""Peak accelerations of the ground that are plausible, g: the largest recorded are 2.7 g horizontally (MYG004, Tohoku 2011) and 3.9 g
vertically (IWTH25, Iwate-Miyagi 2008), and below a hundredth of g no slope that stands is moved.  Beyond them units are mistaken."""
LARGEST_DRIFT = 0.1
"""Velocity of the ground at the end of a record over its largest."""
ROOM_BEHIND, ROOM_AHEAD = 1.0, 2.0
"""Soil behind the crest and before the toe, over the slope's height; the paper's slope runs out 1.3 heights with S_R 0.10."""
SHARE_OF_LIMIT = 0.8
"""Largest part of the lattice's limit for a fixed time step: debris is 1.2 times as stiff (``sph.solver.time_step``)."""


class Diagnostic(NamedTuple):
    """A diagnostic: something that may spoil a result."""

    what: str
    measured: str
    wanted: str
    key: str

    def sentence(self) -> str:
        """The diagnostic in one sentence."""
        return f"{self.what}: {self.measured}, wanted {self.wanted}; change {self.key}"


def strengths(scene: Scene) -> list[tuple[str, str]]:
    """Name and strength of the scene's own soil and of every layer: at the peak and what failed soil keeps, with S_R and gamma."""
    found = []
    layers = [("soil", scene.soil, None, None), *((name, its.soil, its.S_R, its.gamma) for name, its in scene.layers.items())]
    for name, soil, own_ratio, own_rate in layers:
        ratio = scene.coupling.S_R if own_ratio is None else own_ratio
        rate = scene.coupling.gamma if own_rate is None else own_rate
        peak, residual = (f"c = {k * soil.cohesion:.4g} kPa, phi = {k * soil.friction_angle:.4g} degree" for k in (1.0, ratio))
        found.append((name, f"peak {peak}; residual {residual} (S_R = {ratio:g}, gamma = {rate:g} 1/s)"))
    return found


class Layer(NamedTuple):
    """The soil particles of one material."""

    name: str
    soil: Soil
    particles: int
    thickness: float  # that three quarters of its columns exceed, particles


def layers_of(scene: Scene, particles: Particles) -> list[Layer]:
    """The materials with their particles."""
    x, index = particles.x[: particles.n_soil], particles.layer[: particles.n_soil]
    found = []
    for number, (name, soil) in enumerate(zip(("soil", *scene.layers), scene.soils, strict=True)):
        columns = np.unique(np.round(x[index == number] / scene.numerics.spacing - 0.5), return_counts=True)[1]
        found.append(Layer(name, soil, int(columns.sum()), float(np.percentile(columns, 25)) if columns.size else 0.0))
    return found


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


def diagnostics(scene: Scene, particles: Particles) -> list[Diagnostic]:
    """All diagnostics that apply to a scene and its particles."""
    return (
        [found for layer in layers_of(scene, particles) for found in _layer(scene, layer)]
        + (_slope(scene, scene.geometry) if isinstance(scene.geometry, (Slope, GroundLine)) else [])
        + thin_box(scene)
        + of_initiation(scene)
        + of_motion(scene)
        + _series(scene)
        + _step(scene)
    )


def _layer(scene: Scene, layer: Layer) -> list[Diagnostic]:
    found = []
    frequency = highest_frequency(scene)
    lengths = in_wave(scene, layer.soil, frequency)
    if layer.thickness < FEWEST_IN_LAYER:
        wanted = f"at least {FEWEST_IN_LAYER}"
        found.append(Diagnostic(f"{layer.name} is thin", f"{layer.thickness:g} particles across", wanted, "numerics.spacing, or the layer"))
    if lengths < FEWEST_IN_WAVE:
        ratio = wave_speed_ratio(scene, layer.soil.s_wave_speed / frequency)
        found.append(
            Diagnostic(
                f"shear waves of {frequency:.3g} Hz are short in {layer.name}",
                f"{lengths:.2g} smoothing lengths in {layer.soil.s_wave_speed / frequency:.3g} m, carried {1 - ratio:.0%} too slowly",
                f"at least {FEWEST_IN_WAVE} (Kuhlemeyer and Lysmer 1973)",
                "numerics.spacing or numerics.smoothing_ratio",
            )
        )
    return found


def _slope(scene: Scene, geometry: Slope | GroundLine) -> list[Diagnostic]:
    found = []
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    if height < FEWEST_IN_HEIGHT * scene.numerics.spacing * (1 - 1e-9):
        across = f"{height / scene.numerics.spacing:.1f} particles in {height:g} m"
        found.append(Diagnostic("few particles across the slope's height", across, f"at least {FEWEST_IN_HEIGHT}", "numerics.spacing"))
    behind = geometry.width - crest_x
    if behind < ROOM_BEHIND * height:
        key = "geometry.crest_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(Diagnostic("the back wall is near the crest", f"{behind:.3g} m", f"at least H = {ROOM_BEHIND * height:.3g} m", key))
    if toe_x < ROOM_AHEAD * height:
        key = "geometry.apron_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(
            Diagnostic("little room for the run-out before the front wall", f"{toe_x:.3g} m", f"2 H = {ROOM_AHEAD * height:.3g} m", key)
        )
    if isinstance(geometry, GroundLine):
        x, y = (np.array(side) for side in geometry.surface)
        (_, low), (_, high) = largest_climb(np.column_stack([-x, y])[::-1], 0.0)
        if high - low > height:
            other = "right" if geometry.downhill == "left" else "left"
            found.append(
                Diagnostic(
                    f"the ground falls further to the {other} than to the {geometry.downhill}",
                    f"{high - low:.3g} m and {height:.3g} m",
                    "the slope that may fail",
                    f"geometry.downhill={other}, or a narrower geometry.window",
                )
            )
    return found


def thin_box(scene: Scene) -> list[Diagnostic]:
    """A warning if the box has fewer layers of particles than fill the kernel's support."""
    walls, needed = scene.walls, scene.layers_filling_support
    if any(kind.stands for kind in walls.kinds) and walls.layers < needed:
        return [
            Diagnostic(
                "the box's particles do not fill the kernel's support, so that stresses beside it alternate from row to row",
                f"{walls.layers} layers",
                f"{needed}",
                f"walls.layers={needed}, or a smaller numerics.smoothing_ratio",
            )
        ]
    return []


def of_initiation(scene: Scene) -> list[Diagnostic]:
    """A warning if failure begins over no length, or over one that is shorter than particles can average; the paper's has none."""
    initiation, dx = scene.coupling.initiation, scene.numerics.spacing
    if initiation is None and scene.scheme != "paper":
        return [
            Diagnostic(
                "soil fails as soon as its stress reaches its strength, so that the spacing decides at which shaking the slope goes",
                "no length",
                "a slip and a length of a shear test",
                "coupling.initiation",
            )
        ]
    if initiation is None or initiation.length >= FEWEST_IN_LENGTH * dx * (1 - 1e-9):
        return []
    return [
        Diagnostic(
            "the length of initiation is short, so that the spacing decides when soil fails",
            f"{initiation.length / dx:.2g} spacings in {initiation.length:g} m",
            f"at least {FEWEST_IN_LENGTH}",
            "numerics.spacing, or coupling.initiation.length",
        )
    ]


def cut_off(scene: Scene) -> list[Diagnostic]:
    """A warning if the run ends before the motion does."""
    if isinstance(scene.motion, NoMotion) or scene.motion.end <= scene.duration:
        return []
    end = f"{scene.motion.end:.4g} s"
    return [Diagnostic("the run ends while the ground moves", f"{scene.duration:g} s", f"more than {end}", f"duration, above {end}")]


def of_motion(scene: Scene) -> list[Diagnostic]:
    """All diagnostics of the shaking of a scene."""
    loading = loading_of(scene)
    components = {"horizontal": loading.ground, "vertical": loading.vertical}
    return cut_off(scene) + drift(scene) + implausible(components, "motion.amplitude, or the unit of the record")


def peak_accelerations(scene: Scene) -> str:
    """Peak accelerations of the ground in a run, of the motion as processed and scaled."""
    loading = loading_of(scene)
    peaks = {"horizontal": np.abs(loading.ground).max(), "vertical": np.abs(loading.vertical).max()}
    return ", ".join(f"{name} {in_both(float(peak))}" for name, peak in peaks.items() if peak or name == "horizontal")


def drift(scene: Scene) -> list[Diagnostic]:
    """A warning if the record of a scene drifts after processing."""
    if not isinstance(scene.motion, Record):
        return []
    made = processed(scene.motion)
    return drifting(GroundMotion(made.time, made.horizontal), "motion.baseline={}")


def implausible(components: Mapping[str, np.ndarray], key: str) -> list[Diagnostic]:
    """A warning for each peak of accelerations (n,) in m/s2, by direction, the horizontal first, that is not plausible; 0 is."""
    wanted = f"{WEAKEST:g} to {STRONGEST:g} g"
    peaks = {name: float(np.abs(values).max()) for name, values in components.items()}
    return [
        Diagnostic(f"the {name} peak acceleration of the ground is implausible", in_both(peak), wanted, key)
        for name, peak in peaks.items()
        if peak > STRONGEST * GRAVITY or name == "horizontal" and 0.0 < peak < WEAKEST * GRAVITY
    ]


def drifting(motion: GroundMotion, key: str) -> list[Diagnostic]:
    """A warning if the ground still moves at the end of a record: an offset of the recorder, which moves a sliding block like shaking."""
    velocity = cumulative_trapezoid(motion.acceleration, motion.time)
    largest, last = float(np.abs(velocity).max()), abs(float(velocity[-1]))
    if last <= LARGEST_DRIFT * largest:
        return []
    return [Diagnostic("the ground of the record drifts", f"{last:.2g} m/s at its end", f"at most {LARGEST_DRIFT * largest:.2g} m/s", key)]


def in_both(acceleration: float) -> str:
    """An acceleration (m/s2) in m/s2 and g."""
    return f"{acceleration:.4g} m/s2 ({acceleration / GRAVITY:.3g} g)"


def _series(scene: Scene) -> list[Diagnostic]:
    samples = 1.0 / (frequency * scene.outputs.series_interval) if (frequency := highest_frequency(scene)) else np.inf
    if samples >= FEWEST_IN_SERIES:
        return []
    measured = f"{samples:.2g} in a period of {frequency:.3g} Hz"
    return [Diagnostic("the series hold few samples of the shaking", measured, f"at least {FEWEST_IN_SERIES}", "outputs.series_interval")]


def _step(scene: Scene) -> list[Diagnostic]:
    smallest = min(limits(scene), key=lambda limit: limit.seconds)
    step = scene.numerics.time_step
    if scene.numerics.adaptive_step is not None or step <= SHARE_OF_LIMIT * smallest.seconds:
        return []
    wanted = f"at most {SHARE_OF_LIMIT * smallest.seconds:.2g} s, {SHARE_OF_LIMIT:g} of the limit ({smallest.name})"
    return [
        Diagnostic("the time step is near its limit or above", f"{step:.3g} s", wanted, "numerics.time_step, or numerics.adaptive_step={}")
    ]
