"""Lines of a survey in the formats that people have them in, whole and broken."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sph.command.known import Known
from sph.command.new import write_new
from sph.scene.configuration import validated
from sph.scene.ground_line import GroundLine
from sph.scene.survey import HIGHEST, LOWEST, NODATA, read_line, read_outline
from sph.scene.water import Water

MOTION = Path(__file__).resolve().parents[2] / "config" / "motions" / "synthetic.csv"
Line = list[tuple[float, float]]
LINE = [(120.0, 440.0), (150.0, 440.5), (170.0, 465.0)]
FEATURE = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": LINE}}


def read(tmp_path: Path, text: str, encoding: str = "utf-8") -> list[tuple[float, float]]:
    file = tmp_path / "ground"
    file.write_bytes(text.encode(encoding))
    return read_line(file)


@pytest.mark.parametrize(
    "text",
    [
        "120,440\n150,440.5\n170,465\n",
        "x,y\r\n120,440\r\n150,440.5\r\n170,465",
        "Station (m);Höhe (m)\n120;440\n150;440,5\n170;465\n",
        "x_m,elev (m a.s.l.)\n120,440\n150,440.5\n170,465\n",
        "# x, z in m, some 5 ft apart (May)\n120,440\n150,440.5\n170,465\n",
        "# surveyed in May\n\n120 440\n  150   440.5\n170\t465\n".replace("\t", " "),
        "120\t440\n150\t440,5\n170\t465",
        '"x","z"\n"120","440"\n"150","440.5"\n"170","465"\n',
        "120,440,\n150,440.5,\n170,465,\n",
        "1.2e2,4.4e2\r150,440.5\r170,465\r",
        "LINESTRING (120 440, 150 440.5, 170 465)",
        "linestring(120 440,150 440.5,\n170 465)\n",
        "MULTILINESTRING ((120 440, 150 440.5, 170 465))",
        json.dumps(FEATURE["geometry"]),
        json.dumps(FEATURE),
        json.dumps({"type": "FeatureCollection", "features": [FEATURE]}),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_formats(tmp_path: Path, text: str, encoding: str) -> None:
    assert read(tmp_path, text, encoding) == LINE


def test_points_in_space_are_unrolled_along_the_line(tmp_path: Path) -> None:
    assert read(tmp_path, "LINESTRING Z (0 0 440, 30 40 441, 30 100 465)") == [(0.0, 440.0), (50.0, 441.0), (110.0, 465.0)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x (ft), z (ft)\n120,440\n150,441", r"line 1: .*'x \(ft\)'.*0\.3048 m"),
        ("x,elev_ft\n120,440\n150,441", "line 1: the unit in 'elev_ft'"),
        ("x_km z_m\n0.12 440\n0.15 441", "line 1: the unit in 'x_km z_m'"),
        ("x (in);z\n120;440\n150;441", "line 1: the unit in"),
        ("lon (deg),z\n12.0,440\n12.1,441", "line 1: the unit in"),
        ("# elevations in feet\n120,440\n150,441", "line 1: .*'# elevations in feet'"),
        ("120,440\n150;x\n", "line 2: '150;x'"),
        ("x,y\nx,y\n120,440", "line 2"),
        ("12O,440\n150,441", "line 1"),
        ("120,440,1\n150,441,1", "line 1"),
        ("120\n150", "line 1"),
        ("120,nan\n150,441", "line 1"),
        ("", "no points"),
        ("# nothing\n# yet\n", "it holds no points"),
        ("x,y\n", "it holds no points"),
        ("120,440\n", "it holds 1 point; expected two numbers"),
        ("120,440\n150,1e999", "line 2"),
        ("LINESTRING (120 440, 150)", "not WKT of a line.*Expected number"),
        ("LINESTRING EMPTY", "empty LineString"),
        ("SRID=25832;LINESTRING (0 0, 1 1)", "not WKT"),
        ("POINT (120 440)", "holds Point; expected one LineString"),
        ("MULTILINESTRING ((0 0, 1 1), (2 2, 3 3))", "holds LineString, LineString"),
        ("LINESTRING (120 440, 150 nan)", "point 2"),
        ("LINESTRING Z (0 0 1, 1 1 nan)", "point 2"),
        ('{"type": "LineString"', "not GeoJSON.*line 1"),
        ('{"type": "LineString", "coordinates": [[0, 0], [1, "a"]]}', "not GeoJSON.*must be number"),
        ('{"type": "Topology"}', "not GeoJSON"),
        ('{"type": "LineString", "coordinates": [[0, 0], [1, NaN]]}', "NaN is no number"),
        ('{"type": "LineString", "coordinates": [[0, 0], [1, 1e999]]}', "1e999 is no number"),
        ("[" * 20_000, "not GeoJSON.*nested too deeply"),
        ('{"type":"GeometryCollection","geometries":[' * 20_000, "not GeoJSON.*nested too deeply"),
        (json.dumps(FEATURE).replace("{}", "[" * 20_000 + "]" * 20_000), "not GeoJSON.*nested too deeply"),
        ("GEOMETRYCOLLECTION(" * 60_000 + "LINESTRING(0 0,1 1)" + ")" * 60_000, "not WKT.*nested deeper"),
        ("[]", "not GeoJSON"),
        (json.dumps({"type": "FeatureCollection", "features": [FEATURE, FEATURE]}), "holds LineString, LineString"),
        (json.dumps({"type": "FeatureCollection", "features": []}), "expected one LineString"),
    ],
)
def test_a_broken_file_says_where_and_what_is_expected(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read(tmp_path, text)


def test_names_in_a_comment_swap_the_columns(tmp_path: Path) -> None:
    assert read(tmp_path, "# elevation (m),x (m)\n440,120\n440.5,150\n465,170\n") == LINE


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("x,depth", r"line 1: 'depth' .*\(columns 'x', 'depth'\)"),
        ("x,slope", "'slope' is neither"),
        ("lon,lat", "line 1: 'lon', 'lat' are places in plan.*distance along the section"),
        ("easting,northing,elevation", "line 1: 'easting', 'northing' are places in plan.*LINESTRING Z"),
        ("x,y,z", "1 columns of x and 2 of elevation.*GeoJSON or WKT"),
        ("x,distance", "2 columns of x and 0 of elevation"),
        (",elevation", "0 columns of x and 1 of elevation"),
    ],
)
def test_names_of_other_quantities_are_refused(tmp_path: Path, head: str, message: str) -> None:
    width = head.count(",") + 1
    with pytest.raises(ValueError, match=message):
        read(tmp_path, "\n".join([head, *(",".join([str(at)] * width) for at in (1, 2, 3))]))


@pytest.mark.parametrize("mark", [";", "\t"])
def test_separators_of_thousands_are_refused(tmp_path: Path, mark: str) -> None:
    for text in ("998.5;440\n1,123;441", "998;440\n1,123;441"):
        with pytest.raises(ValueError, match="line 2: '1,123'.*thousands"):
            read(tmp_path, text.replace(";", mark))


def system(name: object, at: str) -> str:
    """The line in space, easting, northing and elevation, with a system of coordinates in one of its objects."""
    crs = {"type": "name", "properties": {"name": name}} if isinstance(name, str) else name
    geometry = {"type": "LineString", "coordinates": [[x, 5e6, y] for x, y in LINE]}
    feature = FEATURE | {"geometry": geometry | ({"crs": crs} if at == "geometry" else {})} | ({"crs": crs} if at == "feature" else {})
    return json.dumps({"type": "FeatureCollection", "features": [feature]} | ({"crs": crs} if at == "collection" else {}))


@pytest.mark.parametrize("at", ["collection", "feature", "geometry"])
def test_a_system_of_coordinates_is_in_metres_or_refused(tmp_path: Path, at: str) -> None:
    for name in ("urn:ogc:def:crs:EPSG::32632", "EPSG:25832", "urn:ogc:def:crs:EPSG:9.2:2056", "epsg:27700", None):
        assert read(tmp_path, system(name, at)) == [(x - LINE[0][0], y) for x, y in LINE]
    link = {"type": "link", "properties": {"href": "http://x/2227"}}
    for name in (
        "urn:ogc:def:crs:EPSG::2227",
        "EPSG:4326",
        "urn:ogc:def:crs:OGC:1.3:CRS84",
        "EPSG:3857",
        "EPSG:999999",
        "NAD83 (ftUS)",
        link,
        4,
    ):
        with pytest.raises(ValueError, match="crs: .*metres.*leave crs out"):
            read(tmp_path, system(name, at))


def test_degrees_are_refused_in_points_of_three(tmp_path: Path) -> None:
    for form in (
        "LINESTRING Z (8.5 47.3 440, 8.501 47.3 465)",
        '{"type": "LineString", "coordinates": [[8.5, 47.3, 440], [8.501, 47.3, 465]]}',
    ):
        with pytest.raises(ValueError, match="degrees"):
            read(tmp_path, form)


def ground_of(text: str) -> GroundLine:
    """The ground in a file of this text, as a scene makes it of it."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "ground").write_text(text)
        return validated(GroundLine, {"shape": "ground_line", "file": f"{folder}/ground", "base": -1e5}, "scene.yaml")


