"""V13: the constitutive laws of single particles: loss of strength after failure, no stress by rotation."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.compiled.threads import make_team
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.physics.coupling import cauchy_stress, update_stress
from sph.solver.renewal import make_lists
from sph.solver.state import ARMED, FAILED, HELD, YIELDED
from sph.solver.terms import State, make_terms

pytestmark = pytest.mark.uncompiled

DT = 1e-3
NOT_SOFTENING = {"coupling.gamma": 0.0, "coupling.solid_after_failure": "elastic_plastic"}
"""Failed soil keeps its peak strength."""
PRESSURES = np.array([50e3, 150e3, 300e3, 600e3])


class Bench(NamedTuple):
    """Four particles whose velocity gradients are prescribed; no neighbours are involved."""

    state: State
    terms: Any
    pairs: Any

    def strain(self, gradient: tuple[float, float, float, float], step: int) -> int:
        """One step with the velocity gradient (xx, xy, yx, yy) in 1/s; the number of particles that fail."""
        sums = np.array(gradient)[:, None] * self.state.density
        (team,) = make_team(1, 4, 0)
        team.gradient[:] = sums
        failed, _ = update_stress(self.state, self.pairs, self.terms, step * DT, team, 0, 4)
        return failed

    def stress(self) -> np.ndarray:
        """(4, 4) stress xx, yy, zz, xy, tension positive, Pa."""
        out = np.empty((4, 4))
        cauchy_stress(self.state, self.terms, out)
        return out


def bench(overrides: dict[str, Any] | None = None) -> Bench:
    base = {
        "scheme": "paper",
        "name": "bench",
        "geometry": {"shape": "block", "width": 2.0, "height": 2.0},
        "walls": {"base": "none", "sides": "none"},
        "gravity": {"acceleration": 0.0, "ramp": 0.0, "duration": 0.01, "damping": 0.0},
        "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
        "damping": None,
        "numerics": {"time_step": DT, "artificial_viscosity": None, "short_range_repulsion": None, "gradient_correction": None},
    }
    scene = make_scene(merge(base, dotted(overrides or {})))
    particles = place_particles(scene)
    assert particles.x.size == 4
    state, terms = initial_state(particles, scene), make_terms(scene, particles)
    state.density[:] = scene.soil.density * (1 + PRESSURES / scene.soil.bulk_modulus_si)
    _, pairs = make_lists(state, terms)
    return Bench(state, terms, pairs)


def mohr_coulomb_strength(S_R: float) -> np.ndarray:
    """c cos(phi) + p sin(phi) of the paper's soil at the four pressures (s_zz stays 0), Eqs. 14-15."""
    phi = math.radians(20.0 * S_R)
    return 150e3 * S_R * math.cos(phi) + PRESSURES * math.sin(phi)


LAWS = [(law, gamma, 0.1) for law in ("elastic_plastic", "elastic") for gamma in (1.0, 10.0, 100.0)]


@pytest.mark.parametrize(("law", "gamma", "S_R"), [*LAWS, ("elastic_plastic", 0.0, 0.1), ("elastic", 10.0, 0.5)])
def test_loss_of_strength_in_simple_shear(law: str, gamma: float, S_R: float) -> None:
    # dv_x/dy = 0.05 1/s at constant pressure, after arming (step 10).  Particles fail within a few steps of each other; after t_f the
    # shear stress is tau_f + (tau - tau_f) exp(-gamma (t - t_f)) with t_f the step of failure and tau that of the solid state: tau_s on
    # its yield surface, tau_s + G rate (t - t_f) where it is elastic.  Exact but for eta * rate = 0.1 Pa, the turn of the deviator
    # against the shear plane and rounding: 2e-5.  That turn is (tau/G)^2 / 2 < 1e-6 on a yield surface; elastic, by
    # (rate (t - t_f))^2 / 6 of G rate (t - t_f) in 1.5 s (the Jaumann stress is G sin of the strain): 1e-3 of the strain's part.
    b = bench({"coupling.S_R": S_R, "coupling.gamma": gamma, "coupling.solid_after_failure": law})
    shear_modulus = b.terms.soil.shear_modulus
    times, stresses, failed = [], [], 0
    for step in range(1, 1500):
        failed += b.strain((0.0, 0.05 if step > 10 else 0.0, 0.0, 0.0), step)
        times.append(step * DT)
        stresses.append(b.stress())
    assert failed == 4
    assert np.all(b.state.phase == FAILED)
    tau_s, tau_f = mohr_coulomb_strength(1.0), mohr_coulomb_strength(S_R)
    time, stress = np.array(times), np.array(stresses)
    for i in range(4):
        t_f = b.state.t_f[i]
        after = time > t_f
        strain = 0.05 * (time[after] - t_f) if law == "elastic" else 0.0 * time[after]
        solid = tau_s[i] + shear_modulus * strain
        expected = tau_f[i] + (solid - tau_f[i]) * np.exp(-gamma * (time[after] - t_f))
        np.testing.assert_allclose(stress[after, i, 3], expected, rtol=1e-3 if law == "elastic" else 2e-5)
        at = np.argmin(np.abs(time - t_f))
        assert stress[at, i, 3] == pytest.approx(tau_s[i], rel=2e-5), "peak strength at the moment of failure"
        # Pressure is untouched, sigma_zz stays at -p.
        np.testing.assert_allclose(stress[:, i, 2], -PRESSURES[i], rtol=1e-9)


