"""The numbers of one run.  ``METRICS`` holds the written definition of each; ``measure`` computes exactly these.

Conventions
-----------
* Displacements are relative to the box and *since the end of the gravity stage*, so that the settlement while
  gravity is applied does not count; ``gravity_stage_displacement`` is what they leave out.  Vertical is positive upwards
  (a settlement is negative), horizontal positive to the right (towards the back wall; a slope that fails moves to negative x).
* "At the end" means the last sample for probes and series, and the last frame for particle fields.
* A particle is a square of one spacing: its edge lies half a spacing from its centre.  Thus a slope that is
  moved by 3 m as a whole has a run-out of 3 m, whatever the spacing.

Run-out
-------
The apron is itself soil, from the front wall to the toe, so that the most advanced *soil* particle says nothing.
The front is that of the *slope material in the main mass*: soil particles that (1) belong to the largest set of
soil particles linked by distances below ``link_length`` at the end, which leaves out single particles thrown
ahead, (2) lay behind the toe and above its level initially, which leaves out apron and base, also where the mass pushes
them ahead as a heave, and (3) have moved more than ``moved_threshold``, so that elastic motion and settlement of a
standing slope give no front.  Run-out is defined for shapes with a slope only ('slope', 'ground_line') and is NaN for others.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import scipy  # type: ignore[import-untyped]
from pydantic import model_validator

from sph.measures.linked import largest_mass
from sph.measures.mobilised import DISC, height_of, mobilised_by_layer
from sph.measures.mobility import COROMINAS, corominas_tangent, line_runout, residual_tangent, sliding
from sph.measures.places import Debris, PlaceAt, PlaceName, at_places, place_columns
from sph.measures.rest import RATE, SHARE, SLOWING, rest
from sph.measures.sides import BACK, FRONT, OVER, PART, reached_sides
from sph.output.run import ProbeHistory, Run
from sph.scene.configuration import Section, key
from sph.scene.geometry import SLOPES, Slope
from sph.scene.gravity import FAILED_AREA, FAILED_SHARE, UNSHAKEN
from sph.scene.ground_line import GroundLine
from sph.scene.motion import NoMotion
from sph.scene.places import shifted
from sph.scene.schema import Scene
from sph.storage.trajectory import Status, Variable

if TYPE_CHECKING:
    import xarray as xr

CLASSES = STABLE, MINOR, DAMAGED, COLLAPSE = ("stable", "minor", "damaged", "collapse")
"""Collapse classes in order of damage."""
UNDETERMINED = "undetermined"
"""Class of a diverged run."""

PROBE = "A"
"""The probe that is measured by default."""

AREA_THRESHOLDS = {"area_moved_10cm": 0.1, "area_moved_50cm": 0.5, "area_moved_100cm": 1.0}
"""Displacements (m) beyond which the moved area is counted, by the metric's name."""

CLOSING_RADIUS = 1.25
"""Radius, over the spacing, within which gaps between particles are closed for the outline's area."""
OUTLINE_GRID = 4
"""Points per spacing of the grid on which the outline's area is counted."""

ENERGY_LIMIT = 0.01
"""Above this ``energy_error`` the budget is open and a run's numbers are not to be trusted: the largest of the shipped tables
``cost-accuracy.csv`` and ``resolution.csv`` is 6e-4, and soil that settled 64 % too much had 0.04."""


