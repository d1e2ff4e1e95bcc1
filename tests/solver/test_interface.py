"""Interfaces between soils of unlike strength: weights by hand, pairs across, conjugate forces, the limit of the time step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.schema import Scene
from sph.solver.physics.gradient_correction import power
from sph.solver.physics.interface import NO_SOIL, Interface, once_lost, weights
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.renewal import make_lists
from sph.solver.simulation import Simulation
from sph.solver.terms import only

pytestmark = pytest.mark.uncompiled

STRONG = {"cohesion": 900.0, "friction_angle": 35.0}
RESOLVED = {"coupling.solid_after_failure": "elastic_plastic", "numerics.interfaces": "weaker", "numerics.smoothing_ratio": 1.3}


def two_soils(free_block: SceneBuilder, overrides: dict[str, Any] | None = None) -> Scene:
    """A free block whose lower half is strong; with the layers in a different order for the same soil twice."""
    layers = {"strong": {"region": {"kind": "elevation", "top": 5.0}, "soil": STRONG}}
    return free_block(RESOLVED | {"soil.cohesion": 10.0, "layers": layers, "numerics.precision": "double"} | (overrides or {}))


def pair(strengths: tuple[float, float], lost: tuple[float, float]) -> Interface:
    """Two particles without friction, by their cohesions (Pa) and what they have lost of their solid state."""
    return Interface(np.array([0, 1], np.uint8), np.array(strengths) - 1.0, np.zeros(2), np.zeros(2), np.array(lost), np.zeros(2))


@pytest.mark.parametrize(
    ("strengths", "lost", "expected"),
    [
        ((3e3, 3e3), (1.0, 1.0), 1.0),  # equal: both sides
        ((3e3, 9e9), (1.0, 0.0), 2.0),  # the weaker one alone
        ((9e9, 3e3), (0.0, 1.0), 0.0),
        ((3e3, 9e9), (0.0, 1.0), 1.0),  # before the weaker one has failed, whatever the stronger one has
        ((3e3, 6e3), (1.0, 1.0), 32.0 / 17.0),  # 2 * 2^4 / (1 + 2^4)
        ((3e3, 6e3), (0.25, 0.0), 1.0 + 0.25 * 15.0 / 17.0),
    ],
)
def test_weights(strengths: tuple[float, float], lost: tuple[float, float], expected: float) -> None:
    own, other = weights(pair(strengths, lost), 0, 1)
    assert own == pytest.approx(expected, rel=1e-12)
    assert (own, other) == weights(pair(strengths[::-1], lost[::-1]), 1, 0), "the same from both sides"
    assert own + other == 2.0


def test_the_traction_exceeds_the_weaker_strength_by_eight_per_cent_at_most() -> None:
    # Both sides at yield: (w_i k_i + w_j k_j) / 2 over the smaller k, which the module states.
    ratios = np.linspace(1.0, 50.0, 5000)
    found = []
    for ratio in ratios:
        own, other = weights(pair((1e6, 1e6 * ratio), (1.0, 1.0)), 0, 1)
        found.append(0.5 * (own + other * ratio))
    assert max(found) == pytest.approx(1.08, abs=0.005)
    assert ratios[int(np.argmax(found))] == pytest.approx(1.44, abs=0.02)


def test_strengths_at_the_mean_pressure_of_the_pair() -> None:
    # c cos(phi) + p sin(phi) at p = 50 kPa, from 20 and 80 kPa: 5 + 50 sin(10) = 13.68 kPa and 50 sin(30) = 25 kPa.
    term = Interface(
        np.array([0, 1], np.uint8),
        np.array([5e3, 0.0]),
        np.sin(np.radians([10.0, 30.0])),
        np.array([2e4, 8e4]),
        np.ones(2),
        np.zeros(2),
    )
    weak, strong = (5.0 + 50.0 * math.sin(math.radians(10.0))) ** 4, 25.0**4
    assert weights(term, 0, 1)[0] == pytest.approx(2.0 * strong / (weak + strong), rel=1e-3)


def test_pairs_across_stand_last_and_all_are_there(free_block: SceneBuilder) -> None:
    scenes = two_soils(free_block), two_soils(free_block, {"numerics.interfaces": "both"})
    with_it, without = (Simulation(scene) for scene in scenes)
    for simulation in (with_it, without):
        simulation.candidates, simulation.pairs = make_lists(simulation.state, simulation.list_terms)
    term, pairs = with_it.terms.interface, with_it.pairs
    assert without.terms.interface is None and without.pairs.alike_end.size == 0
    across = 0
    for i in range(with_it.particles.n_soil):
        row = pairs.neighbour[pairs.start[i] : pairs.end[i]]
        assert sorted(row) == sorted(without.pairs.neighbour[without.pairs.start[i] : without.pairs.end[i]])
        unlike = term.soil[row] != term.soil[i]
        split = int(pairs.alike_end[i] - pairs.start[i])
        assert not unlike[:split].any() and unlike[split:].all()
        across += int(unlike.sum())
    assert across > 100


def test_soils_of_the_same_strength_and_walls_have_no_interface(free_block: SceneBuilder, small_slope: SceneBuilder) -> None:
    heavy = {"heavy": {"region": {"kind": "elevation", "top": 5.0}, "soil": {"density": 2500.0}}}
    assert Simulation(free_block(RESOLVED | {"layers": heavy})).terms.interface is None
    strong = {"strong": {"region": {"kind": "elevation", "top": 5.0}, "soil": STRONG}}
    simulation = Simulation(small_slope(RESOLVED | {"layers": strong}))
    assert set(simulation.terms.interface.soil[simulation.particles.n_soil :]) == {NO_SOIL}


def test_other_residual_strengths_alone_make_an_interface(free_block: SceneBuilder) -> None:
    layers = {"brittle": {"region": {"kind": "elevation", "top": 5.0}, "S_R": 0.1}}
    assert Simulation(free_block(RESOLVED | {"layers": layers})).terms.interface is not None


@pytest.mark.parametrize("correction", [None, {"min_determinant": 0.3}], ids=["plain", "corrected"])
def test_forces_and_strain_rates_are_conjugate_whatever_the_weights(free_block: SceneBuilder, correction: dict[str, float] | None) -> None:
    simulation = Simulation(two_soils(free_block, {"numerics.gradient_correction": correction}))
    generator = np.random.default_rng(7)
    state, terms, n = simulation.state, simulation.terms, simulation.particles.n_soil
    for name in ("x", "y"):
        moved = getattr(state, name) + generator.uniform(-0.2, 0.2, n)
        for each in (name, f"{name}_pairs", f"{name}_candidates"):
            getattr(state, each)[:] = moved
    _, pairs = make_lists(state, simulation.list_terms)
    for name in ("vx", "vy", "sxx", "syy", "sxy", "syx"):
        getattr(state, name)[:] = generator.normal(size=n)
    if correction is None:
        state.syx[:] = state.sxy
    terms.interface.lost[:] = generator.uniform(size=n)
    terms.interface.cohesion[:] = 10.0 ** generator.uniform(2.0, 5.0, n)
    gradient = np.zeros((4, n))
    plain = only(terms, "gradient_correction", "layers", "interface")
    velocity_gradients(state, pairs, plain, gradient, 0, n)
    stress_accelerations(state, pairs, plain, gradient, 0, n)
    forces = float(state.ax @ state.vx + state.ay @ state.vy)
    stresses = sum(power(terms.gradient_correction, state, gradient, i) for i in range(n))
    assert abs(forces) > 1.0
    assert forces + stresses == pytest.approx(0.0, abs=1e-11 * abs(forces))
    assert float(state.ax.sum()) == pytest.approx(0.0, abs=1e-10 * np.abs(state.ax).sum()), "equal and opposite"


@pytest.mark.long
@pytest.mark.usefixtures("without_steps")
def test_the_limit_of_the_time_step_is_that_of_soil_that_has_failed(free_block: SceneBuilder) -> None:
    # Weak and strong soil of the same stiffness: the weak rows beside the interface are twice as stiff towards it.
    undamped = {"damping": None, "numerics.artificial_viscosity": None}
    one, other = (Simulation(two_soils(free_block, undamped | {"numerics.interfaces": kind})) for kind in ("weaker", "both"))
    for simulation in (one, other):
        simulation.prepare()
        simulation.measure_limit(200)
    assert 0.65 * other.limit < one.limit < 0.95 * other.limit
    assert once_lost(None) is None
