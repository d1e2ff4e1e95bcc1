"""The smoothing kernels by their mathematics."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sph.scene.schema import make_scene
from sph.solver.physics.kernels import central_value, evaluate, make_kernel, support

KERNELS = ("cubic_spline", "wendland_c2")
LENGTHS = (0.7, 2.3)


def profile(name: str, h: float, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """W and W'/r at distances r."""
    kernel = make_kernel(name, h)
    values = np.array([evaluate(kernel, float(distance)) for distance in r])
    return values[:, 0], values[:, 1]


@pytest.mark.parametrize("h", LENGTHS)
@pytest.mark.parametrize("name", KERNELS)
def test_the_value_at_the_centre(name: str, h: float) -> None:
    assert central_value(make_kernel(name, h)) == pytest.approx(profile(name, h, np.zeros(1))[0][0], rel=1e-14)


@pytest.mark.parametrize("h", LENGTHS)
@pytest.mark.parametrize("name", KERNELS)
def test_integral_over_the_plane_is_one(name: str, h: float) -> None:
    # Both kernels are polynomials of degree <= 6 in r (times r) on [0, h] and [h, 2h]: Gauss-Legendre
    # with 8 nodes a piece is exact, so only rounding is left.
    nodes, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for low, high in ((0.0, h), (h, 2 * h)):
        r = 0.5 * (high - low) * nodes + 0.5 * (high + low)
        total += 0.5 * (high - low) * float(weights @ (2 * math.pi * r * profile(name, h, r)[0]))
    assert total == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("name", KERNELS)
def test_sum_over_a_fine_lattice_is_one(name: str) -> None:
    # The same integral in Cartesian form, without using radial symmetry; the midpoint rule with 100
    # points across the support is good to 1e-5 for a function that ends smoothly.
    h = 1.0
    step = 2 * h / 50
    grid = (np.arange(-50, 50) + 0.5) * step
    x, y = np.meshgrid(grid, grid)
    total = step**2 * profile(name, h, np.hypot(x, y).ravel())[0].sum()
    assert total == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("h", LENGTHS)
@pytest.mark.parametrize("name", KERNELS)
def test_derivative_against_central_differences(name: str, h: float) -> None:
    # Truncation (d/h)^2 W''' with d = 1e-4 h is about 1e-8 of W'; at q = 1 the cubic's third derivative
    # jumps, hence 1e-6.
    r = np.linspace(0.02, 2.2, 110) * h
    d = 1e-4 * h
    slope = (profile(name, h, r + d)[0] - profile(name, h, r - d)[0]) / (2 * d)
    scale = np.abs(slope).max()
    np.testing.assert_allclose(profile(name, h, r)[1] * r, slope, rtol=0, atol=1e-6 * scale)


@pytest.mark.parametrize("h", LENGTHS)
@pytest.mark.parametrize("name", KERNELS)
def test_positive_inside_zero_outside_and_falling(name: str, h: float) -> None:
    inside = np.linspace(1e-6, 1.999, 200) * h
    value, slope = profile(name, h, inside)
    assert np.all(value > 0)
    assert np.all(slope < 0)
    assert np.all(np.diff(value) < 0)
    outside = np.array([2.0, 2.0 + 1e-12, 2.5, 100.0]) * h
    for values in profile(name, h, outside):
        assert np.all(values == 0.0)


@pytest.mark.parametrize("name", KERNELS)
def test_finite_at_zero_distance(name: str) -> None:
    value, slope = evaluate(make_kernel(name, 1.3), 0.0)
    assert math.isfinite(value) and value > 0
    assert math.isfinite(slope)


def test_cubic_spline_by_hand() -> None:
    # sigma = 10 / (7 pi h^2); W(h) = sigma / 4; W'(h) = -3 sigma / (4 h); W'(1.5 h) = -3 sigma / (16 h).
    h = 2.0
    sigma = 10 / (7 * math.pi * h**2)
    value, slope = profile("cubic_spline", h, np.array([h, 1.5 * h]))
    np.testing.assert_allclose(value, [sigma / 4, sigma / 32], rtol=1e-14)
    np.testing.assert_allclose(slope * [h, 1.5 * h], [-0.75 * sigma / h, -0.1875 * sigma / h], rtol=1e-14)


@pytest.mark.parametrize(("reading", "ends_at"), [("half_support", 4.6), ("support", 2.3)])
def test_both_readings_of_the_smoothing_length(reading: str, ends_at: float) -> None:
    numerics = {"spacing": 1.0, "smoothing_ratio": 2.3, "smoothing_length_is": reading}
    scene = make_scene({"scheme": "paper", "name": "k", "geometry": {"shape": "slope"}, "numerics": numerics})
    kernel = make_kernel(scene.numerics.kernel, scene.numerics.smoothing_length)
    assert support(kernel) == pytest.approx(ends_at, rel=1e-14)
    assert evaluate(kernel, ends_at * 0.999)[0] > 0
    assert evaluate(kernel, ends_at * 1.001)[0] == 0