class MetricSettings(Section):
    """Thresholds of the metrics; each is a choice of ours, the paper gives none."""

    probe: str = key("probe whose motion is measured", default=PROBE, source="Figs. 6-7", pattern=r"^[A-Za-z][A-Za-z0-9_]{0,31}$")
    onset_threshold: float = key("displacement of the probe at which its motion has begun", "m", gt=0, le=100, default=0.05)
    arrest_tolerance: float = key("distance to its final place within which the probe has arrested", "m", gt=0, le=100, default=0.05)
    moved_threshold: float = key("displacement beyond which slope material counts towards the run-out", "m", gt=0, le=100, default=0.5)
    link_length: float = key("soil particles nearer than this, over the spacing, count as one mass", ge=1, le=10, default=2.0)
    stable_limit: float = key(
        "class 'stable' below this permanent displacement of the probe over the height of the slope; 0.004 is 0.1 m at 25 m, "
        "the upper end of the 5-10 cm at which Newmark practice expects ground cracks",
        gt=0,
        le=10,
        default=0.004,
    )
    minor_limit: float = key(
        "class 'minor' below this, over the height; 0.02 is 0.5 m at 25 m: cracked and settled, but the same slope",
        gt=0,
        le=10,
        default=0.02,
    )
    damaged_limit: float = key(
        "class 'damaged' below this, over the height, and 'collapse' from it on; 0.1 is 2.5 m at 25 m: "
        "the crest edge has moved by a tenth of the height, the slope has a different profile",
        gt=0,
        le=10,
        default=0.1,
    )
    places: dict[PlaceName, PlaceAt] = key(
        "places in front of the slope or on it that debris may reach, such as a road, by name: x, or a distance, e.g. '12 beyond the toe'",
        "m",
        default={},
    )
    debris_depth: float = key(
        "least depth of debris at a place that reaches it; half a spacing at least, since less is not resolved",
        "m",
        gt=0,
        le=100,
        default=0.1,
    )
    impact_factor: float = key(
        "factor on density times squared speed in the impact pressure at a place: 1 is the momentum flux of debris that is stopped, and "
        "guidance on barriers asks for more",
        gt=0,
        le=100,
        default=1.0,
    )
    moving_window: float = key("length of the interval at the end in which a run is tested for motion", "s", gt=0, le=1000, default=0.5)
    moving_speed: float = key("speed above which a run is still moving", "m/s", gt=0, le=100, default=0.05)

    @model_validator(mode="after")
    def _limits_in_order(self) -> MetricSettings:
        if not self.stable_limit < self.minor_limit < self.damaged_limit:
            raise ValueError(
                f"stable_limit ({self.stable_limit}), minor_limit ({self.minor_limit}) "
                f"and damaged_limit ({self.damaged_limit}) must increase in this order"
            )
        return self


ROW = ("row",)
"""The dimension of a table with a row per run; in ``study.nc`` its columns lie over the dimensions of the study."""


def _number(name: str, units: str, text: str) -> Variable:
    return Variable(name, ROW, "f8", units, text)


