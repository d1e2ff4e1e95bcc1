"""The layers of the ground below a place, and the natural frequencies of that column in shear: the one home of both.

A column of horizontal layers, undamped, of the stiffness at small strain that the scene has.  On a rigid base (the usual definition: the
"fixed-base period" of building codes, V_s / 4H of one soil) its modes are exact.  An elastic half-space below, of whatever stiffness, takes
waves away: the column then has no modes without damping, and its resonance is the first peak of the motion of the surface over that of an
outcrop of the half-space (Kramer 1996, Sec. 7.2.1).  Where the half-space is like the lowest soil nothing is reflected at the base of the
model, whose depth then says nothing; what is left are the resonances of softer layers above.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy  # type: ignore[import-untyped]

from sph.scene.layers import layer_at
from sph.scene.places import Point
from sph.scene.schema import Scene

PARTS, HALVINGS = 2000, 40
"""Parts of a column in which its layers are found, and halvings of a part in which their sides are."""
MODES, POINTS = 10, 8000
"""Modes on a rigid base up to which the first peak over a half-space is sought, and frequencies at which it is."""
FLAT = 1.01
"""Amplification below which a peak is none."""


class Stratum(NamedTuple):
    """Part of a column within one of the scene's soils."""

    number: int  # 0 for the scene's own soil, k for its k-th layer
    top: float  # depth below the ground, m
    bottom: float  # m


class Column(NamedTuple):
    """Horizontal layers (n,) from the ground downwards."""

    thickness: np.ndarray  # m
    speed: np.ndarray  # of shear waves, m/s
    density: np.ndarray  # kg/m3

    @property
    def impedance(self) -> np.ndarray:
        """Impedance (n,) rho V_s, kg/m2/s."""
        return self.density * self.speed


class Transfer(NamedTuple):
    """Complex amplitudes at frequencies (n,) for a unit displacement of the surface."""

    base: np.ndarray  # (n,) displacement of the base
    stress: np.ndarray  # (n,) shear stress there over 2 pi times the frequency, kg/m2/s
    strain: np.ndarray  # (layers, n) shear strain in the middle of each layer, 1/m

    def outcrop(self, below: float) -> np.ndarray:
        """Displacement (n,) of an outcrop of a half-space of an impedance ``below``, kg/m2/s; an infinite one is a rigid base itself."""
        return np.asarray(self.base - 1j * self.stress / below)


class Peak(NamedTuple):
    """Resonance over an elastic half-space."""

    frequency: float  # Hz
    amplification: float  # of the undamped column: motion of the surface over that of an outcrop of the half-space


def strata_at(scene: Scene, place: Point) -> list[Stratum]:
    """The soils below a place on the ground, in coordinates of the box, m, down to the base of the model; none without ground."""
    x, ground = place
    if not ground > 0.0:
        return []

    def numbers(depth: np.ndarray) -> np.ndarray:
        return layer_at(scene, np.full(depth.shape, x), ground - depth, np.full(depth.shape, ground))

    depth = (np.arange(PARTS) + 0.5) * ground / PARTS
    found = numbers(depth)
    last = np.flatnonzero(np.diff(found))
    above, below = depth[last], depth[last + 1]
    for _ in range(HALVINGS):
        middle = 0.5 * (above + below)
        same = numbers(middle) == found[last]
        above, below = np.where(same, middle, above), np.where(same, below, middle)
    ends = [0.0, *below.tolist(), ground]
    return [Stratum(number, *pair) for number, pair in zip(found[[*last, -1]].tolist(), pairwise(ends), strict=True)]


def column_at(scene: Scene, place: Point) -> Column:
    """The column below a place, as ``strata_at``."""
    strata = strata_at(scene, place)
    soils = [scene.soils[each.number] for each in strata]
    columns = [(each.bottom - each.top, soil.s_wave_speed, soil.density) for each, soil in zip(strata, soils, strict=True)]
    return Column(*np.array(columns).reshape(-1, 3).T)


