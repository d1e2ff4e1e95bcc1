"""Initiation over a length: closed forms of what is gathered and averaged (``tests/physics/test_softening.py``: when a particle fails)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.physics.elasticity import Deviator
from sph.solver.physics.slip import average_plastic_strain, gather_plastic_strain
from sph.solver.simulation import Simulation

pytestmark = pytest.mark.uncompiled

BLOCK = {
    "scheme": "paper",
    "name": "block",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 20.0, "height": 20.0},
    "coupling": {"softening": {"slip_at_peak": 0.01, "width": 2.5}},
}


def test_the_average_by_hand() -> None:
    # One particle in the middle has a strain of 1.  With l = 2.5 spacings the weights are 1 at itself, (1 - 1/6.25)^2 = 0.7056 at four
    # neighbours, (1 - 2/6.25)^2 = 0.4624 at four diagonal ones, (1 - 4/6.25)^2 = 0.1296 at four two away, (1 - 5/6.25)^2 = 0.04 at eight.
    simulation = Simulation(make_scene(BLOCK))
    state, terms = simulation.state, simulation.terms
    middle = 10 * 20 + 10
    state.plastic_strain[middle] = 1.0
    terms.slip.at_yield[[middle, middle + 1]] = True
    average_plastic_strain(terms.slip, state, 0, terms.n_soil)
    total = 1.0 + 4 * 0.7056 + 4 * 0.4624 + 4 * 0.1296 + 8 * 0.04
    assert state.mean_plastic_strain[middle] == pytest.approx(1.0 / total, rel=1e-12)
    assert state.mean_plastic_strain[middle + 1] == pytest.approx(0.7056 / total, rel=1e-12)
    assert np.count_nonzero(state.mean_plastic_strain) == 2


def test_the_average_ends_at_the_surface_and_walls_that_hold_soil_do_not_slip() -> None:
    # Without walls a quarter of the neighbours is there in the corner: the mean is over those.  On a base that holds the soil, the places
    # below it count as soil that does not slip: in the middle of the lowest row the weights, 2.6704 in the row, 1.7104 and 0.2096 in the
    # two above, have as much below, so that 4.5904 of 6.5104 slip.
    for base, share in (("none", 1.0), ("free_slip", 1.0), ("fixed", 4.5904 / 6.5104), ("no_slip", 4.5904 / 6.5104)):
        simulation = Simulation(make_scene(merge(BLOCK, {"walls": {"base": base, "sides": "none", "layers": 4}})))
        state, terms = simulation.state, simulation.terms
        state.plastic_strain[: terms.n_soil] = 0.25
        terms.slip.at_yield[:] = True
        average_plastic_strain(terms.slip, state, 0, terms.n_soil)
        mean = state.mean_plastic_strain[: terms.n_soil].reshape(20, 20)
        np.testing.assert_allclose(mean[:, 2:], 0.25, rtol=1e-12)
        assert mean[10, 0] == pytest.approx(0.25 * share, rel=1e-12), base


def test_the_average_goes_around_periodic_sides_and_not_beyond_the_soil() -> None:
    # The leftmost column has a strain of 1.  Around periodic sides it is the neighbour of the rightmost, whose mean is then that of the
    # column on its other side.  A length beyond the box asks for no more memory than the box, and all soil has about one mean.
    unheld = merge(BLOCK, {"walls": {"base": "none", "sides": "none"}})
    periodic, long = merge(unheld, {"walls": {"sides": "periodic"}}), merge(unheld, {"coupling": {"softening": {"width": 1000.0}}})
    found = {}
    for name, scene in (("periodic", periodic), ("open", unheld), ("long", long)):
        simulation = Simulation(make_scene(scene))
        state, terms = simulation.state, simulation.terms
        terms.slip.at_yield[:] = True
        state.plastic_strain[:20] = 1.0
        average_plastic_strain(terms.slip, state, 0, terms.n_soil)
        found[name] = state.mean_plastic_strain[: terms.n_soil].reshape(20, 20)
    assert found["periodic"][-1, 10] == pytest.approx(found["periodic"][1, 10], rel=1e-12) and found["periodic"][1, 10] > 0.1
    assert found["open"][-1, 10] < 1e-100
    np.testing.assert_allclose(found["long"], 1.0 / 20.0, rtol=1e-3)


def test_a_particle_gathers_while_its_solid_state_has_a_weight() -> None:
    # A shear of 1 % beyond yield at beta = 1, 0.4 and 0: the last keeps its strain, and neither it nor one within its surface is at yield.
    simulation = Simulation(make_scene(BLOCK))
    state, terms = simulation.state, simulation.terms
    state.plastic_strain[:4] = 0.25
    state.beta[:4] = 1.0, 0.4, 0.0, 1.0
    modulus = terms.soil.shear_modulus
    for i, factor in enumerate((0.5, 0.5, 0.5, 1.0)):
        gather_plastic_strain(terms.slip, state, i, factor, Deviator(0.02 * modulus, 0.0, 0.0), 0.0, modulus)
    np.testing.assert_allclose(state.plastic_strain[:4], [0.26, 0.26, 0.25, 0.25], rtol=1e-12)
    assert terms.slip.at_yield[:4].tolist() == [True, True, False, False]


def test_slip_of_other_soil_does_not_count_and_a_thin_seam_is_not_diluted() -> None:
    # A seam of one row, slipped by 8 mm over its spacing of 1 m: its mean is that of a slip surface in homogeneous soil, and that of the
    # rows beside it, of other soil, is 0.
    seam = {"region": {"kind": "elevation", "bottom": 10.0, "top": 11.0}, "S_R": 0.1}
    found = {}
    for name, layers in (("seam", {"seam": seam}), ("alike", {})):
        simulation = Simulation(make_scene(merge(BLOCK, {"layers": layers, "coupling": {"softening": {"width": 4.0}}})))
        state, terms = simulation.state, simulation.terms
        terms.slip.at_yield[:] = True
        row = np.round(state.y[: terms.n_soil] - 0.5).astype(int)
        state.plastic_strain[: terms.n_soil][row == 10] = 8e-3
        average_plastic_strain(terms.slip, state, 0, terms.n_soil)
        middle = np.round(state.x[: terms.n_soil] - 0.5).astype(int) == 10
        found[name] = {k: state.mean_plastic_strain[: terms.n_soil][middle & (row == k)].item() for k in (9, 10, 11)}
    assert found["seam"][10] == pytest.approx(found["alike"][10], rel=1e-12)
    assert found["seam"][9] == found["seam"][11] == 0.0 and found["alike"][9] > 0.0
    # slip = mean times width: 16/15 / (pi / 3) of the displacement, to what a lattice of four spacings makes of the integrals
    assert 4.0 * found["seam"][10] == pytest.approx(8e-3 * (16 / 15) / (math.pi / 3), rel=0.02)


@pytest.mark.parametrize("depth", [0.5, 1.5, 2.5, 4.5, 6.5])
def test_a_slip_surface_nearer_to_the_ground_than_the_width_counts_for_more(depth: float) -> None:
    """There is no soil above the ground that it would be averaged with."""
    width, spacing = 8.0, 0.25
    simulation = Simulation(make_scene(merge(BLOCK, {"numerics": {"spacing": spacing}, "coupling": {"softening": {"width": width}}})))
    state, terms = simulation.state, simulation.terms
    x, y = (place[: terms.n_soil] for place in (state.x, state.y))
    slipped = np.abs(20.0 - y - depth) < 0.6 * spacing  # two rows
    asked = np.flatnonzero(slipped & (np.abs(x - 10.0) < spacing))
    terms.slip.at_yield[asked] = True
    state.plastic_strain[: terms.n_soil][slipped] = 4e-3 / spacing
    average_plastic_strain(terms.slip, state, 0, terms.n_soil)
    above = quad(lambda z: 16.0 / 15.0 * (1.0 - z**2) ** 2.5, 0.0, depth / width)[0]
    found = width * state.mean_plastic_strain[asked].mean()
    assert found == pytest.approx(8e-3 * (16.0 / 15.0) / (math.pi / 6.0 + above), rel=0.03)
