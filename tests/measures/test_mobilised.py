"""Mobilised strength on stresses whose answer is known, and on soil that yields."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from synthetic import synthetic, translation

from sph.measures.fields import FIELDS
from sph.measures.metrics import measure
from sph.measures.mobilised import circles, mobilised, mobilised_by_layer
from sph.output.run import Run
from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import SOIL, place_particles
from sph.solver.run import run

COHESION, ANGLE = 10.0, 30.0
SEAM = {"seam": {"region": {"kind": "elevation", "bottom": 4.0, "top": 7.0}, "soil": {"cohesion": 5.0}}}
STRENGTH: dict[str, Any] = {"soil": {"cohesion": COHESION, "friction_angle": ANGLE}}


def stressed(xx: float, yy: float, xy: float, overrides: dict[str, Any] | None = None) -> Run:
    """A trajectory with one stress (kPa, compression positive) everywhere."""
    made = synthetic(translation(0.0), overrides=merge(STRENGTH, overrides or {}))
    for axes, value in (("xx", -xx), ("yy", -yy), ("xy", xy), ("zz", -xx)):
        made[f"stress_{axes}"][:] = 1e3 * value
    return made


def test_the_share_is_that_of_the_mohr_circle() -> None:
    # r = sqrt(15^2 + 20^2) = 25, r_y = 10 cos 30 + 45 / 2.
    share = 25.0 / (10.0 * math.cos(math.radians(30.0)) + 22.5)
    made = stressed(30.0, 60.0, 20.0)
    np.testing.assert_allclose(mobilised(made, 0), share, rtol=1e-6)
    np.testing.assert_allclose(mobilised(stressed(60.0, 30.0, -20.0), 0), share, rtol=1e-6)
    assert FIELDS["mobilised"].of is mobilised
    assert mobilised_by_layer(made, 0) == {"soil": pytest.approx(share, rel=1e-6)}
    assert measure(made)["mobilised_strength"] == pytest.approx(share, rel=1e-6)


def test_soil_at_the_active_limit_uses_all_and_soil_without_strength_too() -> None:
    active, root = 1 / 3, math.sqrt(1 / 3)
    np.testing.assert_allclose(mobilised(stressed(active * 100.0 - 2 * COHESION * root, 100.0, 0.0), 0), 1.0, rtol=1e-6)
    np.testing.assert_array_equal(mobilised(stressed(-50.0, -50.0, 0.0), 0), 1.0)


def test_each_layer_has_its_own_share_where_it_is_largest() -> None:
    made = stressed(50.0, 50.0, 10.0, {"layers": SEAM})
    scene = made.scene
    layer, x = place_particles(scene).layer, made["x0"]
    at_yield = 5.0 * math.cos(math.radians(30.0)) + 25.0
    below = (layer == 1) & (np.abs(x - 0.5 * (scene.geometry.toe[0] + scene.geometry.crest[0])) < 0.5 * scene.geometry.slope_height)
    made["stress_xy"][:, below] = 1e3 * 0.99 * at_yield
    single = np.flatnonzero((layer == 0) & (made["kind"] == SOIL))[100]
    made["stress_xy"][:, single] = 1e3 * 60.0
    shares = mobilised_by_layer(made, made.gravity_frame)
    assert shares["seam"] == pytest.approx(0.99, rel=1e-6)
    plain = 10.0 / (COHESION * math.cos(math.radians(ANGLE)) + 25.0)
    assert plain <= shares["soil"] < plain + 0.15, "one particle is no layer"
    assert measure(made)["mobilised_strength"] == shares["seam"]


BLOCK: dict[str, Any] = {
    "scheme": "paper",
    "name": "level",
    "duration": 0.5,
    "geometry": {"shape": "block", "width": 20.0, "height": 10.0},
    "walls": {"base": "fixed", "sides": "free_slip", "layers": 3},
    "soil": {"density": 2000.0, "youngs_modulus": 5e5, "poisson_ratio": 0.3, "cohesion": 0.0, "friction_angle": 30.0, "K0": 0.5},
    "gravity": {"duration": 0.5},
    "numerics": {"spacing": 0.5, "smoothing_ratio": 1.3, "time_step": 5e-4, "adaptive_step": {"courant": 0.8}},
    "outputs": {"frame_interval": 0.25},
}


def block(**settings: Any) -> Scene:
    return make_scene(merge(BLOCK, dotted(settings)))


def test_level_ground_uses_what_its_K0_asks_for() -> None:
    """(1 - K0) / ((1 + K0) sin(phi)): two thirds, whatever the depth; 2 % after the gravity stage, 1 % of the stress and as much of K0."""
    found = Run(run(block(), until="gravity").trajectory)
    for frame, tolerance in ((0, 1e-5), (-1, 0.02)):
        assert mobilised_by_layer(found, frame)["soil"] == pytest.approx(0.5 / (1.5 * 0.5), rel=tolerance)


def test_soil_beyond_its_strength_is_at_it() -> None:
    """Elastic soil of nu = 0.2 at rest has K0 = 0.25, below the active limit of 20 degrees: it yields, and none lies beyond the surface."""
    settled = {"gravity.ramp": 0.8, "gravity.duration": 1.0, "duration": 1.0}
    scene = block(**settled, **{"soil.K0": None, "soil.poisson_ratio": 0.2, "soil.friction_angle": 20.0})
    weak = Run(run(scene, until="gravity").trajectory)
    radius, at_yield = (of[weak.soil] for of in circles(weak, -1))
    assert np.all(radius <= at_yield * (1 + 1e-5) + 1.0)
    assert mobilised_by_layer(weak, -1)["soil"] == pytest.approx(1.0, abs=0.01)
