"""Mohr-Coulomb return (V14), judged by principal stresses and not by the code's own formula."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sph.solver.physics.elasticity import Deviator
from sph.solver.physics.mohr_coulomb import MohrCoulomb, make_mohr_coulomb
from sph.solver.physics.yield_surface import limit_tension, return_factor, shear_demand, strength

pytestmark = pytest.mark.uncompiled

stresses = st.floats(-2e6, 2e6, allow_nan=False)
cohesions = st.floats(1.0, 500e3)
angles = st.floats(1.0, 50.0)


def full_stress(p: float, d: float, q: float, z: float) -> np.ndarray:
    """Stress tensor (Pa, tension positive) of pressure p and deviator (d, q, z)."""
    return np.array([[-p - 0.5 * z + d, q, 0.0], [q, -p - 0.5 * z - d, 0.0], [0.0, 0.0, -p + z]])


def excess(stress: np.ndarray, cohesion: float, angle: float) -> float:
    """How far the in-plane Mohr circle lies outside the failure line (Pa); <= 0 inside.

    (s1 - s3) / 2 + (s1 + s3) / 2 sin(phi) - c cos(phi), s1 >= s3 in the plane, tension positive.
    """
    low, high = np.linalg.eigvalsh(stress[:2, :2])
    return 0.5 * (high - low) + 0.5 * (high + low) * math.sin(angle) - cohesion * math.cos(angle)


def returned(surface: MohrCoulomb, p: float, d: float, q: float, z: float) -> tuple[float, float, float, float]:
    """Stress after the return, as the solver does it."""
    p = limit_tension(surface, p)
    factor = return_factor(surface, p, Deviator(d, q, z))
    return p, factor * d, factor * q, factor * z


# Rounding of sums of stresses of up to a few MPa in double precision is about 1e-9 Pa.
ROUNDING = 1e-6


@settings(max_examples=300)
@given(p=stresses, d=stresses, q=stresses, z=stresses, cohesion=cohesions, degrees=angles)
def test_on_or_inside_the_surface_afterwards(p: float, d: float, q: float, z: float, cohesion: float, degrees: float) -> None:
    angle = math.radians(degrees)
    surface = make_mohr_coulomb(cohesion, angle)
    before = excess(full_stress(limit_tension(surface, p), d, q, z), cohesion, angle)
    after = full_stress(*returned(surface, p, d, q, z))
    assert excess(after, cohesion, angle) <= ROUNDING
    if before > ROUNDING:
        assert excess(after, cohesion, angle) == pytest.approx(0.0, abs=ROUNDING), "a yielding stress ends on the surface"


@settings(max_examples=200)
@given(p=stresses, d=stresses, q=stresses, z=stresses, cohesion=cohesions, degrees=angles)
def test_direction_kept_pressure_unchanged(p: float, d: float, q: float, z: float, cohesion: float, degrees: float) -> None:
    surface = make_mohr_coulomb(cohesion, math.radians(degrees))
    before = full_stress(p, d, q, z)
    after = full_stress(*returned(surface, p, d, q, z))
    deviators = [s - np.trace(s) / 3 * np.eye(3) for s in (before, after)]
    size = np.linalg.norm(deviators[0])
    if size > 1.0:  # the full stress holds p and the deviator in one sum: less than a pascal is lost in the rounding of MPa
        factor = np.tensordot(deviators[0], deviators[1]) / size**2
        assert -1e-9 <= factor <= 1 + 1e-9
        np.testing.assert_allclose(deviators[1], factor * deviators[0], atol=ROUNDING)
    apex = cohesion / math.tan(math.radians(degrees))
    if p >= -apex:
        assert -np.trace(after) / 3 == pytest.approx(p, abs=ROUNDING)


@settings(max_examples=200)
@given(p=stresses, d=stresses, q=stresses, z=stresses, cohesion=cohesions, degrees=angles)
def test_a_second_return_changes_nothing(p: float, d: float, q: float, z: float, cohesion: float, degrees: float) -> None:
    surface = make_mohr_coulomb(cohesion, math.radians(degrees))
    once = returned(surface, p, d, q, z)
    assert returned(surface, *once) == pytest.approx(once, rel=1e-9, abs=ROUNDING)


def test_stress_inside_is_left_alone() -> None:
    surface = make_mohr_coulomb(150e3, math.radians(20))
    inside = (300e3, 50e3, -60e3, 20e3)
    assert returned(surface, *inside) == inside


def test_apex_in_tension() -> None:
    # Paper's soil: c cot(phi) = 150 / tan 20 = 412.1 kPa.
    surface = make_mohr_coulomb(150e3, math.radians(20))
    apex = 150e3 / math.tan(math.radians(20))
    assert apex == pytest.approx(412.1e3, abs=50)
    p, d, q, z = returned(surface, -1e6, 3e5, 2e5, 1e5)
    assert p == pytest.approx(-apex, rel=1e-12)
    # At the apex only the hydrostatic stress is left; c cos(phi) - apex sin(phi) rounds to 1e-11 Pa.
    assert np.abs([d, q, z]).max() < ROUNDING


def test_at_the_apex_with_positive_z() -> None:
    # z > 0 relieves the plane (p_plane = p + z/2), so a small circle is still inside at the apex.
    surface = make_mohr_coulomb(150e3, math.radians(20))
    result = returned(surface, -1e6, 1e3, 0.0, 1e5)
    assert excess(full_stress(*result), 150e3, math.radians(20)) <= ROUNDING


@settings(max_examples=100)
@given(p=stresses, d=stresses, q=stresses, z=stresses, cohesion=cohesions)
def test_without_friction(p: float, d: float, q: float, z: float, cohesion: float) -> None:
    surface = make_mohr_coulomb(cohesion, 0.0)
    p_after, d_after, q_after, _ = returned(surface, p, d, q, z)
    assert p_after == p, "no apex without friction"
    assert math.hypot(d_after, q_after) == pytest.approx(min(math.hypot(d, q), cohesion), rel=1e-12)


@settings(max_examples=100)
@given(p=stresses, d=stresses, q=stresses, z=stresses, degrees=angles)
def test_without_cohesion(p: float, d: float, q: float, z: float, degrees: float) -> None:
    angle = math.radians(degrees)
    surface = make_mohr_coulomb(0.0, angle)
    after = returned(surface, p, d, q, z)
    assert after[0] == max(p, 0.0), "the apex is at zero"
    assert excess(full_stress(*after), 0.0, angle) <= ROUNDING


def test_without_any_strength() -> None:
    surface = make_mohr_coulomb(0.0, 0.0)
    assert returned(surface, -1e5, 1e3, 2e3, 3e3) == (0.0, 0.0, 0.0, 0.0)
    assert returned(surface, 1e5, 1e3, 2e3, 3e3) == (1e5, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("limit", "expected"), [(0.0, 0.0), (30e3, -30e3), (1e9, -150e3 / math.tan(math.radians(20)))])
def test_tension_limit(limit: float, expected: float) -> None:
    # A cut-off applies only where it is nearer than the apex.
    surface = make_mohr_coulomb(150e3, math.radians(20), limit)
    assert limit_tension(surface, -1e6) == pytest.approx(expected, rel=1e-12)
    assert limit_tension(surface, 5e4) == 5e4


def test_strength_and_demand_by_hand() -> None:
    # c = 100 kPa, phi = 30 degrees: c cos = 86.6025 kPa, sin = 0.5.
    surface = make_mohr_coulomb(100e3, math.radians(30))
    assert strength(surface, 40e3) == pytest.approx(106.6025e3, rel=1e-6)
    assert strength(surface, -1e6) == 0.0
    assert shear_demand(surface, Deviator(30e3, -40e3, 20e3)) == pytest.approx(50e3 - 5e3, rel=1e-12)
    assert return_factor(surface, 40e3, Deviator(180e3, -240e3, 0.0)) == pytest.approx(106.6025 / 300, rel=1e-6)
