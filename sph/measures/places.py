"""Places before, on or behind the slope, such as a road: when debris comes, how deep and fast, with what pressure, and what it leaves.

Debris at a place is soil of the largest linked mass that lay behind the place and above its level initially, has moved more than
``moved_threshold`` and is within a spacing of the place; for places in front of the toe it lay behind the toe and above its level, as for
the run-out.  It is there from a depth of ``debris_depth`` on, at least of half a spacing: less is the roughness of a row of particles.
On the slope and behind its crest the ground of a place may itself slide away, which ``ground_displacement`` tells.
"""

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

PASSED, DEPTH, ARRIVAL, REACHED, PEAK_DEPTH = "passed", "depth", "arrival", "reached", "peak_depth"
PEAK_SPEED, FRONT_SPEED, PRESSURE, GROUND = "peak_speed", "front_speed", "impact_pressure", "ground_displacement"
"""What is measured at a place: the ends of the names of its columns."""


def column_of(place: str, quantity: str) -> str:
    """Name of the column of a quantity at a place."""
    return f"{place}_{quantity}"


def place_columns(places: Iterable[str]) -> tuple[Variable, ...]:
    """The columns of some places in a table with a row per run."""
    texts = {
        PASSED: (
            "m",
            "run-out less the distance of {} from the toe: how far debris goes past it; negative where it stops short; of a place on the "
            "slope, its distance from the front of the debris from above it, NaN if there is none",
        ),
        DEPTH: (
            "m",
            "largest height above the initial ground, within a spacing of {}, of soil in the largest linked mass, at the end; 0 if no "
            "debris is there",
        ),
        ARRIVAL: ("s", "time of the first frame in which debris, as counted for the run-out, reaches {}; NaN if it never does"),
        REACHED: ("1", "1 if {0}_peak_depth is at least debris_depth and half a spacing: debris reaches {0}; else 0"),
        PEAK_DEPTH: ("m", "largest value of {}_depth in any frame"),
        PEAK_SPEED: ("m s-1", "largest speed of a single particle of debris at {} in any frame; 0 if none comes"),
        FRONT_SPEED: ("m s-1", "mean speed of the debris at {} in the first frame in which it is there; NaN if none comes"),
        PRESSURE: (
            "Pa",
            "impact_factor times the mean of density times squared speed over the debris at {}, in the frame in which that is largest: "
            "over its depth, not that of its fastest particle; 0 if none comes",
        ),
        GROUND: ("m", "largest displacement at the end of the soil that lay within a spacing of {} and of the ground"),
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
    """Distance of a place from the toe, m; positive in front of the slope, negative on it."""
    written = BEYOND.match(str(at))
    if written:
        return float(written[1])
    x, _ = geometry.in_box(float(at), 0.0)
    return geometry.toe[0] - x


def foot_of(at: float | str, geometry: Slope | GroundLine) -> tuple[float, float]:
    """Where a place lies on the initial ground, in the box, m."""
    x = geometry.toe[0] - beyond_toe(at, geometry)
    return x, float(geometry.ground(np.array([x]))[0])


def check_places(places: Mapping[str, float | str], scene: Scene, where: str) -> None:
    """ValueError beginning with ``where`` for a place outside the model of a scene, or of one that has no slope."""
    geometry = scene.geometry
    for name, at in places.items():
        if not isinstance(geometry, SLOPES):
            raise ValueError(
                f"{where}: metrics.places.{name}: {at!r}: a place needs geometry.shape slope or ground_line, not {geometry.shape}"
            )
        toe_x = geometry.toe[0]
        if not toe_x - geometry.width <= beyond_toe(at, geometry) <= toe_x:
            ends = [geometry.in_survey(x, 0.0)[0] for x in (geometry.width, 0.0)]
            raise ValueError(
                f"{where}: metrics.places.{name}: {at!r}: must lie within the model, at most {toe_x:.4g} m beyond the toe "
                f"(x from {ends[0]:.6g} to {ends[1]:.6g} m); lengthen the apron or the crest to include it"
            )


def check_same_places(places: Mapping[str, float | str], scene: Scene, base: Scene, where: str) -> None:
    """ValueError beginning with ``where`` for a place that an alternative moves, since its toe is not that of the scene as it is."""
    geometry, before = scene.geometry, base.geometry
    for name, at in places.items():
        assert isinstance(geometry, SLOPES) and isinstance(before, SLOPES)
        now, then = (of.in_survey(foot_of(at, of)[0], 0.0)[0] for of in (geometry, before))
        if not math.isclose(now, then, abs_tol=1e-6):
            raise ValueError(
                f"{where}: metrics.places.{name}: {at!r}: lies at x = {now:.6g} m here and at {then:.6g} m in the scene as it is, since "
                f"the alternative moves the toe; give its x, {then:.6g}"
            )


class Debris(NamedTuple):
    """What counts as debris in a run."""

    x0: np.ndarray  # (soil,) initial places as they are asked on which side of a boundary they lie, m
    y0: np.ndarray
    moved: float  # displacement beyond which soil counts, m
    link: float  # distance up to which particles hang together as one mass, m
    shift: float  # by which the soil's shape lies to the left of its place in the scene, m

    def behind(self, x: float, y: float) -> np.ndarray:
        """Which soil (soil,) lay behind a place (x, y) in the box, m, and above its level initially."""
        return (self.x0 > x) & (self.y0 > y)


class _Seen(NamedTuple):
    """Debris at a place in a frame."""

    front: float  # x of the most advanced debris, less half a spacing, m; infinite without debris
    depth: float  # m
    fastest: float  # m/s
    mean: float  # m/s; NaN if none is at the place
    pressure: float  # mean of density times squared speed, Pa


_NOTHING = _Seen(math.inf, 0.0, 0.0, math.nan, 0.0)


def at_places(
    run: Run, places: Mapping[str, float | str], debris: Debris, runout: float, least_depth: float, impact_factor: float
) -> dict[str, float]:
    """The columns of ``place_columns`` of a finished run whose geometry has a slope; ``least_depth`` (m) of debris counts."""
    geometry, spacing, values = run.scene.geometry, run.scene.numerics.spacing, dict[str, float]()
    assert isinstance(geometry, SLOPES)
    by, times = np.hypot(*run.displacement())[run.soil], run["time"][run.gravity_frame :]
    distances = {name: beyond_toe(at, geometry) for name, at in places.items()}
    feet = {name: foot_of(at, geometry) for name, at in places.items()}
    from_above = {name: debris.behind(*(geometry.toe if distances[name] >= 0.0 else foot)) for name, foot in feet.items()}
    seen = _frames(run, {name: x for name, (x, _) in feet.items()}, from_above, debris)
    for name, (x, _) in feet.items():
        fronts, depths, fastest, means, pressures = map(np.array, zip(*seen[name], strict=True))
        ground = (np.abs(debris.x0 - x) <= spacing) & (geometry.ground(debris.x0) - debris.y0 <= spacing)
        there, at = np.flatnonzero(fronts <= x), np.flatnonzero(np.isfinite(means))
        passed = runout - distances[name] if distances[name] >= 0.0 else x - float(fronts[-1])
        values |= {
            column_of(name, PASSED): passed if math.isfinite(passed) else math.nan,
            column_of(name, DEPTH): float(depths[-1]),
            column_of(name, ARRIVAL): float(times[there[0]]) if there.size else math.nan,
            column_of(name, REACHED): float(depths.max() >= max(least_depth, 0.5 * spacing)),
            column_of(name, PEAK_DEPTH): float(depths.max()),
            column_of(name, PEAK_SPEED): float(fastest.max()),
            column_of(name, FRONT_SPEED): float(means[at[0]]) if at.size else math.nan,
            column_of(name, PRESSURE): impact_factor * float(pressures.max()),
            column_of(name, GROUND): float(by[ground].max(initial=0.0)),
        }
    return values


def _frames(run: Run, at: Mapping[str, float], from_above: Mapping[str, np.ndarray], debris: Debris) -> dict[str, list[_Seen]]:
    """What is seen at each place, by its x in the box, in every frame from the end of the gravity stage on."""
    spacing, surface, seen = run.scene.numerics.spacing, run.scene.geometry.surface, {name: list[_Seen]() for name in at}
    for frame in range(run.gravity_frame, len(run["time"])) if at else ():
        x, y, v_x, v_y, density = run.soil_at(frame, "x", "y", "velocity_x", "velocity_y", "density")
        moved, speed, in_scene = np.hypot(*run.displacement(frame))[run.soil] > debris.moved, np.hypot(v_x, v_y), x + debris.shift
        edge, height = in_scene - 0.5 * spacing, y + 0.5 * spacing - np.interp(in_scene, *surface)
        came = {name for name, above in from_above.items() if (above & moved & (edge <= at[name])).any()}
        mass = largest_mass(x, y, debris.link) if came else np.zeros(x.size, bool)
        for name, above in from_above.items():
            near, of = np.abs(in_scene - at[name]) <= spacing, mass & above & moved
            if name not in came:
                seen[name].append(_NOTHING)
            elif not (here := of & near).any():
                seen[name].append(_NOTHING._replace(front=float(edge[of].min(initial=math.inf))))
            else:
                depth = max(0.0, float(height[mass & near].max()))
                pressure = float(np.mean(density[here] * speed[here] ** 2))
                seen[name].append(_Seen(float(edge[of].min()), depth, float(speed[here].max()), float(speed[here].mean()), pressure))
    return seen