METRICS: tuple[Variable, ...] = (
    Variable("status", ROW, "str", "1", f"how the run ended: one of {', '.join(Status)}"),
    Variable(
        "collapse_class",
        ROW,
        "str",
        "1",
        f"{', '.join(CLASSES)}: displacement_magnitude over the height of the slope against the settings stable_limit, minor_limit, "
        f"damaged_limit (a value on a limit takes the worse class); {UNDETERMINED} for a diverged run",
    ),
    Variable(
        "still_moving",
        ROW,
        "i1",
        "1",
        "1 if in the last moving_window the probe, or the soil by its mass-weighted root-mean-square speed, was faster than moving_speed; "
        "1 for a diverged run, which was stopped in motion",
    ),
    Variable(
        "at_rest",
        ROW,
        "i1",
        "1",
        f"1 if no more than {SHARE:g} of the debris and not the probe still moves at the end: displacement and run-out are final; 0 for a "
        "diverged run. A few particles that roll on can make still_moving 1, and do not count here",
    ),
    _number(
        "moving_share",
        "1",
        f"debris that moves in the last frame, faster than moving_speed and than {RATE:g} of its displacement a second, over all debris, "
        f"by area: soil that has moved more than moved_threshold or moves, {FAILED_AREA:g} H2 at least",
    ),
    _number(
        "time_to_rest",
        "s",
        f"time after which the run would be at rest if the fastest of the debris, but for {SHARE:g} of it, and the probe went on to slow "
        f"down as in the last {SLOWING:g} s; 0 at rest, NaN if they do not slow down",
    ),
    Variable("diverged", ROW, "i1", "1", "1 if the guard stopped the run; its other numbers are then NaN, except those of cost and scene"),
    _number(
        "gravity_stage_displacement",
        "m",
        "magnitude of the probe's displacement from the start to the end of the gravity stage: the settlement that the other displacements "
        "leave out, or the motion of a slope that does not stand",
    ),
    _number(
        "failed_unshaken",
        "1",
        f"soil particles that failed under gravity alone, before the shaking exceeds {UNSHAKEN:g} g, over all soil particles; where they "
        f"cover more than {FAILED_AREA:g} H2, or more than {FAILED_SHARE:g} of the soil that has moved in the end, the status is "
        f"{Status.FAILED_UNSHAKEN}, and the results of the run are not due to the earthquake alone",
    ),
    _number(
        "mobilised_strength",
        "1",
        "largest share of its peak strength that a layer mobilises at the end of the gravity stage: sum of the radii of the Mohr circles "
        f"over that of the radii at yield, in the disc, {DISC:g} times as wide as the slope is high, where it is largest",
    ),
    _number("shaking_start", "s", "start of the shaking; NaN without shaking"),
    _number("shaking_end", "s", "end of the shaking; NaN without shaking"),
    _number("displacement_vertical", "m", "permanent vertical displacement of the probe: value at the last sample"),
    _number("displacement_horizontal", "m", "permanent horizontal displacement of the probe: value at the last sample"),
    _number("displacement_magnitude", "m", "magnitude of the probe's permanent displacement"),
    _number("peak_displacement_vertical", "m", "vertical displacement of the probe where its absolute value is largest, with its sign"),
    _number("peak_displacement_horizontal", "m", "horizontal displacement of the probe where its absolute value is largest, with its sign"),
    _number("peak_displacement_magnitude", "m", "largest magnitude of the probe's displacement"),
    _number(
        "displacement_vertical_end_of_shaking",
        "m",
        "vertical displacement of the probe at the last sample not later than shaking_end; NaN without shaking or if the run ends before",
    ),
    _number("displacement_horizontal_end_of_shaking", "m", "horizontal displacement of the probe at the same sample"),
    _number("displacement_magnitude_end_of_shaking", "m", "magnitude of the probe's displacement at the same sample"),
    _number(
        "onset_time",
        "s",
        "time of the first sample at which the probe's displacement exceeds onset_threshold in magnitude; NaN if it never does",
    ),
    _number(
        "arrest_time",
        "s",
        "time of the first sample from which on the probe stays within arrest_tolerance of its final place (as a vector); "
        "NaN if its motion never began or the run is still moving",
    ),
    _number("probe_peak_speed", "m s-1", "largest speed of the probe after the gravity stage"),
    _number("first_failure_time", "s", "smallest t_f of all particles, those of the box included; NaN if none failed"),
    _number("failed_fraction", "1", "failed soil particles over all soil particles, at the end"),
    _number("peak_speed", "m s-1", "largest speed of any soil particle after the gravity stage"),
    _number(
        "runout",
        "m",
        "x of the initial toe minus x of the front, at least 0; front: smallest x, less half a spacing, of soil that is in the largest "
        "linked mass, lay behind the toe and above its level initially and has moved more than moved_threshold; 0 if there is no such soil",
    ),
    _number("runout_over_height", "1", "runout over the height of the slope"),
    _number(
        "travel_angle",
        "degree",
        "inclination of the line from the original crest edge down to the front (lower left corner of the front particle); "
        "NaN if there is no front",
    ),
    _number(
        "energy_line_angle",
        "degree",
        f"apparent friction angle of the mass that slides, soil of the front that has moved at least {PART:g} as far as the farthest: "
        "tangent of the effective angle that soil at its base keeps after failure times 1 - r_u there, of the initial pore pressure and "
        "its largest rise, the mean by weight; NaN if there is no front or no friction is left",
    ),
    _number(
        "energy_line_runout",
        "m",
        "run-out of a point that slides from the original crest edge with that angle, whose energy line then meets the ground (beyond the "
        "model: level ground); at least 0.  It has neither cohesion nor the spread of a mass",
    ),
    _number(
        "corominas_angle",
        "degree",
        "mean travel angle of debris slides and flows of this volume, log10 tan = "
        f"{COROMINAS[0]:g} - {-COROMINAS[1]:g} log10 V (Corominas 1996, 71 events): V in m3 is area_moved_50cm times the height of the "
        "slope, as if the slide were as wide as that; NaN if there is no front",
    ),
    _number("corominas_runout", "m", "run-out along a line from the original crest edge with that angle, as energy_line_runout"),
    _number(
        "deposit_height",
        "m",
        "largest height above the initial ground, half a spacing included, of soil in the largest linked mass with x below the initial "
        "toe; heave of the apron counts; at least 0",
    ),
    _number(
        "deposit_thickness",
        "m",
        "mean thickness of the deposit in front of the toe: area of soil in the largest linked mass with x below the initial toe and "
        "above the initial ground, over the run-out; NaN without run-out",
    ),
    Variable(
        "reached_side",
        ROW,
        "str",
        "1",
        "sides of the box met in any frame by failed soil that has moved more than moved_threshold, or than a tenth of the largest "
        "displacement where that is less (but at least a fifth of moved_threshold), separated by blanks: "
        f"'{FRONT}' and '{BACK}' where it is in the largest linked mass and within a smoothing length of the end in front of the toe or "
        f"behind the crest, '{OVER}' where it is above the top of the side there, or has left the box. Displacement, run-out and deposit "
        f"are then limited by the box: with '{FRONT}' or '{OVER}' they are lower bounds",
    ),
    _number("reached_side_time", "s", "time of the first frame in which it met a side; NaN if it met none"),
    *(
        _number(name, "m2", f"area (number of soil particles times spacing squared) with a displacement above {limit} m, at the end")
        for name, limit in AREA_THRESHOLDS.items()
    ),
    _number("area_change", "1", "sum of mass over density of the soil in the last frame over that in the first, minus 1"),
    _number(
        "outline_area_change",
        "1",
        "area inside the outline of the largest linked mass in the last frame over that of all soil in the first, minus 1: discs of "
        f"{CLOSING_RADIUS} spacings around the particles, shrunk to half a spacing; shows bulging and scatter that the densities do not",
    ),
    _number(
        "nearest_neighbour_p05",
        "1",
        "fifth percentile over the soil of the distance to the nearest soil particle, over the spacing, in the last frame; "
        "1 on a lattice, less where particles pair up",
    ),
    _number(
        "energy_error",
        "1",
        "closing error of the energy budget: absolute change, from the first to the last sample, of kinetic + elastic + potential + "
        "dissipated energy - work of shaking, over the largest sum in time of the absolute values of the four energies; above "
        f"{ENERGY_LIMIT:g} the finding energy-open",
    ),
    _number(
        "viscous_share",
        "1",
        "energy dissipated by artificial viscosity and stress over all dissipated energy, at the end: the share due to the stabilisation, "
        "not the soil; NaN for runs of versions before 0.2",
    ),
    _number(
        "time_step_ratio",
        "1",
        "largest time step over its measured limit, over the frames; above 1 the limit was exceeded and the fastest modes may be wrong",
    ),
    _number("wall_time", "s", "computing time of the run, its shared pre-failure run included"),
    _number("particle_steps_per_second", "s-1", "particles times time steps over the computing time"),
)
CHIEF = (
    "status", "collapse_class", "still_moving", "displacement_vertical", "displacement_horizontal", "displacement_magnitude",
    "onset_time", "arrest_time", "failed_fraction", "runout", "runout_over_height", "travel_angle", "deposit_height", "reached_side",
)  # fmt: skip
"""The metrics that answer how far a slope has moved; the others say when, how and how well computed."""
METRIC_BY_NAME = {metric.name: metric for metric in METRICS}

