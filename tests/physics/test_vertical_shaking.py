"""Vertical shaking: free fall in the frame of the box, its work, and soil at rest that weighs g + a."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from small_scenes import ABOVE_A_WALL, SceneBuilder

from sph.scene.schema import make_scene
from sph.solver.run import run
from sph.storage.trajectory import scene_of


def record(start: float, interval: float, x: list[float], y: list[float]) -> dict[str, Any]:
    return {"kind": "record", "start": start, "vertical": {}, "data": {"interval": interval, "x": x, "y": y}}


def test_a_free_block_stays_where_it_is_while_the_box_moves(free_block: SceneBuilder) -> None:
    # Nothing holds it, so relative to the box it falls with -a: after n kicks v = -n a dt, its way their sum; both axes alike.
    up, right, dt = 4.0, -3.0, 1e-4
    block = free_block(ABOVE_A_WALL | {"duration": 0.11, "damping.ratio": 0.0, "motion": record(0.01, 1.0, [right, right], [up, up])})
    ds = run(block).trajectory
    kicks = np.maximum(np.round(ds["sample_time"].values / dt) - 100, 0)
    way = 0.5 * kicks * (kicks + 1) * dt**2
    for axis, a in (("x", right), ("y", up)):
        np.testing.assert_allclose(ds[f"probe_velocity_{axis}"].values[:, 0], -a * kicks * dt, atol=1e-9)
        np.testing.assert_allclose(ds[f"probe_displacement_{axis}"].values[:, 0], -a * way, atol=1e-9)
    np.testing.assert_allclose(ds["ground_acceleration_y"].values, np.where(ds["sample_time"] > 0.01 - 1e-9, up, 0.0))
    np.testing.assert_allclose(ds["ground_acceleration"].values, np.where(ds["sample_time"] > 0.01 - 1e-9, right, 0.0))
    # All the work of the shaking is kinetic energy; the stress does none.
    np.testing.assert_allclose(ds["shaking_work"].values, ds["kinetic_energy"].values, rtol=1e-6, atol=1e-6)


@cache
def pressed(up: float) -> xr.Dataset:
    """A column on a fixed base, at rest, then in a box whose upward acceleration (m/s2) is brought on in 2 s and stays."""
    time = np.arange(0.0, 5.0, 0.01)
    motion = record(2.0, 0.01, [0.0] * time.size, (up * np.minimum(time / 2.0, 1.0)).tolist())
    scene = make_scene(
        {
            "scheme": "paper",
            "name": "column",
            "duration": 6.0,
            "geometry": {"shape": "block", "width": 6.0, "height": 10.0},
            "walls": {"base": "fixed", "sides": "free_slip", "layers": 3},
            "soil": {"density": 2000.0, "youngs_modulus": 1e5, "poisson_ratio": 0.3, "cohesion": 1e5},
            "gravity": {"ramp": 1.0, "duration": 2.0},
            "damping": {"ratio": 0.3, "frequencies": [3.0, 15.0]},
            "motion": motion,
            "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 5e-4},
        }
    )
    return run(scene).trajectory


BOTH_WAYS = pytest.mark.parametrize("up", [3.0, pytest.param(-3.0, marks=pytest.mark.long)])


@BOTH_WAYS
def test_soil_at_rest_weighs_g_and_the_acceleration(up: float) -> None:
    # Quasi-static: stresses grow in the ratio (g + a) / g, whatever the discretisation makes of them before.
    ds = pressed(up)
    assert scene_of(ds).motion.vertical is not None and ds.attrs["status"] == "unfailed"
    soil = (ds["kind"].values == 0) & (ds["y0"].values < 8.0)
    before, after = (-ds["stress_yy"].sel(frame=ds["time"].searchsorted(t - 1e-9)).values[soil].astype(float) for t in (2.0, 6.0))
    assert after.mean() / before.mean() == pytest.approx((9.81 + up) / 9.81, rel=0.01)
    depth = 10.0 - ds["y0"].values[soil]
    assert after.mean() == pytest.approx(2000.0 * (9.81 + up) * depth.mean(), rel=0.05)


@BOTH_WAYS
def test_the_energy_of_vertical_shaking_is_counted(up: float) -> None:
    # Heavier soil gives way downwards, lighter soil upwards: the shaking does work on both, and the budget closes to 2 % of the largest
    # energy.
    ds = pressed(up)
    stored = [float(ds[f"{name}_energy"][-1]) for name in ("kinetic", "elastic", "potential", "dissipated")]
    work = float(ds["shaking_work"][-1])
    assert work > 0.0
    assert abs(work - sum(stored)) < 0.02 * max(map(abs, [work, *stored]))
