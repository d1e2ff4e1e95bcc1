"""The two laws of the fluid state."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.solver.physics.capped_viscosity import CappedViscosity
from sph.solver.physics.elastic_viscoplastic import ElasticViscoplastic
from sph.solver.physics.elasticity import Deviator, Strain
from sph.solver.physics.fluid_law import fluid_deviator
from sph.solver.physics.mohr_coulomb import make_mohr_coulomb

pytestmark = pytest.mark.uncompiled

G = 1e7
TAU_Y = 20e3
DT = 1e-4
NO_FRICTION = make_mohr_coulomb(TAU_Y, 0.0)

AT_REST = Deviator(0.0, 0.0, 0.0)


def shear_steps(law: ElasticViscoplastic | CappedViscosity, rate: float, n: int, start: Deviator = AT_REST) -> Deviator:
    """n steps of pure shear strain at the engineering shear rate dv_x/dy + dv_y/dx, without spin."""
    deviator = start
    for _ in range(n):
        deviator = fluid_deviator(law, NO_FRICTION, 0.0, deviator, Strain(0.0, 0.0, 0.5 * rate, 0.0, DT))
    return deviator


@pytest.mark.parametrize("eta", [2.0, 1e3, 5e4])
@pytest.mark.parametrize("rate", [0.5, 20.0])
def test_steady_shear_gives_yield_stress_plus_viscous_stress(eta: float, rate: float) -> None:
    # Backward Euler has the exact steady state; the approach has the time constant eta / G <= 5 ms and
    # the elastic range TAU_Y / (G rate) <= 4 ms, so 1000 steps (0.1 s) leave e^-19 of it.
    d, q, z = shear_steps(ElasticViscoplastic(G, eta), rate, 1000)
    assert q == pytest.approx(TAU_Y + eta * rate, rel=1e-6)
    assert (d, z) == (0.0, 0.0)


def test_elastic_below_yield() -> None:
    # 10 steps of engineering strain 1e-4 each: q = G * 1e-3 = 10 kPa, half the yield stress.
    _, q, _ = shear_steps(ElasticViscoplastic(G, 1e3), 1.0, 10)
    assert q == pytest.approx(G * 1e-3, rel=1e-12)


@settings(max_examples=100)
@given(radius=st.floats(0, 0.999), angle=st.floats(0, 2 * math.pi), z=st.floats(-1e4, 1e4))
def test_no_creep_below_yield(radius: float, angle: float, z: float) -> None:
    start = Deviator(radius * TAU_Y * math.cos(angle), radius * TAU_Y * math.sin(angle), z)
    assert shear_steps(ElasticViscoplastic(G, 2.0), 0.0, 20, start) == start


def test_relaxes_to_the_yield_stress_and_not_below() -> None:
    # Overstress decays as 1 / (1 + theta)^n with 1/theta = G dt / eta = 1: 60 steps leave 2^-60 of it.
    _, q, _ = shear_steps(ElasticViscoplastic(G, G * DT), 0.0, 60, Deviator(0.0, 3 * TAU_Y, 0.0))
    assert q == pytest.approx(TAU_Y, rel=1e-12)


def test_relaxation_by_hand() -> None:
    # theta = 0.5: (tau_y + 0.5 * 3 tau_y) / 1.5 = 5/3 tau_y.
    law = ElasticViscoplastic(G, 0.5 * G * DT)
    _, q, _ = shear_steps(law, 0.0, 1, Deviator(0.0, 3 * TAU_Y, 0.0))
    assert q == pytest.approx(5 / 3 * TAU_Y, rel=1e-12)


def test_yield_stress_follows_the_pressure() -> None:
    surface = make_mohr_coulomb(10e3, math.radians(30))
    deviator = AT_REST
    for _ in range(200):
        deviator = fluid_deviator(ElasticViscoplastic(G, 0.0), surface, 100e3, deviator, Strain(0.0, 0.0, 5.0, 0.0, DT))
    assert deviator[1] == pytest.approx(10e3 * math.cos(math.radians(30)) + 50e3, rel=1e-12)


# ---------------------------------------------------------------- capped viscosity

CAP, ETA = 1e6, 100.0
CAPPED = CappedViscosity(ETA, CAP)


@pytest.mark.parametrize("rate", [1e-6, 1e-3, 0.019])
def test_slow_flow_has_the_capped_viscosity(rate: float) -> None:
    # tau_y / rate > cap - eta, that is rate < 20e3 / (1e6 - 100) = 0.0200 1/s.
    _, q, _ = shear_steps(CAPPED, rate, 1)
    assert q == pytest.approx(CAP * rate, rel=1e-12)


@pytest.mark.parametrize("rate", [0.021, 1.0, 300.0])
def test_fast_flow_is_a_bingham_fluid(rate: float) -> None:
    _, q, _ = shear_steps(CAPPED, rate, 1)
    assert q == pytest.approx(TAU_Y + ETA * rate, rel=1e-12)


def test_capped_viscosity_is_continuous_and_zero_at_rest() -> None:
    at = TAU_Y / (CAP - ETA)
    below, above = (shear_steps(CAPPED, at * s, 1)[1] for s in (1 - 1e-9, 1 + 1e-9))
    assert above == pytest.approx(below, rel=1e-6)
    assert shear_steps(CAPPED, 0.0, 1, Deviator(1e3, 2e3, 3e3)) == (0.0, 0.0, 0.0)


def test_capped_viscosity_in_compression() -> None:
    # Pure d_yy = -e: deviatoric rates xx e/3, yy -2e/3, zz e/3; rate = sqrt(2 d:d) = e sqrt(4/3).
    # Slow: s = 2 eta_max d', that is d = (s_xx - s_yy)/2 = eta_max e, z = 2/3 eta_max e.
    e = 1e-3
    d, q, z = fluid_deviator(CAPPED, NO_FRICTION, 0.0, AT_REST, Strain(0.0, -e, 0.0, 0.0, DT))
    assert (d, q, z) == pytest.approx((CAP * e, 0.0, 2 / 3 * CAP * e), rel=1e-12)
    # Fast: viscosity eta + tau_y / rate.
    e = 10.0
    viscosity = ETA + TAU_Y / (e * math.sqrt(4 / 3))
    d, q, z = fluid_deviator(CAPPED, NO_FRICTION, 0.0, AT_REST, Strain(0.0, -e, 0.0, 0.0, DT))
    assert (d, q, z) == pytest.approx((viscosity * e, 0.0, 2 / 3 * viscosity * e), rel=1e-12)


# ---------------------------------------------------------------- frame invariance

rates = st.floats(-50, 50)


@settings(max_examples=150)
@given(xx=rates, yy=rates, xy=rates, turn=st.floats(0, math.pi), capped=st.booleans(), radius=st.floats(0, 2))
def test_a_rotated_strain_rate_gives_the_rotated_stress(xx: float, yy: float, xy: float, turn: float, capped: bool, radius: float) -> None:
    law = CAPPED if capped else ElasticViscoplastic(G, 1e3)
    surface = make_mohr_coulomb(TAU_Y, math.radians(15))

    def rotated(half_difference: float, shear: float) -> tuple[float, float]:
        # Q A Q^T turns ((a_xx - a_yy)/2, a_xy) by twice the angle.
        c, s = math.cos(2 * turn), math.sin(2 * turn)
        return c * half_difference - s * shear, s * half_difference + c * shear

    start = Deviator(radius * TAU_Y, 0.3 * radius * TAU_Y, -0.2 * TAU_Y)
    plain = fluid_deviator(law, surface, 5e4, start, Strain(xx, yy, xy, 0.0, DT))
    mean, half = 0.5 * (xx + yy), 0.5 * (xx - yy)
    half, shear = rotated(half, xy)
    start = Deviator(*rotated(start.diff, start.xy), start.zz)
    turned = fluid_deviator(law, surface, 5e4, start, Strain(mean + half, mean - half, shear, 0.0, DT))
    # Rounding of stresses of up to about 1e5 Pa, times the sensitivity at the cap's corner.
    assert turned == pytest.approx((*rotated(plain[0], plain[1]), plain[2]), rel=1e-9, abs=1e-6)