@st.composite
def sections(draw: st.DrawFn) -> Line:
    """A surveyed section: 6 to 30 points some metres apart at any elevation, on ground that rises by a tenth of it at most."""
    number, level = draw(st.integers(6, 30)), draw(st.floats(60.0, 4000.0))
    steps = draw(st.lists(st.floats(1.0, 8.0), min_size=number, max_size=number))
    rises = draw(st.lists(st.floats(-0.2, 1.0), min_size=number, max_size=number))
    x = np.round(draw(st.floats(0.0, 500.0)) + np.cumsum(steps), 2)
    climbs = np.cumsum(np.multiply(rises, steps))
    if np.ptp(climbs) < 1e-3:
        climbs = x - x[0]
    y = np.round(level + climbs * 0.1 * min(level, 300.0) / np.ptp(climbs), 2)
    return list(zip(x.tolist(), y.tolist(), strict=True))


HEADS_OF_X = ("x", "Station (m)", "chainage_m", "Distance along line (m)", "Profile (m)", "X", "Offset")
HEADS_OF_ELEVATION = (
    *("z", "Y", "Elevation (m NAVD88)", "Elev_NAVD88_m", "Elev_NAVD_88 (m)", "NAVD88 (m)", "Level (mAOD)", "RL (m AHD)", "Höhe [m NHN]"),
    *("Höhe DHHN2016 (m)", "Height_EGM96_m", "elevation (m a.s.l.)"),
)
HEADS_BESIDE = ("Point", "Polygon", "ID", "FID", "LineString", "No.", "")


