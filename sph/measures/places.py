"""Places in front of the slope, such as a road: how far debris goes past them, how deep it lies there and when it arrives."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from sph.measures.linked import largest_mass
from sph.output.run import Run
from sph.scene.geometry import SLOPES, Slope
from sph.scene.ground_line import GroundLine
from sph.scene.places import Coordinate
from sph.scene.schema import Scene
from sph.storage.trajectory import Variable

BEYOND = re.compile(r"^([0-9]+(?:\.[0-9]+)?) (?:m )?beyond the toe$")
"""A place by its distance from the toe, m."""

PlaceName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$")]
PlaceAt = Coordinate | Annotated[str, Field(pattern=BEYOND.pattern)]
"""x in the coordinates of the scene, or a distance such as '12 beyond the toe', m."""

PASSED, DEPTH, ARRIVAL = "passed", "depth", "arrival"
"""What is measured at a place: the ends of the names of its columns."""


def column_of(place: str, quantity: str) -> str:
    """Name of the column of a quantity at a place."""
    return f"{place}_{quantity}"


def place_columns(places: Iterable[str]) -> tuple[Variable, ...]:
    """The columns of some places in a table with a row per run."""
    texts = {
        PASSED: ("m", "run-out less the distance of {} from the toe: how far debris goes past it; negative where it stops short"),
        DEPTH: ("m", "largest height above the initial ground, within a spacing of {}, of soil in the largest linked mass, at the end"),
        ARRIVAL: ("s", "time of the first frame in which slope material, as counted for the run-out, reaches {}; NaN if it never does"),
    }
    return tuple(
        Variable(column_of(place, quantity), ("row",), "f8", units, text.format(place))
        for place in places
        for quantity, (units, text) in texts.items()
    )


def places_in(columns: Iterable[str]) -> list[str]:
    """The places that the columns of a table are of."""
    return [name.removesuffix(f"_{PASSED}") for name in columns if name.endswith(f"_{PASSED}")]


def beyond_toe(at: float | str, geometry: Slope | GroundLine) -> float:
    """Distance of a place from the toe, m; positive in front of the slope."""
    written = BEYOND.match(str(at))
    if written:
        return float(written[1])
    x, _ = geometry.in_box(float(at), 0.0)
    return geometry.toe[0] - x


def check_places(places: Mapping[str, float | str], scene: Scene, where: str) -> None:
    """ValueError beginning with ``where`` for a place that is not in front of the slope of a scene."""
    geometry = scene.geometry
    for name, at in places.items():
        if not isinstance(geometry, SLOPES):
            raise ValueError(
                f"{where}: metrics.places.{name}: {at!r}: a place needs geometry.shape slope or ground_line, not {geometry.shape}"
            )
        distance, most = beyond_toe(at, geometry), geometry.toe[0]
        if not 0.0 < distance <= most:
            ends = [geometry.in_survey(x, 0.0)[0] for x in (geometry.toe[0], 0.0)]
            raise ValueError(
                f"{where}: metrics.places.{name}: {at!r}: must lie in front of the toe and within the model, at most {most:.4g} m beyond "
                f"the toe (x from {ends[0]:.6g} to {ends[1]:.6g} m); lengthen the apron to include it"
            )


class Debris(NamedTuple):
    """Slope material of a run, as the run-out counts it."""

    behind: np.ndarray  # (soil,) which lay behind the toe and above its level initially
    moved: float  # displacement beyond which it counts, m
    link: float  # distance up to which particles hang together as one mass, m
    shift: float  # by which the soil's shape lies to the left of its place in the scene, m


def at_places(run: Run, places: Mapping[str, float | str], debris: Debris, runout: float) -> dict[str, float]:
    """The columns of ``place_columns`` of a finished run whose geometry has a slope."""
    geometry, spacing, values = run.scene.geometry, run.scene.numerics.spacing, dict[str, float]()
    assert isinstance(geometry, SLOPES)
    x, y = run.soil_at(-1, "x", "y")
    mass, x = largest_mass(x, y, debris.link), x + debris.shift
    height = y + 0.5 * spacing - np.interp(x, *geometry.surface)
    distances = {name: beyond_toe(at, geometry) for name, at in places.items()}
    arrivals = _arrivals(run, spacing, {name: geometry.toe[0] - distance for name, distance in distances.items()}, debris)
    for name, distance in distances.items():
        here = mass & (np.abs(x - (geometry.toe[0] - distance)) <= spacing)
        values[column_of(name, PASSED)] = runout - distance
        values[column_of(name, DEPTH)] = max(0.0, float(height[here].max(initial=0.0)))
        values[column_of(name, ARRIVAL)] = arrivals[name]
    return values


def _arrivals(run: Run, spacing: float, places: Mapping[str, float], debris: Debris) -> dict[str, float]:
    """Time (s) of the first frame in which the front is at each place, by its x in the box; NaN where it never is."""
    found = dict.fromkeys(places, math.nan)
    for frame, time in enumerate(run["time"][run.gravity_frame :], run.gravity_frame):
        x, y = run.soil_at(frame, "x", "y")
        moved = np.hypot(*run.displacement(frame))[run.soil] > debris.moved
        edge = np.where(debris.behind & moved, x + debris.shift - 0.5 * spacing, math.inf)
        open_places = [name for name, place in places.items() if math.isnan(found[name]) and edge.min(initial=math.inf) <= place]
        if open_places:
            front = float(edge[largest_mass(x, y, debris.link)].min(initial=math.inf))
            found |= {name: float(time) for name in open_places if front <= places[name]}
    return found
