"""The elastic law by hand: pressure from the density, and a deviator that turns with the soil."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sph.solver.physics.elasticity import Deviator, Strain, deviator_square, elastic_rate, pressure, rotate

DEVIATOR = (3e4, -4e4)
"""(s_xx - s_yy) / 2 and s_xy, Pa."""


def tensor(d: float, q: float, z: float) -> np.ndarray:
    """Deviator as a matrix, Pa."""
    return np.array([[d - 0.5 * z, q, 0.0], [q, -d - 0.5 * z, 0.0], [0.0, 0.0, z]])


def test_pressure_is_that_of_the_change_of_volume() -> None:
    # K = 2 MPa, 2000 kg/m3 at rest: 1 % denser gives 20 kPa, half as dense -1 MPa, at rest nothing.
    assert pressure(2e6, 2020.0, 2000.0) == pytest.approx(20e3)
    assert pressure(2e6, 1000.0, 2000.0) == -1e6
    assert pressure(2e6, 2000.0, 2000.0) == 0.0


@pytest.mark.parametrize("angle", [0.01, -0.01, 0.3])
def test_a_turn_is_that_of_the_tensor(angle: float) -> None:
    # dv_x/dy > 0 turns clockwise, by atan(angle): R s R^T.
    d, q, _ = rotate(Deviator(*DEVIATOR, 1e4), angle)
    c, s = math.cos(math.atan(angle)), math.sin(math.atan(angle))
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(tensor(d, q, 1e4), turn @ tensor(*DEVIATOR, 1e4) @ turn.T, rtol=1e-12, atol=1e-9)
    assert math.hypot(d, q) == pytest.approx(5e4, rel=1e-14), "exact in norm"


def test_a_small_turn_is_the_jaumann_rate() -> None:
    # w = angle / dt: d' = 2 w q and q' = -2 w d, of an error of second order.
    d, q, _ = rotate(Deviator(*DEVIATOR, 1e4), 1e-6)
    assert (d - DEVIATOR[0]) / 1e-6 == pytest.approx(2 * DEVIATOR[1], rel=1e-5)
    assert (q - DEVIATOR[1]) / 1e-6 == pytest.approx(-2 * DEVIATOR[0], rel=1e-5)


def test_half_a_right_angle_turns_normal_into_shear_stress() -> None:
    # angle = 1 is a turn by 45 degrees, twice that of Mohr's circle.
    assert rotate(Deviator(*DEVIATOR, 1e4), 1.0) == pytest.approx((DEVIATOR[1], -DEVIATOR[0], 1e4))


def test_the_rate_is_two_g_times_the_deviatoric_strain_rate() -> None:
    strain = np.array([[2.0, 0.5, 0.0], [0.5, -1.0, 0.0], [0.0, 0.0, 0.0]])
    expected = 2.0 * 3e6 * (strain - np.eye(3) * np.trace(strain) / 3.0)
    rate = elastic_rate(3e6, Strain(2.0, -1.0, 0.5, 0.0, 1.0))
    np.testing.assert_allclose(tensor(*rate), expected, rtol=1e-14, atol=1e-8)
    assert deviator_square(rate) == pytest.approx((expected**2).sum())