@given(
    sections(),
    st.sampled_from(HEADS_OF_X),
    st.sampled_from(HEADS_OF_ELEVATION),
    st.lists(st.sampled_from(HEADS_BESIDE), max_size=2, unique=True),
    st.sampled_from([",", ";", "\t"]),
    st.randoms(use_true_random=False),
)
def test_heads_at_random_give_the_section(points: Line, x: str, elevation: str, beside: list[str], mark: str, random: Random) -> None:
    order = [x, elevation, *beside]
    random.shuffle(order)
    if order[-1] == "":
        order.reverse()  # what ends in a separator has no column there
    rows = [
        mark.join({x: str(a), elevation: str(b)}.get(name, "1" if name in ("Polygon", "FID", "LineString") else str(at)) for name in order)
        for at, (a, b) in enumerate(points, 1)
    ]
    with tempfile.TemporaryDirectory() as folder:
        assert read(Path(folder), "\n".join([mark.join(order), *rows])) == points


@given(sections(), st.integers(0, 29), st.sampled_from([*NODATA, -9999.0, -999.0, -32768.0, -3.4e38, 9999.0, 1e20]), st.sampled_from("CGW"))
def test_a_point_without_data_at_random_is_refused_with_its_row(points: Line, at: int, nodata: float, form: str) -> None:
    row = at % len(points)
    assume(np.ptp([y for number, (_, y) in enumerate(points) if number != row]) > 0.0)
    gap = [(x, nodata if number == row else y) for number, (x, y) in enumerate(points)]
    if abs(nodata - points[row][1]) < 60.0 or nodata == 999.0 and abs(nodata - points[row][1]) < 0.3 * points[row][1]:
        return  # it may be ground
    place = f"line {row + 2}:" if form == "C" else f"point {row + 1}:"
    texts = {
        "C": "x,z\n" + "".join(f"{x},{y}\n" for x, y in gap),
        "G": json.dumps({"type": "LineString", "coordinates": gap}),
        "W": f"LINESTRING ({', '.join(f'{x} {y}' for x, y in gap)})",
    }
    with pytest.raises(ValueError, match=rf"ground: {place} elevation .*leave out points without data"):
        ground_of(texts[form])


