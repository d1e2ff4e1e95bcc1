"""Lines from the crest edge down to the ground."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from synthetic import synthetic, translation

from sph.measures.metrics import measure
from sph.measures.mobility import line_runout, residual_tangent
from sph.scene.ground_line import GroundLine


def ground(*points: tuple[float, float]) -> GroundLine:
    return GroundLine(shape="ground_line", points=points, base=-5.0, toe_at=(20.0, 0.0), crest_at=(40.0, 10.0))


def test_a_line_ends_where_it_first_meets_the_ground() -> None:
    plain = ground((0.0, 0.0), (20.0, 0.0), (40.0, 10.0), (60.0, 10.0))
    assert line_runout(plain, 1.0) == 0.0, "steeper than the slope: the point stops at the crest edge"
    assert line_runout(plain, 0.4) == pytest.approx(5.0), "10 m over 25 m"
    assert line_runout(plain, 0.1) == pytest.approx(80.0), "beyond the model the ground is level"
    assert math.isnan(line_runout(plain, math.nan))
    bank = ground((0.0, 8.0), (10.0, 8.0), (12.0, 0.0), (20.0, 0.0), (40.0, 10.0), (60.0, 10.0))
    assert line_runout(bank, 0.25) == pytest.approx(20.0 - 48.0 / 4.25), (
        "it meets the far bank, 4 (12 m - x), where that is as high as x / 4"
    )


def test_water_at_the_base_of_the_mass_flattens_the_energy_line() -> None:
    """By hand, for ten columns behind the crest down to the toe's level: tan of the residual angle times 1 - u / (rho g 25 m)."""

    def tangent(rise: float = 0.0, **water: Any) -> float:
        run = synthetic(overrides={"water": {"pressure": "by_place", **water}} if water else {})
        (crest, _), (_, toe) = run.scene.geometry.crest, run.scene.geometry.toe
        x, y = (run[name][run.soil] for name in ("x0", "y0"))
        if rise:
            ratio = np.zeros(run["x"].shape)
            ratio[3] = rise  # of one frame: what counts is the largest
            run.trajectory["pore_pressure_ratio"] = run.trajectory["x"].dims, ratio
        return residual_tangent(run, (crest < x) & (x < crest + 10.0) & (y > toe))

    scene = synthetic().scene
    toe, dry = scene.geometry.toe[1], math.tan(math.radians(scene.materials[0].residual[1]))
    weight = scene.soil.density * scene.gravity.acceleration * 25.0
    wet = 1.0 - 9810.0 * 8.0 / weight
    assert tangent() == pytest.approx(dry) and tangent(level=toe - 1.0) == pytest.approx(dry)
    assert tangent(r_u=0.3) == pytest.approx(0.7 * dry)
    assert tangent(level=toe + 8.0) == pytest.approx(wet * dry, rel=1e-6)
    assert tangent(level=toe + 40.0) == pytest.approx(dry), "all of it under standing water"
    assert tangent(level=toe + 8.0, rise=0.6) == pytest.approx(0.4 * wet * dry, rel=1e-6)


@pytest.mark.parametrize("settled", [0.0, 0.6, 2.0])
def test_rock_that_settles_below_a_cover_does_not_change_its_energy_line(settled: float) -> None:
    """By hand: a slope of 20 m at 1 : 2 whose cover keeps 12 degrees goes 20 m / tan(12) = 94.1 m from its crest, 54.1 m beyond its toe.

    Below the cover rock that has failed, too, which keeps 33 degrees, moves by up to 2 m where the cover goes 30 m."""

    def field(_: Any, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        depth = np.interp(x, [30.0, 70.0], [5.0, 25.0]) - y
        cover = (depth < 3.0) & (y > 5.0) & (x < 75.0)
        return np.where(cover, -30.0, np.where(depth < 6.0, -settled, 0.0)), np.zeros(x.size)

    def strength(angle: float, residual: float) -> dict[str, float]:
        return {"friction_angle": angle, "residual_friction_angle": residual, "residual_cohesion": 0.0}

    run = synthetic(
        field,
        overrides={
            "geometry": {"shape": "slope", "slope_angle": math.degrees(math.atan(0.5)), "slope_height": 20.0, "base_depth": 5.0}
            | {"apron_length": 30.0, "crest_length": 30.0},
            "soil": strength(22.0, 12.0),
            "layers": {"rock": {"region": {"kind": "depth", "top": 3.0}, "soil": strength(36.0, 33.0)}},
        },
    )
    found = measure(run)
    assert found["energy_line_angle"] == pytest.approx(12.0)
    assert found["energy_line_runout"] == pytest.approx(20.0 / math.tan(math.radians(12.0)) - 40.0)


def test_a_block_has_the_energy_line_of_the_weak_layer_on_which_it_slides() -> None:
    """By hand: 10 degrees of the clay at the level of the toe, not the 15 of the sand that makes up most of the mass."""
    soil = {"friction_angle": 30.0, "residual_friction_angle": 15.0, "residual_cohesion": 0.0}
    clay = {"region": {"kind": "elevation", "top": 14.0, "bottom": 9.0}, "soil": {"friction_angle": 20.0, "residual_friction_angle": 10.0}}
    run = synthetic(translation(-3.0), overrides={"soil": soil, "layers": {"clay": clay}})
    assert measure(run)["energy_line_angle"] == pytest.approx(10.0)