def natural_frequencies(column: Column, count: int = 1) -> np.ndarray:
    """First natural frequencies (count,) of a column on a rigid base, Hz.

    In each layer u = a cos(theta), where theta grows by omega h / V_s; the stress over the displacement, Z tan(theta) with the impedance Z,
    is the same on both sides of an interface.  In the n-th mode theta is (n - 1/2) pi at the base.  theta grows with the frequency.
    """
    impedance = column.impedance
    contrasts = [*(impedance[:-1] / impedance[1:]), 1.0]
    times = column.thickness / column.speed

    def phase(omega: float) -> float:
        theta = 0.0
        for time, contrast in zip(times, contrasts, strict=True):
            theta += omega * time
            turns = math.pi * round(theta / math.pi)
            theta = turns + math.atan2(contrast * math.sin(theta - turns), math.cos(theta - turns))
        return theta

    found, held = [], 0.5 * math.pi * len(times)  # each interface shifts theta by less than a quarter of a turn
    for mode in range(count):
        target = (mode + 0.5) * math.pi
        ends = max(target - held, 0.0) / times.sum(), (target + held) / times.sum()
        found.append(scipy.optimize.brentq(lambda omega, wanted=target: phase(omega) - wanted, *ends, rtol=1e-12))
    return np.array(found) / (2.0 * math.pi)


def transfer(column: Column, frequency: np.ndarray, stiff: npt.ArrayLike = 1.0, heavy: npt.ArrayLike = 1.0) -> Transfer:
    """What a vertical shear wave does in a column at frequencies (n,), Hz, for a unit displacement of the surface.

    ``stiff`` and ``heavy`` multiply moduli and densities (broadcast to (layers, n)) with the complex factors of a damping: 1 + 2 i xi of
    one that does not depend on the frequency, 1 + i omega beta and 1 - i alpha / omega of Rayleigh's.
    """
    omega = 2.0 * math.pi * frequency
    shape = column.thickness.size, frequency.size
    factors = (np.broadcast_to(np.asarray(each, complex), shape) for each in (stiff, heavy))
    u, stress, strain = np.ones(frequency.size, complex), np.zeros(frequency.size, complex), []
    for thickness, speed, impedance, g, m in zip(column.thickness, column.speed, column.impedance, *factors, strict=True):
        theta, z = omega * thickness / speed * np.sqrt(m / g), impedance * np.sqrt(m * g)
        middle = stress * np.cos(0.5 * theta) - z * u * np.sin(0.5 * theta)
        strain.append(middle * omega / (impedance * speed * g))
        u, stress = u * np.cos(theta) + stress / z * np.sin(theta), stress * np.cos(theta) - z * u * np.sin(theta)
    return Transfer(u, stress, np.array(strain))


def amplification(column: Column, below: float, frequency: np.ndarray) -> np.ndarray:
    """Motion of the surface over that of an outcrop of an elastic half-space of an impedance ``below`` (kg/m2/s), at frequencies (n,)."""
    return np.asarray(1.0 / np.abs(transfer(column, frequency).outcrop(below)))


def first_peak(column: Column, below: float) -> Peak | None:
    """The lowest resonance of a column over a half-space of an impedance ``below`` (kg/m2/s); None where it amplifies nothing."""
    frequency = np.linspace(0.0, natural_frequencies(column, MODES)[-1], POINTS + 1)
    factor = amplification(column, below, frequency)
    tops = 1 + np.flatnonzero((factor[1:-1] >= factor[:-2]) & (factor[1:-1] > factor[2:]) & (factor[1:-1] > FLAT))
    if not tops.size:
        return None
    low, high = frequency[tops[0] - 1], frequency[tops[0] + 1]

    def inverse(f: float) -> float:
        return float(1.0 / amplification(column, below, np.array([f]))[0])

    found = scipy.optimize.minimize_scalar(inverse, bounds=(low, high), method="bounded", options={"xatol": 1e-6 * high})
    return Peak(float(found.x), 1.0 / float(found.fun))


def natural_frequency(scene: Scene, place: Point) -> float:
    """First natural frequency of the ground below a place, on a rigid base, Hz; infinite without ground."""
    column = column_at(scene, place)
    return float(natural_frequencies(column)[0]) if column.thickness.size else math.inf


def impedance_below(scene: Scene, column: Column) -> float:
    """Impedance of the half-space below a column, kg/m2/s: of the bedrock, or of the lowest soil, which goes on; infinite if rigid."""
    if not scene.walls.kinds.base.absorbs:
        return math.inf
    rock = scene.walls.bedrock
    return float(column.impedance[-1]) if rock is None else rock.density * rock.s_wave_speed
