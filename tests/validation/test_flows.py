"""Laws of the columns of rods, and what is measured of a deposit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

from cases.case import Result
from cases.flows import aspect_ratio, reach_of_share, rods_height, rods_runout, thickness
from cases.rods import LINE, SURFACE, failure_line, foot_and_angle, reach, surface
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


def moved_column(spacing: float, foot: float, angle: float) -> Result:
    """A column 0.1 m wide and high against the wall at x = 1 m whose particles beyond a line have moved 2 mm from the wall."""
    x, y = (values.ravel() for values in np.meshgrid(1.0 - spacing * (np.arange(40) + 0.5), spacing * (np.arange(40) + 0.5)))
    slid = np.where(1.0 - x > foot - y / np.tan(np.radians(angle)), 2e-3, 0.0)
    data = xr.Dataset(
        {
            "kind": ("particle", np.full(x.size, SOIL)),
            "x0": ("particle", x),
            "y0": ("particle", y),
            "x": (("frame", "particle"), (x - slid)[None]),
            "y": (("frame", "particle"), y[None]),
        }
    )
    scene = column_of(0.1)
    scene["numerics"] = {**scene["numerics"], "spacing": spacing, "time_step": 1e-6}
    return Result(make_scene(scene), data)


def test_surface_and_line_of_failure_of_a_column() -> None:
    result = moved_column(0.0025, 0.09, 60.0)
    np.testing.assert_allclose(surface(result, np.array([0.01, 0.05, 0.2])), [0.1, 0.1, 0.0])
    found = failure_line(result)
    assert len(found) == 40
    foot, angle = foot_and_angle(found)
    assert foot == pytest.approx(0.09, abs=0.00125) and angle == pytest.approx(60.0, abs=1.0)


def test_what_the_test_with_rods_gives() -> None:
    """The points of the test lead to 0.179 m, 33 degrees and 0.43 m."""
    foot, angle = foot_and_angle(LINE)
    assert foot == pytest.approx(0.179, abs=5e-4) and angle == pytest.approx(33.0, abs=0.1)
    assert reach(*SURFACE.T) == pytest.approx(0.429, abs=0.002)
    assert reach(np.array([0.0, 0.1, 0.2]), np.array([0.1, 0.004, 0.0])) == pytest.approx(0.15)
    assert reach(np.array([0.0, 0.1]), np.array([0.1, 0.01])) == 0.1
