"""Slopes that stand well and are hardly shaken do not move: strength that is lost by slip is not lost by one particle at yield."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from cases.limit_analysis import stability_number
from sph.measures.metrics import measure
from sph.scene.gravity import GRAVITY
from sph.scene.schema import make_scene
from sph.solver.run import run

pytestmark = pytest.mark.long

HARDLY = 0.002 * GRAVITY
"""Amplitude (m/s2): a hundredth of the yield acceleration of a slope with a factor of safety of 1.3 or more."""


def slope(seed: int, factor: float | None = None) -> dict[str, Any]:
    """A slope of soft to stiff soil, gentle to steep, low to high, with a factor of safety by limit analysis, drawn from 1.3 to 2."""
    draw = np.random.default_rng(seed)
    angle, height = float(draw.uniform(25.0, 65.0)), float(draw.uniform(6.0, 40.0))
    friction, density = float(draw.uniform(0.0, min(35.0, angle - 3.0))), float(draw.uniform(1700.0, 2200.0))
    drawn, weight = float(draw.uniform(1.3, 2.0)), density * GRAVITY
    wanted = drawn if factor is None else factor
    divided = math.degrees(math.atan(math.tan(math.radians(friction)) / wanted))
    cohesion = weight * height * wanted / stability_number(angle, divided, 0.4)
    return {
        "name": f"slope{seed}",
        "duration": 16.0,
        "gravity": {"ramp": 2.0, "duration": 7.0, "damping": 10.0},  # soft soil takes seconds to settle
        "geometry": {
            "shape": "slope",
            "slope_angle": angle,
            "slope_height": height,
            "base_depth": 0.4 * height,
            "apron_length": 1.5 * height,
            "crest_length": 2.0 * height,
        },
        "walls": {"base": "no_slip", "sides": "absorbing"},
        "soil": {
            "density": density,
            "youngs_modulus": 1e-3 * weight * height * float(10.0 ** draw.uniform(2.3, 3.7)),
            "poisson_ratio": float(draw.uniform(0.2, 0.42)),
            "cohesion": 1e-3 * cohesion,
            "friction_angle": friction,
            "viscosity": 2.0,
        },
        "coupling": {
            "S_R": float(draw.uniform(0.1, 0.6)),
            "softening": {"slip_at_peak": 1e-3, "slip_at_residual": float(10.0 ** draw.uniform(-1.7, -0.7)), "width": 0.4 * height},
        },
        "damping": {"ratio": 0.1, "frequencies": [0.3, 5.0]},  # so that elastic vibrations have died out at the end
        "motion": {
            "kind": "tapered_sine",
            "amplitude": HARDLY,
            "frequency": 1.5,
            "start": 7.0,
            "ramp": 0.5,
            "decay_start": 10.0,
            "end": 10.5,
        },
        "outputs": {"frame_interval": 4.0, "series_interval": 0.01},
    }


@pytest.mark.parametrize(("seed", "rows"), [(1, 8), (0, 8), (0, 14), (3, 14), (5, 8), (10, 14)])
def test_a_slope_that_stands_well_and_is_hardly_shaken_does_not_move(seed: int, rows: int) -> None:
    # A's permanent displacement, a millimetre at most, at every spacing.
    data = slope(seed)
    result = run(make_scene(data | {"numerics": {"spacing": data["geometry"]["slope_height"] / rows}}))
    found = measure(result.trajectory)
    print(
        f"slope {seed}, {rows} rows: {1e3 * found['displacement_magnitude']:.3f} mm, {found['failed_fraction']:.1%} failed, {result.status}"
    )
    assert found["displacement_magnitude"] < 1e-3


@pytest.mark.parametrize(("seed", "rows"), [(0, 8), (3, 14)])
def test_a_slope_that_yields_as_gravity_is_brought_on_has_not_failed(seed: int, rows: int) -> None:
    """Factor of safety 1.2: soil yields in the gravity stage, but its slip counts from the end; A moves by less than half a millimetre."""
    data = slope(seed, 1.2)
    made = make_scene(data | {"numerics": {"spacing": data["geometry"]["slope_height"] / rows}})
    restart = run(made, until="gravity").restart
    assert restart is not None and restart["plastic_strain"].values.any()
    result = run(made)
    found = measure(result.trajectory)
    print(f"slope {seed}, {rows} rows: {1e3 * found['displacement_magnitude']:.3f} mm, {result.status}")
    assert result.status == "unfailed" and found["displacement_magnitude"] < 5e-4


@pytest.mark.parametrize(("seed", "stiffer", "rows"), [(0, 1.0, 8), (0, 1.0, 12), (0, 0.1, 8), (0, 10.0, 8), (1, 10.0, 8)])
def test_such_a_slope_that_the_clock_brings_down_has_failed_unshaken(seed: int, stiffer: float, rows: int) -> None:
    """With strength that is lost by time it collapses, whatever its stiffness and the spacing; not by the shaking."""
    data = slope(seed)
    soil = data["soil"] | {"youngs_modulus": stiffer * data["soil"]["youngs_modulus"]}
    clock = {"soil": soil, "coupling": {"S_R": data["coupling"]["S_R"], "gamma": 100.0}}
    result = run(make_scene(data | clock | {"numerics": {"spacing": data["geometry"]["slope_height"] / rows}}))
    found = measure(result.trajectory)
    assert found["displacement_magnitude"] > 0.01 * data["geometry"]["slope_height"]
    assert result.status == "failed_unshaken" and "shaken by less than" in result.trajectory.attrs["status_reason"]
