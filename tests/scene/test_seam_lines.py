"""Seams of a scene: where a line lies, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.scene.seams import Seam

SLOPE: dict[str, Any] = {"scheme": "paper", "name": "s", "geometry": {"shape": "slope"}}
LINE = {"points": [[0.0, 5.0], [103.0, 5.0]], "cohesion": 10.0, "friction_angle": 12.0}


def scene(**changes: Any) -> Scene:
    return make_scene(merge(SLOPE, {"seams": {"clay": LINE | changes}}))


def test_offsets_from_a_line_with_a_bend() -> None:
    # Along x to (10, 0), then upwards at 45 degrees.  Left is above; beyond the ends nothing is near; at the outside of the bend the
    # corner is the nearest point, and the side is that of both parts.
    line = Seam.model_validate(LINE | {"points": [[0.0, 0.0], [10.0, 0.0], [20.0, 10.0]]})
    offset, direction = line.offset(np.array([5.0, 5.0, -1.0, 15.0, 11.0, 22.0]), np.array([2.0, -3.0, 1.0, 6.0, -2.0, 9.0]))
    np.testing.assert_allclose(offset, [2.0, -3.0, math.inf, math.sqrt(0.5), -math.sqrt(5.0), math.inf])
    np.testing.assert_allclose(direction[:2], 0.0)
    assert direction[3] == pytest.approx(math.pi / 4)


def test_the_height_of_a_line_under_places() -> None:
    # From (0, 0) to (10, 0), back over itself to (5, 4), and on to (20, 4).
    line = Seam.model_validate(LINE | {"points": [[0.0, 0.0], [10.0, 0.0], [5.0, 4.0], [20.0, 4.0]]})
    under = line.under(np.array([2.0, 2.0, 7.5, 7.5, 7.5, 15.0, 21.0, -1.0]), np.array([1.0, -1.0, 1.0, 3.0, 5.0, 9.0, 9.0, 9.0]))
    np.testing.assert_allclose(under, [0.0, -math.inf, 0.0, 2.0, 4.0, 4.0, -math.inf, -math.inf])


def test_the_length_of_a_seam_is_that_in_the_soil() -> None:
    assert scene().length_in_soil(scene().seams["clay"]) == pytest.approx(103.0, rel=0.01)
    beyond = scene(points=[[-100.0, 5.0], [300.0, 5.0]])
    assert beyond.length_in_soil(beyond.seams["clay"]) == pytest.approx(beyond.geometry.width, rel=0.03)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"residual_cohesion": 11.0, "slip_at_residual": 0.1}, "residual_cohesion: 11 .*cohesion: 10"),
        ({"residual_friction_angle": 8.0}, "residual_friction_angle: 8 needs slip_at_residual"),
        ({"slip_at_residual": 0.1}, "slip_at_residual: 0.1 m needs residual_cohesion"),
        ({"slip_at_residual": 0.1, "slip_at_peak": 0.1, "residual_cohesion": 1.0}, "slip_at_residual: 0.1 m, must be more than"),
        ({"points": [[0.0, 5.0], [0.0, 5.0], [9.0, 5.0]]}, r"points.1: \[0.0, 5.0\] m"),
        ({"points": [[0.0, 80.0], [100.0, 80.0]]}, "seams.clay.points: .*outside"),
        ({"thickness": 0.0}, "seams.clay.thickness"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        scene(**changes)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"numerics.gradient_correction": {"min_determinant": 0.3}}, "numerics.gradient_correction: .*null"),
        ({"prescribed_velocity_gradient": {"xy": 1.0}}, "prescribed_velocity_gradient: "),
    ],
)
def test_what_takes_both_sides_for_one_body_is_refused(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        make_scene(merge(SLOPE, {"seams": {"clay": LINE}} | dotted(changes)))


def test_a_seam_is_stored_and_read_again() -> None:
    one = scene(thickness=0.4, slip_at_residual=0.1, residual_cohesion=0.0)
    assert make_scene(one.model_dump(mode="json")) == one
    assert one.seams["clay"].peak == (10e3, pytest.approx(math.tan(math.radians(12.0))))
    assert one.seams["clay"].residual == (0.0, pytest.approx(math.tan(math.radians(12.0))))