Value = float | int | str


def measure(run: Run | xr.Dataset, settings: MetricSettings | None = None) -> dict[str, Value]:
    """Every metric of ``METRICS``, in its order, and those of the places of the settings, for one finished run or its trajectory.

    Raises ValueError for a paused run, an unknown status, a probe that the run does not have and a run in the survey's coordinates.
    """
    settings = settings or MetricSettings()
    run = Run.of(run)
    status = run.status
    finished = [name for name in Status if name != Status.PAUSED]
    if status not in finished:
        raise ValueError(f"status: {status!r}; only a finished run can be measured, with a status among {', '.join(finished)}")
    values: dict[str, Value] = {metric.name: math.nan for metric in (*METRICS, *place_columns(settings.places))}
    values |= _facts(run)
    if status == Status.DIVERGED:
        return values | {"collapse_class": UNDETERMINED, "still_moving": 1, "at_rest": 0, "reached_side": ""}
    probe = run.history(settings.probe)
    moving = _still_moving(run, probe, settings)
    values |= _probe_metrics(probe, run, settings, moving)
    end = rest(run, probe, settings.moved_threshold, settings.moving_speed, settings.moving_window)
    values |= {
        "still_moving": int(moving),
        "at_rest": int(end.at_rest),
        "moving_share": end.moving_share,
        "time_to_rest": end.time_to_rest,
        "collapse_class": collapse_class(float(probe.displacement_magnitude[-1]) / height_of(run.scene), settings),
        "viscous_share": _viscous_share(run),
        "energy_error": energy_error(run),
    }
    values |= _soil_metrics(run, settings)
    met = reached_sides(run, settings.moved_threshold, settings.link_length * run.scene.numerics.spacing)
    return values | {"reached_side": " ".join(met), "reached_side_time": min(met.values(), default=math.nan)}


