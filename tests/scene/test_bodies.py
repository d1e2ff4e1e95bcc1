"""Bodies of any shape: what lies inside, how the box around them is filled, their surface, toe and crest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sph.scene.geometry import Bodies, PolygonBody, RingBody
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import BASE, SIDE, SOIL, TOP, Particles, locate_probes, place_particles

Point = tuple[float, float]


def polygon(*points: Sequence[float]) -> dict[str, Any]:
    return {"kind": "polygon", "points": points}


def ring(centre: Sequence[float], outer: float, inner: float = 0.0) -> dict[str, Any]:
    return {"kind": "ring", "centre": centre, "outer_radius": outer, "inner_radius": inner}


def scene(*bodies: dict[str, Any], spacing: float = 0.5, **sections: Any) -> Scene:
    """Bodies in a box of 20 by 10 m; the free-slip walls that a test may ask for need two layers at h = 1.3 spacings."""
    geometry = {"shape": "bodies", "width": 20.0, "height": 10.0, "bodies": list(bodies)}
    numerics = {"spacing": spacing, "smoothing_ratio": 1.3}
    return make_scene({"scheme": "paper", "name": "bodies", "geometry": geometry, "numerics": numerics} | sections)


def geometry(*bodies: dict[str, Any]) -> Bodies:
    found = scene(*bodies).geometry
    assert isinstance(found, Bodies)
    return found


def soil(particles: Particles) -> tuple[np.ndarray, np.ndarray]:
    return particles.x[: particles.n_soil], particles.y[: particles.n_soil]


# ---------------------------------------------------------------- inside


def test_a_rectangle_between_lattice_lines_holds_its_cells() -> None:
    # Corners on cell borders: exactly the cells within, wherever in the box, and none twice where two bodies overlap.
    left, right = polygon((2, 1), (5, 1), (5, 4), (2, 4)), polygon((4, 2), (8, 2), (8, 3), (4, 3))
    particles = place_particles(scene(left, right))
    x, y = soil(particles)
    expected = {(c, r) for c in range(4, 10) for r in range(2, 8)} | {(c, r) for c in range(8, 16) for r in (4, 5)}
    assert set(zip((x // 0.5).astype(int), (y // 0.5).astype(int), strict=True)) == expected
    assert particles.n_soil == len(expected)


def test_a_concave_body_by_hand() -> None:
    # An L with arms one cell thick, its corners in either turning direction: five cells and four.
    corners = [(0.0, 0.0), (2.5, 0.0), (2.5, 0.5), (0.5, 0.5), (0.5, 2.5), (0.0, 2.5)]
    for points in (corners, corners[::-1], corners[3:] + corners[:3]):
        x, y = soil(place_particles(scene(polygon(*points))))
        cells = set(zip((x // 0.5).astype(int), (y // 0.5).astype(int), strict=True))
        assert cells == {(c, 0) for c in range(5)} | {(0, r) for r in range(5)}


@given(
    angles=st.lists(st.floats(0.0, 2 * math.pi), min_size=3, max_size=9, unique=True),
    radii=st.lists(st.floats(0.5, 4.5), min_size=9, max_size=9),
)
def test_area_of_star_shaped_bodies(angles: list[float], radii: list[float]) -> None:
    # Slanted and concave outlines about (10, 5), area by the shoelace formula.  A lattice cell differs from its centre's verdict only
    # if the outline crosses it, and an outline of length L meets at most 3 (L / dx + n) + 1 cells; half a cell each on average.
    points = [(10 + r * math.cos(a), 5 + r * math.sin(a)) for a, r in zip(sorted(angles), radii, strict=False)]
    x, y = np.transpose(points)
    area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    length = np.hypot(x - np.roll(x, -1), y - np.roll(y, -1)).sum()
    dx = 0.1
    column, row = np.meshgrid(np.arange(200), np.arange(100))
    inside = PolygonBody(points=tuple(points)).contains((column + 0.5) * dx, (row + 0.5) * dx)
    assert abs(np.count_nonzero(inside) * dx**2 - area) <= dx**2 * (3 * (length / dx + len(points)) + 1)


@given(cut=st.integers(1, 199), slant=st.floats(-3.0, 3.0), dx=st.sampled_from([0.1, 0.25, 0.5]))
def test_two_bodies_with_a_common_side_share_no_particle(cut: int, slant: float, dx: float) -> None:
    # A box cut in two by a slanted line: every place belongs to one part, also those on the line (a half cell offset meets it often).
    # Rounding may leave a place within 1e-12 of the line to neither or both: those are left out.
    top, bottom = 0.1 * cut + slant, 0.1 * cut
    assume(0 < top < 20)
    left = PolygonBody(points=((0.0, 0.0), (bottom, 0.0), (top, 10.0), (0.0, 10.0)))
    right = PolygonBody(points=((20.0, 0.0), (20.0, 10.0), (top, 10.0), (bottom, 0.0)))
    x, y = (a.ravel() for a in np.meshgrid(np.arange(dx / 2, 20, dx), np.arange(dx / 2, 10, dx)))
    clear = np.abs(x - bottom - y / 10 * (top - bottom)) > 1e-12
    assert np.array_equal((left.contains(x, y) ^ right.contains(x, y))[clear], np.ones(np.count_nonzero(clear), bool))


def test_area_of_a_ring() -> None:
    # pi (R^2 - r^2); a cell is wrong only where a circle crosses it: within dx of 2 pi (R + r), here far below half of that.
    dx, outer, inner = 0.1, 3.0, 2.0
    particles = place_particles(scene(ring((7.0, 5.0), outer, inner), spacing=dx))
    x, y = soil(particles)
    r = np.hypot(x - 7.0, y - 5.0)
    assert r.min() >= inner and r.max() < outer
    area = math.pi * (outer**2 - inner**2)
    assert abs(particles.n_soil * dx**2 - area) < 0.1 * dx * 2 * math.pi * (outer + inner)


def test_a_disc_holds_its_centre() -> None:
    # A centre on the lattice: five cells within 0.6 m (the centre and its four neighbours at 0.5 m), symmetric.
    x, y = soil(place_particles(scene(ring((5.25, 5.25), 0.6))))
    cells = set(zip((x // 0.5).astype(int), (y // 0.5).astype(int), strict=True))
    assert cells == {(10, 10), (9, 10), (11, 10), (10, 9), (10, 11)}


def test_bodies_without_a_particle_are_refused() -> None:
    with pytest.raises(ValueError, match=r"geometry: .*numerics\.spacing: 0\.5 m"):
        place_particles(scene(polygon((1.3, 1.3), (1.7, 1.3), (1.7, 1.7), (1.3, 1.7))))


# ---------------------------------------------------------------- surface, toe, crest


def height_at(body: Bodies, x: float) -> float:
    return float(np.interp(x, *body.surface))


def test_surface_of_a_block_beside_nothing() -> None:
    # Steps at its sides, height 0 beside it; 1e-6 of the box beside a corner is outside the step (its ends are 1e-9 apart).
    body = geometry(polygon((4, 0), (8, 0), (8, 3), (4, 3)))
    for x, height in ((0, 0), (4 - 2e-5, 0), (4 + 2e-5, 3), (6, 3), (8 - 2e-5, 3), (8 + 2e-5, 0), (20, 0)):
        assert height_at(body, x) == pytest.approx(height, abs=1e-9), x
    xs, _ = body.surface
    assert xs[0] == 0.0 and xs[-1] == 20.0 and all(a < b for a, b in zip(xs, xs[1:], strict=False))


def test_surface_of_an_overhang_is_its_upper_side() -> None:
    # A mushroom: cap from x = 2 to 8 between 3 and 4 m, stem below; and a body that hangs in the air above nothing.
    mushroom = polygon((4, 0), (6, 0), (6, 3), (8, 3), (8, 4), (2, 4), (2, 3), (4, 3))
    floating = polygon((10, 6), (12, 6), (12, 8))
    body = geometry(mushroom, floating)
    for x, height in ((3, 4), (5, 4), (7, 4), (9, 0), (10.5, 6.5), (11.5, 7.5), (13, 0)):
        assert height_at(body, x) == pytest.approx(height), x


def test_surface_where_two_bodies_cross() -> None:
    # Two triangles of height 4 that meet at (5, 2), which is a corner of neither: a valley, not a ridge's straight line.
    body = geometry(polygon((0, 0), (6, 0), (3, 4)), polygon((4, 0), (10, 0), (7, 4)))
    for x, height in ((3, 4), (4, 4 - 4 / 3), (5, 4 - 8 / 3), (6, 4 - 4 / 3), (7, 4), (10.5, 0)):
        assert height_at(body, x) == pytest.approx(height, abs=1e-6), x


def test_surface_of_a_ring() -> None:
    # Its upper half circle; 180 chords lie within R (1 - cos(1 degree)) = 1.5e-4 R of it (vertically more near the ends).
    body = geometry(ring((10, 5), 3.0, 2.0))
    for x in (8.5, 10.0, 11.0):
        assert height_at(body, x) == pytest.approx(5 + math.sqrt(9 - (x - 10) ** 2), abs=1e-3)


def test_toe_and_crest() -> None:
    # Lowest and highest corner, the leftmost of several, over all bodies.
    body = geometry(polygon((4, 1), (8, 1), (8, 3), (4, 3)), polygon((9, 1), (11, 1), (11, 3)))
    assert body.toe == (4, 1)
    assert body.crest == (4, 3)
    circle = geometry(ring((10, 5), 3.0))
    assert circle.toe == pytest.approx((10, 2))
    assert circle.crest == pytest.approx((10, 8))


def test_probes_on_bodies() -> None:
    body = scene(polygon((4, 1), (8, 1), (8, 3), (4, 3)), ring((14, 5), 2.0, 1.0), probes={"A": "crest_edge", "B": "toe", "C": [8.0, 3.0]})
    particles = place_particles(body)
    at = {name: (particles.x[i], particles.y[i]) for name, i in locate_probes(body, particles).items()}
    assert at["A"] in {(13.75, 6.75), (14.25, 6.75)}
    assert at["B"] == (4.25, 1.25)
    assert at["C"] == (7.75, 2.75)
    hole = scene(ring((10, 5), 4.0, 3.0), probes={"A": [10.0, 5.0]})
    with pytest.raises(ValueError, match=r"probes\.A: \(10, 5\) m .*3.* m"):
        locate_probes(hole, place_particles(hole))


def test_inner_and_outer_circle_of_a_ring() -> None:
    # Tiling rings: a place on the circle between two of them belongs to the outer one only.
    inner, outer = (RingBody(kind="ring", centre=(0, 0), outer_radius=b, inner_radius=a) for a, b in ((0, 1), (1, 2)))
    x, y = np.array([0.0, 1.0, 2.0]), np.zeros(3)
    assert inner.contains(x, y).tolist() == [True, False, False]
    assert outer.contains(x, y).tolist() == [False, True, False]


# ---------------------------------------------------------------- the box

BLOCK = polygon((0, 0), (20, 0), (20, 4), (0, 4))
WALLS = [(base, top, sides) for base in ("fixed", "no_slip", "free_slip", "none") for top in ("fixed", "free_slip", "none") for sides in
         ("fixed", "no_slip", "free_slip", "periodic", "none")]  # fmt: skip


@pytest.mark.parametrize(("base", "top", "sides"), WALLS)
def test_order_and_number_of_wall_particles(base: str, top: str, sides: str) -> None:
    """Soil, fixed, no-slip, free-slip base and top, free-slip sides; 40 columns, 20 rows, 2 layers; corners only beside side walls."""
    p = place_particles(scene(BLOCK, walls={"base": base, "top": top, "sides": sides}))
    overhang = 2 if sides in ("fixed", "no_slip", "free_slip") else 0
    plate, wall = 2 * (40 + 2 * overhang), 2 * 2 * 20
    expected = {SOIL: 40 * 8, BASE: plate * (base != "none"), TOP: plate * (top != "none"), SIDE: wall * (overhang > 0)}
    assert {kind: np.count_nonzero(p.kind == kind) for kind in expected} == expected
    assert np.all(p.kind[: p.n_soil] == SOIL)
    how = {BASE: base, TOP: top, SIDE: sides}
    assert all(how[kind] == "fixed" for kind in p.kind[p.n_soil : p.first_no_slip])
    assert all(how[kind] == "no_slip" for kind in p.kind[p.first_no_slip : p.first_slip])
    assert all(how[kind] == "free_slip" and kind != SIDE for kind in p.kind[p.first_slip : p.first_slip_side])
    assert all(how[kind] == "free_slip" and kind == SIDE for kind in p.kind[p.first_slip_side :])
    # No place is taken twice, and the walls lie outside the box: below, above and beside it.
    assert len(set(zip(p.x.round(6), p.y.round(6), strict=True))) == p.x.size
    assert np.all(p.y[p.kind == BASE] < 0) and np.all(p.y[p.kind == TOP] > 10)
    beside = p.x[p.kind == SIDE]
    assert np.all((beside < 0) | (beside > 20))
    if not overhang:
        assert p.x.min() > 0 and p.x.max() < 20, "nothing may reach into the next period"
