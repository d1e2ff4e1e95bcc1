"""Reading the line of a survey: CSV, GeoJSON or WKT, told apart by how they begin; and what no line in a vertical section is."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import shapely

from sph.scene.cells import COMMENT, cells, check_commas, counts_rows, listed, names, words
from sph.scene.configuration import DEEPEST, FileSection, key, one_line, read_text
from sph.scene.strict_json import parse_json, to_json
from sph.scene.units import Units, named, unit_of

QUANTITIES = {
    "x": set(
        [
            "x",
            "chainage",
            "ch",
            "station",
            "sta",
            "stn",
            "distance",
            "dist",
            "along",
            "line",
            "section",
            "profile",
            "abscissa",
            "offset",
            "horizontal",
            "entfernung",
            "abstand",
        ]
    ),
    "elevation": set(
        [
            "y",
            "z",
            "elevation",
            "elev",
            "level",
            "height",
            "altitude",
            "alt",
            "rl",
            "ground",
            "surface",
            "water",
            "table",
            "head",
            "phreatic",
            "vertical",
            "höhe",
            "hoehe",
            "kote",
            "cota",
            "quota",
        ]
    ),
}
"""Words of the columns' names."""
UNITS = {"m", "metre", "metres", "meter", "meters", "ft", "km", "in", "of", "the", "asl", "msl", "above", "sea", "a", "s", "l"}
"""Words that say nothing of the quantity."""
PLAN = {"easting", "eastings", "northing", "northings", "east", "north", "e", "n", "lon", "long", "longitude", "lat", "latitude"}
PLAN |= {"rechtswert", "hochwert", "ostwert", "nordwert"}
"""Words of coordinates in plan."""
SECTIONS = {"section", "sections", "profile", "line", "name", "id"}
"""Words of a column that names the sections of a file, beside ``PARTS``."""
PARTS = {"polygon", "linestring", "line", "string", "polyline", "part", "feature", "fid", "shape"}
"""Words of a column that numbers the lines of a file."""
DATUM = re.compile(r"(?<![a-z])(m?)[ _]?(?:navd|ngvd|dhhn|nhn|ahd|aod|odn|nap|egm|evrf)[ _-]?(?:\d{2,4})?(?![a-z\d])", re.IGNORECASE)
"""Names of the level from which elevations count, and an m before them: 'NAVD88', 'mAOD'."""
IN_FEET = re.compile("navd|ngvd", re.IGNORECASE)
"""Those of the United States, where elevations are in feet as often as in metres."""
WKT = re.compile(
    r"(SRID=\d+;)?\s*(MULTI)?(POINT|LINESTRING|LINEARRING|POLYGON|GEOMETRYCOLLECTION)\s*(?:ZM?|M)?\s*(\(|EMPTY\b)", re.IGNORECASE
)
MEASURED = re.compile(r"(?<!Z)(?<!Z )M\s*\(", re.IGNORECASE)
"""WKT whose third number is a measure along the line."""
EXPECTED = "expected two numbers, x and elevation in m"
IN_PLAN = "give distance along the section and elevation, or easting, northing and elevation as GeoJSON or as WKT (LINESTRING Z), in m"
METRES = Units({"m": 1.0}, r"[kcdmnu]m|ft|usft|inch(es)?|yds?|yards?|mi|miles?|deg(rees?)?|°", "m")
"""Feet are refused: they may be international or US survey feet, and the scene's other places are in m."""

EPSG = re.compile(r'"(?:urn:ogc:def:crs:)?EPSG:(?:[\d.]*:)?(\d+)"', re.IGNORECASE)
METRIC = (
    range(32601, 32661), range(32701, 32761), range(25828, 25839), range(26901, 26924), range(28348, 28359), range(7846, 7860),
    range(31254, 31260), range(31466, 31470), range(2443, 2462), range(6669, 6688), (2056, 21781, 27700, 2154, 2193, 3006, 3035),
)  # fmt: skip
"""EPSG codes of projected systems in metres: UTM on WGS 84, ETRS89 and NAD83, MGA of GDA94 and GDA2020, those of Austria, Germany, Japan,
Switzerland, Great Britain, France, New Zealand and Sweden, and that of Europe.  Web Mercator is none: its metres are stretched."""
STEEPEST = 100.0
"""Rise over length in plan from which on points near 0 may be degrees."""
LOWEST, HIGHEST = -500.0, 9000.0
"""Elevations between which all ground lies, m: from below the shore of the Dead Sea to above Mount Everest."""
MAX_POINTS = 10_000
NODATA = (0.0, -1.0, -9.0, -99.0, 999.0)
"""Elevations that tables hold where there are none, besides those that no ground has, as -9999."""
STEEP, STEEPER, HIGH = 2.0, 5.0, 100.0
"""Gradients beside a point with such an elevation and beside any point, and height (m) of several of them, from which on they are a gap
in the data and not ground, which would be a face of 63 or 79 degrees that alone is higher than all the rest of the line."""


