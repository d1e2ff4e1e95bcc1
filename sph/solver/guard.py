"""The guard: what must never happen in a run, checked at every sample.

The loop itself stops when a particle moves further between two steps than its neighbours' skin allows, or to no number.  At every
sample (``outputs.series_interval``) the state must further be finite, no particle faster than the P-wave, none behind the walls, and the
budget of energy must close: more energy in the soil than was put into it is made by the scheme.  A run in which one of these happens
ends with the status ``diverged`` and says what, when, which particle, and what is likely to be the cause.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.particles import Particles
from sph.solver.terms import State
from sph.storage.sources import words

MAX_SPEED_RATIO = 1.0
"""A particle is too fast above this multiple of V_p."""
MAX_ENERGY_GAP = 0.25
"""Largest gap in the energy budget, and largest negative dissipation, over the sum of its parts: now, half-way or at the start.
Soil that settles between free-slip walls gains up to a tenth of its small energies from them; what diverges gains more than all."""
SMALL_SPEED = 1e-3
"""Energies below that of the soil at this part of V_p are not judged: a run begins with none."""
PARTS = ("kinetic_energy", "elastic_energy", "potential_energy", "dissipated_energy")


class Fault(StrEnum):
    """What must never happen."""

    NOT_A_NUMBER = "not_a_number"
    JUMPED = "jumped"
    TOO_FAST = "too_fast"
    LEFT_THE_BOX = "left_the_box"
    ENERGY_GAP = "energy_gap"
    ENERGY_MADE = "energy_made"


SENTENCES = {
    Fault.NOT_A_NUMBER: words("is not a number"),
    Fault.JUMPED: words("jumped further than its neighbours' skin in a step"),
    Fault.TOO_FAST: words("is faster than V_p, {:.0f} m/s"),
    Fault.LEFT_THE_BOX: words("has left the box"),
    Fault.ENERGY_GAP: words("the energy budget is open by {:.0%} of its parts"),
    Fault.ENERGY_MADE: words("energy was made: the dissipated part is {:.0%} of all"),
}
"""The faults in words with the value of each, those of a particle as what is said of it."""


class Trouble(NamedTuple):
    """A fault of a run at a sample: what, where and by how much."""

    fault: Fault
    value: float = math.nan  # V_p, m/s, or the share of the energies
    particle: int | None = None  # none for a fault of all
    place: tuple[float, float] = (math.nan, math.nan)  # where the particle was at first, in the coordinates of the ground, m

    def __str__(self) -> str:
        """The fault in words."""
        text = SENTENCES[self.fault].format(self.value)
        x, y = self.place
        return text if self.particle is None else words(f"particle {self.particle}, at first at ({x:.4g}, {y:.4g}) m, {text}")


def trouble(scene: Scene, particles: Particles, state: State, series: Mapping[str, Sequence[Any]], jumped: bool = False) -> Trouble | None:
    """What is wrong with a run at its last sample; None while it is sound.

    ``series`` holds the samples by name; ``jumped`` says that the loop has stopped by itself.
    """
    soil = slice(0, particles.n_soil)
    fields = np.array([getattr(state, name)[soil] for name in ("x", "y", "vx", "vy", "density", "ax", "ay")])
    wrong = ~np.isfinite(fields).all(axis=0)
    if wrong.any():
        return _at(scene, particles, int(np.argmax(wrong)), Fault.NOT_A_NUMBER)
    if jumped:
        moved = np.hypot(state.x - state.x_pairs, state.y - state.y_pairs)[soil]
        return _at(scene, particles, int(np.argmax(moved)), Fault.JUMPED)
    speed = np.hypot(state.vx, state.vy)[soil]
    wave = scene.largest_p_wave_speed
    if not speed.max() < MAX_SPEED_RATIO * wave:
        return _at(scene, particles, int(np.argmax(speed)), Fault.TOO_FAST, wave)
    outside = _behind_walls(scene, particles, state)
    if outside.any():
        return _at(scene, particles, int(np.argmax(outside)), Fault.LEFT_THE_BOX)
    smallest = 0.5 * float(particles.mass[soil].sum()) * (SMALL_SPEED * wave) ** 2
    return _energy_made(series, smallest)


def _at(scene: Scene, particles: Particles, i: int, fault: Fault, value: float = math.nan) -> Trouble:
    return Trouble(fault, value, i, scene.geometry.in_survey(float(particles.x[i]), float(particles.y[i])))


def _behind_walls(scene: Scene, particles: Particles, state: State) -> np.ndarray:
    """Which soil (n,) lies behind the last layer of a wall as it is now (sides are as high as theirs) or below the base past its end."""
    reach = 0.5 * scene.numerics.spacing
    (x, wall_x), (y, wall_y) = (np.split(a, [particles.n_soil]) for a in (state.x, state.y))
    (base, sides, top), behind = scene.walls.kinds, np.zeros(x.size, bool)
    if not base.open:
        behind |= y < wall_y.min() - reach
    if not top.open:
        behind |= y > wall_y.max() + reach
    if sides.has_particles:
        low = y < wall_y.max() + reach
        behind |= low & ((x < wall_x.min() - reach) | (x > wall_x.max() + reach))
    return behind


def _energy_made(series: Mapping[str, Sequence[Any]], smallest: float) -> Trouble | None:
    """What shows, by the last sample, that the scheme has made energy; energies below the smallest (J/m) do not count."""
    now = {name: float(series[name][-1]) for name in (*PARTS, "shaking_work")}
    half_way = len(series["kinetic_energy"]) // 2
    scale = max(smallest, *(math.fsum(abs(float(series[name][k])) for name in PARTS) for k in (-1, half_way, 0)))
    balance = math.fsum(now[name] for name in PARTS) - now["shaking_work"]
    start = math.fsum(float(series[name][0]) for name in PARTS) - float(series["shaking_work"][0])
    gap = abs(balance - start)
    if not gap <= MAX_ENERGY_GAP * scale:
        return Trouble(Fault.ENERGY_GAP, gap / scale)
    if not now["dissipated_energy"] >= -MAX_ENERGY_GAP * scale:
        return Trouble(Fault.ENERGY_MADE, now["dissipated_energy"] / scale)
    return None


def likely_cause(scene: Scene, ratio: float, wrong: Trouble) -> str:
    """What to look at first, from the largest time step over its measured limit so far, the scene, and what is wrong."""
    if ratio > 1.0:
        return words(
            f"the time step was {ratio:.2f} times its measured limit: choose a smaller numerics.time_step, or numerics.adaptive_step"
        )
    if wrong.fault == Fault.LEFT_THE_BOX:
        return words(
            "soil ran off an open end of the base, ran over the walls, or pushed away an absorbing base, which holds no load that "
            "comes after the gravity stage: widen the box or deepen it (geometry), close its sides, give it a stiff base "
            "(walls.bedrock, or walls.base: no_slip), or shake it less"
        )
    if scene.numerics.artificial_viscosity is None or scene.numerics.artificial_viscosity.alpha < 0.1:
        return words("little or no artificial viscosity: particles that meet fast pass between each other (numerics.artificial_viscosity)")
    return words("particles that meet fast pass between each other: try a smaller time step, more artificial viscosity, or a finer spacing")
