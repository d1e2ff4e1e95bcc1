"""Particles on a boundary, up to rounding: they belong to what is right of it or above it, in every shape, layer and survey."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sph.scene.schema import Scene, make_scene
from sph.solver.initial_state import initial_state
from sph.solver.particles import locate_probes, overburden, place_particles

STEEP = {"shape": "slope", "slope_angle": 45.0, "slope_height": 10.0, "base_depth": 10.0, "apron_length": 12.0, "crest_length": 12.0}
GROUND = [[0.0, 10.0], [12.0, 10.0], [22.0, 20.0], [34.0, 20.0]]
DRAWN = {
    "ground_line": {"shape": "ground_line", "points": GROUND, "base": 0.0},
    "bodies": {
        "shape": "bodies",
        "width": 34.0,
        "height": 20.0,
        "bodies": [{"kind": "polygon", "points": [[0.0, 0.0], [34.0, 0.0], *GROUND[::-1]]}],
    },
}
"""The slope in other words."""


def scene(geometry: dict[str, Any], spacing: float = 1.0, **sections: Any) -> Scene:
    return make_scene({"scheme": "paper", "name": "own", "geometry": geometry, "numerics": {"spacing": spacing}} | sections)


def assert_same_particles(one: Scene, other: Scene) -> None:
    for name, mine, theirs in zip(("x", "y", "kind", "mass", "layer"), place_particles(one), place_particles(other), strict=False):
        np.testing.assert_array_equal(mine, theirs, name)


# At 1 m the diagonal lies on the face; at 0.8 and 4 m a row lies on the apron, at 8 m on the crest.
@pytest.mark.parametrize("spacing", [0.5, 0.8, 1.0, 4.0, 8.0])
@pytest.mark.parametrize("drawn", DRAWN)
def test_one_slope_has_the_same_particles_however_it_is_drawn(drawn: str, spacing: float) -> None:
    assert_same_particles(scene(STEEP, spacing), scene(DRAWN[drawn], spacing))


def test_particles_on_a_face_are_soil_and_those_on_level_ground_are_not() -> None:
    particles = place_particles(scene(STEEP))
    assert particles.n_soil == 34 * 10 + 12 * 10 + 55
    coarse = place_particles(scene(STEEP, 4.0))
    assert coarse.y[: coarse.n_soil][coarse.x[: coarse.n_soil] < 12.0].max() == 6.0, "not the row at 10 m"


def test_a_block_and_a_polygon_of_its_size_have_the_same_particles() -> None:
    block = place_particles(scene({"shape": "block", "width": 5.5, "height": 4.5}))
    body = {"kind": "polygon", "points": [[0.0, 0.0], [5.5, 0.0], [5.5, 4.5], [0.0, 4.5]]}
    drawn = place_particles(scene({"shape": "bodies", "width": 20.0, "height": 10.0, "bodies": [body]}))
    assert block.n_soil == drawn.n_soil == 5 * 4
    np.testing.assert_array_equal(block.x[:20], drawn.x[:20])
    np.testing.assert_array_equal(block.y[:20], drawn.y[:20])


def surveyed(east: float, up: float, downhill: str, size: float = 1.0, **sections: Any) -> Scene:
    """A 45 degree slope with a cliff, and layers, all with particles on their boundaries, in a survey with its origin elsewhere."""
    turn = -size if downhill == "right" else size

    def places(points: list[list[float]]) -> list[list[float]]:
        return [[east + turn * x, up + size * y] for x, y in points]

    line = [[0.0, 10.0], [10.5, 10.0], [10.5, 12.0], [12.0, 12.0], [20.0, 20.0], [34.5, 20.0]]
    layers: dict[str, Any] = {
        "cover": {"region": {"kind": "depth", "bottom": 2.5 * size}},
        "seam": {"region": {"kind": "elevation", "bottom": up + 3.5 * size, "top": up + 5.5 * size}},
        "lens": {"region": {"kind": "polygon", "points": places([[5.5, 1.5], [9.5, 1.5], [13.5, 5.5], [5.5, 5.5]])}},
    }
    geometry = {"shape": "ground_line", "points": places(line), "base": up, "downhill": downhill}
    return scene(geometry, size, layers=layers, probes={"A": "crest_edge", "P": places([[25.0, 15.0]])[0]}, **sections)


SHIFTS = [(0.1, 0.1), (-7.3, 431.7), (1e6 + 0.1, 0.3), (512345.7, 2345.6), (-3300000.1, 2.8e3 + 0.7)]


@pytest.mark.parametrize("size", [1.0, 0.3])
@pytest.mark.parametrize("downhill", ["left", "right"])
@pytest.mark.parametrize("shift", SHIFTS)
def test_where_a_survey_begins_and_which_way_it_looks_changes_no_particle(shift: tuple[float, float], downhill: str, size: float) -> None:
    here, there = surveyed(0.0, 0.0, "left", size), surveyed(*shift, downhill, size)
    assert np.bincount(place_particles(here).layer).tolist() == np.bincount(place_particles(surveyed(0.0, 0.0, "left")).layer).tolist()
    assert here.lattice == there.lattice
    assert_same_particles(here, there)
    assert locate_probes(here, place_particles(here)) == locate_probes(there, place_particles(there))
    particles = place_particles(here)
    over = [overburden(other, particles.x, particles.y) for other in (here, there)]
    np.testing.assert_allclose(over[0], over[1], rtol=1e-5, atol=1e-3)


def test_rows_on_the_bounds_of_layers() -> None:
    # Level ground at 10 m: the rows at 7.5 and 5.5 m lie on bounds, and belong to what is above them, by depth as by elevation.
    level = {"shape": "block", "width": 6.0, "height": 10.0}
    regions = {"depth": {"kind": "depth", "top": 2.5, "bottom": 4.5}, "elevation": {"kind": "elevation", "bottom": 5.5, "top": 7.5}}
    regions["polygon"] = {"kind": "polygon", "points": [[-1.0, 5.5], [7.0, 5.5], [7.0, 7.5], [-1.0, 7.5]]}  # type: ignore[dict-item]
    for kind, region in regions.items():
        made = place_particles(scene(level, layers={"seam": {"region": region}}))
        assert set(made.y[: made.n_soil][made.layer[: made.n_soil] == 1]) == {5.5, 6.5}, kind


@pytest.mark.parametrize("region", [{"kind": "depth"}, {"kind": "elevation", "top": 10.0}])
def test_walls_above_the_ground_go_on_as_the_soil_below_it(region: dict[str, Any]) -> None:
    geometry = {"shape": "ground_line", "points": GROUND, "base": 0.0}
    particles = place_particles(scene(geometry, layers={"fill": {"region": region}}))
    beside = (particles.x < 0.0) & (particles.kind == 2)
    assert particles.y[beside].max() > 10.0
    assert set(particles.layer[beside]) == {1}


@pytest.mark.parametrize("downhill", ["left", "right"])
def test_initial_velocities_lie_and_point_as_the_survey_does(downhill: str) -> None:
    turn = -1.0 if downhill == "right" else 1.0
    at = sorted((500.0 + turn * 10.0, 500.0 + turn * 20.0))
    table = {"along": "x", "position": at, "x": [1.0, 3.0], "y": [0.0, 4.0]}
    made = surveyed(500.0, 300.0, downhill, initial_velocity=table)
    particles = place_particles(made)
    state = initial_state(particles, made)
    soil = slice(0, particles.n_soil)
    x, _ = made.geometry.in_survey(particles.x[soil], particles.y[soil])
    np.testing.assert_allclose(turn * state.vx[soil], np.interp(x, at, [1.0, 3.0]))
    np.testing.assert_allclose(state.vy[soil], np.interp(x, at, [0.0, 4.0]))
    high = made.model_copy(update={"initial_velocity": made.initial_velocity.model_copy(update={"along": "y", "position": (305.0, 310.0)})})  # type: ignore[union-attr]
    y = particles.y[soil] + 300.0
    np.testing.assert_allclose(turn * initial_state(particles, high).vx[soil], np.interp(y, (305.0, 310.0), [1.0, 3.0]))
