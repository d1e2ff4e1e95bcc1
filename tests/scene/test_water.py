"""Water of a scene: where the phreatic line lies, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sph.checks.scene import water_rows
from sph.command.check import check, draw
from sph.command.check import rows as check_rows
from sph.command.info import describe
from sph.scene.configuration import merge
from sph.scene.schema import Scene, make_scene
from sph.scene.water import PRESSURES

SURVEY: dict[str, Any] = {
    "name": "survey",
    "scheme": "paper",
    "duration": 5.0,
    "geometry": {"shape": "ground_line", "points": [[100, 440], [130, 440], [150, 430], [180, 430]], "base": 420, "downhill": "right"},
    "water": {"pressure": "by_place"},
}


def scene(water: dict[str, Any], **others: Any) -> Scene:
    return make_scene(merge(SURVEY, {"water": water, **others}))


def test_a_line_has_the_coordinates_of_the_ground() -> None:
    # The slope falls to the right and is turned round: the box's x is 180 m less the survey's, its y that above 420 m.
    built = scene({"points": [[90, 434], [140, 434], [150, 428], [200, 428]]})
    assert built.water is not None
    found = built.water.surface(built.geometry, np.array([0.0, 30.0, 35.0, 40.0, 80.0]))
    np.testing.assert_allclose(found, [8.0, 8.0, 11.0, 14.0, 14.0])


def test_the_direction_in_which_a_line_was_drawn_does_not_matter() -> None:
    points = [[90, 436], [150, 428], [200, 428]]
    one, other = (scene({"points": drawn}) for drawn in (points, points[::-1]))
    x = np.linspace(0.0, 80.0, 7)
    assert one.water is not None and other.water is not None
    np.testing.assert_array_equal(one.water.surface(one.geometry, x), other.water.surface(other.geometry, x))


def test_a_line_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "line.csv"
    path.write_text("x (m),elevation (m)\n100,436\n150,428\n180,428\n")
    built = scene({"file": str(path)})
    assert built.water is not None and built.water.points == ((100.0, 436.0), (150.0, 428.0), (180.0, 428.0))
    assert make_scene(built.model_dump()) == built, "a stored scene repeats without the file"


def test_standing_water_is_level() -> None:
    # 3 m of water before the toe, a line that rises within the slope from where the water meets its face.
    assert scene({"points": [[100, 437], [144, 433], [180, 433]]}).water is not None
    assert scene({"level": 445}).water is not None


@pytest.mark.parametrize("kind", PRESSURES)
def test_whose_pressure_it_is_must_be_written(kind: str) -> None:
    with pytest.raises(ValueError, match=rf"water: pressure: .*pressure: {kind}"):
        scene({"pressure": None, "level": 425})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"water": {}}, r"level, points \(or file\), r_u: none given"),
        ({"water": {"level": 425, "r_u": 0.3}}, r"level and r_u given"),
        ({"water": {"r_u": 1.0}}, r"water\.r_u: .* less than 1 \(found 1\.0\)"),
        ({"water": {"points": [[100, 425], [150, 425], [140, 425], [180, 425]]}}, r"points\.2: \(140, 425\) m lies behind"),
        ({"water": {"points": [[110, 425], [180, 425]]}}, r"water\.points: .*110 to 180 m .*100 to 180 m"),
        ({"water": {"points": [[100, 437], [180, 432]]}}, r"water\.points: .*3\.87 m above"),
        ({"water": {"pressure": "carried", "level": 433}}, r"water\.pressure: carried .*3 m above"),
        (
            {"layers": {"clay": {"region": {"kind": "depth"}, "r_u": 0.2}}, "water": {"level": 425}},
            r"layers\.clay\.r_u: 0\.2 needs water\.r_u",
        ),
        ({"layers": {"clay": {"region": {"kind": "depth"}, "r_u": 0.2}}, "water": None}, r"layers\.clay\.r_u: 0\.2 needs water\.r_u"),
        ({"water": {"level": 425}, "gravity": {"acceleration": 0.0}}, r"gravity\.acceleration: 0 m/s2 with water"),
        ({"water": {"r_u": 0.2}, "gravity": {"inclination": 10.0}}, r"gravity\.inclination: 10\.0 degree with water"),
        ({"water": {"r_u": 0.2}, "prescribed_velocity_gradient": {"xy": 1.0}}, r"prescribed_velocity_gradient: moves the soil"),
        (
            {"water": {"pressure": "carried", "r_u": 0.2}, "soil": {"dilation_angle": 5.0}},
            r"soil\.dilation_angle: above 0 with water\.pressure: carried",
        ),
        (
            {"water": {"pressure": "carried", "r_u": 0.2}, "walls": {"sides": "free_slip", "layers": 4, "friction": {"sides": 0.2}}},
            r"walls\.friction: with water\.pressure: carried",
        ),
    ],
)
def test_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_scene(merge(SURVEY, changes) if changes["water"] is not None else {**SURVEY, **changes})


def test_a_line_does_not_go_on_over_periodic_sides() -> None:
    block = {
        "name": "block",
        "scheme": "paper",
        "duration": 5.0,
        "geometry": {"shape": "block", "width": 20.0, "height": 5.0},
        "walls": {"sides": "periodic"},
        "numerics": {"smoothing_ratio": 1.3},
    }
    assert make_scene(merge(block, {"water": {"pressure": "by_place", "level": 4.0}})).water is not None
    with pytest.raises(ValueError, match=r"water\.points: .*walls\.sides: periodic"):
        make_scene(merge(block, {"water": {"pressure": "by_place", "points": [[0, 4], [20, 3]]}}))


def test_summaries_and_figures_show_the_water() -> None:
    # 3 m of water before the toe; the line is drawn from side to side of the box, whose x is that of the survey turned round.
    built = scene({"points": [[100, 437], [144, 433], [180, 433]]}, numerics={"spacing": 2.0})
    expected = "phreatic line from 433 to 437 m, 9.81 kN/m3; pressure by_place: " + PRESSURES["by_place"]
    expected += "; stands up to 3 m above the ground"
    assert dict(water_rows(built)) == {"water": expected}
    for rows in (describe(built), check_rows(check(built))):
        assert dict(rows)["water"] == expected
    figure = draw([check(built)])
    (line,) = (line for line in figure.axes[0].lines if line.get_linestyle() == "--" and line.get_color() == "tab:blue")
    np.testing.assert_allclose(line.get_xydata(), [[0.0, 13.0], [36.0, 13.0], [80.0, 17.0]])


def test_a_dry_scene_says_nothing_of_water() -> None:
    assert water_rows(make_scene({**SURVEY, "water": None})) == []


def test_a_ratio_is_told_with_those_of_layers() -> None:
    built = scene({"r_u": 0.3}, layers={"clay": {"region": {"kind": "depth", "top": 2.0}, "r_u": 0.1}})
    assert dict(water_rows(built))["water"].startswith("r_u = 0.3; pressure by_place: ")
    assert dict(water_rows(built))["water"].endswith("; layer clay r_u = 0.1")
