"""What is said of how soil loses its strength, by hand-computed numbers."""

from __future__ import annotations

import math
from typing import Any

import pytest

from sph.checks.loss import of_loss, slip_zone
from sph.checks.messages import words
from sph.scene.configuration import dotted, merge, read_scene
from sph.scene.schema import Scene, make_scene

CLAY = read_scene("config/scenes/stiff_clay.yaml")


def clay(**changes: Any) -> Scene:
    return make_scene(merge(CLAY, dotted(changes)))


def test_the_zone_by_hand() -> None:
    # G = 2e8 / 2.6 Pa, half the weight 0.5 * 1900 * 9.81 * 15 Pa; c falls from 20 to 6 kPa and tan(phi) from tan(25) to tan(7.5); 99 mm.
    scene = clay()
    lost = 14e3 + 0.5 * 1900 * 9.81 * 15 * (math.tan(math.radians(25)) - math.tan(math.radians(7.5)))
    assert slip_zone(scene, scene.materials[0]) == pytest.approx(2e8 / 2.6 * 0.099 / lost, rel=1e-9)
    whole = clay(**{"coupling.S_R": 1.0})
    assert math.isinf(slip_zone(whole, whole.materials[0]))


def test_a_short_zone_is_told_and_a_long_one_is_not() -> None:
    assert of_loss(clay()) == []
    (found,) = of_loss(clay(**{"coupling.softening.slip_at_residual": 0.01}))
    assert (found.code, found.severity) == ("progressive-failure", "warning") and words(found).measured.endswith(" m")
    brittle = {"layers": {"seam": {"region": {"kind": "depth", "top": 3.0}, "slip_at_residual": 0.01}}}
    (found,) = of_loss(make_scene(merge(CLAY, brittle)))
    assert "slip in seam" in words(found).what


def test_a_loss_by_time_is_a_note_and_beside_slip_a_warning() -> None:
    (by_time,) = of_loss(clay(**{"coupling.softening": None, "coupling.gamma": 100.0}))
    assert (by_time.code, by_time.severity) == ("lost-by-time", "note")
    (both,) = of_loss(clay(**{"coupling.gamma": 100.0}))
    assert (both.code, both.severity, words(both).key) == ("lost-by-time", "warning", "coupling.gamma")
    assert "0.03 s to lose 95 %" in words(both).measured
    paper = {"scheme": "paper", "walls.layers": 4, "coupling.softening": None, "coupling.gamma": 100.0}
    assert of_loss(clay(**paper)) == []