FORMS = ("GeoJSON", "crs", "WKT", "M")


@given(
    st.floats(-9e6, 9e6).filter(lambda north: not 2 * LOWEST < north < 2 * HIGHEST),
    st.floats(1e3, 9e6),
    st.lists(st.tuples(st.floats(0.5, 40.0), st.floats(-40.0, 40.0)), min_size=3, max_size=20),
    st.sampled_from(["x,y", "X;Y", "x,z", "", "chainage,elevation", "easting,northing", "Rechtswert;Hochwert", *FORMS]),
    st.booleans(),
)
def test_a_line_in_plan_at_random_is_refused(north: float, east: float, steps: Line, form: str, swapped: bool) -> None:
    x, y = np.round(np.array([east, north])[:, None] + np.cumsum(np.array(steps).T, axis=1), 2)
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    if swapped and east > 2 * HIGHEST:
        points = [(b, a) for a, b in points]
    mark = ";" if ";" in form else ","
    rows = "".join(f"{a}{mark}{b}\n" for a, b in points)
    section = [(float(at), 100.0 + at) for at in range(len(points))]  # distances and elevations, but for what is said of them
    text, message = {
        "GeoJSON": (json.dumps({"type": "LineString", "coordinates": points}), "point 1: elevation"),
        "crs": (
            json.dumps({"type": "LineString", "coordinates": section, "crs": {"properties": {"name": "EPSG:25832"}}}),
            "crs: .*two coordinates, which lie in plan and hold no elevation",
        ),
        "WKT": (f"LINESTRING ({', '.join(f'{a} {b}' for a, b in points)})", "point 1: elevation"),
        "M": (
            f"LINESTRING M ({', '.join(f'{a} {b} {a - points[0][0]}' for a, b in section)})",
            "it is a line with a measure .M., which is no elevation",
        ),
    }.get(form, (f"{form}\n{rows}", "line 2: elevation" if "t" not in form else "line 1: .* places in plan"))
    if form == "chainage,elevation":
        message = "line 2: elevation"
    with pytest.raises(ValueError, match=f"file: .*ground: {message}.*GeoJSON or as WKT"):
        ground_of(text)


@given(
    st.floats(-179.0, 179.0),
    st.floats(1.0, 85.0) | st.floats(-85.0, -1.0),
    st.lists(st.floats(-4e-4, 4e-4), min_size=6, max_size=40),
    st.sampled_from("CGW"),
)
def test_degrees_at_random_are_refused(longitude: float, latitude: float, steps: list[float], form: str) -> None:
    points = [(longitude + 1e-4 * at, latitude + step) for at, step in enumerate(sorted(steps))]
    texts = {
        "C": "x,y\n" + "".join(f"{x:.6f},{y:.6f}\n" for x, y in points),
        "G": json.dumps({"type": "LineString", "coordinates": points}),
        "W": f"LINESTRING ({', '.join(f'{x} {y}' for x, y in points)})",
    }
    with pytest.raises(ValueError, match="they may be degrees; give distance along the section and elevation, both in m.*file: .*ground"):
        ground_of(texts[form])


