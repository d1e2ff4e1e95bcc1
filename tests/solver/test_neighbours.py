"""Neighbour lists against brute force, kernel gradients against hand-computed numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_scenes import some_terms

from sph.solver.boundaries.periodic import Periodic
from sph.solver.neighbours import Candidates, Pairs, Places, allocate_pairs, find_candidates, update_pairs
from sph.solver.physics.gradient_correction import GradientCorrection
from sph.solver.physics.kernels import evaluate, make_kernel

Cloud = tuple[np.ndarray, np.ndarray]

coordinate = st.floats(-50.0, 50.0, allow_nan=False, width=32)
seeds = st.integers(0, 2**32 - 1)


def random_cloud(seed: int, n: int) -> Cloud:
    x, y = np.random.default_rng(seed).uniform(-10, 10, (2, n))
    return x, y


def clustered_cloud(seed: int, n: int) -> Cloud:
    generator = np.random.default_rng(seed)
    centre = generator.uniform(-100, 100, (4, 2))[generator.integers(0, 4, n)]
    x, y = (centre + generator.normal(0, 0.5, (n, 2))).T.copy()
    return x, y


def collinear_cloud(seed: int, n: int) -> Cloud:
    generator = np.random.default_rng(seed)
    along = generator.uniform(-20, 20, n)
    angle = generator.choice([0.0, math.pi / 2, 0.3])
    return along * math.cos(angle), along * math.sin(angle)


def coincident_cloud(seed: int, n: int) -> Cloud:
    generator = np.random.default_rng(seed)
    x, y = (generator.integers(0, 5, (2, n)) + 1e-12 * generator.normal(size=(2, n))).astype(float)
    x[0], y[0] = x[-1], y[-1]
    return x, y


def lattice_cloud(seed: int, n: int) -> Cloud:
    side = max(int(math.sqrt(n)), 1)
    x, y = np.meshgrid(np.arange(side) + 0.5, np.arange(side) + 0.5)
    return x.ravel().copy(), y.ravel().copy()


CLOUDS = [random_cloud, clustered_cloud, collinear_cloud, coincident_cloud, lattice_cloud]


def as_pairs(candidates: Candidates) -> list[tuple[int, int]]:
    counts = candidates.end.astype(np.int64) - candidates.start
    rows = np.repeat(np.arange(counts.size), counts)
    return list(zip(rows.tolist(), candidates.neighbour.tolist(), strict=True))


def check_against_brute_force(x: np.ndarray, y: np.ndarray, reach: float) -> None:
    found = as_pairs(find_candidates(x, y, reach, None))
    assert len(found) == len(set(found)), "a directed pair is listed twice"
    found_set = set(found)
    assert all(i != j for i, j in found_set)
    assert {(j, i) for i, j in found_set} == found_set, "not symmetric"
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(distance, np.inf)
    # Pairs within rounding of the reach may fall either way: the square is summed in another order.
    surely = set(zip(*(a.tolist() for a in np.nonzero(distance < reach * (1 - 1e-9))), strict=True))
    perhaps = set(zip(*(a.tolist() for a in np.nonzero(distance < reach * (1 + 1e-9))), strict=True))
    assert surely <= found_set <= perhaps


@settings(max_examples=80)
@given(seed=seeds, n=st.integers(1, 120), cloud=st.sampled_from(CLOUDS), reach=st.floats(0.3, 30.0))
def test_candidates_of_clouds(seed: int, n: int, cloud, reach: float) -> None:
    check_against_brute_force(*cloud(seed, n), reach)


@settings(max_examples=80)
@given(points=st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=25), reach=st.floats(0.5, 20.0))
def test_candidates_of_any_points(points: list[tuple[float, float]], reach: float) -> None:
    x, y = np.array(points).T.copy()
    check_against_brute_force(x, y, reach)


@settings(max_examples=60)
@given(seed=seeds, n=st.integers(1, 120), cloud=st.sampled_from(CLOUDS), reach=st.floats(0.3, 30.0), periods=st.floats(2.0, 9.0))
def test_periodic_candidates(seed: int, n: int, cloud, reach: float, periods: float) -> None:
    # Nearest images by brute force, with a period of 2 to 9 reaches and particles several periods away from each other.
    x, y = cloud(seed, n)
    period = Periodic(periods * reach)
    found = as_pairs(find_candidates(x, y, reach, period))
    assert len(found) == len(set(found)), "a directed pair is listed twice"
    across = x[:, None] - x
    across -= period.length * np.round(across / period.length)
    distance = np.hypot(across, y[:, None] - y)
    np.fill_diagonal(distance, np.inf)
    surely = set(zip(*(a.tolist() for a in np.nonzero(distance < reach * (1 - 1e-9))), strict=True))
    perhaps = set(zip(*(a.tolist() for a in np.nonzero(distance < reach * (1 + 1e-9))), strict=True))
    assert surely <= set(found) <= perhaps


def test_one_particle_has_no_neighbours() -> None:
    candidates = find_candidates(np.array([3.0]), np.array([-2.0]), 1.0, None)
    assert candidates.start.tolist() == candidates.end.tolist() == [0]
    assert candidates.neighbour.size == 0


def test_indices_are_unsigned() -> None:
    # Signed indices are tested for wrap-around and do not vectorise (2.7 against 0.9 ns a pair).
    candidates = find_candidates(*random_cloud(0, 20), 5.0, None)
    assert candidates.neighbour.dtype == np.uint32
    assert candidates.start.dtype == np.uint32


# ---------------------------------------------------------------- gradients

DOUBLE, SINGLE = np.float64(0), np.float32(0)
PRECISIONS = pytest.mark.parametrize("zero", [DOUBLE, SINGLE], ids=["double", "single"])


def rounding(zero: np.floating) -> float:
    """What storing a gradient adds to the error of a double-precision one, relative: half the spacing of its type's numbers."""
    return 0.5 * float(np.finfo(zero.dtype).eps) if zero is SINGLE else 0.0


