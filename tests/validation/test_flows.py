"""Laws of the columns of rods, and what is measured of a deposit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

from sph.experiments.validation.flows import aspect_ratio, reach_of_share, rods_height, rods_runout, thickness
from sph.experiments.validation.level import Result
from sph.scene.schema import make_scene
from sph.solver.particles import SOIL


def column_of(height: float) -> dict[str, Any]:
    """Scene of a column 0.1 m wide against the right wall of a box of 1 m."""
    points = [[0.9, 0.0], [1.0, 0.0], [1.0, height], [0.9, height]]
    return {
        "name": "column",
        "duration": 0.1,
        "scheme": "paper",
        "geometry": {"shape": "bodies", "width": 1.0, "height": 0.4, "bodies": [{"kind": "polygon", "points": points}]},
        "walls": {"base": "fixed", "sides": "free_slip"},
        "gravity": {"ramp": 0.01, "duration": 0.01},
        "numerics": {"spacing": 0.01, "smoothing_ratio": 1.3, "time_step": 1e-5},
    }


@pytest.mark.parametrize(
    ("ratio", "runout", "height"), [(1.0, 3.25, 0.7042), (1.5, 4.7966, 0.5374), (2.0, 6.3028, 0.4436), (3.0, 8.4739, 0.3386)]
)
def test_laws_of_rods(ratio: float, runout: float, height: float) -> None:
    scene = make_scene(column_of(0.1 * ratio))
    assert aspect_ratio(scene) == ratio
    assert rods_runout(aspect_ratio(scene)) == pytest.approx(runout, abs=1e-4)
    assert rods_height(aspect_ratio(scene)) == pytest.approx(height, abs=1e-4)


def test_reach_of_a_share_and_thickness_of_a_slab() -> None:
    spacing = 0.01
    scene = make_scene(column_of(0.1))
    x, y = (values.ravel() for values in np.meshgrid(1.0 - spacing * (np.arange(50) + 0.5), spacing * (np.arange(2) + 0.5)))
    data = xr.Dataset(
        {"kind": ("particle", np.full(x.size, SOIL)), "x": (("frame", "particle"), x[None]), "y": (("frame", "particle"), y[None])}
    )
    result = Result(scene, data)
    assert reach_of_share(result, 1.0) == pytest.approx(0.5)
    assert reach_of_share(result, 0.5) == pytest.approx(0.255, abs=0.006)
    distance, thick = thickness(result)
    np.testing.assert_allclose(thick[distance < 5.0], 0.2)
    assert not thick[distance > 5.0].any()