def collapse_class(relative_displacement: float, settings: MetricSettings) -> str:
    """Class of a permanent displacement over the height of the slope."""
    return CLASSES[sum(relative_displacement >= limit for limit in _limits(settings).values())]


def class_displacement(name: str, scene: Scene, settings: MetricSettings) -> float:
    """Displacement of the probe (m) at which a class but the first begins."""
    return _limits(settings)[name] * height_of(scene)


def class_words(settings: MetricSettings, scene: Scene) -> str:
    """Which displacements of the probe the classes are, in words."""
    height = height_of(scene)
    limits = ", ".join(f"{name} from {limit:g} H ({limit * height:.2g} m)" for name, limit in _limits(settings).items())
    return f"Class by the displacement of {settings.probe}: {limits}; the height H of the slope is {height:.3g} m."


def _limits(settings: MetricSettings) -> dict[str, float]:
    return dict(zip(CLASSES[1:], (settings.stable_limit, settings.minor_limit, settings.damaged_limit), strict=True))


def outline_area(x: np.ndarray, y: np.ndarray, spacing: float) -> float:
    """Area (m2) inside the outline of particles at (n,) with gaps below 2 ``CLOSING_RADIUS`` spacings closed; lengths in m."""
    step, margin = spacing / OUTLINE_GRID, 2.0 * CLOSING_RADIUS * spacing
    grid = np.meshgrid(*(np.arange(a.min() - margin, a.max() + margin, step) for a in (x, y)))
    distance, _ = scipy.spatial.cKDTree(np.column_stack([x, y])).query(np.column_stack([axis.ravel() for axis in grid]))
    dilated = distance.reshape(grid[0].shape) <= CLOSING_RADIUS * spacing
    inside = step * scipy.ndimage.distance_transform_edt(dilated) > (CLOSING_RADIUS - 0.5) * spacing
    return float(np.count_nonzero(inside)) * step**2