def make_pairs(
    x: np.ndarray,
    y: np.ndarray,
    mass: float,
    density: np.ndarray,
    h: float = 1.0,
    name: str = "cubic_spline",
    skin: float = 0.5,
    close_range: float = 0.0,
    correction: GradientCorrection | None = None,
    zero: np.floating = DOUBLE,
) -> Pairs:
    kernel = make_kernel(name, h)
    candidates = find_candidates(x, y, 2 * h + skin, None)
    terms = some_terms(kernel=kernel, close_range=close_range, gradient_mass=mass, gradient_correction=correction)
    pairs = allocate_pairs(candidates, zero, terms)
    assert pairs.gx.dtype == pairs.inverse_norm.dtype == zero.dtype
    update_pairs(pairs, candidates, terms, Places(x, y, density), 0, x.size)
    return pairs


def row(pairs: Pairs, i: int) -> dict[int, tuple[float, float, float]]:
    """Neighbour: (gx, gy, inverse norm) of particle i."""
    inside = slice(int(pairs.start[i]), int(pairs.end[i]))
    return dict(
        zip(pairs.neighbour[inside].tolist(), zip(pairs.gx[inside], pairs.gy[inside], pairs.inverse_norm[inside], strict=True), strict=True)
    )


def close_row(pairs: Pairs, i: int) -> list[int]:
    """Neighbours of particle i that are listed for short-range forces."""
    return pairs.close[int(pairs.start[i]) : int(pairs.close_end[i])].tolist()


