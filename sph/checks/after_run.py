"""Findings after a run, from its metrics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sph.checks.cover_rows import SCATTER, covers
from sph.checks.finding import Finding, called, finding
from sph.measures.metrics import CLASSES, ENERGY_LIMIT, MINOR, STABLE, MetricSettings, Value, debris_metrics, energy_error, main_mass
from sph.measures.places import PASSED, column_of
from sph.measures.sides import BACK, FRONT, OVER, reached_sides
from sph.output.run import Run
from sph.scene.ground_line import GroundLine
from sph.scene.schema import Scene
from sph.solver.physics.cyclic_pore_pressure import can_liquefy

if TYPE_CHECKING:
    import pandas as pd

LOWER_BOUND = (FRONT, OVER)
"""Sides with which displacement and run-out are lower bounds: debris would have gone further, or has been lost."""
BRAKED = ("weak-on-strong", "layer-held")
"""Findings before a run with which they are, too: strong soil holds weak soil of few rows of particles back."""
LATE = "cover-late"
"""The finding with which soil that stands might fail; once it fails it runs as far as it should."""
THICK = 4
"""Particles across a deposit at least: with four a layer of debris flows 1.16 times too far on a smooth base, with two 1.7 times
(``tests/physics/test_thin_debris.py``)."""
FAR = 10
"""Spacings of run-out beyond which that matters: nearer, a thin deposit is the foot of the slope."""


def is_bounded(reached_side: str) -> bool:
    """Whether displacement and run-out of a run are lower bounds, by its metric ``reached_side``."""
    return any(side in LOWER_BOUND for side in reached_side.split())


def is_braked(findings: str) -> bool:
    """Whether debris with more rows of particles would have gone further, by the column ``findings`` of a study's table."""
    return any(code in BRAKED for code in findings.split())


def is_held(run: Mapping[Any, Any]) -> bool:
    """Whether strong soil holds weak soil of few rows back, by a run's row of a study's table.

    Its debris is braked, or it has not come down and might with more rows.
    """
    late = LATE in run["findings"].split() and run["collapse_class"] in (STABLE, MINOR)
    return is_braked(run["findings"]) or late


def held(table: pd.DataFrame) -> pd.Series:
    """The same of all runs of a study's table."""
    import pandas as pd  # here, since a run does without it

    return pd.Series([is_held(run) for run in table.to_dict("records")], table.index, bool)


def is_lower_bound(run: Mapping[Any, Any]) -> bool:
    """Whether displacement and run-out of a run are lower bounds, for either reason, by its row of a study's table."""
    return is_bounded(run["reached_side"]) or is_held(run)


def lower_bounds(table: pd.DataFrame) -> pd.Series:
    """The same of all runs of a study's table."""
    return (table["reached_side"].map(is_bounded) | held(table)).astype(bool)


def in_motion(run: Mapping[Any, Any]) -> bool:
    """Whether a run that did not diverge still moves at its end, by its row of a study's table."""
    return not run["at_rest"] and not run["diverged"]


def is_at_least(run: Mapping[Any, Any]) -> bool:
    """Whether displacement and run-out of a run are shown as lower bounds: they are, or the run ends in motion."""
    return is_lower_bound(run) or in_motion(run)


def has_debris(run: Mapping[Any, Any]) -> bool:
    """Whether soil has come down in a run, by its row of a study's table: its probe with it, or beyond the toe."""
    return run["collapse_class"] in CLASSES[2:] or run["runout"] > 0.0


def has_thin_debris(table: pd.DataFrame) -> pd.Series:
    """Whether the debris of runs is thin (``thin_debris``), by the rows of a study's table."""
    return table["findings"].map(lambda codes: "thin-debris" in str(codes).split()).astype(bool)


def near_miss(run: Mapping[Any, Any], place: str) -> float:
    """The error of a run-out, as a share of it, if the debris stops short of a place by less than that; else 0.

    It is the run's expected error or, where none is known, the scatter of covers (``SCATTER``).
    """
    error = run["expected_runout_error"] if run["expected_runout_error"] > 0.0 else SCATTER
    return float(error) if 0.0 < -run[column_of(place, PASSED)] < error * run["runout"] else 0.0