class SurveyLine(FileSection):
    """A line whose points may stand in a file of the survey, alone or as one of several sections."""

    content: ClassVar[tuple[str, ...]] = ("points",)

    section: str | None = key(
        "name of one of several sections in the file: in a column section (CSV), or a property of its feature (GeoJSON); null: the file "
        "holds one line",
        default=None,
        min_length=1,
        max_length=200,
    )


class _InPlan(ValueError):
    """Coordinates in plan that are not known to be in metres, or that hold no elevation."""


def read_line(path: Path, steps: bool = True, section: Any = None) -> list[tuple[float, float]]:
    """Points (x, elevation) of the one line in a file, or of its ``section``, m, with vertical ``steps`` or without.  ValueError names the
    line or the point, and what is expected there.

    CSV: two columns between commas, semicolons, tabs or blanks; lines with '#' are left out, and between semicolons and tabs a comma is a
    decimal one; a row of names at the top decides which column is x and which the elevation, beside one that counts the rows; names, and
    lines with '#' before the points, may say m and no other unit.
    GeoJSON (a LineString, alone, in a Feature or in a collection of one) and WKT (LINESTRING): points with two numbers are x and
    elevation, unless a system of coordinates says that they lie in plan; with three they are easting, northing and elevation, and x is
    the distance along the line in plan.
    """
    found = _read(path, section)
    points, places = list(found.values()), list(found)
    check_line(points, places, steps)
    _check_gaps(points, places)
    return points


def read_outline(path: Path, section: Any = None) -> list[tuple[float, float]]:
    """Corners (x, elevation) of the one polygon in a file, or of its ``section``, m, in the forms of ``read_line``, each corner once; a
    GeoJSON or WKT may hold it as a Polygon.  ValueError as there."""
    found = _read(path, section, "Polygon")
    points, places = list(found.values()), list(found)
    check_elevations(points, places)
    return points[:-1] if points[0] == points[-1] else points


def _read(path: Path, section: Any, shape: str = "LineString") -> dict[str, tuple[float, float]]:
    """Points by their places in a file."""
    text = read_text(path)
    form = text.strip()
    kind = "GeoJSON" if form.startswith(("{", "[")) else "WKT" if WKT.match(form) else None
    if section is not None:
        form = text = _of_section(form if kind else text, kind, str(section))
    return _points(form, kind, shape) if kind else _table(text, shape)


def _of_section(text: str, kind: str | None, section: str) -> str:
    """A file with one of its sections alone; a table keeps the numbers of its lines.  ValueError names the sections that it holds."""
    if kind == "WKT":
        raise ValueError(f"section: {section[:80]!r}: WKT names no sections; give CSV with a column section, or GeoJSON with a property")
    if kind == "GeoJSON":
        data = parse_json(text)
        features = data.get("features") if isinstance(data, dict) else None
        owned = [each.get("properties") or {} if isinstance(each, dict) else {} for each in features or ()]
        kept = [each for each, own in zip(features or (), owned, strict=True) if section in map(str, own.values())]
        if not kept:
            some = _some(str(one) for own in owned for one in own.values())
            raise ValueError(f"section: {section[:80]!r} is no property of a feature; they have {some}")
        return to_json({**data, "features": kept})
    lines = text.splitlines()
    rows = [(at, cells(line)) for at, line in enumerate(lines) if any(cells(line)) and not line.lstrip().startswith(COMMENT)]
    head = names(lines[rows[0][0]], lines[rows[-1][0]]) if rows else []
    columns = [at for at, name in enumerate(head) if words(name) and (SECTIONS | PARTS).issuperset(words(name))]
    named = [at for at in columns if any(texts[at : at + 1] == [section] for _, texts in rows[1:])]
    if len(named) != 1:
        held = "; ".join(f"{head[at]!r} holds {_some(texts[at] for _, texts in rows[1:] if at < len(texts))}" for at in columns)
        raise ValueError(
            f"section: {section[:80]!r} is in {len(named) or 'no'} column of sections; {held or 'no column is called section'}"
        )
    kept_lines = [line if line.lstrip().startswith(COMMENT) else "" for line in lines]
    for number, (at, texts) in enumerate(rows):
        if number == 0 or texts[named[0] : named[0] + 1] == [section]:
            own = head if number == 0 else texts
            kept_lines[at] = ";".join(text for place, text in enumerate(own) if place != named[0])
    return "\n".join(kept_lines)


