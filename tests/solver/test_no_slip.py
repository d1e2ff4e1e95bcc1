"""No-slip walls without states: they take no energy, bear constant stress, and see a linear fall of the velocity to their face."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.gradient_correction import power
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.renewal import make_lists
from sph.solver.terms import State, make_terms, only

pytestmark = pytest.mark.uncompiled

BLOCK = {
    "scheme": "paper",
    "name": "block",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 8.0, "height": 6.0},
    "walls": {"base": "no_slip", "sides": "no_slip", "top": "no_slip"},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "precision": "double"},
}
MIDDLE = 3
"""Column of the soil that is further from the side walls than the kernel's support of 2.6 spacings."""


class Box:
    """Soil that fills a box, and the sums of the two loops over pairs."""

    def __init__(self, overrides: dict[str, Any] | None = None, jitter: float = 0.0) -> None:
        self.scene = make_scene(merge(BLOCK, dotted(overrides or {})))
        particles = place_particles(self.scene)
        self.n = particles.n_soil
        self.state: State = initial_state(particles, self.scene)
        generator = np.random.default_rng(3)
        for name in ("x", "y"):
            moved = getattr(self.state, name)
            moved[: self.n] += generator.uniform(-jitter, jitter, self.n)
            for other in (f"{name}_pairs", f"{name}_candidates"):
                getattr(self.state, other)[:] = moved
        self.x, self.y = self.state.x[: self.n], self.state.y[: self.n]
        self.terms = make_terms(self.scene, particles)
        self.mass = particles.mass
        self.pairs: Any = make_lists(self.state, self.terms)[1]
        self.plain = only(self.terms, "gradient_correction", "no_slip", "contact")
        self.gradient = np.zeros((4, self.state.x.size))

    def strain(self) -> np.ndarray:
        """Velocity gradients (4, soil) of the plain sums, 1/s: xx, xy, yx, yy."""
        velocity_gradients(self.state, self.pairs, self.plain, self.gradient, 0, self.state.x.size)
        return self.gradient[:, : self.n] / self.state.density[: self.n]

    def accelerate(self) -> None:
        stress_accelerations(self.state, self.pairs, self.plain, self.gradient, 0, self.n)


@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.3}], ids=["plain", "corrected"])
def test_the_walls_take_no_energy(correction: dict[str, float] | None) -> None:
    # Whatever the velocities and stresses: power of the forces plus power of the stress on the strain rates is zero for each arrangement.
    box = Box({"numerics.gradient_correction": correction}, jitter=0.2)
    generator = np.random.default_rng(5)
    for name in ("vx", "vy", "sxx", "syy", "sxy", "syx"):
        getattr(box.state, name)[: box.n] = generator.normal(size=box.n)
    if correction is None:
        box.state.syx[:] = box.state.sxy
    box.strain()
    box.accelerate()
    s, cell = box.state, box.terms.cell_mass
    forces = cell * sum(float(a[: box.n] @ v[: box.n]) for a, v in ((s.ax, s.vx), (s.ay, s.vy)))
    stresses = cell * sum(power(box.terms.gradient_correction, s, box.gradient, i) for i in range(box.n))
    assert abs(forces) > 1.0
    assert forces + stresses == pytest.approx(0.0, abs=1e-11 * abs(forces))


def test_constant_stress_is_in_equilibrium_on_the_lattice() -> None:
    box = Box()
    box.state.sxx[: box.n], box.state.syy[: box.n], box.state.sxy[: box.n] = 2.0, -3.0, 0.7
    box.accelerate()
    scale = np.abs(box.pairs.wall).max() * 3.0
    assert scale > 1.0
    assert np.abs(box.state.ax[: box.n]).max() < 1e-12 * scale
    assert np.abs(box.state.ay[: box.n]).max() < 1e-12 * scale


def test_soil_at_the_wall_is_sheared_as_much_as_the_soil_above() -> None:
    # v_x = y over a plate: plain sums are 4 % low in the first row and 7 % high in the second (the image of a particle stands for all
    # layers of the wall), corrected ones exact on the lattice and within 3 % on a disordered arrangement.
    box = Box({"walls.sides": "none", "walls.top": "none"})
    box.state.vx[: box.n] = box.y
    shear = box.strain()[1].reshape(8, 6)[MIDDLE]
    print("shear by rows", shear)
    np.testing.assert_allclose(shear[:3], 1.0, atol=0.07)

    for jitter, tolerance in ((0.0, 1e-12), (0.2, 0.03)):
        box = Box({"walls.sides": "none", "walls.top": "none", "numerics.gradient_correction": {"min_determinant": 0.1}}, jitter)
        box.state.vx[: box.n] = box.y
        xx, xy, _, _ = box.strain()
        b = box.pairs.correction[: box.n]
        np.testing.assert_allclose((xx * b[:, 1] + xy * b[:, 2])[(box.y < 3.0) & (np.abs(box.x - 4.0) < 2.0)], 1.0, atol=tolerance)


def test_particles_of_the_wall_are_nobody_s_neighbours() -> None:
    box = Box()
    assert box.terms.n_stressed == box.n
    for i in range(box.state.x.size):
        row = box.pairs.neighbour[box.pairs.start[i] : box.pairs.end[i]]
        assert np.all(row < box.n) and (row.size > 0) == (i < box.n)


def test_too_few_layers_are_refused() -> None:
    with pytest.raises(
        ValueError,
        match=r"walls\.layers: 1 .*2\.6 m.*needs 2",
    ):
        make_scene(merge(BLOCK, {"walls": {"layers": 1}}))
