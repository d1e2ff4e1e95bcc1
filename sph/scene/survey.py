"""Reading the line of a survey: CSV, GeoJSON or WKT, told apart by how they begin."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from sph.scene.cells import COMMENT, cells, check_commas, counts_rows, listed, names, words
from sph.scene.configuration import DEEPEST, one_line, read_text
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
WKT = re.compile(r"(SRID=\d+;)?\s*(MULTI)?(POINT|LINESTRING|LINEARRING|POLYGON|GEOMETRYCOLLECTION)\b", re.IGNORECASE)
EXPECTED = "expected two numbers, x and elevation in m"
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


class _UnknownSystem(ValueError):
    """A system of coordinates that is not known to be in metres."""


def read_line(path: Path) -> list[tuple[float, float]]:
    """Points (x, elevation) of the one line in a file, m.  ValueError names the line or the point, and what is expected there.

    CSV: two columns between commas, semicolons, tabs or blanks; lines with '#' are left out, and between semicolons and tabs a comma is a
    decimal one; a row of names at the top decides which column is x and which the elevation, beside one that counts the rows; names, and
    lines with '#' before the points, may say m and no other unit.
    GeoJSON (a LineString, alone, in a Feature or in a collection of one) and WKT (LINESTRING): points with two numbers are x and
    elevation; with three they are easting, northing and elevation, and x is the distance along the line in plan.
    """
    text = read_text(path)
    form = text.strip()
    if form.startswith(("{", "[")):
        return _points(form, "GeoJSON")
    return _points(form, "WKT") if WKT.match(form) else _table(text)


def _table(text: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    comment: tuple[int, str] | None = None
    head: tuple[int, str] | None = None
    places: tuple[int, int] | None = None
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
            places = _places(head, comment, line)
        try:
            if len(texts) != (2 if head is None else len(names(head[1], line))):
                raise ValueError("another number of columns")
            x, y = (float(texts[place]) for place in places)
        except (ValueError, IndexError) as error:
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}") from error
        if not np.isfinite([x, y]).all():
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}")
        points.append((x, y))
    if len(points) < 2:
        raise ValueError(f"it holds {len(points) or 'no'} point{'s' * (not points)}; {EXPECTED}, on each of at least two lines")
    return points


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _places(head: tuple[int, str] | None, comment: tuple[int, str] | None, line: str) -> tuple[int, int]:
    """Places of x and elevation by the names above the first line of numbers; the first and the second column without names."""
    if head is None:
        if comment is None or [_quantity(name) for name in names(comment[1], line)] != ["elevation", "x"]:
            return 0, 1
        head = comment
    number, text = head
    _check_metres(number, re.split("[,;\t]", text))
    found = names(text, line)
    kinds = [_quantity(name) for name in found]
    remedy = "name one column for x (x, chainage, station, distance) and one for the elevation (elevation, z, y, level), both in m"
    unknown = [name for name, kind in zip(found, kinds, strict=True) if kind is None]
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
    return places[0][0], places[1][0]


def _quantity(name: str) -> str | None:
    """x, elevation or index, by the name of a column; None where it states neither."""
    said = [word for word in words(name) if word not in UNITS]
    if counts_rows(name):
        return "index"
    return next((what for what, known in QUANTITIES.items() if said and known.issuperset(said)), None)


def _check_metres(number: int, names: list[str]) -> None:
    for name in names:
        try:
            unit_of(name, METRES)
        except ValueError as error:
            raise ValueError(f"line {number}: {error} (a foot is 0.3048 m, a US survey foot 1200/3937 m)") from error


def _check_crs(value: Any) -> None:
    """Refuse a system of coordinates, wherever in a GeoJSON it is named, that is not known to be in metres."""
    if isinstance(value, dict):
        crs = value.get("crs")
        found = EPSG.search(to_json(crs))
        if crs is not None and not (found and any(int(found[1]) in codes for codes in METRIC)):
            raise _UnknownSystem(
                f"crs: {one_line(to_json(crs), 120)}: must be a system of coordinates that is known to be in metres, as EPSG:32632 (UTM), "
                "EPSG:25832, EPSG:2056 or EPSG:27700; project the line to one, or convert it to metres and leave crs out"
            )
        value = list(value.values())
    for part in value if isinstance(value, list) else ():
        if isinstance(part, dict | list):
            _check_crs(part)


def _points(text: str, form: str) -> list[tuple[float, float]]:
    try:
        # What is nested too deeply would end the process.
        if form == "GeoJSON":
            _check_crs(parse_json(text))
        elif len(re.findall("GEOMETRYCOLLECTION", text, re.IGNORECASE)) > DEEPEST:
            raise ValueError(f"it is nested deeper than {DEEPEST} levels")
        with np.errstate(invalid="ignore"):
            found = shapely.from_geojson(text) if form == "GeoJSON" else shapely.from_wkt(text)
    except _UnknownSystem:
        raise
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise ValueError(f"it is not {form} of a line: {one_line(str(error), 200)}") from error
    lines = [part for part in shapely.get_parts(shapely.get_parts(found)) if not part.is_empty]
    if len(lines) != 1 or lines[0].geom_type != "LineString":
        kinds = ", ".join(part.geom_type for part in lines[:5]) or f"an empty {found.geom_type}"
        raise ValueError(f"it holds {kinds}; expected one LineString")
    points = shapely.get_coordinates(lines[0], include_z=True)
    solid = np.isfinite(points[:, 2]).any()
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
    if solid:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])
        points = np.column_stack([along, points[:, 2]])
    return [(float(x), float(y)) for x, y in points[:, :2]]
