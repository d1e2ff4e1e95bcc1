"""Artificial stress against numerical fracture: a pressure in place of part of each principal tension (Gray, Monaghan and Swift 2001)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock, rows
from sph.solver.compiled.slots import neighbours_of, slot
from sph.solver.optional import Arrays, Term
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel, evaluate
from sph.solver.physics.material import lightness

if TYPE_CHECKING:
    from sph.solver.neighbours import Pairs
    from sph.solver.physics.material import Layers
    from sph.solver.terms import State


class ArtificialStress(NamedTuple):
    """Coefficients of the term."""

    factor: float
    exponent: float
    inverse_kernel: float
    """1 / W(spacing), m2"""


@slot
def keep_nearness(tension: ArtificialStress | None, nearness: np.ndarray, k: int, value: float) -> None:
    """Keep (W(r) / W(spacing)) to the term's exponent of pair k, from its W(r)."""


@keep_nearness.of(ArtificialStress)
def _keep_nearness(tension: ArtificialStress, nearness: np.ndarray, k: int, value: float) -> None:
    nearness[k] = (value * tension.inverse_kernel) ** tension.exponent


@slot
def set_artificial_stress(tension: ArtificialStress | None, state: State, first: int, last: int) -> None:
    """Artificial stress of particles first to last: minus a share of each principal tension."""


@set_artificial_stress.of(ArtificialStress)
def _set_artificial_stress(tension: ArtificialStress, state: State, first: int, last: int) -> None:
    for i in rows(first, last):
        mean = 0.5 * (state.sxx[i] + state.syy[i])
        diff = 0.5 * (state.sxx[i] - state.syy[i])
        shear = state.sxy[i]
        radius = math.sqrt(diff * diff + shear * shear)
        first_principal = -tension.factor * max(mean + radius, 0.0)
        second_principal = -tension.factor * max(mean - radius, 0.0)
        middle, half = 0.5 * (first_principal + second_principal), 0.5 * (first_principal - second_principal)
        cosine, sine = (diff / radius, shear / radius) if radius > 0.0 else (1.0, 0.0)
        state.tension_xx[i] = middle + half * cosine
        state.tension_yy[i] = middle - half * cosine
        state.tension_xy[i] = half * sine


@slot
def add_artificial_stress(
    tension: ArtificialStress | None, layers: Layers | None, state: State, pairs: Pairs, first: int, last: int
) -> None:
    """Add the artificial stress' acceleration to particles first to last; equal and opposite for a pair."""


@add_artificial_stress.of(ArtificialStress)
def _add_artificial_stress(tension: ArtificialStress, layers: Layers | None, state: State, pairs: Pairs, first: int, last: int) -> None:
    for i in rows(first, last):
        ax = ay = 0.0
        for k in neighbours_of(pairs, pairs.start[i], pairs.end[i]):
            j = pairs.neighbour[k]
            xy = state.tension_xy[i] + state.tension_xy[j]
            ax += pairs.nearness[k] * ((state.tension_xx[i] + state.tension_xx[j]) * pairs.gx[k] + xy * pairs.gy[k])
            ay += pairs.nearness[k] * (xy * pairs.gx[k] + (state.tension_yy[i] + state.tension_yy[j]) * pairs.gy[k])
        ax *= lightness(layers, i)
        ay *= lightness(layers, i)
        state.viscous_x[i] += ax
        state.viscous_y[i] += ay
        state.ax[i] += ax
        state.ay[i] += ay


class ArtificialStressState(NamedTuple):
    """What the term keeps of the state."""

    tension_xx: np.ndarray  # (n,) artificial stress over density squared
    tension_yy: np.ndarray  # (n,)
    tension_xy: np.ndarray  # (n,)


def _start(scene: Scene, particles: Particles) -> ArtificialStressState:
    n = particles.x.size
    return ArtificialStressState(np.zeros(n), np.zeros(n), np.zeros(n))


def _make(scene: Scene, particles: Particles, kernel: Kernel, dt: float) -> ArtificialStress:
    tension = scene.numerics.artificial_stress
    assert tension is not None
    with compile_lock(required=False):
        value, _ = evaluate(kernel, scene.numerics.spacing)
    return ArtificialStress(tension.factor, tension.exponent, 1.0 / value)


class ArtificialStressPairs(NamedTuple):
    """What the term keeps with the pairs."""

    nearness: np.ndarray  # (m,) (W(r) / W(spacing)) to its exponent


def _room(n: int, size: int, dtype: np.dtype[Any]) -> ArtificialStressPairs:
    return ArtificialStressPairs(np.empty(size, dtype))


TERM = Term(
    "artificial_stress",
    "numerics.artificial_stress: prevents numerical fracture",
    lambda scene: scene.numerics.artificial_stress is not None,
    _make,
    in_pairs=True,
    state=Arrays(ArtificialStressState, _start),
    pairs=Arrays(ArtificialStressPairs, _room),
)