def at_least(table: pd.DataFrame) -> pd.Series:
    """The same of all runs of a study's table."""
    return lower_bounds(table) | (table["at_rest"] == 0) & (table["diverged"] == 0)


def debris_at_wall(scene: Scene, reached_side: str, time: float) -> list[Finding]:
    """The finding of a run whose failed soil met sides of the box, by the metrics ``reached_side`` and ``reached_side_time`` (s)."""
    sides = reached_side.split()
    if not sides:
        return []
    keys = {FRONT: "geometry.apron_length", BACK: "geometry.crest_length", OVER: "geometry.apron_length"}
    ends = ("geometry.window", "geometry.points") if isinstance(scene.geometry, GroundLine) else dict.fromkeys(keys[side] for side in sides)
    return [finding("debris-at-wall", *ends, sides=reached_side, time=time)]


def is_open(error: float) -> bool:
    """Whether the energy budget of a run is open, by its metric ``energy_error``; False for NaN, that of a run that diverged."""
    return error > ENERGY_LIMIT


def energy_open(error: float) -> list[Finding]:
    """The finding of a run that made or lost energy, by its metric ``energy_error``."""
    return [finding("energy-open", "numerics.time_step", "numerics.spacing", value=error, bound=ENERGY_LIMIT)] if is_open(error) else []


def thin_debris(scene: Scene, runout: float, thickness: float) -> list[Finding]:
    """The finding of a run whose debris has run far and lies in few rows of particles, by its metrics (m); none where they are NaN.

    It says what is known of the run-out of a weak ``cover`` where the scene has one, and each has enough rows (``cover-rows``).
    """
    spacing = scene.numerics.spacing
    if not (runout > FAR * spacing and thickness < THICK * spacing):
        return []
    weak = covers(scene)
    known = {"cover": weak[0].name} if weak and not any(cover.short or cover.between for cover in weak) else {}
    return [finding("thin-debris", "numerics.spacing", value=thickness / spacing, bound=THICK, runout=runout, **known)]


def liquefied(run: Run) -> list[Finding]:
    """A finding for each layer of whose sand below water some has liquefied."""
    scene = run.scene
    if scene.water is None or scene.water.excess_pressure is None or scene.water.excess_pressure.liquefaction is None:
        return []
    findings, layer = [], run["layer"]
    sand = can_liquefy(scene, run["x0"], run["y0"], layer) & run.soil
    for number, name in enumerate((scene.soil.name or "soil", *scene.layers)):
        times = run["t_f"][sand & (layer == number)]
        failed = times[np.isfinite(times)]
        if failed.size:
            first, middle = float(failed.min()), float(np.median(failed))
            findings.append(finding("liquefied", subject=name, share=failed.size / times.size, first=first, middle=middle))
    return findings


def after_run(scene: Scene, values: Mapping[str, Value]) -> list[Finding]:
    """All findings of a run by its metrics."""
    met = debris_at_wall(scene, str(values["reached_side"]), float(values["reached_side_time"]))
    thin = thin_debris(scene, float(values["runout"]), float(values["deposit_thickness"]))
    return [*met, *thin, *energy_open(float(values["energy_error"]))]


def found_after(run: Run) -> list[Finding]:
    """The same of a run that came to its end, with the default settings of the metrics."""
    scene, settings = run.scene, MetricSettings()
    met = reached_sides(run, settings.moved_threshold, settings.link_length * scene.numerics.spacing)
    debris = debris_metrics(run, settings, main_mass(run, settings))
    return [
        *debris_at_wall(scene, " ".join(met), min(met.values(), default=0.0)),
        *thin_debris(scene, debris.get("runout", math.nan), debris.get("deposit_thickness", math.nan)),
        *energy_open(energy_error(run)),
        *called(liquefied(run), scene.soil.name),
    ]
