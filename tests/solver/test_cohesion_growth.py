"""Cohesion of particles whose strength grows with depth, by hand, and what must not change it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.solver.initial_stress import soils_at_greatest_stress
from sph.solver.particles import peak_strength, place_particles
from sph.solver.terms import make_terms
from sph.stability.standing import divided_strength, weakened

pytestmark = pytest.mark.uncompiled

GROUND: dict[str, Any] = {
    "name": "clay",
    "scheme": "paper",
    "duration": 1.0,
    "geometry": {"shape": "ground_line", "points": [[100.0, 50.0], [110.0, 50.0], [130.0, 60.0], [150.0, 60.0]], "base": 40.0},
    "soil": {"undrained_strength": {"at_top": 20.0, "gradient": 1.5}},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "numerics": {"spacing": 0.5, "time_step": 1e-3},
}
"""A slope of 1 : 2, 10 m high, in the coordinates of a survey."""
SHIFT = 1e-3
"""kPa, by which a cohesion differs since particles are asked for to the right of and above their place (``sph.scene.places``)."""


def scene(**changes: Any) -> Scene:
    return make_scene(merge(GROUND, changes))


def cohesion(made: Scene, x: float, y: float) -> float:
    """Peak cohesion (kPa) of the particle at a place of the survey."""
    particles = place_particles(made)
    inside = slice(0, particles.n_soil)
    px, py = made.geometry.in_survey(particles.x[inside], particles.y[inside])
    nearest = int(np.argmin(np.hypot(px - x, py - y)))
    assert (px[nearest], py[nearest]) == (pytest.approx(x), pytest.approx(y)), "a place where there is a particle"
    return float(1e-3 * peak_strength(made, particles)[0, nearest])


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [
        (105.25, 49.25, 20.0 + 1.5 * 0.75),  # before the toe: ground at 50
        (120.25, 50.25, 20.0 + 1.5 * 4.875),  # under the face: ground at 50 + 10.25 / 2
        (145.25, 40.25, 20.0 + 1.5 * 19.75),  # behind the crest: ground at 60
    ],
)
def test_depth_is_vertical_below_the_ground(x: float, y: float, expected: float) -> None:
    assert cohesion(scene(), x, y) == pytest.approx(expected, abs=SHIFT)


def test_depth_below_a_datum_is_that_of_the_ground_before_a_cut() -> None:
    cut = scene(soil={"undrained_strength": {"datum": 58.0}})
    assert cohesion(cut, 105.25, 49.25) == pytest.approx(20.0 + 1.5 * 8.75, abs=SHIFT)
    assert cohesion(cut, 145.25, 59.25) == pytest.approx(20.0, abs=1e-12), "nothing is weaker than at the datum"


@pytest.mark.parametrize(
    ("region", "top"),
    [
        ({"kind": "depth", "top": 3.0}, 55.125 - 3.0),
        ({"kind": "elevation", "top": 53.0}, 53.0),
        ({"kind": "elevation"}, 55.125),
        ({"kind": "elevation", "top": 58.0}, 55.125),
        ({"kind": "polygon", "points": [[110.0, 40.0], [140.0, 40.0], [140.0, 56.0], [110.0, 50.0]]}, 50.0 + 10.25 * 6.0 / 30.0),
        ({"kind": "polygon", "points": [[90.0, 30.0], [160.0, 30.0], [160.0, 80.0], [90.0, 80.0]]}, 55.125),
    ],
    ids=["depth", "elevation", "to the ground", "cut by the ground", "polygon", "polygon about the ground"],
)
def test_in_a_layer_it_counts_from_its_upper_side(region: dict[str, Any], top: float) -> None:
    layers = {"clay": {"region": region, "soil": {"undrained_strength": {"at_top": 8.0, "gradient": 2.0}}, "S_R": 0.5}}
    made = scene(soil={"undrained_strength": 90.0}, layers=layers)
    assert cohesion(made, 120.25, 48.25) == pytest.approx(8.0 + 2.0 * (top - 48.25), abs=SHIFT)


@pytest.mark.parametrize(
    ("region", "top"),
    [
        ({"kind": "elevation", "bottom": 52.0}, 52.0),
        ({"kind": "elevation", "bottom": 56.0}, 55.125),  # above the ground here
        ({"kind": "depth", "bottom": 2.3}, 55.125 - 2.3),
        ({"kind": "polygon", "points": [[110.0, 50.0], [130.0, 50.0], [130.0, 61.0], [110.0, 61.0]]}, 50.0),
        ({"kind": "depth", "top": 2.0, "bottom": 3.0}, 55.125),
    ],
    ids=["fill", "fill elsewhere", "crust", "fill by a polygon", "a band within the soil"],
)
def test_below_a_layer_it_counts_from_the_top_of_the_soil_itself(region: dict[str, Any], top: float) -> None:
    made = scene(layers={"other": {"region": region, "soil": {"undrained_strength": 50.0}}})
    assert cohesion(made, 120.25, 48.25) == pytest.approx(20.0 + 1.5 * (top - 48.25), abs=SHIFT)


def test_below_two_layers_it_counts_from_the_lower_side_of_the_lower() -> None:
    regions = {"fill": {"kind": "elevation", "bottom": 53.0}, "crust": {"kind": "elevation", "top": 53.0, "bottom": 51.0}}
    made = scene(layers={name: {"region": region, "soil": {"undrained_strength": 50.0}} for name, region in regions.items()})
    assert cohesion(made, 120.25, 48.25) == pytest.approx(20.0 + 1.5 * (51.0 - 48.25), abs=SHIFT)


def test_a_polygon_with_a_gap_counts_from_the_side_next_above() -> None:
    points = [[110.0, 42.0], [140.0, 42.0], [140.0, 50.0], [115.0, 50.0], [115.0, 46.0], [135.0, 46.0], [135.0, 44.0], [110.0, 44.0]]
    made = scene(
        soil={"undrained_strength": 90.0},
        layers={
            "clay": {"region": {"kind": "polygon", "points": points}, "soil": {"undrained_strength": {"at_top": 8.0, "gradient": 2.0}}}
        },
    )
    assert cohesion(made, 120.25, 43.25) == pytest.approx(8.0 + 2.0 * 0.75, abs=SHIFT)
    assert cohesion(made, 120.25, 48.25) == pytest.approx(8.0 + 2.0 * 1.75, abs=SHIFT)


def test_each_particle_has_its_own_row_of_peak_and_residual_strength() -> None:
    made = scene(coupling={"S_R": 0.4})
    particles = place_particles(made)
    layers = make_terms(made, particles).layers
    strength = peak_strength(made, particles)[0]
    assert strength.max() - strength.min() > 25e3
    assert layers.table[layers.layer, 2] == pytest.approx(strength), "c cos(phi) of the solid state"
    assert layers.table[layers.layer, 5] == pytest.approx(0.4 * strength), "and of the fluid state"


def test_a_growth_of_zero_is_the_constant_to_the_bit() -> None:
    constant, level = scene(soil={"undrained_strength": 20.0}), scene(soil={"undrained_strength": {"gradient": 0.0}})
    written = make_scene(merge(constant.model_dump(), {"soil": {"cohesion_growth": {"gradient": 0.0}}}))
    for made in (level, written):
        particles = place_particles(made)
        assert (peak_strength(made, particles) == peak_strength(constant, particles)).all()
        assert make_terms(made, particles).layers is None, "the compiled code is that of one soil"


def test_a_datum_at_level_ground_is_that_ground() -> None:
    by_ground = scene(geometry={"points": [[100.0, 60.0], [150.0, 60.0], [150.2, 60.2], [151.0, 60.2]]})
    by_datum = merge(by_ground.model_dump(), {"soil": {"cohesion_growth": {"datum": 60.0}}})
    particles = place_particles(by_ground)
    left = particles.x < 49.0
    difference = peak_strength(by_ground, particles)[0] - peak_strength(make_scene(by_datum), particles)[0]
    assert np.abs(difference[left]).max() < 1e-6 * 20e3


def test_strength_reduction_divides_the_growth_and_weakening_keeps_its_share() -> None:
    made, particles = scene(), place_particles(scene())
    peak = peak_strength(made, particles)[0]
    assert peak_strength(divided_strength(made, 1.6), particles)[0] == pytest.approx(peak / 1.6, rel=1e-12)
    assert peak_strength(weakened(made, 0.3), particles)[0] == pytest.approx(0.3 * peak, rel=1e-12)
    residual = scene(soil={"residual_cohesion": 6.0})
    assert peak_strength(weakened(residual, 0.3), particles)[0] == pytest.approx(6e3), "a residual cohesion does not grow"


def test_a_random_field_multiplies_what_has_grown() -> None:
    pytest.importorskip("gstools")
    field = {"horizontal_length": 20.0, "vertical_length": 2.0}
    drawn = {"of": "soil.cohesion", "kind": "lognormal", "mean": 20.0, "cov": 0.3, "field": field}
    bare = {name: value for name, value in GROUND.items() if name != "soil"}
    soil, uncertain = {"cohesion": 20.0, "friction_angle": 0.0}, {"seed": 3, "variables": {"c": drawn}}
    growth = {"cohesion_growth": {"gradient": 1.5}}
    grown, constant = (make_scene(merge(bare, {"soil": soil | more, "uncertain": uncertain})) for more in (growth, {}))
    particles = place_particles(grown)
    ratio = peak_strength(constant, particles)[0] / 20e3
    assert ratio.std() > 0.1
    assert peak_strength(grown, particles)[0] == pytest.approx(ratio * peak_strength(scene(), particles)[0], rel=1e-12)


def test_at_rest_the_strength_at_the_greatest_stress_counts() -> None:
    made = scene()
    held, *_ = soils_at_greatest_stress(made, place_particles(made))
    assert held.cohesion == pytest.approx(20.0 + 1.5 * 19.75, abs=SHIFT) and held.gradient == 0.0
    weak = {"undrained_strength": {"at_top": 0.0, "gradient": 4.0}, "K0": 0.7}  # |1 - K0| rho g z <= 2 c = 8 z: rho g = 19.3
    assert make_scene(merge(GROUND, {"soil": weak, "gravity": {"initial_stress": "geostatic", "ramp": 0.0}})).soil.K0 == 0.7