@given(sections(), st.sampled_from(["x in km", "x in mm", "z in mm", "z in km"]))
def test_x_and_elevation_of_different_units_are_refused(points: Line, mixed: str) -> None:
    by_x, by_z = {"x in km": (1e-3, 1.0), "x in mm": (1e3, 1.0), "z in mm": (1.0, 1e3), "z in km": (1.0, 1e-3)}[mixed]
    x, y = np.array(points).T
    if not 0.02 < np.ptp(y) / np.ptp(x) < 1.8 or np.all(np.diff(y) <= 0.0):  # ground that rises nowhere is refused for that
        return
    with pytest.raises(ValueError, match=r"(in another unit|of different units).*ground|ground: line 2: .* in another unit"):
        ground_of("x,z\n" + "".join(f"{a * by_x},{b * by_z}\n" for a, b in points))


@given(sections())
def test_a_section_in_a_frame_of_its_own_is_read(points: Line) -> None:
    """Named x and y, from the toe of the slope as (0, 0)."""
    x, y = np.array(points).T
    local = np.column_stack([x - x[0], np.maximum.accumulate(y) - y[0]])
    if local[-1, 1] < 0.01 * local[-1, 0]:
        return
    line = [(float(a), float(b)) for a, b in np.vstack([[-40.0, 0.0], local, local[-1] + [40.0, 0.0]])]
    assert list(ground_of("x,y\n" + "".join(f"{a},{b}\n" for a, b in line)).points) == line


def test_idealised_ground_from_0_is_read() -> None:
    for line in (
        [(0, 0), (30, 0), (30, 25), (60, 25), (90, 25)],  # a vertical cut
        [(0, 0), (30, 0), (31, 25), (60, 26), (90, 27)],
        [(0, 20), (20, 20), (25, 0), (60, 0), (65, 20), (90, 20)],
        [(0, 10), (20, 10), (21, 6), (22, 10), (40, 10.5), (60, 20)],  # a ditch
        [(0, 0), (20, 25), (50, 25)],
    ):
        assert len(ground_of("x,y\n" + "".join(f"{x},{y}\n" for x, y in line)).points) == len(line)


def test_lines_of_a_file_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="line 4: '2,120,430': another line begins; leave one line in the file"):
        read(tmp_path, "Polygon,X,Z\n1,120,440\n1,150,441\n2,120,430\n2,150,431\n")


@pytest.mark.parametrize("head", ["Station,Elev_NAVD88", "x,NAVD88", "x,Elevation (NAVD88)", "x,NGVD29 elevation"])
def test_a_datum_of_feet_needs_a_unit(tmp_path: Path, head: str) -> None:
    with pytest.raises(ValueError, match=r"line 1: .*does not say its unit, often feet.*0\.3048 m"):
        read(tmp_path, f"{head}\n120,440\n150,441\n")


def test_every_refusal_names_the_file_and_the_row(tmp_path: Path) -> None:
    """Of ground and of water, in a scene and in ``sph new``."""
    file = tmp_path / "line.csv"
    for text, row in (("x,z\n0,1\n9,2\n8,3\n", "line 4"), ("x,z\n0,1\n9,-9999\n10,3\n", "line 3"), ("x,z\n0,1\n9,\n", "line 3")):
        file.write_text(text)
        for section, keys in ((GroundLine, {"shape": "ground_line", "base": -1.0}), (Water, {"pressure": "by_place"})):
            with pytest.raises(ValueError, match=rf"line\.csv: {row}"):
                validated(section, {"file": str(file)} | keys, "scene.yaml")
        with pytest.raises(ValueError, match=rf"line\.csv: {row}"):
            write_new(Known(file, [MOTION]), tmp_path / "out")
    file.write_text("x,z\n0,1\n9,2\n9,3\n")
    with pytest.raises(ValueError, match=r"line\.csv: line 4.*vertical"):
        validated(Water, {"file": str(file), "pressure": "by_place"}, "scene.yaml")
    file.write_text("".join(f"{at},1\n" for at in range(10_001)))
    with pytest.raises(ValueError, match=r"line\.csv: it holds 10,001 points, at most 10,000"):
        validated(GroundLine, {"shape": "ground_line", "base": -1.0, "file": str(file)}, "scene.yaml")
    with pytest.raises(ValueError, match="points.1: elevation 5500001 m"):
        validated(GroundLine, {"shape": "ground_line", "points": [(5e5, 5.5e3), (500001.0, 5500001.0)], "base": 0.0}, "scene.yaml")


