"""Drained soil: buoyancy and seepage by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import place_particles
from sph.solver.physics.seepage import with_seepage
from sph.solver.terms import make_terms, wanted_terms

pytestmark = pytest.mark.uncompiled

DENSITY, G = 2000.0, 9.81
SLOPE: dict[str, Any] = {
    "name": "slope",
    "scheme": "paper",
    "duration": 5.0,
    "geometry": {
        "shape": "slope",
        "slope_angle": 45.0,
        "slope_height": 10.0,
        "base_depth": 10.0,
        "apron_length": 10.0,
        "crest_length": 10.0,
    },
    "soil": {"density": DENSITY},
}


def build(changes: dict[str, Any]) -> Scene:
    return make_scene(merge(SLOPE, changes))


def force(scene: Scene, x: float, y: float) -> np.ndarray:
    """Force of the water on a cubic metre of soil at a place, N."""
    particles = place_particles(scene)
    term = make_terms(scene, particles).seepage
    return DENSITY * np.array(with_seepage(term, x, y, particles.mass[0], G, 0.0, 0.0))


def test_buoyancy_under_a_level() -> None:
    scene = build({"water": {"pressure": "by_place", "level": 15.0}})
    for y, share in ((0.5, 1.0), (14.5, 1.0), (15.5, 0.0), (18.5, 0.0)):
        np.testing.assert_allclose(force(scene, 28.5, y), [0.0, share * 9810.0], atol=1e-6)
    # Before the slope the water stands above the ground, and soil that comes there floats in it.
    np.testing.assert_allclose(force(scene, 2.5, 12.5), [0.0, 9810.0], atol=1e-6)


def test_a_level_through_the_cells_floats_their_part() -> None:
    scene = build({"water": {"pressure": "by_place", "level": 5.3}})
    np.testing.assert_allclose(force(scene, 28.5, 5.5), [0.0, 0.3 * 9810.0], rtol=1e-9, atol=1e-6)


def test_seepage_runs_down_the_line() -> None:
    # A line that falls by 1 in 5 to the toe drives the soil with gamma_w / 5 and floats it with gamma_w.
    scene = build({"water": {"pressure": "by_place", "points": [[0.0, 4.0], [40.0, 12.0]], "unit_weight": 10.0}})
    np.testing.assert_allclose(force(scene, 20.5, 3.5), [-2000.0, 10000.0], rtol=1e-9)


def test_a_ratio_is_of_the_weight_above() -> None:
    # u = r_u gamma (y_ground - y): vertically r_u gamma, and r_u gamma times the ground's gradient towards the toe.
    scene = build({"water": {"pressure": "by_place", "r_u": 0.25}})
    weight = 0.25 * DENSITY * G
    np.testing.assert_allclose(force(scene, 34.5, 5.5), [0.0, weight], atol=1e-2)
    np.testing.assert_allclose(force(scene, 15.5, 5.5), [-weight, weight], rtol=1e-3)
    np.testing.assert_allclose(force(scene, 5.5, 12.5), [0.0, 0.0], atol=1e-6)


def test_a_ratio_by_layer() -> None:
    # Above 5 m r_u = 0, below it 0.5: the pressure of the lower layer presses it up over the cell at the interface.
    layer = {"region": {"kind": "elevation", "top": 5.0}, "r_u": 0.5}
    scene = build({"water": {"pressure": "by_place", "r_u": 0.0}, "layers": {"wet": layer}})
    np.testing.assert_allclose(force(scene, 34.5, 8.5), [0.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(force(scene, 34.5, 2.5), [0.0, 0.5 * DENSITY * G], rtol=1e-6)
    above = sum(force(scene, 34.5, y + 0.5)[1] for y in range(4, 20))
    assert above == pytest.approx(0.5 * DENSITY * G * 16.0, rel=1e-6), "all of the pressure at 4 m is found again above it"


def test_absent_without_water_and_for_carried_pressure() -> None:
    particles = place_particles(build({}))
    for water, held in (
        (None, None),
        ({"pressure": "carried", "r_u": 0.2}, "pore_pressure"),
        ({"pressure": "by_place", "r_u": 0.2}, "seepage"),
    ):
        scene = build({"water": water})
        terms, wanted = make_terms(scene, particles), wanted_terms(scene)
        for name in ("seepage", "pore_pressure"):
            assert (getattr(terms, name) is not None) == wanted[name] == (name == held)
