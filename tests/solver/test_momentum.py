"""The two loops over pairs, on numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_scenes import some_terms

from sph.scene.schema import make_scene
from sph.solver.initial_state import initial_state
from sph.solver.neighbours import Pairs, Places, allocate_pairs, find_candidates, update_pairs
from sph.solver.particles import place_particles
from sph.solver.physics.artificial_viscosity import ArtificialViscosity
from sph.solver.physics.kernels import make_kernel
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.terms import State

pytestmark = pytest.mark.uncompiled

MASS, H = 2.0, 1.0
SLOPE = 10.0 / (28.0 * math.pi) * (12.0 * 0.5**2 - 3.0 * 1.5**2) / 0.5
"""W'/r of the cubic spline (h = 1 m) at r = 0.5 m: 10 / (28 pi h^4) (12 (1 - q)^2 - 3 (2 - q)^2) / q with q = 0.5, 1/m4."""
G = MASS * SLOPE * 0.5
"""m_j dW/dx_i of the neighbour half a metre to the left, kg/m3: negative, W falls with distance."""


@pytest.fixture
def pair() -> tuple[State, Pairs]:
    """Two particles of 2 kg at x = 0 and 0.5 m."""
    scene = make_scene({"scheme": "paper", "name": "two", "duration": 5.0, "geometry": {"shape": "block", "width": 4.0, "height": 4.0}})
    whole = initial_state(place_particles(scene), scene)
    state = State(*(np.zeros(2, array.dtype) if array.ndim == 1 else array for array in whole))
    state.x[:] = 0.0, 0.5
    state.density[:] = 4.0, 5.0
    candidates = find_candidates(state.x, state.y, 2.0 * H, None)
    terms = some_terms(kernel=make_kernel("cubic_spline", H), close_range=0.0, gradient_mass=MASS)
    pairs = allocate_pairs(candidates, np.float64(0), terms)
    update_pairs(pairs, candidates, terms, Places(state.x, state.y, state.density), 0, 2)
    return state, pairs


def test_the_gradient_of_the_pair(pair: tuple[State, Pairs]) -> None:
    # The left particle's neighbour lies to its right, at dx = -0.5 m: the gradient points to it.
    _, pairs = pair
    assert G < 0
    assert pairs.gx.tolist()[:2] == pytest.approx([-G, G], rel=1e-14) and not pairs.gy[:2].any()
    assert pairs.sum_x.tolist() == pytest.approx([-G, G], rel=1e-14)


def test_velocity_gradients(pair: tuple[State, Pairs]) -> None:
    # Sum of (v_j - v_i) g: with 3 m/s to the right and 1 m/s upwards of the right particle, xx 3 (-G), yx 1 (-G), for both the same.
    state, pairs = pair
    state.vx[:] = 0.0, 3.0
    state.vy[:] = 0.0, 1.0
    gradient = np.zeros((4, 2))
    velocity_gradients(state, pairs, some_terms(), gradient, 0, 2)
    xx, xy, yx, yy = gradient
    assert xx.tolist() == pytest.approx([-3.0 * G] * 2, rel=1e-14)
    assert yx.tolist() == pytest.approx([-G] * 2, rel=1e-14)
    assert not xy.any() and not yy.any()
    assert not state.viscous_x.any(), "particles that part feel no artificial viscosity"


def test_artificial_viscosity_of_an_approach(pair: tuple[State, Pairs]) -> None:
    # Approach at 3 m/s along the line between them: speed * (-3) * |g| against the motion, on both, equal and opposite.
    state, pairs = pair
    state.vx[:] = 0.0, -3.0
    velocity_gradients(state, pairs, some_terms(artificial_viscosity=ArtificialViscosity(0.25)), np.zeros((4, 2)), 0, 2)
    assert state.viscous_x.tolist() == pytest.approx([-0.25 * 3.0 * abs(G), 0.25 * 3.0 * abs(G)], rel=1e-14)
    assert not state.viscous_y.any()


def test_stress_accelerations(pair: tuple[State, Pairs]) -> None:
    # a_i = sum_j (s_i + s_j) g with s = sigma / rho^2: tension of 7 and 2 m2/s2 pulls the left one to the right by 9 |G|.
    state, pairs = pair
    state.sxx[:] = 7.0, 2.0
    state.sxy[:] = 1.0, 3.0
    state.viscous_y[:] = 0.5
    stress_accelerations(state, pairs, some_terms(), np.zeros((3, 2)), 0, 2)
    assert state.ax.tolist() == pytest.approx([-9.0 * G, 9.0 * G], rel=1e-14)
    assert state.ay.tolist() == pytest.approx([-4.0 * G + 0.5, 4.0 * G + 0.5], rel=1e-14)