def test_columns_without_names_that_are_swapped_are_refused(tmp_path: Path) -> None:
    """Of a slope of 1 : 4 either way; ground that is a profile as it stands is read, and so are swapped columns with names."""
    ground = [(0, 98.0), (40, 98.5), (60, 104), (90, 120), (140, 121)]
    back = [(0, 98.0), (40, 98.5), (60, 104), (90, 103.0), (140, 121)]
    for points, fault in ((ground, "may be swapped"), (back, None)):
        swapped = "\n".join(f"{y},{x}" for x, y in points)
        with pytest.raises(ValueError, match="may be swapped" if fault else "may be swapped.*turns back"):
            read(tmp_path, swapped)
        assert read(tmp_path, "\n".join(f"{x},{y}" for x, y in points)) == points
        assert read(tmp_path, f"elevation (m),x (m)\n{swapped}") == points


SEVERAL = """\
# two sections
section,chainage (m),elevation (m)
A,0,10
B,0,5
A,30,20
B,40,15
"""
FEATURES = (
    '{"type": "FeatureCollection", "features": ['
    '{"type": "Feature", "properties": {"name": "A"}, "geometry": {"type": "LineString", "coordinates": [[0, 10], [30, 20]]}},'
    '{"type": "Feature", "properties": {"name": "B"}, "geometry": {"type": "LineString", "coordinates": [[0, 5], [40, 15]]}}]}'
)


@pytest.mark.parametrize("text", [SEVERAL, SEVERAL.replace(",", ";"), FEATURES], ids=["comma", "semicolon", "features"])
def test_a_section_is_chosen_by_its_name(text: str, tmp_path: Path) -> None:
    path = tmp_path / "survey"
    path.write_text(text)
    assert read_line(path, section="A") == [(0, 10), (30, 20)] and read_line(path, section="B") == [(0, 5), (40, 15)]
    with pytest.raises(ValueError, match=r"section: 'C' is .*'A', 'B'"):
        read_line(path, section="C")


def test_a_fault_in_a_section_names_its_row(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text(SEVERAL.replace("B,40,15", "B,40,x"))
    with pytest.raises(ValueError, match="line 6"):
        read_line(path, section="B")


def test_an_outline_is_read_as_a_table_and_as_a_polygon(tmp_path: Path) -> None:
    corners = [(10.0, 2.0), (20.0, 2.0), (20.0, 8.0), (10.0, 8.0)]
    path = tmp_path / "lens"
    for text in (
        "x,y\n" + "".join(f"{x},{y}\n" for x, y in corners),
        "x,y\n" + "".join(f"{x},{y}\n" for x, y in [*corners, corners[0]]),
        "POLYGON ((10 2, 20 2, 20 8, 10 8, 10 2))",
        '{"type": "Polygon", "coordinates": [[[10, 2], [20, 2], [20, 8], [10, 8], [10, 2]]]}',
    ):
        path.write_text(text)
        assert read_outline(path) == corners, text
    path.write_text("POLYGON ((0 0, 9 0, 9 9, 0 0), (2 1, 3 1, 3 2, 2 1))")
    with pytest.raises(ValueError, match="expected one Polygon without holes"):
        read_outline(path)
