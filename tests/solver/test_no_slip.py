"""No-slip walls without states: they take no energy, bear constant stress, and see a linear fall of the velocity to their face."""

from __future__ import annotations

import numpy as np
import pytest
from placed import Placed

from sph.scene.configuration import merge
from sph.scene.schema import make_scene

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


@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.3}], ids=["plain", "corrected"])
def test_the_walls_take_no_energy(correction: dict[str, float] | None) -> None:
    # Whatever the velocities and stresses: power of the forces plus power of the stress on the strain rates is zero for each arrangement.
    Placed(BLOCK, {"numerics.gradient_correction": correction}, jitter=0.2).take_no_energy()


def test_constant_stress_is_in_equilibrium_on_the_lattice() -> None:
    box = Placed(BLOCK)
    box.state.sxx[: box.n], box.state.syy[: box.n], box.state.sxy[: box.n] = 2.0, -3.0, 0.7
    box.accelerate()
    scale = np.abs(box.pairs.wall).max() * 3.0
    assert scale > 1.0
    assert np.abs(box.state.ax[: box.n]).max() < 1e-12 * scale
    assert np.abs(box.state.ay[: box.n]).max() < 1e-12 * scale


def test_soil_at_the_wall_is_sheared_as_much_as_the_soil_above() -> None:
    # v_x = y over a plate: plain sums are 4 % low in the first row and 7 % high in the second (the image of a particle stands for all
    # layers of the wall), corrected ones exact on the lattice and within 3 % on a disordered arrangement.
    box = Placed(BLOCK, {"walls.sides": "none", "walls.top": "none"})
    box.state.vx[: box.n] = box.y
    shear = box.strain()[1].reshape(8, 6)[MIDDLE]
    print("shear by rows", shear)
    np.testing.assert_allclose(shear[:3], 1.0, atol=0.07)

    for jitter, tolerance in ((0.0, 1e-12), (0.2, 0.03)):
        box = Placed(BLOCK, {"walls.sides": "none", "walls.top": "none", "numerics.gradient_correction": {"min_determinant": 0.1}}, jitter)
        box.state.vx[: box.n] = box.y
        xx, xy, _, _ = box.strain()
        b = box.pairs.correction[: box.n]
        np.testing.assert_allclose((xx * b[:, 1] + xy * b[:, 2])[(box.y < 3.0) & (np.abs(box.x - 4.0) < 2.0)], 1.0, atol=tolerance)


def test_particles_of_the_wall_are_nobody_s_neighbours() -> None:
    box = Placed(BLOCK)
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
