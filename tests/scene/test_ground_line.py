"""Slopes of the user's own: the ground as a line in the coordinates of its survey."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sph.checks.messages import words
from sph.checks.scene import to_side
from sph.scene.configuration import merge
from sph.scene.ground_line import GroundLine
from sph.scene.places import RIGHT
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.particles import locate_probes, place_particles
from sph.solver.restart import check_restart
from sph.stability.standing import FailureRule, slope_height, static_scene

SLOPE = [[120.0, 440.0], [150.0, 440.0], [170.0, 465.0], [200.0, 465.0]]


def scene(points: Any = None, spacing: float = 1.0, probes: Any = None, **geometry: Any) -> Scene:
    own = {} if points is None else {"points": points}
    data = {
        "scheme": "paper",
        "name": "own",
        "geometry": {"shape": "ground_line", "base": 430.0} | own | geometry,
        "numerics": {"spacing": spacing},
    }
    return make_scene(data | ({"probes": probes} if probes else {}))


def ground(points: Any, **geometry: Any) -> GroundLine:
    made = scene(points, **geometry).geometry
    assert isinstance(made, GroundLine)
    return made


def in_survey(geometry: GroundLine) -> list[tuple[float, float]]:
    return [geometry.in_survey(*place) for place in (geometry.toe, geometry.crest)]


def test_a_plane_slope_is_that_of_the_shape_slope() -> None:
    plane = {"shape": "slope", "slope_angle": 50.0, "slope_height": 25.0, "base_depth": 10.0, "apron_length": 30.0, "crest_length": 30.0}
    theirs = make_scene({"scheme": "paper", "name": "own", "geometry": plane})
    own = scene(list(zip(*theirs.geometry.surface, strict=True)), base=0.0)
    for one, other in zip(place_particles(own), place_particles(theirs), strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_allclose([own.geometry.toe, own.geometry.crest], [theirs.geometry.toe, theirs.geometry.crest])
    assert (own.geometry.width, own.geometry.height) == pytest.approx((theirs.geometry.width, theirs.geometry.height))


def test_the_survey_keeps_its_coordinates() -> None:
    geometry = ground(SLOPE)
    assert geometry.origin == (120.0, 430.0)
    assert geometry.surface == ((0.0, 30.0, 50.0, 80.0), (10.0, 10.0, 35.0, 35.0))
    assert geometry.in_box(150.0, 440.0) == geometry.toe == (30.0, 10.0)
    assert in_survey(geometry) == [(150.0, 440.0), (170.0, 465.0)]


def test_a_slope_that_falls_to_the_right_is_turned_round() -> None:
    turned = [[320.0 - x, y] for x, y in SLOPE][::-1]
    one, other = ground(SLOPE), ground(turned, downhill="right")
    assert one.surface == other.surface and one.toe == other.toe
    assert in_survey(other) == [(170.0, 440.0), (150.0, 465.0)]
    probe = {"P": [165.0, 446.0]}
    made = scene(turned, downhill="right", probes=probe)
    particles = place_particles(made)
    found = locate_probes(made, particles)["P"]
    assert made.geometry.in_survey(particles.x[found], particles.y[found]) == pytest.approx((165.0, 446.0), abs=0.71)
    with pytest.raises(ValueError, match=r"probes.P: \(110, 446\) m"):
        locate_probes(scene(turned, downhill="right", probes={"P": [110.0, 446.0]}), particles)


def test_a_line_drawn_backwards_is_the_same_line() -> None:
    assert ground(SLOPE[::-1]).surface == ground(SLOPE).surface


def test_a_window_takes_a_part() -> None:
    geometry = ground(SLOPE, window=[140, 160])
    assert geometry.origin == (140.0, 430.0)
    assert geometry.surface == ((0.0, 10.0, 20.0), (10.0, 10.0, 22.5))


CLIFFS = [
    [0.0, 440.0],
    [20.0, 440.0],
    [20.0, 450.0],
    [30.0, 450.0],
    [40.0, 460.0],
    [60.0, 460.0],
    [60.0, 455.0],
    [60.0, 470.0],
    [80.0, 470.0],
]


@pytest.mark.parametrize(
    ("window", "surface"),
    [
        ((20, 60), ((0.0, 10.0, 20.0, 40.0), (20.0, 20.0, 30.0, 30.0))),  # level at both ends, whatever lies beyond the steps
        ((10, 60), ((0.0, 10.0, 10.0, 20.0, 30.0, 50.0), (10.0, 10.0, 20.0, 20.0, 30.0, 30.0))),
        ((20, 70), ((0.0, 10.0, 20.0, 40.0, 40.0, 40.0, 50.0), (20.0, 20.0, 30.0, 30.0, 25.0, 40.0, 40.0))),
    ],
)
@pytest.mark.parametrize("backwards", [False, True])
def test_a_window_may_end_on_a_vertical_step(window: Any, surface: Any, backwards: bool) -> None:
    assert ground(CLIFFS[::-1] if backwards else CLIFFS, window=window).surface == surface
    turned = [[100.0 - x, y] for x, y in CLIFFS][::-1]
    assert ground(turned, window=[100.0 - x for x in window[::-1]], downhill="right").surface == surface


@pytest.mark.parametrize(
    ("points", "toe", "crest"),
    [
        (SLOPE, (150, 440), (170, 465)),
        ([[0, 440], [100, 441], [125, 466], [200, 467]], (100, 441), (125, 466)),  # gentle ground before and behind
        ([[0, 440], [30, 440], [40, 455], [45, 455], [55, 470], [99, 470]], (30, 440), (55, 470)),  # a berm
        ([[0, 440], [30, 440.5], [31, 440.2], [40, 455], [44, 454.8], [55, 470], [99, 469]], (31, 440.2), (55, 470)),  # dips
        ([[0, 450], [20, 440], [40, 442], [60, 460], [80, 461], [120, 445]], (40, 442), (60, 460)),  # a ridge above a valley
        ([[0, 440], [30, 440], [30, 460], [60, 460]], (30, 440), (30, 460)),  # a cliff
        ([[0, 440], [40, 450]], (0, 440), (40, 450)),  # slope all along
        # gentler ground before and behind that climbs as well: the mean gradient is that of the slope, not of the whole survey
        ([[0, 440.1], [50, 441.4], [58, 442.2], [65, 444.9], [98, 462.1], [109, 465.8], [128, 467.4]], (58, 442.2), (109, 465.8)),
    ],
)
def test_toe_and_crest_are_those_of_the_main_slope(points: Any, toe: tuple[float, float], crest: tuple[float, float]) -> None:
    assert in_survey(ground(points)) == [toe, crest]


def test_toe_and_crest_can_be_set() -> None:
    geometry = ground(SLOPE, toe_at=[155, 446.25], crest_at=[180, 465])
    assert in_survey(geometry) == [(155, 446.25), (180, 465)]
    assert geometry.slope_height == pytest.approx(18.75)


@pytest.mark.parametrize(
    ("points", "geometry", "message"),
    [
        ([[0, 440], [10, 440], [9, 450], [20, 450]], {}, r"points.2: \(9, 450\) m .*\(10, 440\) m.*overhang"),
        ([[0, 440], [0, 450]], {}, "points: all lie at x = 0 m"),
        ([[0, 440]], {}, "points"),
        ([[0, 440], [10, "x"]], {}, "points.1.1"),
        (SLOPE, {"base": 440}, r"base: 440 m .*\(120, 440\) m"),
        (SLOPE, {"window": [100, 150]}, "window: .*120 to 200 m"),
        (SLOPE, {"window": [160, 150]}, "window"),
        (SLOPE, {"window": [120, 150]}, "downhill: left: no slope"),
        (SLOPE[::-1], {"downhill": "right"}, "downhill: right: no slope"),
        (SLOPE, {"toe_at": [100, 440]}, "toe_at"),
        (SLOPE, {"crest_at": [140, 440]}, "crest_at"),
        (None, {}, "points"),
        (None, {"file": "absent.csv"}, "geometry: file: absent.csv: "),
    ],
)
def test_a_bad_line_is_refused(points: Any, geometry: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        scene(points, **geometry)


def test_a_stored_scene_repeats_without_its_file(tmp_path: Path) -> None:
    (tmp_path / "ground.csv").write_text("x,y\n120,440\n150,440\n170,465\n200,465\n")
    (tmp_path / "own.yaml").write_text("name: own\nscheme: paper\ngeometry: {shape: ground_line, file: ground.csv, base: 430}\n")
    loaded = load_scene(tmp_path / "own.yaml")
    assert loaded.geometry.surface == ground(SLOPE).surface  # type: ignore[union-attr]
    (tmp_path / "ground.csv").unlink()
    stored = loaded.model_dump(mode="json")
    assert make_scene(stored) == loaded
    (tmp_path / "other.csv").write_text("0,440\n30,450\n")
    other = make_scene(merge(stored, {"geometry": {"file": str(tmp_path / "other.csv")}}))
    assert other.geometry.width == 30.0


heights = st.floats(1.0, 30.0)
steps = st.floats(0.5, 20.0)


@st.composite
def grounds(draw: st.DrawFn) -> list[list[float]]:
    """A line of 3 to 8 points that rises somewhere, some of its steps vertical."""
    count = draw(st.integers(3, 8))
    x = np.cumsum([draw(st.just(0.0) | steps) for _ in range(count)])
    y = [draw(heights) for _ in range(count)]
    line = [[float(a), b] for a, b in zip(x, y, strict=True)]
    rises = any(y[j] > y[i] + 0.5 for i in range(count) for j in range(i + 1, count))
    return line if rises and x[-1] - x[0] > 5.0 else [[0.0, 2.0], *([a + 5.0, b] for a, b in line), [float(x[-1]) + 10.0, 32.0]]


@given(grounds(), st.sampled_from([0.5, 0.8, 1.0]))
def test_particles_lie_below_the_ground_and_fill_it(points: list[list[float]], spacing: float) -> None:
    made = scene(points, spacing, base=0.0)
    geometry, particles = made.geometry, place_particles(made)
    n = particles.n_soil
    x, y = np.array(geometry.surface)
    # A particle at a vertical step, or next to nothing left of it, belongs to the right side.
    assert np.all(particles.y[:n] <= geometry.ground(particles.x[:n] + RIGHT * spacing) + 1e-6)
    columns = np.unique(particles.x[:n])
    tops = np.array([particles.y[:n][particles.x[:n] == column].max() for column in columns])
    ground = geometry.ground(columns + RIGHT * spacing)
    assert np.all(np.abs(tops + 0.5 * spacing - ground) <= 0.5 * spacing + 2e-6), "within half a spacing of the ground"
    area = np.trapezoid(y, x)
    outline = np.hypot(np.diff(x), np.diff(y)).sum() + 2.0 * geometry.height
    assert abs(n * spacing**2 - area) <= spacing * outline


@pytest.mark.parametrize("downhill", ["left", "right"])
def test_layers_lie_in_the_survey(downhill: str) -> None:
    turned = downhill == "right"
    points = [[320.0 - x, y] for x, y in SLOPE][::-1] if turned else SLOPE
    own = scene(points, downhill=downhill).model_dump(mode="json")
    lens = [[160 if turned else 150, 432], [170 if turned else 160, 432], [170 if turned else 160, 436], [160 if turned else 150, 436]]
    layers = {
        "rock": {"region": {"kind": "elevation", "top": 431.0}},
        "cover": {"region": {"kind": "depth", "bottom": 2.0}},
        "lens": {"region": {"kind": "polygon", "points": lens}},
    }
    particles = place_particles(make_scene(own | {"layers": layers}))
    x, y = scene(points, downhill=downhill).geometry.in_survey(particles.x, particles.y)
    soil = particles.kind == 0
    regions = (
        y < 431.0,
        np.interp(x, *np.array(points).T) - y < 2.0,
        (np.abs(x - np.mean(lens, axis=0)[0]) < 5.0) & (np.abs(y - 434.0) < 2.0),
    )
    for number, inside in enumerate(regions, 1):
        assert np.array_equal(particles.layer[soil] == number, inside[soil])


def test_a_run_goes_on_wherever_its_file_lies_but_not_on_other_ground(tmp_path: Path) -> None:
    for name, top in (("one", 465), ("same", 465), ("other", 460)):
        (tmp_path / f"{name}.csv").write_text(f"120,440\n150,440\n170,{top}\n200,{top}\n")
    one, same, other = (scene(file=str(tmp_path / f"{name}.csv")) for name in ("one", "same", "other"))
    check_restart(one, same, 1.0, False, "gravity.nc")
    with pytest.raises(ValueError, match=r"geometry\.points"):
        check_restart(one, other, 1.0, False, "gravity.nc")


def test_the_static_test_measures_by_the_height_of_the_main_slope() -> None:
    valley = scene([[80, 470], [120, 440], [150, 440], [170, 465], [200, 465]])
    assert slope_height(valley) == 25.0
    assert static_scene(valley, FailureRule()).geometry == valley.geometry


@given(
    st.floats(5.0, 40.0),
    st.floats(0.3, 3.0),
    st.floats(0.1, 0.75),
    st.floats(1.0, 4.0),
    st.integers(1, 8),
    st.sampled_from(["left", "right"]),
)
def test_a_face_below_a_hillside_that_rises_to_the_side_has_a_crest_of_its_own(
    height: float, gradient: float, gentler: float, longer: float, parts: int, downhill: str
) -> None:
    """A cut of any height and gradient, in parts of one gradient, at the foot of a hillside that is gentler and longer."""
    face = [(30.0 + height / gradient * share, 100.0 + height * share) for share in np.linspace(0.0, 1.0, parts + 1)]
    far = face[-1][0] + longer * height / gradient
    line = [(0.0, 100.0), *face, (far, 100.0 + height + gentler * gradient * (far - face[-1][0]))]
    turn = -1.0 if downhill == "right" else 1.0
    points = [[turn * x, y] for x, y in line]
    own = scene(points, downhill=downhill, base=95.0, spacing=0.01 * far)
    geometry = own.geometry
    assert isinstance(geometry, GroundLine)
    found = to_side(geometry)
    if geometry.crest[0] < geometry.width:
        assert in_survey(geometry)[1] == pytest.approx((turn * face[-1][0], face[-1][1])) and not found
        return
    (one,) = found
    x, y = (float(number) for number in words(one).key.removeprefix("geometry.crest_at=[").rstrip("]").split(","))
    assert (x, y) == pytest.approx((turn * face[-1][0], face[-1][1])) and one.code == "slope-to-side"
    assert f"H = {geometry.slope_height:.4g} m" in words(one).measured and f"H = {height:.4g} m" in words(one).wanted
    chosen = scene(points, downhill=downhill, base=95.0, spacing=0.01 * far, crest_at=(x, y)).geometry
    assert isinstance(chosen, GroundLine) and chosen.slope_height == pytest.approx(height) and not to_side(chosen)


def test_a_slope_that_goes_on_to_a_side_of_the_model_is_told() -> None:
    assert to_side(ground(SLOPE)) == []
    whole = ground([[0, 440], [40, 450]])
    assert [(each.subject, each.keys) for each in to_side(whole)] == [
        (end, ("geometry.window", "geometry.points")) for end in ("crest", "toe")
    ]
    low = to_side(ground([[0, 440], [40, 455], [50, 470], [90, 470]]))
    assert [words(each).key for each in low] == ["geometry.toe_at=[40, 455]"]
