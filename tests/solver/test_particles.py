"""Particle counts, walls and probes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from sph.scene.configuration import dotted, merge
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.particles import BASE, SIDE, SOIL, Particles, locate_probes, place_particles

PAPER = Path(__file__).parents[2] / "config" / "scenes" / "paper.yaml"


def paper(**overrides: object) -> Scene:
    return load_scene(PAPER, dotted({name.replace("__", "."): value for name, value in overrides.items()}))


def cells(particles: Particles, spacing: float, kinds: tuple[int, ...]) -> set[tuple[int, int]]:
    """Lattice cells (column, row) of the particles of some kinds."""
    chosen = np.isin(particles.kind, kinds)
    column = np.floor(particles.x[chosen] / spacing).astype(int)
    row = np.floor(particles.y[chosen] / spacing).astype(int)
    return set(zip(column.tolist(), row.tolist(), strict=True))


def test_the_paper_scene_has_the_papers_number_of_particles() -> None:
    particles = place_particles(paper())
    assert particles.x.size == 2404
    assert particles.n_soil == 2050
    assert np.all(particles.kind[:2050] == SOIL), "soil comes first"
    assert len(cells(particles, 1.0, (SOIL, BASE, SIDE))) == 2404, "two particles in one place"


def test_crest_edge_probe() -> None:
    # Crest edge at 55 + 25 / tan 60 = 69.434 m, 35 m.  In the top row (34.5 m) the face is at
    # 55 + 24.5 / tan 60 = 69.145 m: the first particle right of it is at 69.5 m.
    scene = paper()
    particles = place_particles(scene)
    a = locate_probes(scene, particles)["A"]
    assert (particles.x[a], particles.y[a]) == (69.5, 34.5)
    assert particles.kind[a] == SOIL


def test_probes_by_place_and_by_coordinates() -> None:
    scene = paper(probes={"A": "crest_edge", "toe": "toe", "middle": [80.2, 20.1]})
    particles = place_particles(scene)
    found = locate_probes(scene, particles)
    assert list(found) == ["A", "toe", "middle"]
    assert (particles.x[found["middle"]], particles.y[found["middle"]]) == (80.5, 20.5)
    assert math.hypot(particles.x[found["toe"]] - 55, particles.y[found["toe"]] - 10) < 0.75


def test_walls_surround_the_soil_without_a_gap() -> None:
    scene = paper()
    particles = place_particles(scene)
    columns, rows = 103, 35
    expected_base = {(c, r) for c in range(-2, columns + 2) for r in (-1, -2)}
    expected_sides = {(c, r) for c in (-1, -2, columns, columns + 1) for r in range(rows)}
    assert cells(particles, 1.0, (BASE,)) == expected_base
    assert cells(particles, 1.0, (SIDE,)) == expected_sides
    soil = cells(particles, 1.0, (SOIL,))
    assert min(c for c, _ in soil) == 0 and max(c for c, _ in soil) == columns - 1
    assert min(r for _, r in soil) == 0 and max(r for _, r in soil) == rows - 1


@pytest.mark.parametrize("layers", [1, 3])
def test_number_of_wall_layers(layers: int) -> None:
    particles = place_particles(paper(walls__layers=layers))
    assert np.count_nonzero(particles.kind == BASE) == layers * (103 + 2 * layers)
    assert np.count_nonzero(particles.kind == SIDE) == 2 * layers * 35
    assert particles.n_soil == 2050


def test_absent_walls() -> None:
    free = place_particles(paper(walls={"base": "none", "sides": "none"}))
    assert free.x.size == free.n_soil == 2050
    no_base = place_particles(paper(walls__base="none"))
    assert not np.any(no_base.kind == BASE) and np.any(no_base.kind == SIDE)
    no_sides = place_particles(paper(walls__sides="none"))
    assert not np.any(no_sides.kind == SIDE)
    assert cells(no_sides, 1.0, (BASE,)) == {(c, r) for c in range(103) for r in (-1, -2)}


@pytest.mark.parametrize("spacing", [0.5, 0.8, 2.0, 2.5, 5.0])
def test_other_spacings_conserve_the_area(spacing: float) -> None:
    scene = paper(numerics__spacing=spacing, numerics__time_step=1e-4)
    geometry = scene.geometry
    run = geometry.slope_height / math.tan(math.radians(geometry.slope_angle))
    exact = geometry.base_depth * geometry.width + geometry.slope_height * (geometry.crest_length + 0.5 * run)
    n_soil = place_particles(scene).n_soil
    # A lattice cuts every edge within half a spacing; only the right side, the top and the face are cut.
    edges = geometry.height + geometry.crest_length + math.hypot(run, geometry.slope_height) + geometry.apron_length
    assert abs(n_soil * spacing**2 - exact) <= 0.5 * spacing * edges


def test_mass_is_density_times_cell() -> None:
    particles = place_particles(paper(numerics__spacing=2.0, soil__density=2000.0))
    assert np.all(particles.mass == 8000.0)


def test_block_fills_its_rectangle() -> None:
    block = {"scheme": "paper", "name": "b", "geometry": {"shape": "block", "width": 6.0, "height": 4.0}, "numerics": {"spacing": 0.5}}
    particles = place_particles(make_scene(merge(block, {})))
    assert cells(particles, 0.5, (SOIL,)) == {(c, r) for c in range(12) for r in range(8)}


def test_the_lattice_can_be_shifted_under_the_shape_of_the_soil() -> None:
    # The face is at 69.145 m in the top row (34.5 m), and at 68.568 m in that below: particles at 69.5 and 68.5 m are asked 0.4 m beside.
    edges = {}
    for shift in (-0.4, 0.0, 0.4):
        particles = place_particles(paper(numerics__lattice_shift=shift))
        soil = particles.kind == SOIL
        edges[shift] = [particles.x[soil & (particles.y == y)].min() for y in (34.5, 33.5)]
        assert soil.sum() == pytest.approx(2050, abs=25), "the area is the same but for a part of a column of the slope's height"
        np.testing.assert_allclose((particles.x - 0.5) % 1.0, 0.0, atol=1e-9)
    assert edges == {-0.4: [70.5, 69.5], 0.0: [69.5, 69.5], 0.4: [69.5, 68.5]}