@PRECISIONS
def test_three_particles_by_hand(zero: np.floating) -> None:
    # h = 1, sigma = 10 / (7 pi).  Distances 0-1: 1, 0-2: 1.5, 1-2: sqrt(3.25).
    # W'(1) = -3/4 sigma, W'(1.5) = -3/16 sigma, W'(q) = -3/4 (2 - q)^2 sigma beyond q = 1.
    # g_ij = m_j W' (x_i - x_j) / r.
    sigma = 10 / (7 * math.pi)
    x, y = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.5])
    mass = 3.0
    pairs = make_pairs(x, y, mass, np.ones(3), zero=zero)
    relative = 1e-13 + rounding(zero)
    far = math.sqrt(3.25)
    slope = -0.75 * (2 - far) ** 2 * sigma
    expected = {
        0: {1: (3 * 0.75 * sigma, 0.0), 2: (0.0, 3 * 0.1875 * sigma)},
        1: {0: (-3 * 0.75 * sigma, 0.0), 2: (3 * slope * 1 / far, 3 * slope * -1.5 / far)},
        2: {0: (0.0, -3 * 0.1875 * sigma), 1: (3 * slope * -1 / far, 3 * slope * 1.5 / far)},
    }
    for i, neighbours in expected.items():
        found = row(pairs, i)
        assert found.keys() == neighbours.keys()
        for j, g in neighbours.items():
            assert found[j][:2] == pytest.approx(g, rel=relative, abs=1e-15)
            assert found[j][2] == pytest.approx(1 / math.hypot(*g), rel=relative)
        for total, parts in zip((pairs.sum_x[i], pairs.sum_y[i]), zip(*neighbours.values(), strict=True), strict=True):
            # Terms may cancel, their rounding does not.
            size = sum(abs(part) for part in parts)
            assert total == pytest.approx(sum(parts), rel=1e-13, abs=1e-15 + rounding(zero) * size)


def test_compression_repels() -> None:
    # Errata of Eq. 7: the gradient is taken with respect to x_i, so it points from i towards j and
    # pressure (negative sigma) times it pushes i away.
    pairs = make_pairs(np.array([0.0, 1.0]), np.zeros(2), 1.0, np.ones(2))
    assert row(pairs, 0)[1][0] > 0 > row(pairs, 1)[0][0]


@settings(max_examples=25)
@given(seed=seeds, n=st.integers(2, 60), name=st.sampled_from(["cubic_spline", "wendland_c2"]), zero=st.sampled_from([DOUBLE, SINGLE]))
def test_gradients_and_sums_against_the_formula(seed: int, n: int, name: str, zero: np.floating) -> None:
    generator = np.random.default_rng(seed)
    x, y = generator.uniform(0, 5, (2, n))
    mass = 1.7
    pairs = make_pairs(x, y, mass, np.ones(n), name=name, zero=zero)
    kernel = make_kernel(name, 1.0)
    for i in range(n):
        expected = {}
        for j in range(n):
            r = math.hypot(x[i] - x[j], y[i] - y[j])
            if i != j and r < 2.0:
                factor = mass * evaluate(kernel, r)[1]
                expected[j] = (factor * (x[i] - x[j]), factor * (y[i] - y[j]))
        found = row(pairs, i)
        assert found.keys() == expected.keys()
        for j, g in expected.items():
            assert found[j][:2] == pytest.approx(g, rel=1e-10 + rounding(zero), abs=1e-12)
        # Sums: rounding of up to 60 terms of size up to about 3, and of storing them.
        size = rounding(zero) * sum(abs(gx) + abs(gy) for gx, gy in expected.values())
        assert pairs.sum_x[i] == pytest.approx(sum(g[0] for g in expected.values()), abs=1e-11 + size)
        assert pairs.sum_y[i] == pytest.approx(sum(g[1] for g in expected.values()), abs=1e-11 + size)


@PRECISIONS
def test_opposite_pairs_have_opposite_gradients_to_the_last_bit(zero: np.floating) -> None:
    # Momentum is conserved to rounding because of this, whatever the precision.
    x, y = random_cloud(3, 300)
    pairs = make_pairs(x, y, 1.0, np.ones(300), h=1.3, zero=zero)
    rows = [row(pairs, i) for i in range(300)]
    assert sum(len(r) for r in rows) > 3000
    for i, neighbours in enumerate(rows):
        for j, (gx, gy, inverse_norm) in neighbours.items():
            assert (-gx, -gy, inverse_norm) == rows[j][i]


