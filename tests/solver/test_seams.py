"""Seams: the kernel along a line, pairs across it, strength, slip and its average by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import merge
from sph.scene.schema import make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.elasticity import Deviator
from sph.solver.physics.kernels import kernel_of, make_kernel
from sph.solver.physics.seams import TERM, average_seams, line_integral, not_slip, slide, without_slip
from sph.solver.renewal import make_lists
from sph.solver.simulation import Simulation
from sph.stability.safety import DEFAULT_RULE
from sph.stability.standing import divided_strength, static_scene, weakened

pytestmark = pytest.mark.uncompiled

DIP = math.radians(20.0)
BLOCK: dict[str, Any] = {
    "scheme": "paper",
    "name": "block",
    "duration": 5.0,
    "geometry": {"shape": "block", "width": 20.0, "height": 20.0},
    "numerics": {"smoothing_ratio": 1.3},
    "seams": {
        "clay": {
            "points": [[-5.0, 10.0 - 15.0 * math.tan(DIP)], [25.0, 10.0 + 15.0 * math.tan(DIP)]],
            "cohesion": 20.0,
            "friction_angle": 30.0,
            "residual_cohesion": 5.0,
            "residual_friction_angle": 10.0,
            "slip_at_peak": 0.1,
            "slip_at_residual": 0.3,
        }
    },
}


@pytest.fixture
def simulation() -> Simulation:
    made = Simulation(make_scene(BLOCK))
    made.candidates, made.pairs = make_lists(made.state, made.list_terms)
    return made


@pytest.mark.parametrize("name", ["cubic_spline", "wendland_c2"])
def test_the_integral_of_the_kernel_along_lines_is_one_over_all_lines(name: str) -> None:
    kernel = make_kernel(name, 1.3)
    distance = np.linspace(-3.0, 3.0, 6001)
    assert np.trapezoid(line_integral(kernel, np.abs(distance)), distance) == pytest.approx(1.0, abs=1e-3)
    assert line_integral(kernel, np.array([2.6, 5.0])).tolist() == [0.0, 0.0]


def test_gradients_across_are_normal_to_the_seam_and_those_beside_it_are_not(simulation: Simulation) -> None:
    pairs, side = simulation.pairs, simulation.terms.seams.side
    normal = np.array([-math.sin(DIP), math.cos(DIP)])
    along = np.array([math.cos(DIP), math.sin(DIP)])
    crossing = beside = 0
    for i in np.flatnonzero(side):
        row = slice(pairs.start[i], pairs.end[i])
        gradient, j = np.column_stack([pairs.gx[row], pairs.gy[row]]).astype(float), pairs.neighbour[row]
        over = side[j] == -side[i]
        np.testing.assert_allclose(gradient[over] @ along, 0.0, atol=1e-6 * np.abs(gradient).max())
        np.testing.assert_allclose(pairs.grip[i], np.abs(gradient[over] @ normal).sum(), rtol=1e-6)
        crossing, beside = crossing + over.sum(), beside + (np.abs(gradient[~over] @ along) > 1.0).sum()
    assert crossing > 100 and beside > 100


def test_forces_across_are_equal_and_opposite(simulation: Simulation) -> None:
    pairs, side = simulation.pairs, simulation.terms.seams.side
    gradient = {
        (int(i), int(pairs.neighbour[k])): (float(pairs.gx[k]), float(pairs.gy[k]))
        for i in np.flatnonzero(side)
        for k in range(pairs.start[i], pairs.end[i])
    }
    both = [(gradient[i, j], gradient[j, i]) for i, j in gradient if (j, i) in gradient]
    one, other = (np.array(values) for values in zip(*both, strict=True))
    np.testing.assert_array_equal(one, -other)


def test_the_strength_on_the_plane_and_what_slips(simulation: Simulation) -> None:
    """tau = c + sigma_n tan(phi) where more is tried; along the plane only; less as slip goes on."""
    state, terms, modulus = simulation.state, simulation.terms, 1e8
    i = int(np.flatnonzero(terms.seams.side)[0])
    c, s = math.cos(2.0 * DIP), math.sin(2.0 * DIP)
    normal, shear, parallel = 100e3, 200e3, 10e3  # parallel: the deviator along the seam
    d, q = parallel * c - shear * s, parallel * s + shear * c
    for slip, lost in ((0.0, 0.0), (0.2, 0.5), (1.0, 1.0)):
        state.seam_normal[i], state.seam_slip[i], state.seam_strain[i] = normal, slip, 0.0
        cohesion = 20e3 - lost * 15e3
        friction = math.tan(math.radians(30.0)) - lost * (math.tan(math.radians(30.0)) - math.tan(math.radians(10.0)))
        limit = cohesion + normal * friction
        new_d, new_q, _ = slide(terms.seams, state, i, normal - parallel, Deviator(d, q, 0.0), 1.0, modulus, 10.0)
        assert new_q * c - new_d * s == pytest.approx(limit, rel=1e-2)
        assert new_d * c + new_q * s == pytest.approx(parallel, abs=300.0)
        assert state.seam_strain[i] == pytest.approx((shear - limit) / modulus)
    state.seam_strain[i] = 0.0
    slide(terms.seams, state, i, normal - parallel, Deviator(d, q, 0.0), 1.0, modulus, 0.5)
    assert state.seam_strain[i] == 0.0, "slip before the end of the gravity stage does not count"
    away = int(np.flatnonzero(terms.seams.side == 0)[0])
    assert slide(terms.seams, state, away, 0.0, Deviator(d, q, 0.0), 1.0, modulus, 10.0) == (d, q, 0.0)


def test_damping_does_not_act_on_shear_along_the_seam(simulation: Simulation) -> None:
    terms = simulation.terms.seams
    i = int(np.flatnonzero(terms.side)[0])
    c, s = math.cos(2.0 * DIP), math.sin(2.0 * DIP)
    assert without_slip(terms, i, Deviator(-3.0 * s, 3.0 * c, 0.0)) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert without_slip(terms, i, Deviator(3.0 * c, 3.0 * s, 0.0)) == pytest.approx((3.0 * c, 3.0 * s, 0.0))


def test_mass_damping_fades_as_the_velocity_becomes_slip(simulation: Simulation) -> None:
    """Above the seam, with the slip at its foot; below it, and against the slip, nothing changes."""
    state, seams = simulation.state, simulation.terms.seams
    x, y = state.x[: simulation.terms.n_soil], state.y[: simulation.terms.n_soil]
    height = 10.0 + (x - 10.0) * math.tan(DIP)
    np.testing.assert_array_equal(seams.foot[:, 0] >= 0, y > height)
    above = np.flatnonzero(y > height)
    feet = seams.particle[seams.foot[above, 0]]
    assert np.all(np.hypot(x[feet] - x[above], y[feet] - height[above]) < 1.5) and np.all(y[feet] > height[feet])
    state.seam_speed[feet] = -0.5  # downwards to the left
    for along, across, weight in ((-0.5, 0.0, 0.0), (-1.0, 0.0, 0.0), (-2.0, 0.0, 0.5), (0.5, 0.0, 1.0), (0.0, 1.0, 1.0), (-1.0, 1.0, 0.5)):
        state.vx[:] = along * math.cos(DIP) - across * math.sin(DIP)
        state.vy[:] = along * math.sin(DIP) + across * math.cos(DIP)
        assert {round(not_slip(seams, state, int(i)), 9) for i in above[::20]} == {weight}
        assert not_slip(seams, state, int(np.flatnonzero(y < height)[0])) == 1.0
    state.vx[:] = state.vy[:] = 0.0
    assert not_slip(seams, state, int(above[0])) == 1.0


def test_the_feet_of_particles_on_lines_at_random() -> None:
    """Dips to both sides, lines from either end: soil above a line has its foot there, that below has none, directions point right."""
    random = np.random.default_rng(7)
    for dip in np.radians(random.uniform(-55.0, 55.0, 12)):
        ends = [[-5.0, 10.0 - 15.0 * math.tan(dip)], [25.0, 10.0 + 15.0 * math.tan(dip)]]
        scene = make_scene(merge(BLOCK, {"seams": {"clay": {"points": ends[:: random.choice([-1, 1])]}}}))
        particles = place_particles(scene)
        seams = TERM.make(scene, particles, kernel_of(scene), 1e-3)
        x, y = particles.x[: particles.n_soil], particles.y[: particles.n_soil]
        height = 10.0 + (x - 10.0) * math.tan(dip)
        above = seams.foot[:, 0] >= 0
        np.testing.assert_array_equal(above, (y > height) & (height > 0.0))
        feet = seams.particle[seams.foot[above, 0]]
        assert np.all(y[feet] > height[feet])
        assert np.hypot(x[feet] - x[above], y[feet] - height[above]).max() < 1.5
        np.testing.assert_allclose(seams.along[seams.foot[above, 0]], [[math.cos(dip), math.sin(dip)]] * above.sum(), atol=1e-9)


def test_the_sense_of_slip_is_that_of_the_shear_stress(simulation: Simulation) -> None:
    state, terms = simulation.state, simulation.terms
    there = terms.seams.particle[: terms.seams.soil_rows]
    state.seam_strain[there] = simulation.pairs.grip[there] / state.density[there] * 1e-3
    terms.seams.normal[:], terms.seams.shear[:] = 70e3, -20e3
    average_seams(terms.seams, state, simulation.pairs, 0, terms.n_soil)
    assert state.seam_speed[there].mean() == pytest.approx(-1e-3 / terms.seams.dt, rel=0.1)


def test_a_jump_across_is_the_slip_wherever_a_particle_lies(simulation: Simulation) -> None:
    """Sliding by 0.2 m gives each particle the shear strain 0.2 m times the gradients across over the density."""
    state, terms, pairs = simulation.state, simulation.terms, simulation.pairs
    there = np.flatnonzero(terms.seams.side)
    state.seam_strain[there] = 0.2 * pairs.grip[there] / state.density[there]
    terms.seams.normal[:] = 70e3
    average_seams(terms.seams, state, pairs, 0, terms.n_soil)
    inner = there[(np.abs(simulation.particles.x[there] - 10.0) < 7.0)]
    np.testing.assert_allclose(state.seam_slip[inner], 0.2, rtol=0.15)  # by where it lies on the lattice
    assert state.seam_slip[inner].mean() == pytest.approx(0.2, rel=0.02)
    np.testing.assert_allclose(state.seam_normal[inner], 70e3)


def test_searches_divide_the_peak_strength() -> None:
    geometry = {"shape": "slope"}
    scene = make_scene(merge(BLOCK | {"geometry": geometry}, {"gravity": {"duration": 3.0}, "numerics": {"spacing": 2.5}}))
    static = static_scene(scene, DEFAULT_RULE)
    seam = divided_strength(static, 2.0).seams["clay"]
    assert seam.cohesion == 10.0 and math.tan(math.radians(seam.friction_angle)) == pytest.approx(0.5 * math.tan(math.radians(30.0)))
    assert seam.slip_at_residual is None and seam.residual == seam.peak
    assert weakened(static, 0.5).seams == static.seams
