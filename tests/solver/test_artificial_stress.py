"""Artificial stress: a share of each principal tension is taken back, and pairs push each other alike."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from placed import Placed

from sph.solver.physics.artificial_stress import add_artificial_stress, set_artificial_stress
from sph.solver.physics.kernels import evaluate

pytestmark = pytest.mark.uncompiled

BASE: dict[str, Any] = {
    "scheme": "paper",
    "name": "patch",
    "geometry": {"shape": "block", "width": 4.0, "height": 4.0},
    "walls": {"base": "none", "sides": "none"},
    "numerics": {"spacing": 0.5, "smoothing_ratio": 1.3, "precision": "double", "artificial_stress": {"factor": 0.4, "exponent": 3.0}},
}


class Patch(Placed):
    """Particles without walls whose stress is given."""

    def __init__(self, overrides: dict[str, Any] | None = None, jitter: float = 0.0) -> None:
        super().__init__(BASE, overrides, jitter)

    def stress(self, xx: Any, yy: Any, xy: Any) -> None:
        self.state.sxx[:], self.state.syy[:], self.state.sxy[:] = xx, yy, xy
        set_artificial_stress(self.terms.artificial_stress, self.state, 0, self.n)

    def push(self) -> None:
        add_artificial_stress(self.terms.artificial_stress, None, self.state, self.pairs, 0, self.n)


PATCH = Patch()
PATCH.stress(0.0, 0.0, 0.0)  # compiled here, since hypothesis limits the time of an example
STRESS = st.floats(-1e6, 1e6).filter(lambda s: s == 0 or abs(s) > 1e-3)


@given(xx=STRESS, yy=STRESS, xy=STRESS)
def test_principal_tensions_are_taken_back(xx: float, yy: float, xy: float) -> None:
    # By numpy's eigenvectors: -0.4 of each positive principal stress, along the same axis, nothing of the negative ones.
    values, axes = np.linalg.eigh([[xx, xy], [xy, yy]])
    expected = axes @ np.diag(-0.4 * np.maximum(values, 0.0)) @ axes.T
    PATCH.stress(xx, yy, xy)
    state = PATCH.state
    found = np.array([[state.tension_xx[0], state.tension_xy[0]], [state.tension_xy[0], state.tension_yy[0]]])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(values).max() + 1e-300)


def test_nothing_under_compression() -> None:
    patch = Patch()
    patch.stress(-1.0, -2.0, 0.5)
    patch.push()
    for field in (patch.state.tension_xx, patch.state.tension_yy, patch.state.tension_xy, patch.state.ax, patch.state.ay):
        assert not field.any()


@pytest.mark.parametrize("precision", ["mixed", "double"])
def test_pairs_push_alike(precision: str) -> None:
    # Random stresses at jittered places: the sum of the forces is zero to rounding, 64 particles with some 20 pairs.
    patch = Patch({"numerics.precision": precision}, jitter=0.1)
    patch.stress(*np.random.default_rng(5).normal(size=(3, patch.n)))
    patch.push()
    ax, ay = patch.state.ax, patch.state.ay
    assert np.abs(ax).max() > 0 and np.array_equal(ax, patch.state.viscous_x) and np.array_equal(ay, patch.state.viscous_y)
    assert max(abs(ax.sum()), abs(ay.sum())) < 1e-13 * np.abs(ax).sum()


def test_one_particle_by_hand() -> None:
    # Four particles in a square under tension along x, sigma / rho^2 = 1: the lower left one is pushed left by its right neighbour at dx
    # with (W / W)^3 = 1, and by the one across at sqrt(2) dx with (W(sqrt 2 dx) / W(dx))^3; the one above is beside.  R = -0.4 each.
    patch = Patch({"geometry": {"shape": "block", "width": 1.0, "height": 1.0}})
    assert patch.n == 4
    patch.stress(1.0, 0.0, 0.0)
    patch.push()
    dx, mass = 0.5, patch.particles.mass[0]
    (w, slope), (w_across, slope_across) = (evaluate(patch.terms.kernel, r) for r in (dx, math.sqrt(2) * dx))
    gx, gx_across = -mass * slope * dx, -mass * slope_across * dx  # m W'/r (x_i - x_j), x_i - x_j = -dx
    expected = 2 * -0.4 * (gx + gx_across * (w_across / w) ** 3)
    assert expected < 0
    lower_left = int(np.argmin(patch.particles.x + patch.particles.y))
    assert patch.state.ax[lower_left] == pytest.approx(expected, rel=1e-12)
    assert patch.state.ay[lower_left] == 0.0