def _some(values: Iterable[str]) -> str:
    found = list(dict.fromkeys(values))
    return listed(found[:10]) + ", ..." * (len(found) > 10) if found else "none"


def _check_order(points: list[tuple[float, float]]) -> None:
    """Refuse columns without names that are no profile, or a steep one, and a better one with x and elevation swapped."""
    x, y = np.array(points, float).T
    goes_on, rises_on = ((np.diff(each) >= 0.0).all() or (np.diff(each) <= 0.0).all() for each in (x, y))
    if rises_on and (not goes_on or np.ptp(y) > STEEP * np.ptp(x)) and np.ptp(x) <= STEEP * np.ptp(y):
        raise ValueError(
            f"its columns have no names and may be swapped: as x and elevation the line spreads over {np.ptp(x):.4g} m and rises by "
            f"{np.ptp(y):.4g} m{'' if goes_on else ', and turns back'}; write their names above them, as x (m),elevation (m)"
        )


def check_line(points: Sequence[tuple[float, float]], places: Sequence[str], steps: bool = True) -> None:
    """Refuse points (x, elevation) of a line in a vertical section, m, that no ground has, and a line that turns back, or with ``steps``
    false is vertical; ValueError names one of the ``places`` that the points have in their file or scene."""
    check_elevations(points, places)
    x = np.array(points, float)[:, 0]
    along = np.diff(x) * (1.0 if x[-1] >= x[0] else -1.0)
    back = np.flatnonzero(along < 0.0 if steps else along <= 0.0)
    if back.size:
        (x1, y1), (x2, y2) = points[back[0]], points[back[0] + 1]
        fault = "the line may not overhang" if steps else "the line may not overhang or be vertical"
        raise ValueError(f"{places[back[0] + 1]}: ({x2:.10g}, {y2:.10g}) m lies behind ({x1:.10g}, {y1:.10g}) m; {fault}")


def check_elevations(points: Sequence[tuple[float, float]], places: Sequence[str]) -> None:
    """Refuse points (x, elevation) that no ground has, m, and too many; ValueError as ``check_line``."""
    if len(points) > MAX_POINTS:
        raise ValueError(f"it holds {len(points):,} points, at most {MAX_POINTS:,}; leave some out")
    y = np.array(points, float)[:, 1]
    wrong = np.flatnonzero((y < LOWEST) | (y > HIGHEST))
    if wrong.size:
        remedy = "leave out points without data"
        if wrong.size == y.size:
            remedy = f"it is a northing or in another unit than m: {IN_PLAN}; the elevation of a sea floor may count from a nearer level"
        raise ValueError(
            f"{places[wrong[0]]}: elevation {y[wrong[0]]:.10g} m: no ground lies below {LOWEST:g} m or above {HIGHEST:,g} m; {remedy}"
        )


def _check_gaps(points: list[tuple[float, float]], places: list[str]) -> None:
    """Refuse elevations that stand for none: of points whose height over or below those beside them exceeds that of all other ground."""
    x, y = np.array(points).T
    edges = [0, *(np.flatnonzero(np.diff(y)) + 1).tolist(), len(points)]
    for first, last in zip(edges, [edge - 1 for edge in edges[1:]], strict=False):
        others = np.delete(y, slice(first, last + 1))
        beside = [(one, other) for one, other in ((first, first - 1), (last, last + 1)) if 0 <= other < len(points)]
        if others.size < 3 or np.ptp(others) == 0.0:
            continue
        named = y[first] in NODATA and (first == last or all(abs(y[other] - y[one]) > HIGH for one, other in beside))
        steep = STEEP if named else STEEPER
        if not named and not (first == last and len(beside) == 2):
            continue
        if all(abs(y[other] - y[one]) > max(np.ptp(others), steep * abs(x[other] - x[one])) for one, other in beside):
            raise ValueError(
                f"{places[first]}: elevation {y[first]:.10g} m beside {y[beside[0][1]]:.10g} m, where all other points lie within "
                f"{np.ptp(others):.4g} m: leave out points without data; of ground that is so steep give a second point as high or low"
            )