def nearest_distances(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance (n,) of each of the points (n,) to the nearest other one."""
    points = np.column_stack([x, y])
    distances: np.ndarray = scipy.spatial.cKDTree(points).query(points, k=2)[0][:, 1]
    return distances


def _facts(run: Run) -> dict[str, Value]:
    motion = run.scene.motion
    start, end = (math.nan, math.nan) if isinstance(motion, NoMotion) else (motion.start, motion.end)
    return {
        "status": run.status,
        "diverged": int(run.status == Status.DIVERGED),
        "shaking_start": start,
        "shaking_end": end,
        "time_step_ratio": run.time_step_ratio,
        "wall_time": float(run.attrs["wall_time_s"]),
        "particle_steps_per_second": float(run.attrs["particle_steps_per_second"]),
    }


def _probe_metrics(probe: ProbeHistory, run: Run, settings: MetricSettings, moving: bool) -> dict[str, Value]:
    horizontal, vertical, magnitude = probe.displacement_horizontal, probe.displacement_vertical, probe.displacement_magnitude
    begun = magnitude > settings.onset_threshold
    onset = float(probe.time[np.argmax(begun)]) if begun.any() else math.nan
    away = np.hypot(horizontal - horizontal[-1], vertical - vertical[-1]) > settings.arrest_tolerance
    arrived = 1 + np.flatnonzero(away)[-1] if away.any() else 0
    at_end = _sample_at_end_of_shaking(probe, run)
    values: dict[str, Value] = {
        "gravity_stage_displacement": probe.gravity_stage_displacement,
        "onset_time": onset,
        "arrest_time": float(probe.time[arrived]) if begun.any() and not moving else math.nan,
        "probe_peak_speed": float(probe.speed.max()),
    }
    for name, u in {"vertical": vertical, "horizontal": horizontal, "magnitude": magnitude}.items():
        values[f"displacement_{name}"] = float(u[-1])
        values[f"peak_displacement_{name}"] = float(u[np.argmax(np.abs(u))])
        values[f"displacement_{name}_end_of_shaking"] = float(u[at_end]) if at_end >= 0 else math.nan
    return values


def _sample_at_end_of_shaking(probe: ProbeHistory, run: Run) -> int:
    """Index of the last sample not later than the end of the shaking; -1 where there is none."""
    scene = run.scene
    if isinstance(scene.motion, NoMotion) or probe.time[-1] < scene.motion.end - 0.5 * scene.numerics.time_step:
        return -1
    return run.last_at(probe.time, scene.motion.end)


def _still_moving(run: Run, probe: ProbeHistory, settings: MetricSettings) -> bool:
    soil_mass = float(run["mass"][run.soil].sum())
    rms_speed = np.sqrt(2.0 * run["kinetic_energy"] / soil_mass)
    time = run["sample_time"]
    fastest_soil = rms_speed[time >= time[-1] - settings.moving_window].max()
    fastest_probe = probe.speed[probe.time >= probe.time[-1] - settings.moving_window].max()
    return bool(max(fastest_soil, fastest_probe) > settings.moving_speed)


def _soil_metrics(run: Run, settings: MetricSettings) -> dict[str, Value]:
    scene, soil, spacing = run.scene, run.soil, run.scene.numerics.spacing
    (x, y), (first_x, first_y) = (run.soil_at(frame, "x", "y") for frame in (-1, 0))
    moved = np.hypot(*run.displacement())[soil]
    mass = main_mass(run, settings)
    after_gravity = run["sample_time"] >= scene.gravity.duration - 0.5 * scene.numerics.time_step
    t_f = run["t_f"]
    first_area, last_area = ((run["mass"][soil] / run.soil_at(frame, "density")[0]).sum() for frame in (0, -1))
    values: dict[str, Value] = {
        "first_failure_time": float(np.nanmin(t_f)) if np.isfinite(t_f).any() else math.nan,
        "failed_unshaken": float(np.mean(scene.unshaken(t_f[soil], scene.held(run["x0"][soil], run["y0"][soil])))),
        "mobilised_strength": max(mobilised_by_layer(run, run.gravity_frame).values(), default=math.nan),
        "failed_fraction": float(run["failed_fraction"][-1]),
        "peak_speed": float(run["maximum_speed"][after_gravity].max()),
        "area_change": float(last_area / first_area - 1.0),
        "outline_area_change": outline_area(x[mass], y[mass], spacing) / outline_area(first_x, first_y, spacing) - 1.0,
        "nearest_neighbour_p05": float(np.percentile(nearest_distances(x, y), 5)) / spacing,
    }
    values |= {name: float(np.count_nonzero(moved > limit)) * spacing**2 for name, limit in AREA_THRESHOLDS.items()}
    return values | debris_metrics(run, settings, mass)


def main_mass(run: Run, settings: MetricSettings) -> np.ndarray:
    """The largest linked mass at the end (soil,)."""
    x, y = run.soil_at(-1, "x", "y")
    return largest_mass(x, y, settings.link_length * run.scene.numerics.spacing)


def debris_metrics(run: Run, settings: MetricSettings, mass: np.ndarray) -> dict[str, float]:
    """The metrics of debris at rest in front of the toe, and of the places; empty for a scene without a slope.

    ``mass`` (soil,) as by ``main_mass``.
    """
    scene, soil = run.scene, run.soil
    if not isinstance(scene.geometry, SLOPES):
        return {}
    spacing, lattice_shift = scene.numerics.spacing, scene.numerics.lattice_shift
    x, y = run.soil_at(-1, "x", "y")
    toe_x, toe_y = scene.geometry.toe
    x0, y0 = shifted(run["x0"][soil], run["y0"][soil], spacing, lattice_shift)
    x = x + lattice_shift * spacing  # the soil's shape lies that much to the left of the toe
    debris = Debris(x0, y0, settings.moved_threshold, settings.link_length * spacing, lattice_shift * spacing)
    moved = np.hypot(*run.displacement())[soil]
    front = mass & debris.behind(toe_x, toe_y) & (moved > settings.moved_threshold)
    values = _runout_metrics(x, y, mass, front, scene.geometry, spacing)
    values |= _mobility_metrics(run, front, float(np.count_nonzero(moved > AREA_THRESHOLDS["area_moved_50cm"])) * spacing**2)
    return values | at_places(run, settings.places, debris, values["runout"], settings.debris_depth, settings.impact_factor)


def _mobility_metrics(run: Run, front: np.ndarray, area: float) -> dict[str, float]:
    """How far a sliding point and slides of the field go, beside the run-out; ``front`` (soil,) is its soil, ``area`` (m2) has moved."""
    geometry, values = run.scene.geometry, dict[str, float]()
    assert isinstance(geometry, SLOPES)
    tangents = {
        "energy_line": residual_tangent(run, sliding(run, front)) if front.any() else math.nan,
        "corominas": corominas_tangent(area * geometry.slope_height) if front.any() and area > 0.0 else math.nan,
    }
    for name, tangent in tangents.items():
        values |= {f"{name}_angle": math.degrees(math.atan(tangent)), f"{name}_runout": line_runout(geometry, tangent)}
    return values


def _runout_metrics(
    x: np.ndarray, y: np.ndarray, mass: np.ndarray, slope_material: np.ndarray, geometry: Slope | GroundLine, spacing: float
) -> dict[str, float]:
    toe_x, toe_y = geometry.toe
    runout, travel_angle = 0.0, math.nan
    if slope_material.any():
        front = np.flatnonzero(slope_material)[np.argmin(x[slope_material])]
        front_x, front_y = x[front] - 0.5 * spacing, y[front] - 0.5 * spacing
        runout = max(0.0, float(toe_x - front_x))
        travel_angle = math.degrees(math.atan2(geometry.crest[1] - front_y, geometry.crest[0] - front_x))
    on_apron = mass & (x < toe_x)
    above_ground = y[on_apron] - np.interp(x[on_apron], *geometry.surface)
    deposit = float(above_ground.max()) + 0.5 * spacing if on_apron.any() else 0.0
    area = float(np.count_nonzero(above_ground > 0.0)) * spacing**2
    return {
        "runout": runout,
        "runout_over_height": runout / geometry.slope_height,
        "travel_angle": travel_angle,
        "deposit_height": max(0.0, deposit),
        "deposit_thickness": area / runout if runout > 0.0 else math.nan,
    }


def energy_error(run: Run) -> float:
    """The metric ``energy_error`` of a run."""
    balance, scale = _energy_budget(run)
    return float(abs(balance[-1] - balance[0]) / scale) if scale > 0 else 0.0


def _viscous_share(run: Run) -> float:
    if "viscous_energy" not in run:
        return math.nan
    taken = float(run["dissipated_energy"][-1])
    return float(run["viscous_energy"][-1]) / taken if taken > 0 else 0.0


def energy_gap(run: Run) -> float:
    """Largest gap in the energy budget over all samples, over the largest sum of the absolute values of its parts."""
    balance, scale = _energy_budget(run)
    return float(np.abs(balance - balance[0]).max() / scale) if scale > 0 else 0.0


def _energy_budget(run: Run) -> tuple[np.ndarray, float]:
    stored = [run[f"{name}_energy"] for name in ("kinetic", "elastic", "potential", "dissipated")]
    return np.sum(stored, axis=0) - run["shaking_work"], float(np.abs(stored).sum(axis=0).max())
