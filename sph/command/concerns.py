"""What a user should know before trusting a scene's numbers: each with what is measured, what is wanted and the key to change."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sph.geometry import Slope
from sph.ground_line import GroundLine, largest_climb
from sph.motion import NoMotion
from sph.particles import Particles
from sph.scene import Scene
from sph.soil import Soil
from sph.timestep import limits, wave_speed_ratio

FEWEST_IN_HEIGHT = 12
"""Particles across the height of a slope: the fewest in the ladder (README), whose classes are right and run-outs 60 % off."""
FEWEST_IN_LAYER = 4
"""Particles across a layer: a kernel of h = 1.3 spacings reaches 2.6 to either side, and mixes a thinner one with its neighbours."""
FEWEST_IN_WAVE = 8
"""Smoothing lengths (or spacings, where they are longer) in the shortest wavelength: one eighth is the largest element that Kuhlemeyer
and Lysmer (1973) allow; at it the lattice carries waves some 9 % too slowly at any h, at a tenth 6 %."""
ENERGY = 0.95
"""Part of the motion's energy (Arias intensity) below its highest significant frequency."""
ROOM_BEHIND, ROOM_AHEAD = 1.0, 2.0
"""Soil behind the crest and before the toe, over the slope's height; the paper's slope runs out 1.3 heights with S_R 0.10."""
SHARE_OF_LIMIT = 0.8
"""Largest part of the lattice's limit for a fixed time step: debris is 1.2 times as stiff (``sph.timestep``)."""


class Concern(NamedTuple):
    """Something that may spoil a result."""

    what: str
    measured: str
    wanted: str
    key: str

    def sentence(self) -> str:
        """All of it in one line."""
        return f"{self.what}: {self.measured}, wanted {self.wanted}; change {self.key}"


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
    interval = max(scene.numerics.time_step, scene.duration / 200_000)
    acceleration = scene.motion.acceleration(np.arange(0.0, scene.duration, interval))
    power = np.abs(np.fft.rfft(acceleration)) ** 2
    if not power.any():
        return 0.0
    return float(np.fft.rfftfreq(acceleration.size, interval)[np.searchsorted(np.cumsum(power), ENERGY * power.sum())])


def in_wave(scene: Scene, soil: Soil, frequency: float) -> float:
    """Smoothing lengths, or spacings where they are longer, in a shear wave's length at a frequency (Hz)."""
    return soil.s_wave_speed / frequency / max(scene.numerics.smoothing_length, scene.numerics.spacing) if frequency else np.inf


def concerns(scene: Scene, particles: Particles) -> list[Concern]:
    """All that holds for a scene and its particles."""
    return (
        [found for layer in layers_of(scene, particles) for found in _layer(scene, layer)]
        + (_slope(scene, scene.geometry) if isinstance(scene.geometry, (Slope, GroundLine)) else [])
        + thin_box(scene)
        + cut_off(scene)
        + _step(scene)
    )


def _layer(scene: Scene, layer: Layer) -> list[Concern]:
    found = []
    frequency = highest_frequency(scene)
    lengths = in_wave(scene, layer.soil, frequency)
    if layer.thickness < FEWEST_IN_LAYER:
        wanted = f"at least {FEWEST_IN_LAYER}"
        found.append(Concern(f"{layer.name} is thin", f"{layer.thickness:g} particles across", wanted, "numerics.spacing, or the layer"))
    if lengths < FEWEST_IN_WAVE:
        ratio = wave_speed_ratio(scene, layer.soil.s_wave_speed / frequency)
        found.append(
            Concern(
                f"shear waves of {frequency:.3g} Hz are short in {layer.name}",
                f"{lengths:.2g} smoothing lengths in {layer.soil.s_wave_speed / frequency:.3g} m, carried {1 - ratio:.0%} too slowly",
                f"at least {FEWEST_IN_WAVE} (Kuhlemeyer and Lysmer 1973)",
                "numerics.spacing or numerics.smoothing_ratio",
            )
        )
    return found


def _slope(scene: Scene, geometry: Slope | GroundLine) -> list[Concern]:
    found = []
    height, (toe_x, _), (crest_x, _) = geometry.slope_height, geometry.toe, geometry.crest
    if height < FEWEST_IN_HEIGHT * scene.numerics.spacing * (1 - 1e-9):
        across = f"{height / scene.numerics.spacing:.1f} particles in {height:g} m"
        found.append(Concern("few particles across the slope's height", across, f"at least {FEWEST_IN_HEIGHT}", "numerics.spacing"))
    behind = geometry.width - crest_x
    if behind < ROOM_BEHIND * height:
        key = "geometry.crest_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(Concern("the back wall is near the crest", f"{behind:.3g} m", f"at least H = {ROOM_BEHIND * height:.3g} m", key))
    if toe_x < ROOM_AHEAD * height:
        key = "geometry.apron_length" if isinstance(geometry, Slope) else "geometry.window or the line"
        found.append(
            Concern("little room for the run-out before the front wall", f"{toe_x:.3g} m", f"2 H = {ROOM_AHEAD * height:.3g} m", key)
        )
    if isinstance(geometry, GroundLine):
        x, y = (np.array(side) for side in geometry.surface)
        (_, low), (_, high) = largest_climb(np.column_stack([-x, y])[::-1], 0.0)
        if high - low > height:
            other = "right" if geometry.downhill == "left" else "left"
            found.append(
                Concern(
                    f"the ground falls further to the {other} than to the {geometry.downhill}",
                    f"{high - low:.3g} m and {height:.3g} m",
                    "the slope that may fail",
                    f"geometry.downhill={other}, or a narrower geometry.window",
                )
            )
    return found


def thin_box(scene: Scene) -> list[Concern]:
    """Whether the box's layers of particles leave the kernel unfilled."""
    walls, needed = scene.walls, scene.layers_filling_support
    if walls.hold and walls.layers < needed:
        return [
            Concern(
                "the box's particles do not fill the kernel's support, so that stresses beside it alternate from row to row",
                f"{walls.layers} layers",
                f"{needed}",
                f"walls.layers={needed}, or a smaller numerics.smoothing_ratio",
            )
        ]
    return []


def cut_off(scene: Scene) -> list[Concern]:
    """Whether the run ends before the motion."""
    if isinstance(scene.motion, NoMotion) or scene.motion.end <= scene.duration:
        return []
    end = f"{scene.motion.end:.4g} s"
    return [Concern("the run ends while the ground moves", f"{scene.duration:g} s", f"more than {end}", f"duration, above {end}")]


def _step(scene: Scene) -> list[Concern]:
    smallest = min(limits(scene), key=lambda limit: limit.seconds)
    step = scene.numerics.time_step
    if scene.numerics.adaptive_step is not None or step <= SHARE_OF_LIMIT * smallest.seconds:
        return []
    wanted = f"at most {SHARE_OF_LIMIT * smallest.seconds:.2g} s, {SHARE_OF_LIMIT:g} of the limit ({smallest.name})"
    return [
        Concern("the time step is near its limit or above", f"{step:.3g} s", wanted, "numerics.time_step, or numerics.adaptive_step={}")
    ]