def _table(text: str, shape: str) -> dict[str, tuple[float, float]]:
    """Points by the numbers of their lines; those of a line need not have names above them where their order is plain."""
    points: dict[str, tuple[float, float]] = {}
    comment: tuple[int, str] | None = None
    head: tuple[int, str] | None = None
    places: tuple[int, int] | None = None
    parts: list[int] = []
    part: list[str] = []
    lines = text.splitlines()
    check_commas(lines)
    for number, line in enumerate(lines, start=1):
        texts = cells(line)
        if line.lstrip().startswith(COMMENT):
            if not points:
                comment = number, line.strip(" \t#")
                if any(size is None and not beside_number for size, beside_number in named(line, METRES)):
                    _check_metres(number, [line])
            continue
        if not any(texts):
            continue
        if head is None and not points and not any(map(_is_number, texts)) and re.match(r"[^\W\d_]|[,;\t]", line.lstrip(' "')):
            head = number, line
            continue
        if places is None:
            places, parts = _places(head, comment, line)
        try:
            if len(texts) != (2 if head is None else len(names(head[1], line))):
                raise ValueError("another number of columns")
            x, y = (float(texts[place]) for place in places)
        except (ValueError, IndexError) as error:
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}") from error
        if not np.isfinite([x, y]).all():
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}")
        part = part or [texts[place] for place in parts]
        if part != [texts[place] for place in parts]:
            raise ValueError(
                f"line {number}: {one_line(line.strip(), 60)!r}: another line begins; leave one line in the file, "
                "or choose one by the key section"
            )
        points[f"line {number}"] = x, y
    if len(points) < 2:
        raise ValueError(f"it holds {len(points) or 'no'} point{'s' * (not points)}; {EXPECTED}, on each of at least two lines")
    said = [] if comment is None else [_quantity(name) for name in names(comment[1], lines[-1])]
    if head is None and sorted(filter(None, said)) != ["elevation", "x"] and shape == "LineString":
        check_elevations(list(points.values()), list(points))
        _check_order(list(points.values()))
    return points


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _places(head: tuple[int, str] | None, comment: tuple[int, str] | None, line: str) -> tuple[tuple[int, int], list[int]]:
    """Places of x and elevation by the names above the first line of numbers, the first and the second column without names; and of columns
    that number the lines of the file."""
    if head is None:
        if comment is None or [_quantity(name) for name in names(comment[1], line)] != ["elevation", "x"]:
            return (0, 1), []
        head = comment
    number, text = head
    _check_metres(number, re.split("[,;\t]", text))
    found = names(text, line)
    kinds = [_quantity(name) for name in found]
    remedy = "name one column for x (x, chainage, station, distance) and one for the elevation (elevation, z, y, level), both in m"
    unknown = [name for name, kind in zip(found, kinds, strict=True) if kind is None]
    if unknown and all(PLAN.issuperset(words(name)) for name in unknown):
        raise ValueError(f"line {number}: {listed(unknown)} are places in plan (columns {listed(found)}); {IN_PLAN}")
    if unknown:
        raise ValueError(
            f"line {number}: {listed(unknown)} is neither x nor an elevation (columns {listed(found)}); leave it out, or {remedy}"
        )
    places = [[place for place, kind in enumerate(kinds) if kind == wanted] for wanted in ("x", "elevation")]
    if [len(each) for each in places] != [1, 1]:
        raise ValueError(
            f"line {number}: {listed(found)} name {len(places[0])} columns of x and {len(places[1])} of elevation, "
            f"must be one of each; {remedy}, or give points with easting, northing and elevation as GeoJSON or WKT"
        )
    return (places[0][0], places[1][0]), [place for place, kind in enumerate(kinds) if kind == "part"]


def _quantity(name: str) -> str | None:
    """x, elevation, index or part, by the name of a column; None where it states none."""
    said = [word for word in words(DATUM.sub(r"\1 elevation ", name)) if word not in UNITS]
    if counts_rows(name):
        return "index"
    if said and PARTS.issuperset(said):
        return "part"
    return next((what for what, known in QUANTITIES.items() if said and known.issuperset(said)), None)


