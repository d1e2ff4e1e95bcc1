"""The table of the robustness: a row holds the status of a run, which ends sound, diverged or refused, and the results of its checks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]
from matplotlib.figure import Figure

from sph.experiments.variants.design import Measured
from sph.experiments.variants.figures_robustness import REFUSED, figure_robustness
from sph.measures.linked import largest_mass
from sph.measures.metrics import MetricSettings, energy_gap, nearest_distances, outline_area
from sph.output.run import Run
from sph.storage.trajectory import Variable
from sph.study.tables import number_column, read_csv, text_column

SHIPPED = Path(__file__).parents[1] / "measured" / "robustness.csv"
"""Table measured for this release."""
LINK = 2.0
"""Particles nearer than this many spacings are connected."""

ROBUSTNESS: tuple[Variable, ...] = (
    text_column("sweep", "name of the key that is varied"),
    text_column("value", "its value"),
    text_column("case", "the slope, or the scheme of a sweep over time steps"),
    text_column("status", "complete, unfailed, diverged, or refused before any work"),
    text_column("reason", "why it diverged or was refused"),
    number_column("time_step_ratio", "1", "largest time step over its limit measured during the run"),
    number_column("energy_gap", "1", "largest gap in the energy budget over the largest sum of its parts"),
    number_column("area_change", "1", "area inside the outline of the largest mass at the end over that of all soil at the start, minus 1"),
    number_column(
        "nearest_p05",
        "1",
        "5th percentile of the distance to the nearest soil particle at the end over the spacing; small for pairs",
    ),
    number_column("nearest_least", "1", "smallest such distance over the spacing"),
    number_column("penetration", "1", "largest depth of soil behind the face of a wall, over all frames, over the spacing"),
    number_column("stragglers", "1", "share of the soil that is not in the largest mass at the end"),
    number_column(
        "asymmetry",
        "1",
        "largest distance of a particle from the mirror image of its counterpart, over the spacing; NaN in scenes without symmetry",
    ),
    number_column("displacement", "m", "largest displacement of a soil particle"),
    number_column("reproducible", "1", "1 if the repeats gave the same bits, 0 if not; NaN for one run"),
    number_column("wall_time", "s", "computing time of a run"),
)
"""The columns."""


def penetration(run: Run) -> float:
    """Largest depth of soil behind the face of a wall over all frames, over the spacing."""
    x, y = (run[name][:, run.soil].astype(float) for name in ("x", "y"))
    scene, walls, depth = run.scene, run.scene.walls, np.zeros(1)
    width, height = (count * scene.numerics.spacing for count in scene.lattice)
    inside = (x >= 0.0) & (x <= width) if walls.kinds.sides.open else np.ones(x.shape, bool)
    if walls.kinds.base.stands:
        depth = np.append(depth, -y[inside])
    if walls.kinds.sides.stands:
        beside = (y >= 0.0) & (y <= height)
        depth = np.append(depth, np.append(-x[beside], x[beside] - width))
    return float(np.nanmax(depth)) / scene.numerics.spacing


def asymmetry(run: Run) -> float:
    """Largest distance of a particle from the mirror image of its counterpart, over the spacing."""
    scene, x0, y0 = run.scene, run["x0"][run.soil], run["y0"][run.soil]
    x, y = run.soil_at(-1, "x", "y")
    _, twin = scipy.spatial.cKDTree(np.column_stack([x0, y0])).query(np.column_stack([scene.geometry.width - x0, y0]))
    return float(np.hypot(scene.geometry.width - x[twin] - x, y[twin] - y).max()) / scene.numerics.spacing


def checks(run: Run, symmetric: bool) -> dict[str, Any]:
    """The columns of a run."""
    spacing = run.scene.numerics.spacing
    (x0, y0), (x, y) = (run.soil_at(frame, "x", "y") for frame in (0, -1))
    values: dict[str, Any] = {
        "status": run.status,
        "reason": run.attrs["status_reason"],
        "time_step_ratio": run.time_step_ratio,
        "energy_gap": energy_gap(run),
        "wall_time": float(run.attrs["wall_time_s"]),
        "displacement": float(np.nanmax(np.hypot(x - x0, y - y0))),
        "penetration": penetration(run),
        "asymmetry": asymmetry(run) if symmetric else math.nan,
    }
    if np.isfinite([x, y]).all():
        mass, nearest = largest_mass(x, y, LINK * spacing), nearest_distances(x, y) / spacing
        values |= {
            "area_change": outline_area(x[mass], y[mass], spacing) / outline_area(x0, y0, spacing) - 1.0,
            "nearest_p05": float(np.percentile(nearest, 5)),
            "nearest_least": float(nearest.min()),
            "stragglers": 1.0 - float(np.mean(mass)),
        }
    return values


def read_robustness(path: Path | str = SHIPPED) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is not one."""
    return read_csv(path, ROBUSTNESS, "the robustness")


def measure_robustness(plan: Measured, runs: Mapping[str, Run], settings: MetricSettings) -> pd.DataFrame:
    """How far the solver can be pushed: one key at a time to the ends of its range. Every run ends valid, or diverged or refused with a
    reason.
    """
    places = [*dict.fromkeys((row.parameter, row.case) for row in plan.rows)]
    table = []
    for row in sorted(plan.rows, key=lambda row: places.index((row.parameter, row.case))):
        values: dict[str, Any] = {"status": REFUSED, "reason": row.refused}
        if row.runs:
            repeats = [runs[name] for name in row.runs[: row.repeats]]
            values = checks(repeats[0], row.symmetric)
            if len(repeats) > 1:
                values["reproducible"] = float(all(repeat.trajectory.equals(repeats[0].trajectory) for repeat in repeats[1:]))
        table.append({"sweep": row.parameter, "value": row.variant, "case": row.case, **values})
    return pd.DataFrame(table, columns=[column.name for column in ROBUSTNESS])


def draw_robustness(table: str) -> Figure:
    """Every run of the sweeps: a row per sweep and case, a cell per value, a panel per check, coloured from good (light) to bad (dark);
    D diverged, R refused.
    """
    return figure_robustness(read_robustness(table))
