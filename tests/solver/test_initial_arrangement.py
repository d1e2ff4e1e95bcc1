"""Pairs of soil that has not failed, by hand: deformed as the soil around them is, else as they lie."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.neighbours import Places
from sph.solver.physics.initial_arrangement import deform, is_intact, largest_changes, note_intact, offset
from sph.solver.renewal import fill_pairs, make_lists
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED

pytestmark = pytest.mark.uncompiled

ROWS = 6
LEFT, RIGHT = 2 * ROWS + 2, 3 * ROWS + 2
"""A particle in the middle and its neighbour one spacing (1 m) to the right."""


def block(overrides: dict[str, Any] | None = None) -> Simulation:
    """A free block of 6 x 6 particles, 1 m apart."""
    scene = {
        "scheme": "paper",
        "name": "block",
        "duration": 5.0,
        "geometry": {"shape": "block", "width": 6.0, "height": 6.0},
        "walls": {"base": "none", "sides": "none"},
        "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "precision": "double", "reference": "initial"},
    }
    simulation = Simulation(make_scene(merge(scene, dotted(overrides or {}))))
    simulation.candidates, simulation.pairs = make_lists(simulation.state, simulation.list_terms)
    return simulation


def pair(simulation: Simulation, i: int = LEFT, j: int = RIGHT) -> tuple[float, float, bool]:
    """The vector from j to i that their pair has, m, and whether it is that of the start."""
    term, state = simulation.terms.initial_arrangement, simulation.state
    intact = is_intact(term, simulation.pairs, i)
    dx, dy, kept = offset(term, intact, None, simulation.pairs, Places(state.x, state.y, state.density), i, j)
    return float(dx), float(dy), bool(kept)


def note(simulation: Simulation) -> None:
    """Take the deformations over into the pairs."""
    note_intact(simulation.terms.initial_arrangement, simulation.state, simulation.pairs, 0, simulation.state.x.size)


def stretch(simulation: Simulation, i: int, xx: float = 0.0, xy: float = 0.0, yx: float = 0.0, yy: float = 0.0) -> None:
    """Deform one particle by an increment of the displacement gradient."""
    deform(simulation.terms.initial_arrangement, simulation.state, i, xx, xy, yx, yy)


def test_increments_of_deformation_follow_each_other() -> None:
    # F = (1 + L2)(1 + L1) with L1 = 0.1 in xx and L2 = 0.2 in yx: rows (1.1, 0) and (0.22, 1).
    simulation = block()
    stretch(simulation, LEFT, xx=0.1)
    stretch(simulation, LEFT, yx=0.2)
    np.testing.assert_allclose(simulation.state.stretch[:, LEFT], [0.1, 0.0, 0.22, 0.0], rtol=1e-14, atol=1e-15)


def test_a_pair_is_deformed_by_the_mean_of_both() -> None:
    # F of i has 10 % along x and 4 % of shear, that of j is the identity: the vector (-1, 0) becomes (-1.05, -0.02) wherever they lie.
    simulation = block()
    stretch(simulation, LEFT, xx=0.1, yx=0.04)
    simulation.state.x[LEFT] -= 0.04
    note(simulation)
    dx, dy, kept = pair(simulation)
    assert kept and (dx, dy) == (pytest.approx(-1.05, rel=1e-14), pytest.approx(-0.02, rel=1e-14))
    back_x, back_y, kept = pair(simulation, RIGHT, LEFT)
    assert kept and (back_x, back_y) == (-dx, -dy), "equal and opposite to the last bit"


@pytest.mark.parametrize(("moved", "kept"), [(0.19, True), (0.21, False)])
def test_a_pair_that_lies_elsewhere_counts_as_it_lies(moved: float, kept: bool) -> None:
    # Nothing is deformed, so that the neighbour lies as far off as it has moved; a fifth of the first distance is allowed.
    simulation = block()
    simulation.state.x[LEFT] -= moved
    note(simulation)
    assert pair(simulation) == (pytest.approx(-1.0 if kept else -1.0 - moved, rel=1e-14), 0.0, kept)


def test_the_pairs_of_a_failed_particle_are_as_they_lie() -> None:
    simulation = block()
    simulation.state.phase[RIGHT] = FAILED
    simulation.state.x[LEFT] -= 0.05
    note(simulation)
    assert not simulation.state.intact[RIGHT] and simulation.state.intact[LEFT]
    assert pair(simulation) == (pytest.approx(-1.05, rel=1e-14), 0.0, False)
    other = pair(simulation, LEFT, LEFT - ROWS)
    assert other == (pytest.approx(1.0, rel=1e-14), 0.0, True), "its other neighbours are as at the start"
    simulation.state.phase[RIGHT] = 0
    note(simulation)
    assert not simulation.state.intact[RIGHT], "for good"


def test_particles_that_were_no_neighbours_are_as_they_lie() -> None:
    # Three spacings are beyond the support of 2.6, so that one that comes near is no neighbour of the start.
    simulation = block()
    simulation.state.x[LEFT + 3 * ROWS] = simulation.state.x[LEFT] + 1.0
    note(simulation)
    assert pair(simulation, LEFT, LEFT + 3 * ROWS) == (pytest.approx(-1.0, rel=1e-14), 0.0, False)


@pytest.mark.parametrize(("slid", "kept"), [(0.49, True), (0.51, False)])
def test_soil_that_slides_along_a_smooth_wall_is_mirrored_as_at_the_start_for_half_a_spacing(slid: float, kept: bool) -> None:
    simulation = block({"walls.base": "free_slip", "walls.layers": 4})
    n = simulation.particles.n_soil
    lowest = int(np.flatnonzero(simulation.state.y[:n] < 1.0)[2])
    wall = int(n + np.argmin(np.hypot(simulation.state.x[n:] - simulation.state.x[lowest], simulation.state.y[n:] + 0.5)))
    assert wall >= simulation.terms.initial_arrangement.first_slip
    simulation.state.x[lowest] += slid
    note(simulation)
    assert pair(simulation, lowest, wall) == (pytest.approx(0.0 if kept else slid, abs=1e-12), pytest.approx(1.0, rel=1e-12), kept)


def test_gradients_of_the_pairs_are_those_of_the_deformed_vectors() -> None:
    # A uniform strain of 5 % along x that no position shows: the sums over pairs are those of soil that lies so.
    simulation, lying = block(), block()
    for i in range(simulation.state.x.size):
        stretch(simulation, i, xx=0.05)
    note(simulation)
    lying.state.x[:] *= 1.05
    lying.state.phase[:] = FAILED
    note(lying)
    found = []
    for each in (simulation, lying):
        each.state.x_pairs[:] = each.state.x
        fill_pairs(each.state, each.candidates, each.pairs, each.list_terms)
        begin, end = int(each.pairs.start[LEFT]), int(each.pairs.end[LEFT])
        order = np.argsort(each.pairs.neighbour[begin:end])
        found.append((each.pairs.neighbour[begin:end][order], each.pairs.gx[begin:end][order], each.pairs.gy[begin:end][order]))
    for mine, other in zip(*found, strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-12, atol=1e-12)
    assert not simulation.pairs.changing[LEFT] and lying.pairs.changing[LEFT]


def test_what_asks_for_new_pairs() -> None:
    # 3 % of deformation moves soil ten spacings away by 0.3 m; a move of an intact particle with its own pairs alone asks for nothing.
    simulation = block()
    n = simulation.state.x.size
    term, state, pairs = simulation.terms.initial_arrangement, simulation.state, simulation.pairs
    state.x[LEFT] += 0.3
    seen, far = largest_changes(term, state, pairs, 0, 0, n)
    assert (seen, far) == (0.0, pytest.approx(0.09, rel=1e-12))
    pairs.changing[LEFT] = True
    assert largest_changes(term, state, pairs, 1, 0, n)[0] == pytest.approx(0.09, rel=1e-12)
    pairs.changing[LEFT] = False
    stretch(simulation, RIGHT, xx=0.03)
    assert largest_changes(term, state, pairs, 0, 0, n)[0] == pytest.approx(0.09, rel=1e-12)
    assert largest_changes(term, state, pairs, 1, 0, n)[0] == 0.0, "not looked at in this step"
    state.y[0] = math.nan
    assert math.isnan(largest_changes(term, state, pairs, 1, 0, n)[0])


def test_density_keeps_to_particles_that_move_in_disorder(small_slope: SceneBuilder) -> None:
    # Over a step of moves of random direction (0.03 spacings an axis) the density has to change as the sums of the kernel do.  Pairs at the
    # end of the step, which runs without this term keep, put it ahead of them, time after time.  Seeds 1 to 3.
    for reference in ("initial", "current"):
        simulation = Simulation(
            small_slope({"numerics.reference": reference, "numerics.smoothing_ratio": 1.3, "gravity.acceleration": 0.0})
        )
        simulation.candidates, simulation.pairs = make_lists(simulation.state, simulation.list_terms)
        state, terms, at_start = simulation.state, simulation.terms, simulation.saved()
        n, h, spacing = simulation.particles.n_soil, terms.kernel.h, simulation.scene.numerics.spacing
        for seed in (1, 2, 3):
            simulation.go_back(at_start._replace(state=at_start.state._make(field.copy() for field in at_start.state)))
            state, rng = simulation.state, np.random.default_rng(seed)
            state.phase[:n] = FAILED
            first = np.column_stack([state.x, state.y])
            first[:n] += 0.1 * spacing * rng.standard_normal((n, 2))
            move = np.zeros_like(first)
            move[:n] = 0.03 * spacing * rng.standard_normal((n, 2))
            (state.x[:], state.y[:]), (state.vx[:], state.vy[:]) = first.T, move.T / terms.dt
            simulation.advance_steps(1)
            move = np.column_stack([state.x, state.y]) - first  # but for what damping took of it
            changed = (state.density[:n] / at_start.state.density[:n] - 1.0) / terms.kernel.gradient_scale

            def sums(places: np.ndarray, scale: float = spacing**2, h: float = h, n: int = n) -> tuple[np.ndarray, np.ndarray]:
                """Kernel sums (n,), and its gradient to every neighbour (n, all, 2) times volume."""
                apart = places[:n, None] - places[None]
                q = np.hypot(*np.moveaxis(apart, -1, 0)) / h
                near, far = np.maximum(1.0 - q, 0.0), np.maximum(2.0 - q, 0.0)
                factor = scale * 10.0 / (28.0 * math.pi * h * h)
                slope = factor * (12.0 * near**2 - 3.0 * far**2) / np.where(q > 0, q, 1.0) / h**2
                return factor * (far**3 - 4.0 * near**3).sum(axis=1), slope[:, :, None] * apart

            (before, _), (after, gradient) = sums(first), sums(first + move)
            at_end = ((move[:n, None] - move[None]) * gradient).sum(axis=(1, 2))
            ahead = float(np.mean(at_end - (after - before)))
            assert ahead > 0.0
            if reference == "initial":
                assert abs(float(np.mean(changed - (after - before)))) < 0.05 * ahead
            else:
                np.testing.assert_allclose(changed, at_end, rtol=1e-3, atol=1e-6)