@PRECISIONS
def test_sums_are_those_of_the_stored_gradients(zero: np.floating) -> None:
    # Energy is conserved because of this: both loops see the same gradients.  Rounding of sums of some 15 terms of
    # order 1 in double precision; sums of the gradients before they are stored would be off by 1e-8 in single.
    x, y = random_cloud(5, 300)
    pairs = make_pairs(x, y, 1.0, np.ones(300), h=1.3, zero=zero)
    for i in range(300):
        inside = slice(int(pairs.start[i]), int(pairs.end[i]))
        assert pairs.sum_x[i] == pytest.approx(pairs.gx[inside].astype(float).sum(), abs=1e-13)
        assert pairs.sum_y[i] == pytest.approx(pairs.gy[inside].astype(float).sum(), abs=1e-13)


def test_rows_filled_in_parts_are_those_filled_at_once() -> None:
    # Threads fill a part of the rows each; places differ, since each part has its own room.
    x, y = random_cloud(9, 300)
    candidates = find_candidates(x, y, 2.5, None)
    density = np.random.default_rng(9).uniform(1, 3, 300)
    terms = some_terms(
        kernel=make_kernel("cubic_spline", 1.0), close_range=0.9, gradient_mass=2.0, gradient_correction=GradientCorrection(1e-3)
    )
    whole, parts = (allocate_pairs(candidates, SINGLE, terms) for _ in range(2))
    common = candidates, terms, Places(x, y, density)
    update_pairs(whole, *common, 0, 300)
    for first, last in ((200, 300), (0, 7), (7, 7), (7, 200)):
        update_pairs(parts, *common, first, last)
    for i in range(300):
        assert row(parts, i) == row(whole, i)
        assert close_row(parts, i) == close_row(whole, i)
    for name in ("sum_x", "sum_y", "correction"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))


@PRECISIONS
def test_sums_vanish_inside_a_lattice(zero: np.floating) -> None:
    x, y = lattice_cloud(0, 144)
    pairs = make_pairs(x, y, 1.0, np.ones(144), h=1.3, zero=zero)
    inside = (np.abs(x - 6) < 3) & (np.abs(y - 6) < 3)
    # By symmetry zero but for rounding of terms of order 1.
    assert np.abs(pairs.sum_x[inside]).max() < 1e-14
    assert np.abs(pairs.sum_y[inside]).max() < 1e-14
    assert np.abs(pairs.sum_x[x < 1]).min() > 0.1


@PRECISIONS
def test_coincident_particles_exert_no_gradient_and_stay_finite(zero: np.floating) -> None:
    pairs = make_pairs(np.zeros(2), np.zeros(2), 1.0, np.ones(2), zero=zero)
    assert row(pairs, 0)[1] == (0.0, 0.0, 0.0)
    assert np.isfinite(pairs.sum_x).all()


@PRECISIONS
@pytest.mark.parametrize("name", ["cubic_spline", "wendland_c2"])
def test_a_neighbour_at_the_very_edge_of_the_support_stays_finite(name: str, zero: np.floating) -> None:
    # A lattice of 2 h / spacing = 3, 4 or 5 has such neighbours: the gradient of Wendland's kernel falls below what single
    # precision holds (1e-38), and so does what is divided by its norm.
    for edge in (2.0, math.nextafter(2.0, 0.0), 2.0 - 1e-14):
        pairs = make_pairs(np.array([0.0, edge]), np.zeros(2), 1.0, np.ones(2), name=name, zero=zero)
        stored = np.array([g for i in range(2) for g in row(pairs, i).values()])
        assert np.isfinite(stored).all(), f"{name}: {stored} at distance {edge!r}"


def test_close_pairs_are_listed_in_the_rows_of_both() -> None:
    x, y = random_cloud(7, 200)
    pairs = make_pairs(x, y, 1.0, np.ones(200), close_range=0.9)
    distance = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(distance, np.inf)
    assert np.count_nonzero(distance < 0.9) > 40
    for i in range(200):
        assert sorted(close_row(pairs, i)) == np.flatnonzero(distance[i] < 0.9).tolist()


