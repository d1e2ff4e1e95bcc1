"""Soil that dilates: an element in simple shear at constant volume, which dilation puts under pressure."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge, read_scene
from sph.scene.schema import Scene, make_scene
from sph.solver.run import run
from sph.stability.standing import divided_strength, weakened

SHEARED = read_scene("config/scenes/validation/v13_simple_shear.yaml")


KEPT: dict[str, Any] = {
    "coupling.gamma": 0.0,
    "coupling.solid_after_failure": "elastic_plastic",
    "geometry.width": 3.0,
    "geometry.height": 3.0,
    "prescribed_velocity_gradient.xy": 0.025,
    "duration": 0.24,
}
"""Without a loss of strength; so few particles and steps that they need not be compiled."""


def scene(changes: dict[str, Any]) -> Scene:
    return make_scene(merge(SHEARED, dotted(KEPT | changes)))


def history(built: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shear strain, mean pressure and shear stress (Pa) of the element in the frames."""
    data = run(built).trajectory
    xx, yy, zz, xy = (data[f"stress_{name}"].values.astype(float).mean(axis=1) for name in ("xx", "yy", "zz", "xy"))
    return built.prescribed_velocity_gradient.xy * data["time"].values, -(xx + yy + zz) / 3.0, xy  # type: ignore[union-attr]


@pytest.mark.uncompiled
@pytest.mark.parametrize("dilation", [10.0, 20.0])
def test_pressure_rises_with_the_plastic_shear_strain(dilation: float) -> None:
    """d tau = sin(phi) dp, dp = K sin(psi) lambda, and lambda = d gamma - d tau / G: a straight line after yield."""
    built = scene({"soil.dilation_angle": dilation})
    soil = built.soil
    bulk, shear, phi, psi = soil.bulk_modulus_si, soil.shear_modulus_si, soil.friction_angle_si, math.radians(dilation)
    strain, pressure, tau = history(built)
    start = soil.cohesion_si * math.cos(phi) + 1e5 * math.sin(phi)
    plastic = np.maximum(strain - start / shear, 0.0)
    expected = 1e5 + bulk * math.sin(psi) * plastic / (1.0 + bulk * math.sin(phi) * math.sin(psi) / shear)
    np.testing.assert_allclose(pressure, expected, rtol=0.01)
    last = soil.cohesion_si * math.cos(phi) + pressure[-1] * math.sin(phi)
    assert tau[-1] == pytest.approx(last, rel=1e-3) and last > 2.0 * start, "the stress stays on the surface"


@pytest.mark.uncompiled
def test_without_dilation_the_pressure_stays() -> None:
    _, pressure, _ = history(scene({}))
    np.testing.assert_allclose(pressure, 1e5, rtol=1e-3)


def test_dilation_is_reduced_with_the_strength() -> None:
    built = scene({"soil.dilation_angle": 10.0})
    assert math.tan(math.radians(divided_strength(built, 2.0).soil.dilation_angle)) == pytest.approx(math.tan(math.radians(10.0)) / 2.0)
    assert weakened(built, 0.5).soil.dilation_angle == 5.0


def test_dilation_beyond_friction_is_refused() -> None:
    with pytest.raises(ValueError, match=r"dilation_angle: 21.0 .*friction_angle: 20.0"):
        scene({"soil.dilation_angle": 21.0})
