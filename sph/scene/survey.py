"""Reading the line of a survey: CSV, GeoJSON or WKT, told apart by how they begin."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import shapely

from sph.scene.cells import cells
from sph.scene.configuration import DEEPEST, one_line, read_text
from sph.scene.strict_json import parse_json
from sph.scene.units import Units, named, unit_of

WKT = re.compile(r"(SRID=\d+;)?\s*(MULTI)?(POINT|LINESTRING|LINEARRING|POLYGON|GEOMETRYCOLLECTION)\b", re.IGNORECASE)
EXPECTED = "expected two numbers, x and elevation in m"
METRES = Units({"m": 1.0}, r"[kcdmnu]m|ft|usft|inch(es)?|yds?|yards?|mi|miles?|deg(rees?)?|°", "m")
"""Feet are refused: they may be international or US survey feet, and the scene's other places are in m."""


def read_line(path: Path) -> list[tuple[float, float]]:
    """Points (x, elevation) of the one line in a file, m.  ValueError names the line or the point, and what is expected there.

    CSV: two columns between commas, semicolons, tabs or blanks; a row of names at the top and lines with '#' are left out, and
    between semicolons and tabs a comma is a decimal one; names, and lines with '#' before the points, may say m and no other unit.
    GeoJSON (a LineString, alone, in a Feature or in a collection of one) and WKT (LINESTRING): points with two numbers are x and
    elevation; with three they are easting, northing and elevation, and x is the distance along the line in plan.
    """
    text = read_text(path).strip()
    if text.startswith(("{", "[")):
        return _points(text, "GeoJSON")
    return _points(text, "WKT") if WKT.match(text) else _table(text)


def _table(text: str) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    names_allowed = True
    for number, line in enumerate(text.splitlines(), start=1):
        words = cells(line)
        if line.lstrip().startswith("#"):
            if not points and any(size is None and not beside_number for size, beside_number in named(line, METRES)):
                _check_metres(number, [line])
            continue
        if not any(words):
            continue
        try:
            x, y = map(float, words)
        except ValueError as error:
            if names_allowed and words[0][:1].isalpha():
                names_allowed = False
                _check_metres(number, re.split("[,;\t]", line))
                continue
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}") from error
        if not np.isfinite([x, y]).all():
            raise ValueError(f"line {number}: {one_line(line.strip(), 60)!r}: {EXPECTED}")
        points.append((x, y))
        names_allowed = False
    if len(points) < 2:
        raise ValueError(f"it holds {len(points) or 'no'} point{'s' * (not points)}; {EXPECTED}, on each of at least two lines")
    return points


def _check_metres(number: int, names: list[str]) -> None:
    for name in names:
        try:
            unit_of(name, METRES)
        except ValueError as error:
            raise ValueError(f"line {number}: {error} (a foot is 0.3048 m, a US survey foot 1200/3937 m)") from error


def _points(text: str, form: str) -> list[tuple[float, float]]:
    try:
        # What is nested too deeply would end the process.
        if form == "GeoJSON":
            parse_json(text)
        elif len(re.findall("GEOMETRYCOLLECTION", text, re.IGNORECASE)) > DEEPEST:
            raise ValueError(f"it is nested deeper than {DEEPEST} levels")
        with np.errstate(invalid="ignore"):
            found = shapely.from_geojson(text) if form == "GeoJSON" else shapely.from_wkt(text)
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
    if solid:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))])
        points = np.column_stack([along, points[:, 2]])
    return [(float(x), float(y)) for x, y in points[:, :2]]
