"""Lines from the crest edge down to the ground."""

from __future__ import annotations

import math

import pytest

from sph.measures.mobility import line_runout
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
