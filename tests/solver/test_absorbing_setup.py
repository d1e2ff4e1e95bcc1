"""Dashpots and free-field columns as they are set up: sums over rows of the lattice, weights, impedances, heights of sides."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.boundaries.dashpots import kick_boundary, make_absorbing, moved_rows, resist_bending
from sph.solver.boundaries.free_field import lattice_rows, layer_weights, make_free_field
from sph.solver.initial_state import initial_state
from sph.solver.integration import Loads
from sph.solver.particles import BASE, SIDE, SOIL, place_particles
from sph.solver.physics.kernels import make_kernel
from sph.solver.renewal import make_lists
from sph.solver.terms import make_terms

pytestmark = pytest.mark.uncompiled

SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "slope",
    "geometry": {"shape": "slope", "slope_height": 10.0, "base_depth": 6.0, "apron_length": 10.0, "crest_length": 10.0},
    "walls": {"base": "absorbing", "sides": "absorbing", "layers": 3},
    "numerics": {"spacing": 2.0, "smoothing_ratio": 1.3},
}
ROCK = {"density": 2400.0, "s_wave_speed": 1000.0, "p_wave_speed": 2000.0}


def slope(overrides: dict[str, Any]) -> Scene:
    return make_scene(merge(SLOPE, dotted(overrides)))


@pytest.mark.parametrize("name", ["cubic_spline", "wendland_c2"])
@pytest.mark.parametrize("ratio", [1.3, 2.3])
def test_rows_sum_up_to_the_gradient(name: str, ratio: float) -> None:
    # Times the volume, the gradient of y is 1 and that of x as well; a lattice sums a kernel's integral to some per cent.
    dx = 0.5
    rows = lattice_rows(make_kernel(name, ratio * dx), dx)
    offset = np.arange(-rows.reach, rows.reach + 1) * dx
    assert dx * dx * (rows.gradient @ offset) == pytest.approx(1.0, abs=0.05)
    assert dx * dx * rows.moment_x.sum() == pytest.approx(dx * dx * rows.moment_y.sum(), rel=1e-12)
    np.testing.assert_allclose(rows.gradient * offset, rows.moment_y, atol=1e-12)
    np.testing.assert_array_equal(rows.gradient, -rows.gradient[::-1])


def test_weights_of_the_layers() -> None:
    kernel = make_kernel("cubic_spline", 1.3)
    rows = lattice_rows(kernel, 1.0)
    first, second = np.abs(rows.gradient[rows.reach + 1 : rows.reach + 3])
    np.testing.assert_allclose(layer_weights(kernel, 1.0, 2), np.array([first + second, second]) / (first + 2 * second), rtol=1e-12)
    np.testing.assert_allclose(layer_weights(kernel, 1.0, 4), [*layer_weights(kernel, 1.0, 2), 0.0, 0.0], rtol=1e-12)


def test_dashpots_add_up_to_the_impedance() -> None:
    # Over the layers: rho V dx of a column of the base, of a row of a side; the bedrock's below, the soil's beside.
    scene = slope({"walls.bedrock": ROCK})
    particles, dx = place_particles(scene), 2.0
    impedances = [scene.soil.density * speed for speed in (scene.soil.p_wave_speed, scene.soil.s_wave_speed)]
    term = make_absorbing(scene, particles, make_kernel("cubic_spline", 2.6), 1e-3)
    sprung = make_absorbing(slope({"walls.bedrock": {**ROCK, "spring_frequency": 0.1}}), particles, make_kernel("cubic_spline", 2.6), 1e-3)
    np.testing.assert_allclose(sprung.hold, 0.2 * np.pi * term.base)
    assert not term.hold.any() and term.base.any()
    moving = slice(particles.n_soil, particles.first_fixed)
    x, y, mass, kind = (getattr(particles, name)[moving] for name in ("x", "y", "mass", "kind"))
    for along in (-5.0, 11.0):
        of_column = (x == along) & (kind == BASE)
        np.testing.assert_allclose((term.base * mass)[:, of_column].sum(1), [2.4e6 * dx, 4.8e6 * dx])
    for row in (y == 3.0, y == -1.0):
        for side, sign in ((row & (x < 0), -1), (row & (x > 15), 1)):
            np.testing.assert_allclose((term.side * mass)[:, side].sum(1), np.array(impedances) * dx)
            assert (term.outward * mass)[side].sum() == pytest.approx(sign * dx)
    assert not term.base[:, kind == SIDE].any() and not term.side[:, (x > 0) & (x < 15)].any()


def test_a_base_resists_bending_and_no_other_motion() -> None:
    # Columns that alternate meet 16 times the stiffness; moved or tilted as a whole they meet nothing; what it does is an inner force that
    # takes energy from any motion which bends.
    scene, dt = slope({}), 1e-3
    particles = place_particles(scene)
    walls = make_absorbing(scene, particles, make_kernel("cubic_spline", 2.6), dt)
    assert walls.bending == pytest.approx((scene.soil.s_wave_speed / 8.0) ** 2)
    state, n_soil = initial_state(particles, scene), particles.n_soil
    base = slice(n_soil, n_soil + walls.in_base)
    column = np.arange(walls.in_base) // walls.layers

    def change(v: np.ndarray) -> np.ndarray:
        state.vy[base], state.vx[base] = v, -2.0 * v
        state.reaction_y[:], state.reaction_x[:] = 0.0, 0.0
        resist_bending(walls, state, n_soil, dt, 0, state.x.size)
        np.testing.assert_allclose(state.reaction_x, -2.0 * state.reaction_y, atol=1e-9)
        assert not state.reaction_y[walls.in_base :].any()
        return state.reaction_y[: walls.in_base].copy()

    inner = (column >= 2) & (column < column[-1] - 1)
    alternating = (-1.0) ** column
    np.testing.assert_allclose(change(alternating)[inner], 16.0 * walls.bending * dt * alternating[inner])
    np.testing.assert_allclose(change(3.0 + 0.5 * column), 0.0, atol=1e-6)
    bent = np.random.default_rng(1).standard_normal(walls.in_base)
    rows = change(bent).reshape(-1, walls.layers)
    np.testing.assert_allclose(rows.sum(axis=0), 0.0, atol=1e-6 * np.abs(rows).max())
    assert np.all((rows * bent.reshape(rows.shape)).sum(axis=0) > 0.0)


def test_sides_are_as_high_as_the_ground_and_so_are_their_columns() -> None:
    scene = slope({})
    particles = place_particles(scene)
    term, boundary = (make(scene, particles, make_kernel("cubic_spline", 2.6), 1e-3) for make in (make_free_field, make_absorbing))
    assert term is not None and boundary is not None
    side = particles.kind == SIDE
    assert particles.y[side & (particles.x < 0)].max() == 5.0 and particles.y[side & (particles.x > 0)].max() == 15.0
    assert term.begin.tolist() == [0, 3 + 3, 3 + 3 + 3 + 8]
    # Each side's particle beside the node of its own row.
    nodes = np.concatenate([np.arange(count) for count in (6, 11)])
    beside = np.flatnonzero(boundary.side[0])
    row = np.floor(particles.y[particles.n_soil :][beside] / 2.0) + 3
    np.testing.assert_array_equal(nodes[boundary.node[beside]], row)
    np.testing.assert_array_equal(boundary.node[beside] >= 6, particles.x[particles.n_soil :][beside] > 0)


@pytest.mark.parametrize(("base", "fixed"), [("fixed", 3), ("absorbing", 0)])
def test_columns_stand_on_the_base_of_the_model(base: str, fixed: int) -> None:
    scene = slope({"walls.base": base})
    particles = place_particles(scene)
    term = make_free_field(scene, particles, make_kernel("cubic_spline", 2.6), 1e-3)
    assert term is not None
    assert np.count_nonzero(term.mobile == 0.0) == 2 * fixed
    assert term.drag.any() == (base == "absorbing")
    assert np.count_nonzero(particles.kind[: particles.first_fixed] == BASE) == (0 if fixed else np.count_nonzero(particles.kind == BASE))
    assert np.all(particles.kind[: particles.n_soil] == SOIL)


@pytest.mark.parametrize("base", ["no_slip", "contact"])
@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.1}], ids=["plain", "corrected"])
def test_columns_see_a_no_slip_base_as_the_soil_does(base: str, correction: dict[str, float] | None) -> None:
    # Nodes are the rows of soil alone, beside the sides' particles of their row; b and correction are those of the last column of soil.
    scene = slope({"walls.base": base, "numerics.gradient_correction": correction, "numerics.precision": "double"})
    particles = place_particles(scene)
    kernel = make_kernel("cubic_spline", 2.6)
    term, boundary = make_free_field(scene, particles, kernel, 1e-3), make_absorbing(scene, particles, kernel, 1e-3)
    assert term.begin.tolist() == [0, 3, 3 + 8] and term.mobile.all() and not term.drag.any()
    side = np.flatnonzero(boundary.side[0])
    x, y = (getattr(particles, name)[particles.n_soil :][side] for name in ("x", "y"))
    np.testing.assert_array_equal(boundary.node[side], np.floor(y / 2.0) + 3 * (x > 0))
    pairs = make_lists(initial_state(particles, scene), make_terms(scene, particles))[1]
    x, y = particles.x[: particles.n_soil], particles.y[: particles.n_soil]
    last = np.flatnonzero(x == x.max())[np.argsort(y[x == x.max()])]  # further from the slope's face than the kernel reaches
    np.testing.assert_allclose(term.wall[3:], pairs.wall[last, 1] / scene.soil.density, rtol=1e-9, atol=1e-12)
    if correction:
        np.testing.assert_allclose(term.correction[3:], pairs.correction[last, 2], rtol=1e-9)


def test_layers_count_where_they_meet_the_boundary() -> None:
    # Between 6 and 10 m of height and, under the base, below 0 m a layer of its own; walls go on as the soil beside them.
    stiff = {"density": 2500.0, "youngs_modulus": 5e6, "poisson_ratio": 0.25}
    strata = {"cover": {"region": {"kind": "elevation", "bottom": 6.0, "top": 10.0}, "soil": stiff}}
    scene = slope({"layers": strata | {"deep": {"region": {"kind": "elevation", "top": 2.0}, "soil": stiff}}})
    particles = place_particles(scene)
    term, boundary = (make(scene, particles, make_kernel("cubic_spline", 2.6), 1e-3) for make in (make_free_field, make_absorbing))
    assert term is not None and boundary is not None
    own, hard = scene.soil, scene.layers["cover"].soil
    column = np.array([2, 2, 2, 2, 1, 1, 2, 2, 1, 1, 1])  # three rows under the base, the rows at 1, 3, 5, 7, ... m
    for nodes in (slice(0, 6), slice(6, 17)):
        expected = np.where(column == 2, hard.shear_modulus_si, own.shear_modulus_si)[: nodes.stop - nodes.start]
        np.testing.assert_allclose(term.modulus[0, nodes], expected, rtol=1e-12)
    base = particles.kind[particles.n_soil : particles.first_fixed] == BASE
    rate = hard.s_wave_speed / 2.0 * layer_weights(make_kernel("cubic_spline", 2.6), 2.0, 3)
    np.testing.assert_allclose(np.unique(boundary.base[0, base]), np.sort(rate), rtol=1e-12)


def test_sides_without_soil_are_refused() -> None:
    body = {"kind": "polygon", "points": [[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0]]}
    data = SLOPE | {"geometry": {"shape": "bodies", "width": 20.0, "height": 10.0, "bodies": [body]}}
    with pytest.raises(ValueError, match=r"walls\.sides: absorbing .*both sides"):
        place_particles(make_scene(data))


def test_a_thread_looks_at_the_rows_that_it_has_moved() -> None:
    # The lists of pairs are renewed by how far a thread's own particles have moved, while other threads may still move theirs.
    scene = slope({})
    particles = place_particles(scene)
    terms = make_terms(scene, particles)
    assert terms.absorbing_walls is not None and terms.absorbing_walls.in_base > 3 * scene.walls.layers
    loads = Loads(time=terms.armed_from + 1.0, ground=1.0, vertical=0.0, gravity=9.81, extra_damping=0.0)
    ends = range(terms.n_soil, terms.n_moving + 1)
    for first, last in zip([0, *ends], [*ends, terms.n_moving], strict=True):
        state = initial_state(particles, scene)
        kick_boundary(terms.absorbing_walls, state, terms, particles.mass, loads, first, last)
        begin, end = moved_rows(terms.absorbing_walls, terms.n_soil, first, last)
        assert set(np.flatnonzero(state.vx)) == set(range(max(begin, terms.n_soil), end))