def test_time_of_failure() -> None:
    # Elastic shear reaches tau_s at t = tau_s / (G rate), and t_f is the first step after it.  The rate is slow
    # enough for the arming at step 10 to come first: tau_s / G is 2.5e-4 to 5.6e-4.
    b = bench()
    for step in range(1, 80):
        b.strain((0.0, 0.01, 0.0, 0.0), step)
    exact = mohr_coulomb_strength(1.0) / (b.terms.soil.shear_modulus * 0.01)
    np.testing.assert_allclose(b.state.t_f, np.ceil(exact / DT) * DT, rtol=1e-9)


def test_beta_follows_equation_9() -> None:
    b = bench({"coupling.gamma": 3.0})
    for step in range(1, 1000):
        b.strain((0.0, 0.05 if step > 10 else 0.0, 0.0, 0.0), step)
    np.testing.assert_allclose(b.state.beta, np.exp(-3.0 * (0.999 - b.state.t_f)), rtol=1e-10)


def test_before_failure_neither_S_R_nor_gamma_matters() -> None:
    results = []
    for S_R, gamma in ((0.1, 100.0), (0.5, 1.0)):
        b = bench({"coupling.S_R": S_R, "coupling.gamma": gamma})
        for step in range(1, 30):
            b.strain((0.001, 0.005, 0.002, -0.003), step)
        assert not np.any(b.state.phase == FAILED)
        results.append(b.stress())
    np.testing.assert_array_equal(*results)


def test_what_yields_under_gravity_fails_at_the_end_of_its_stage() -> None:
    # At yield from step 1 on; the stage ends at step 500, and nothing fails in it.
    b = bench({"gravity.duration": 0.5})
    for step in range(1, 501):
        assert b.strain((0.0, 1.0, 0.0, 0.0), step) == 0
    assert np.all(b.state.phase == YIELDED)
    assert b.strain((0.0, 1.0, 0.0, 0.0), 501) == 4
    assert np.all(b.state.phase == FAILED)
    np.testing.assert_allclose(b.state.t_f, 0.5, rtol=1e-12)
    # What reaches the surface for the first time after the stage fails when it does.
    late = bench({"gravity.duration": 0.5})
    for step in range(1, 501):
        late.strain((0.0, 0.0, 0.0, 0.0), step)
    assert np.all(late.state.phase == ARMED)
    assert late.strain((0.0, 1.0, 0.0, 0.0), 501) == 4
    np.testing.assert_allclose(late.state.t_f, 0.501, rtol=1e-12)


def test_what_a_wall_holds_at_yield_fails_only_after_it_came_off() -> None:
    # A particle that yields through the end of the gravity stage (step 500) and on is not armed and does not fail.
    b = bench({"gravity.duration": 0.5})
    b.state.phase[:] = HELD
    for step in range(1, 700):
        assert b.strain((0.0, 1.0, 0.0, 0.0), step) == 0
    assert not np.any(b.state.phase == FAILED)
    np.testing.assert_allclose(b.stress()[:, 3], mohr_coulomb_strength(1.0), rtol=2e-5)
    # Unloaded clearly below the surface after the stage they are armed, loaded again they fail.
    for step in range(700, 720):
        b.strain((0.0, -0.02, 0.0, 0.0), step)
    assert np.all(b.state.phase == ARMED)
    for step in range(720, 800):
        b.strain((0.0, 1.0, 0.0, 0.0), step)
    assert np.all(b.state.phase == FAILED)


def test_extension_fails_at_the_apex() -> None:
    # Pulled apart uniformly: mean tension is limited to c cot(phi) = 412 kPa, which counts as failure.
    b = bench(NOT_SOFTENING)
    failed = 0
    for step in range(1, 200):
        failed += b.strain((0.01, 0.0, 0.0, 0.01), step)
    apex = 150e3 / math.tan(math.radians(20))
    assert failed == 4
    stress = b.stress()
    mean = stress[:, :3].mean(axis=1)
    assert np.all(mean <= apex * (1 + 1e-9))


@pytest.mark.parametrize("state", ["elastic", pytest.param("failed", marks=pytest.mark.long)])
def test_rigid_rotation_gives_no_stress(state: str) -> None:
    # Ten turns and an eighth, which shows the sense, in steps of 4 mrad.  The midpoint form keeps the norm to rounding and turns the
    # deviator by 2 atan(a) instead of 2 a: a^2 / 3 of the turn, 10 * 4 pi * 5.3e-6 = 7e-4 rad in all.
    b = bench(NOT_SOFTENING if state == "failed" else {})
    shear = 120 if state == "failed" else 12
    for step in range(1, shear):
        b.strain((0.001, 0.01, 0.0, -0.001), step)
    assert np.all((b.state.phase == FAILED) == (state == "failed"))
    start = b.stress()
    in_plane = start[:, 3] ** 2 + 0.25 * (start[:, 0] - start[:, 1]) ** 2
    assert np.all(in_plane > 1e3**2), "stressed, so that the test means something"
    angle, steps = 4e-3, round(10.125 * 2 * math.pi / 4e-3)
    omega = angle / DT
    for step in range(shear, shear + steps):
        b.strain((0.0, -omega, omega, 0.0), step)
    turn = steps * angle
    c, s = math.cos(turn), math.sin(turn)
    turned = b.stress()
    rotation = np.array([[c, -s], [s, c]])
    for before, after in zip(start, turned, strict=True):
        tensor = rotation @ np.array([[before[0], before[3]], [before[3], before[1]]]) @ rotation.T
        deviator = math.hypot(before[3], 0.5 * (before[0] - before[1]))
        expected = [tensor[0, 0], tensor[1, 1], before[2], tensor[0, 1]]
        np.testing.assert_allclose(after, expected, rtol=0, atol=2e-3 * deviator)
        radius = math.hypot(after[3], 0.5 * (after[0] - after[1]))
        assert radius == pytest.approx(deviator, rel=1e-6), "norm kept"
        assert after[2] == pytest.approx(before[2], rel=1e-9)