def _check_metres(number: int, names: list[str]) -> None:
    for name in names:
        plain = DATUM.sub(r"\1 ", name)
        try:
            if IN_FEET.search(name) and not any(named(plain, METRES)):
                raise ValueError(f"{name.strip()[:80]!r} does not say its unit, often feet; it must be m: write it as in 'elevation (m)'")
            unit_of(plain, METRES)
        except ValueError as error:
            raise ValueError(f"line {number}: {error} (a foot is 0.3048 m, a US survey foot 1200/3937 m)") from error


def _systems(value: Any) -> Iterator[Any]:
    """The systems of coordinates that are named anywhere in a GeoJSON."""
    if isinstance(value, dict):
        if value.get("crs") is not None:
            yield value["crs"]
        value = list(value.values())
    for part in value if isinstance(value, list) else ():
        if isinstance(part, dict | list):
            yield from _systems(part)


def _check_system(crs: Any) -> None:
    """Refuse a system of coordinates that is not known to be in metres."""
    found = EPSG.search(to_json(crs))
    if not (found and any(int(found[1]) in codes for codes in METRIC)):
        raise _InPlan(
            f"crs: {one_line(to_json(crs), 120)}: must be a system of coordinates that is known to be in metres, as EPSG:32632 (UTM), "
            "EPSG:25832, EPSG:2056 or EPSG:27700; project the line to one, or convert it to metres and leave crs out"
        )


def _points(text: str, form: str, shape: str) -> dict[str, tuple[float, float]]:
    """Points of the only line, or of the outside of the only polygon, by their numbers."""
    systems: list[Any] = []
    try:
        # What is nested too deeply would end the process.
        if form == "GeoJSON":
            systems = list(_systems(parse_json(text)))
            for crs in systems:
                _check_system(crs)
        elif MEASURED.search(text):
            raise _InPlan(f"it is a line with a measure (M), which is no elevation; {IN_PLAN}")
        elif len(re.findall("GEOMETRYCOLLECTION", text, re.IGNORECASE)) > DEEPEST:
            raise ValueError(f"it is nested deeper than {DEEPEST} levels")
        with np.errstate(invalid="ignore"):
            found = shapely.from_geojson(text) if form == "GeoJSON" else shapely.from_wkt(text)
    except _InPlan:
        raise
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise ValueError(f"it is not {form} of a line: {one_line(str(error), 200)}") from error
    lines = [part for part in shapely.get_parts(shapely.get_parts(found)) if not part.is_empty]
    if shape == "Polygon":
        lines = [part.exterior if part.geom_type == "Polygon" and not part.interiors else part for part in lines]
    if len(lines) != 1 or lines[0].geom_type not in ("LineString", "LinearRing"):
        kinds = ", ".join(part.geom_type for part in lines[:5]) or f"an empty {found.geom_type}"
        raise ValueError(f"it holds {kinds}; expected one {shape}{' without holes' * (shape == 'Polygon')}")
    points = shapely.get_coordinates(lines[0], include_z=True)
    solid = np.isfinite(points[:, 2]).any()
    if systems and not solid:
        raise ValueError(
            f"crs: {one_line(to_json(systems[0]), 120)}: its points have two coordinates, which lie in plan and hold no elevation; "
            f"{IN_PLAN}; of points that are distance and elevation leave crs out"
        )
    for number, point in enumerate(points if solid else points[:, :2], start=1):
        if not np.isfinite(point).all():
            raise ValueError(f"point {number}: {point.tolist()}: {EXPECTED}, or easting, northing and elevation at every point")
    if solid and (np.abs(points[:, :2]) <= (180.0, 90.0)).all():
        plan, rise = (float(np.hypot(*size)) for size in (np.ptp(points[:, :2], axis=0), (np.ptp(points[:, 2]), 0.0)))
        if rise > STEEPEST * plan > 0.0:
            raise ValueError(
                f"its points rise by {rise:.4g} m over {plan:.4g} in plan and are within 180 and 90: they may be degrees of longitude and "
                "latitude, the coordinates of GeoJSON; project the line to a system in metres, as UTM, or give x and elevation"
            )
    if solid and shape == "Polygon":
        raise ValueError("its corners have easting, northing and elevation; give distance along the section and elevation, in m")
    if solid:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])
        points = np.column_stack([along, points[:, 2]])
    return {f"point {number}": (float(x), float(y)) for number, (x, y) in enumerate(points[:, :2], start=1)}
