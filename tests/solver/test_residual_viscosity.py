"""Artificial viscosity with linear reconstruction: nothing for linear fields, all for alternating rows, and never energy for a pair."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from placed import Placed

from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.physics.residual_viscosity import keep_strain_rate
from sph.solver.terms import only

pytestmark = pytest.mark.uncompiled

BLOCK = {
    "scheme": "paper",
    "name": "block",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 12.0, "height": 12.0},
    "walls": {"base": "none", "sides": "none"},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "precision": "double"},
}


class Block(Placed):
    """A free block of soil with velocities, and the acceleration (2, n) that its artificial viscosity gives."""

    def __init__(self, reconstruction: str, jitter: float = 0.0, overrides: dict[str, Any] | None = None) -> None:
        viscosity = {"numerics.artificial_viscosity": {"alpha": 0.1, "reconstruction": reconstruction}}
        super().__init__(BLOCK, viscosity | (overrides or {}), jitter)

    def acceleration(self) -> np.ndarray:
        n, terms = self.state.x.size, only(self.terms, "artificial_viscosity", "residual_viscosity", "layers")
        gradient, strain_rate = np.zeros((4, n)), np.zeros((3, n))
        velocity_gradients(self.state, self.pairs, terms, gradient, 0, n)
        keep_strain_rate(terms.residual_viscosity, self.pairs, self.state.density, gradient, strain_rate, 0, n)
        stress_accelerations(self.state, self.pairs, terms, strain_rate, 0, n)
        return np.array([self.state.viscous_x, self.state.viscous_y])


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_a_linear_field_is_left_alone(jitter: float) -> None:
    # Compression in one direction, extension in the other, shear and spin.  Particles at a corner may have too few neighbours for an exact
    # strain rate and keep the plain one, which those within the support of 2.6 spacings of them feel.
    found = {}
    for reconstruction in ("none", "linear"):
        block = Block(reconstruction, jitter)
        x, y = block.state.x, block.state.y
        block.state.vx[:] = -0.3 * x + 0.2 * y
        block.state.vy[:] = 0.1 * x + 0.1 * y
        found[reconstruction] = np.hypot(*block.acceleration())
    away = (np.abs(x - 6.0) < 2.5) | (np.abs(y - 6.0) < 2.5)
    assert np.count_nonzero(away) >= 70
    assert np.median(found["none"]) > 0.1
    assert found["linear"][away].max() < 1e-10 * found["none"].max()


def test_alternating_rows_are_damped_as_by_the_plain_form() -> None:
    # Inside a lattice the sums over neighbours do not see them: their strain rate is zero, and all of the approach is left over.
    found = {}
    for reconstruction in ("none", "linear"):
        block = Block(reconstruction)
        block.state.vy[:] = np.where(np.round(block.state.y - 0.5) % 2 == 0, 1.0, -1.0)
        inside = (np.abs(block.state.x - 6.0) < 2.0) & (np.abs(block.state.y - 6.0) < 2.0)
        found[reconstruction] = block.acceleration()[1][inside]
    assert np.abs(found["none"]).min() > 0.0
    np.testing.assert_allclose(found["linear"], found["none"], rtol=1e-12)


@pytest.mark.parametrize("layered", [False, True])
def test_pairs_keep_momentum_and_only_lose_energy(layered: bool) -> None:
    heavy = {"region": {"kind": "depth", "bottom": 6.0}, "soil": {"density": 2900.0}}
    block = Block("linear", 0.2, {"layers": {"heavy": heavy}} if layered else None)
    generator = np.random.default_rng(7)
    block.state.vx[:], block.state.vy[:] = generator.normal(size=(2, block.state.x.size))
    force = block.particles.mass * block.acceleration()
    assert np.abs(force.sum(axis=1)).max() < 1e-11 * np.abs(force).sum()
    assert float(force[0] @ block.state.vx + force[1] @ block.state.vy) < -0.1 * np.abs(force).sum()


def test_particles_that_part_feel_nothing() -> None:
    # Four particles are too few for exact strain rates: the smaller of the approach and of what is left of it dissipates, never a parting.
    for speed in (-1.0, 1.0):
        block = Block("linear", overrides={"geometry.width": 2.0, "geometry.height": 2.0, "probes": {}})
        right = block.state.x > 1.0
        block.state.vx[right] = speed
        acceleration = block.acceleration()[0]
        np.testing.assert_allclose(acceleration[~right], -acceleration[right], rtol=1e-12)
        assert np.all(acceleration[~right] < 0.0 if speed < 0.0 else acceleration == 0.0)
