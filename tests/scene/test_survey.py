"""Lines of a survey in the formats that people have them in, whole and broken."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from sph.scene.survey import read_line

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


X = ["x", "chainage (m)", "Station", "distance", "Distance along section (m)"]
ELEVATION = ["elevation", "z (m)", "y", "level", "Höhe (m)", "elev (m a.s.l.)"]


@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("order", [(0, 1, 2), (1, 0, 2), (2, 1, 0), (2, 0, 1), (0, 1), (1, 0)])
@pytest.mark.parametrize("elevation", ELEVATION)
@pytest.mark.parametrize("x", X)
def test_names_decide_which_column_is_the_elevation(tmp_path: Path, x: str, elevation: str, order: tuple[int, ...], mark: str) -> None:
    rows = [[x, elevation, ""], *([str(a), str(b), str(at)] for at, (a, b) in enumerate(LINE))]
    assert read(tmp_path, "\n".join(mark.join(row[place] for place in order) for row in rows)) == LINE


def test_names_in_a_comment_swap_the_columns(tmp_path: Path) -> None:
    assert read(tmp_path, "# elevation (m),x (m)\n440,120\n440.5,150\n465,170\n") == LINE


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("x,depth", r"line 1: 'depth' .*\(columns 'x', 'depth'\)"),
        ("x,slope", "'slope' is neither"),
        ("lon,lat", "'lon', 'lat' is neither"),
        ("easting,northing,elevation", "'easting', 'northing' is neither"),
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
    """The line with a system of coordinates in one of its objects."""
    crs = {"type": "name", "properties": {"name": name}} if isinstance(name, str) else name
    feature = FEATURE | ({"crs": crs} if at == "feature" else {})
    if at == "geometry":
        feature["geometry"] = {**FEATURE["geometry"], "crs": crs}  # type: ignore[dict-item]
    return json.dumps({"type": "FeatureCollection", "features": [feature]} | ({"crs": crs} if at == "collection" else {}))


@pytest.mark.parametrize("at", ["collection", "feature", "geometry"])
def test_a_system_of_coordinates_is_in_metres_or_refused(tmp_path: Path, at: str) -> None:
    for name in ("urn:ogc:def:crs:EPSG::32632", "EPSG:25832", "urn:ogc:def:crs:EPSG:9.2:2056", "epsg:27700", None):
        assert read(tmp_path, system(name, at)) == LINE
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