# ---------------------------------------------------------------- correction


def jittered_lattice(side: int = 14) -> Cloud:
    x, y = lattice_cloud(0, side * side)
    jitter = np.random.default_rng(3).uniform(-0.2, 0.2, (2, x.size))
    return x + jitter[0], y + jitter[1]


def gradients(pairs: Pairs, vx: np.ndarray, vy: np.ndarray, density: np.ndarray) -> np.ndarray:
    """(n, 2, 2) plain gradients dv_a/dx_b, by the formula, and the same times the correction."""
    n = vx.size
    plain = np.zeros((n, 2, 2))
    for i in range(n):
        k = slice(int(pairs.start[i]), int(pairs.end[i]))
        j = pairs.neighbour[k].astype(int)
        dv = np.stack([vx[j] - vx[i], vy[j] - vy[i]])
        plain[i] = dv @ np.stack([pairs.gx[k], pairs.gy[k]], axis=1) / density[i]
    b = pairs.correction
    matrix = np.stack([np.stack([b[:, 0], b[:, 1]], -1), np.stack([b[:, 1], b[:, 2]], -1)], 1)
    return plain @ matrix


def test_corrected_gradient_of_a_linear_field_is_exact_everywhere() -> None:
    x, y = jittered_lattice()
    density = np.random.default_rng(5).uniform(900, 1100, x.size)
    mass = 1000.0
    slope = np.array([[0.3, -1.1], [0.7, 0.2]])
    vx = 4 + slope[0, 0] * x + slope[0, 1] * y
    vy = -1 + slope[1, 0] * x + slope[1, 1] * y
    # A small limit, so that corners (moment determinant of about 0.1) are corrected too.
    found = gradients(make_pairs(x, y, mass, density, h=1.3, correction=GradientCorrection(1e-3)), vx, vy, density)
    side = x.max()
    places = {
        "interior": int(np.argmin(np.hypot(x - side / 2, y - side / 2))),
        "edge": int(np.argmin(np.hypot(x, y - side / 2))),
        "corner": int(np.argmin(np.hypot(x, y))),
    }
    for place, i in places.items():
        # Exact but for rounding: moments of condition below 100, terms of order 1.
        np.testing.assert_allclose(found[i], slope, atol=1e-11, err_msg=place)
    np.testing.assert_allclose(found, np.broadcast_to(slope, found.shape), atol=1e-10)
    plain = gradients(make_pairs(x, y, mass, density, h=1.3), vx, vy, density)
    assert np.abs(plain[places["corner"]] - slope).max() > 0.3, "without correction the corner is far off"


def test_too_singular_a_neighbourhood_keeps_the_plain_gradient() -> None:
    # Particles on one line have a moment matrix of determinant zero.
    x, y = np.arange(5) + 0.5, np.zeros(5)
    pairs = make_pairs(x, y, 1.0, np.ones(5), h=1.3, correction=GradientCorrection(0.3))
    np.testing.assert_array_equal(pairs.correction, np.broadcast_to([1.0, 0.0, 1.0], (5, 3)))


def test_correction_threshold_decides() -> None:
    x, y = jittered_lattice()
    density, mass = np.full(x.size, 1000.0), 1000.0
    corner = int(np.argmin(np.hypot(x, y)))
    loose = make_pairs(x, y, mass, density, h=1.3, correction=GradientCorrection(1e-3)).correction[corner]
    moment = np.linalg.inv([[loose[0], loose[1]], [loose[1], loose[2]]])
    determinant = float(np.linalg.det(moment))
    for limit, corrected in ((0.99 * determinant, True), (1.01 * determinant, False)):
        b = make_pairs(x, y, mass, density, h=1.3, correction=GradientCorrection(limit)).correction[corner]
        assert (b.tolist() != [1.0, 0.0, 1.0]) == corrected
