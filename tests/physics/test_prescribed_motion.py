"""A prescribed velocity gradient: the exact homogeneous stress, and a work that is found again as energy.

With gradients corrected and renewed every step the discrete motion is known in closed form: x(n + 1) = (1 + L dt) x(n), and the
stress sees the velocities L x(n) at the places x(n + 1), a gradient L' = L (1 + L dt)^-1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.run import run

pytestmark = pytest.mark.uncompiled

ELEMENT: dict[str, Any] = {
    "scheme": "paper",
    "name": "element",
    "duration": 0.1,
    "geometry": {"shape": "block", "width": 0.3, "height": 0.3},
    "walls": {"base": "none", "sides": "none"},
    "soil": {"density": 2000.0, "youngs_modulus": 1e4, "poisson_ratio": 0.3, "cohesion": 1e5},
    "coupling": {"solid_after_failure": "elastic_plastic"},
    "damping": None,
    "gravity": {"ramp": 0.0, "duration": 0.01, "damping": 0.0, "acceleration": 0.0},
    "numerics": {
        "spacing": 0.1,
        "smoothing_ratio": 1.3,
        "time_step": 5e-4,
        "gradient_tolerance": 0.0,
        "precision": "double",
        "gradient_correction": {"min_determinant": 0.1},
        "artificial_viscosity": None,
        "short_range_repulsion": None,
    },
    "outputs": {"frame_interval": 0.01, "series_interval": 5e-4},
    "probes": {},
}
DT, STEPS = 5e-4, 200
COMPONENTS = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")


def element(gradient: dict[str, float], overrides: dict[str, Any] | None = None) -> tuple[Scene, xr.Dataset]:
    scene = make_scene(merge(ELEMENT, dotted({"prescribed_velocity_gradient": gradient} | (overrides or {}))))
    return scene, run(scene).trajectory


def stress(ds: xr.Dataset, frame: int = -1) -> np.ndarray:
    """xx, yy, zz, xy of a frame (Pa), the same for all particles to the precision of the file."""
    fields = np.array([ds[name].values[frame] for name in COMPONENTS], float)
    assert np.ptp(fields, axis=1).max() <= 4e-7 * max(np.abs(fields).max(), 1.0)
    return fields.mean(axis=1)


def uniaxial(scene: Scene, rate: float) -> np.ndarray:
    """Stress after ``STEPS`` steps of stretching along x at ``rate`` (1/s): pressure by the density, deviator by the sum of L' dt."""
    strain = STEPS * rate * DT / (1 + rate * DT)
    pressure = scene.soil.bulk_modulus_si * ((1 + rate * DT) ** -STEPS - 1)
    shear = scene.soil.shear_modulus_si
    return np.array([-pressure + 4 / 3 * shear * strain, -pressure - 2 / 3 * shear * strain, -pressure - 2 / 3 * shear * strain, 0.0])


@pytest.mark.parametrize("rate", [0.5, -0.5])
def test_uniaxial_stretching(rate: float) -> None:
    # 5 %, in tension and compression, at edges and corners as inside: to the single precision of the frames.
    scene, ds = element({"xx": rate})
    np.testing.assert_allclose(stress(ds), uniaxial(scene, rate), rtol=1e-6, atol=1e-3)
    # Homogeneous: x grows by (1 + L dt)^n, y not at all.
    np.testing.assert_allclose(ds["x"].values[-1], ds["x0"].values * (1 + rate * DT) ** STEPS, rtol=1e-6)
    assert not ds["displacement_y"].values.any()


def test_stretching_along_y_is_that_along_x_turned() -> None:
    scene, ds = element({"yy": 0.5})
    np.testing.assert_allclose(stress(ds), uniaxial(scene, 0.5)[[1, 0, 2, 3]], rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("component", ["xy", "yx"])
def test_simple_shear(component: str) -> None:
    # Jaumann: sigma_xy = G sin(g), sigma_xx = -sigma_yy = +-G (1 - cos g), no pressure (L^2 = 0 makes L' = L).  A step turns the
    # stress before it and not its own increment, which leaves the normal stresses behind by half a step, G g * rate dt / 2.
    scene, ds = element({component: 0.7})
    g, modulus = 0.7 * 0.1, scene.soil.shear_modulus_si
    sign = 1 if component == "xy" else -1
    xx, yy, zz, xy = stress(ds)
    assert xy == pytest.approx(modulus * math.sin(g), rel=2e-5)
    assert sign * xx == pytest.approx(modulus * (1 - math.cos(g)) - modulus * g * 0.7 * DT / 2, rel=1e-4)
    assert yy == pytest.approx(-xx, rel=1e-6) and abs(zz) < 1e-3


# ---------------------------------------------------------------- start and energy


def test_a_confined_test_starts_from_its_confinement() -> None:
    # Neither strain nor work nor speed at time 0, the stress as given; at the end the stress of the pressure plus that of the strain,
    # of which the pressure follows from the density, (1 + p / K) (1 + L dt)^-n.
    scene, ds = element({"xx": 0.5}, {"gravity.initial_stress": {"pressure": 100.0}})
    np.testing.assert_allclose(stress(ds, 0), [-100e3, -100e3, -100e3, 0.0], rtol=1e-6, atol=1e-3)
    for name in ("displacement_x", "displacement_y", "velocity_x"):
        assert not ds[name].values[0].any(), name
    assert ds["shaking_work"].values[0] == 0.0 and ds["dissipated_energy"].values[0] == 0.0
    shrink = (1 + 0.5 * DT) ** -STEPS
    expected = uniaxial(scene, 0.5) - np.array([100e3, 100e3, 100e3, 0.0]) * shrink
    np.testing.assert_allclose(stress(ds), expected, rtol=1e-6, atol=0.1)


def test_an_initial_velocity_does_not_move_confined_soil_before_the_start() -> None:
    moving = {"along": "x", "position": [0.0], "x": [1.0], "y": [0.0]}
    _, ds = element({}, {"gravity.initial_stress": {"pressure": 100.0}, "initial_velocity": moving})
    assert not ds["displacement_x"].values[0].any()
    assert np.all(ds["velocity_x"].values[0] == 1.0)


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize(
    "gradient",
    [
        pytest.param({"xx": 0.5}, marks=pytest.mark.long),
        pytest.param({"xy": 0.7}, marks=pytest.mark.long),
        {"xx": -0.3, "xy": 0.2, "yy": 0.4},
    ],
    ids=str,
)
def test_the_work_is_found_again(gradient: dict[str, float], damping: float) -> None:
    # Kinetic + elastic + dissipated = work, but for the last half step's work (velocities lag); mass damping, with 20 1/s for the
    # whole run, takes energy that the motion has to supply, exactly.
    _, ds = element(gradient, {"gravity.damping": damping, "gravity.duration": 0.1})
    work = ds["shaking_work"].values
    stored = sum(ds[f"{name}_energy"].values for name in ("kinetic", "elastic", "dissipated"))
    last_half = 0.5 * (work[-1] - work[-2])
    print(f"{gradient}: {stored[-1] - work[-1]:.3f} of {work[-1]:.1f} J/m, half a step's work {last_half:.3f}")
    assert work[-1] > 9.0
    assert stored[-1] - work[-1] == pytest.approx(last_half, rel=0.05)
    assert np.all(np.diff(work)[1:] > 0)
