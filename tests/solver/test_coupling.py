"""The stress update in chunks: what a chunk holds, and where it begins, changes nothing but rounding."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.solver.compiled.threads import make_team
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.coupling import CHUNK, update_stress
from sph.solver.renewal import make_lists
from sph.solver.state import ARMED, FAILED, HELD, UNARMED, YIELDED
from sph.solver.terms import State, make_terms

TIME = 0.5
"""s, after the gravity stage."""
VARIANTS: dict[str, dict[str, Any]] = {
    "default": {},
    "others": {
        "coupling.solid_after_failure": "elastic_plastic",
        "coupling.fluid": {"law": "capped_viscosity", "max_viscosity": 1e6},
        "numerics.gradient_correction": {"min_determinant": 0.1},
        "damping": None,
    },
}
"""Each function that stands in the loops over a chunk in one of them."""


class Mixture(NamedTuple):
    """A block of soil in every state a particle can be in, and how to strain it."""

    state: State
    terms: Any
    pairs: Any
    mass: np.ndarray
    gradient: np.ndarray

    def strain(self, ranges: list[tuple[int, int]]) -> tuple[State, int, float]:
        """A copy of the state strained over ranges of rows, the number of particles that failed and the internal work."""
        state = State(*(array.copy() for array in self.state))
        failed, internal = 0, 0.0
        for first, last in ranges:
            (team,) = make_team(1, state.x.size, 0)
            team.gradient[:] = self.gradient
            new, work = update_stress(state, self.pairs, self.terms, TIME, team, first, last)
            failed, internal = failed + new, internal + work
        return state, failed, internal


def phases(n: int, generator: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Phase and solid weight of n particles: chunks of none failed, all, all with and some with a solid rest, one; and a mixture."""
    phase, beta = np.full(n, ARMED, np.uint8), np.ones(n)
    chunk = [slice(k * CHUNK, (k + 1) * CHUNK) for k in range(n // CHUNK + 1)]
    phase[chunk[1]], beta[chunk[1]] = FAILED, 0.0
    phase[chunk[2]], beta[chunk[2]] = FAILED, generator.uniform(0, 1, CHUNK)
    phase[chunk[3]], beta[chunk[3]] = FAILED, np.where(generator.random(CHUNK) < 0.5, 0.0, 0.3)
    phase[4 * CHUNK + 10] = FAILED
    beta[4 * CHUNK + 10] = 0.5
    rest = slice(5 * CHUNK, n)
    phase[rest] = generator.choice([UNARMED, ARMED, FAILED, HELD, YIELDED], n - 5 * CHUNK)
    beta[rest] = np.where(phase[rest] == FAILED, generator.choice([0.0, 0.7], n - 5 * CHUNK), 1.0)
    return phase, beta


def mixed(free_block: SceneBuilder, overrides: dict[str, Any]) -> Mixture:
    scene = free_block(
        {"geometry.width": 20.0, "geometry.height": 20.0, "soil.cohesion": 150.0, "coupling.S_R": 0.25, "coupling.gamma": 10.0} | overrides
    )
    particles = place_particles(scene)
    n = particles.x.size
    assert n == 6 * CHUNK + 16
    generator = np.random.default_rng(4)
    state, terms = initial_state(particles, scene), make_terms(scene, particles)
    _, pairs = make_lists(state, terms)
    state.phase[:], state.beta[:] = phases(n, generator)
    was = state.phase == FAILED
    state.t_f[was] = 0.4
    # From beyond the apex in tension (412 kPa) to pressures at which most deviators are elastic.
    state.density[:] = scene.soil.density * (1 + generator.uniform(-6e5, 1.5e6, n) / scene.soil.bulk_modulus_si)
    for name in ("solid_diff", "solid_xy", "solid_zz"):
        getattr(state, name)[:] = generator.normal(0, 1.2e5, n)
        getattr(state, name.replace("solid", "fluid"))[was] = generator.normal(0, 3e4, np.count_nonzero(was))
    for name in ("sxx", "syy", "sxy", "syx"):
        getattr(state, name)[:] = generator.normal(0, 0.05, n)
    return Mixture(state, terms, pairs, particles.mass, scene.soil.density * generator.normal(0, 2.0, (4, n)))


@pytest.fixture(params=[pytest.param(name, marks=pytest.mark.long) for name in VARIANTS])
def mixture(free_block: SceneBuilder, request: pytest.FixtureRequest) -> Mixture:
    return mixed(free_block, VARIANTS[request.param])


def test_the_mixture_holds_every_case(mixture: Mixture) -> None:
    state, failed, _ = mixture.strain([(0, mixture.mass.size)])
    was, now = mixture.state.phase, state.phase
    assert failed > 50
    changes = [(UNARMED, ARMED), (UNARMED, YIELDED), (HELD, HELD), (HELD, ARMED), (ARMED, ARMED), (ARMED, FAILED), (YIELDED, FAILED)]
    assert {(int(before), int(after)) for before, after in zip(was, now, strict=True)} == {*changes, (FAILED, FAILED)}
    tension = mixture.terms.soil.bulk_modulus * (1 - state.density / mixture.terms.reference_density)
    assert np.any(tension > mixture.terms.soil.solid.tension_limit)


@pytest.mark.parametrize("size", [1, 7, CHUNK, 100])
def test_chunks_do_not_show(mixture: Mixture, size: int) -> None:
    # Loops over chunks vectorise, rests do not, and a chunk without solid or fluid state is another loop: the same formulas with sums
    # in another order.  A stress is a sum of some ten terms of at most the pressure's parts K rho / rho_0 and K, which cancel; the
    # stresses themselves are 1 to 10 MPa with stiffness damping.
    n = mixture.mass.size
    whole, failed, internal = mixture.strain([(0, n)])
    parts, failed_in_parts, internal_in_parts = mixture.strain([(k, min(k + size, n)) for k in range(0, n, size)])
    pascal = 10 * np.finfo(float).eps * mixture.terms.soil.bulk_modulus
    assert pascal < 1e-5
    per_square = pascal / mixture.terms.reference_density**2
    tolerance = dict.fromkeys(("solid_diff", "solid_xy", "solid_zz", "fluid_diff", "fluid_xy", "fluid_zz"), pascal)
    tolerance |= dict.fromkeys(("sxx", "syy", "sxy", "syx"), per_square)
    tolerance |= {"density": 4 * np.finfo(float).eps * mixture.terms.reference_density}
    matters = {name: whole.beta > 0.0 for name in ("solid_diff", "solid_xy", "solid_zz")}
    assert failed_in_parts == failed
    for name, expected in whole._asdict().items():
        found, rows = getattr(parts, name), matters.get(name, slice(None))
        np.testing.assert_allclose(found[rows], expected[rows], rtol=0, atol=tolerance.get(name, 0.0), err_msg=name)
    # Power sums cancel: their rounding is that of the largest terms.
    size_of_work = 0.5 * np.abs(mixture.gradient).sum(axis=0) @ (mixture.mass * 4 * np.abs(whole.sxx).max())
    assert internal_in_parts == pytest.approx(internal, abs=n * np.finfo(float).eps * size_of_work)


@pytest.mark.uncompiled
def test_the_solid_state_differs_after_failure_alone(free_block: SceneBuilder) -> None:
    # The same mixture with either solid state: what has not failed before the step is the same to the last bit.  A failed particle's
    # solid deviator is the elastic trial where it is elastic, and that brought to the surface where it is not.
    states, terms = [], None
    for law in ("elastic", "elastic_plastic"):
        mixture = mixed(free_block, {"coupling.solid_after_failure": law})
        terms = mixture.terms
        states.append(mixture.strain([(0, mixture.mass.size)])[0])
        was = mixture.state.phase == FAILED
    elastic, plastic = states
    for name in State._fields:
        before, after = getattr(elastic, name), getattr(plastic, name)
        if before.shape == was.shape:
            np.testing.assert_array_equal(before[~was], after[~was], err_msg=name)
    solid = was & (elastic.beta > 0.0)
    deviators = [np.stack([s.solid_diff, s.solid_xy, s.solid_zz])[:, solid] for s in states]
    factor = np.linalg.norm(deviators[1], axis=0) / np.linalg.norm(deviators[0], axis=0)
    np.testing.assert_allclose(deviators[1], deviators[0] * factor, rtol=0, atol=1e-6)
    assert np.all(factor <= 1.0 + 1e-12) and np.count_nonzero(factor < 0.99) > 20 and np.count_nonzero(factor > 0.99) > 5
    surface, bulk = terms.soil.solid, terms.soil.bulk_modulus
    p = bulk * (plastic.density[solid] / terms.reference_density - 1.0)
    d, q, z = deviators[0]
    demand = np.hypot(d, q) - 0.5 * z * surface.sine
    available = np.maximum(surface.cohesion_term + np.maximum(p, -surface.tension_limit) * surface.sine, 0.0)
    np.testing.assert_allclose(factor, np.where(demand > available, available / demand, 1.0), rtol=1e-9, atol=1e-12)  # 0 at the apex
