"""Robustness of the solver: one key at a time to the ends of its range (``config/extremes.yaml``, ``snakemake extremes``).

Every run ends sound, diverged or refused, with a reason; a row holds the status and the results of the run's checks.  Scenes that the
schema refuses have no run.  ``time_steps`` runs fixed steps below and above the limit that theory gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]
import xarray as xr
from pydantic import Field, model_validator

from sph.experiments.base import Cases, Experiment, Label, Overrides, Table, Trace, check_file_names, file_name
from sph.measures.linked import largest_mass
from sph.measures.metrics import MetricSettings, energy_gap, outline_area
from sph.scene.configuration import Section, dotted, found_file, key, merge, read_scene, read_yaml, validated
from sph.scene.motion import NoMotion
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import SOIL
from sph.solver.time_step import check_time_step, limits
from sph.storage.trajectory import Variable, scene_of
from sph.study.plan import Plan
from sph.study.runs import Run
from sph.study.tables import ROW, number_column, read_csv

TIME_STEP = "time step over limit"
"""Name of the sweep over fixed time steps."""
SHIPPED = Path(__file__).with_name("measured") / "extremes.csv"
"""Table measured for this release."""
REFUSED = "refused"
FRAME = 0.5
"""Interval of the frames of a run with a fixed step, about, s."""
LINK = 2.0
"""Particles nearer than this many spacings hang together."""


EXTREMES: tuple[Variable, ...] = (
    Variable("sweep", ROW, "str", "1", "name of the key that is varied"),
    Variable("value", ROW, "str", "1", "its value"),
    Variable("case", ROW, "str", "1", "the slope, or the scheme of a sweep over time steps"),
    Variable("status", ROW, "str", "1", "complete, unfailed, diverged, or refused before any work"),
    Variable("reason", ROW, "str", "1", "why it diverged or was refused"),
    number_column("time_step_ratio", "1", "largest time step over its limit measured on the particles as they lay"),
    number_column("energy_gap", "1", "largest gap in the energy budget over the largest sum of its parts"),
    number_column("area_change", "1", "area inside the outline of the largest mass at the end over that of all soil at the start, minus 1"),
    number_column("nearest_p05", "1", "5th percentile of the distance to the nearest soil particle at the end over the spacing: pairing"),
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


class Sweep(Section):
    """One key and its values."""

    scene_key: str = key("scene key, dotted", pattern=r"^[A-Za-z_][A-Za-z0-9_.]*$")
    values: Annotated[tuple[Any, ...] | dict[Label, Any], Field(min_length=1)] = key("its values, by label where they are sections")
    cases: tuple[str, ...] | None = key("cases that are run; null: all", default=None)
    repeats: int | None = key("runs of every value; null: as for all sweeps", ge=1, le=10, default=None)
    scene: str | None = key("another scene file; null: that of all sweeps, with its overrides", default=None)
    symmetry: Literal["none", "mirror"] = key("mirror: the scene is symmetric about the middle of its box", default="none")


class TimeSteps(Section):
    """Fixed time steps around the limit."""

    factors: tuple[Annotated[float, Field(gt=0, le=10)], ...] = key("steps over the limit from theory", min_length=1)
    schemes: dict[Label, Overrides] = key("scene keys of each scheme, by label", min_length=1)


class Extremes(Cases):
    """The configuration."""

    repeats: int = key("runs of every value, whose bits are compared", ge=1, le=10, default=2)
    sweeps: dict[Label, Sweep] = key("the sweeps, by label", min_length=1)
    time_steps: TimeSteps = key("sweep over fixed time steps, in the first case")

    @model_validator(mode="after")
    def _apart(self) -> Extremes:
        check_file_names("sweeps", (*self.sweeps, TIME_STEP))
        check_file_names("time_steps.schemes", self.time_steps.schemes)
        for label, sweep in self.sweeps.items():
            check_file_names(f"sweeps.{label}.values", labelled(sweep.values))
        return self


class Row(NamedTuple):
    """One row of the table before it is measured."""

    sweep: str
    value: str
    case: str
    symmetric: bool
    refused: str
    """why the scene is refused; empty for one that runs"""
    runs: tuple[str, ...]
    """file names of its repeats, without suffix"""


def labelled(values: tuple[Any, ...] | Mapping[str, Any]) -> dict[str, Any]:
    """Values of a sweep by their labels."""
    return dict(values) if isinstance(values, Mapping) else {"null" if value is None else str(value): value for value in values}


class ExtremeRuns:
    """Every row of the table, and every run by file name without suffix."""

    def __init__(self, extremes: Extremes, scenes: Mapping[str, Mapping[str, Any]], origin: str) -> None:
        self.rows: list[Row] = []
        self.runs: dict[str, Run] = {}
        for label, sweep in extremes.sweeps.items():
            base = scenes[sweep.scene] if sweep.scene else merge(scenes[extremes.scene], extremes.overrides)
            check_known(f"{origin}: sweeps.{label}.cases", sweep.cases, extremes.cases)
            for case in sweep.cases or extremes.cases:
                start = merge(base, extremes.cases[case])
                make_scene(start, f"{origin}: sweeps.{label}, case {case!r}")
                repeats = sweep.repeats or extremes.repeats
                for text, value in labelled(sweep.values).items():
                    self._add(label, text, case, merge(start, dotted({sweep.scene_key: value})), repeats, sweep.symmetry == "mirror")
        start = merge(merge(scenes[extremes.scene], extremes.overrides), next(iter(extremes.cases.values())))
        for scheme, overrides in extremes.time_steps.schemes.items():
            for factor in extremes.time_steps.factors:
                self._add(TIME_STEP, f"{factor:g}", scheme, fixed_step(merge(start, overrides), factor), 1, symmetric=False)

    def _add(self, sweep: str, value: str, case: str, scene: dict[str, Any], repeats: int, symmetric: bool) -> None:
        stem = "/".join(file_name(part) for part in (sweep, case, value))
        refused = ""
        try:
            built = make_scene(scene, "scene")
            if sweep != TIME_STEP:
                check_time_step(built)
        except ValueError as error:
            refused = str(error)
        runs = () if refused else tuple(f"{stem}_{number}" for number in range(1, repeats + 1))
        self.runs |= dict.fromkeys(runs, Run(scene, enforce_limit=sweep != TIME_STEP))
        self.rows.append(Row(sweep, value, case, symmetric, refused, runs))

    @property
    def parameters(self) -> list[Row]:
        """The rows."""
        return self.rows


def fixed_step(scene: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """A scene with a fixed time step, a factor times the smallest limit from theory; its intervals become multiples of the step."""
    step = factor * min(limit.seconds for limit in limits(make_scene(merge(scene, {"numerics": {"adaptive_step": None}}))))
    built = make_scene(scene)
    sample = max(1, round(built.outputs.series_interval / step)) * step

    def samples(time: float) -> float:
        return max(1, round(time / sample)) * sample

    stage = samples(built.gravity.duration)
    return merge(
        scene,
        {
            "duration": samples(built.duration),
            "gravity": {"duration": stage},
            "motion": {} if isinstance(built.motion, NoMotion) else {"start": max(stage, built.motion.start)},
            "numerics": {"time_step": step, "adaptive_step": None},
            "outputs": {"series_interval": sample, "frame_interval": samples(FRAME)},
        },
    )


def load_extremes(path: str, study: Plan, folders: Sequence[Path] = (Path(),)) -> ExtremeRuns:
    """Validate the configuration; ValueError names file, key and value.  Values that the schema refuses are rows, not errors.

    It takes nothing from the study.
    """
    extremes = validated(Extremes, read_yaml(found_file(folders, path, "extremes")), path)
    names = {extremes.scene, *(sweep.scene for sweep in extremes.sweeps.values() if sweep.scene)}
    scenes = {name: read_scene(found_file(folders, name, f"{path}: scene")) for name in names}
    return ExtremeRuns(extremes, scenes, path)


# ---------------------------------------------------------------- measuring


def penetration(run: xr.Dataset, scene: Scene) -> float:
    """Largest depth of soil behind the face of a wall over all frames, over the spacing."""
    soil = run["kind"].values == SOIL
    x, y = (run[name].values[:, soil].astype(float) for name in ("x", "y"))
    walls, depth = scene.walls, np.zeros(1)
    width, height = (count * scene.numerics.spacing for count in scene.lattice)
    inside = (x >= 0.0) & (x <= width) if walls.kinds.sides.open else np.ones(x.shape, bool)
    if walls.kinds.base.stands:
        depth = np.append(depth, -y[inside])
    if walls.kinds.sides.stands:
        beside = (y >= 0.0) & (y <= height)
        depth = np.append(depth, np.append(-x[beside], x[beside] - width))
    return float(np.nanmax(depth)) / scene.numerics.spacing


def asymmetry(run: xr.Dataset, scene: Scene) -> float:
    """Largest distance of a particle from the mirror image of its counterpart, over the spacing."""
    soil = run["kind"].values == SOIL
    x0, y0 = run["x0"].values[soil], run["y0"].values[soil]
    x, y = (run[name].values[-1, soil].astype(float) for name in ("x", "y"))
    _, twin = scipy.spatial.cKDTree(np.column_stack([x0, y0])).query(np.column_stack([scene.geometry.width - x0, y0]))
    return float(np.hypot(scene.geometry.width - x[twin] - x, y[twin] - y).max()) / scene.numerics.spacing


def measure_extreme(run: xr.Dataset, symmetric: bool) -> dict[str, Any]:
    """The columns of a run."""
    scene = scene_of(run)
    soil, spacing = run["kind"].values == SOIL, scene.numerics.spacing
    first, last = (np.column_stack([run[name].values[frame, soil].astype(float) for name in ("x", "y")]) for frame in (0, -1))
    values: dict[str, Any] = {
        "status": run.attrs["status"],
        "reason": run.attrs["status_reason"],
        "time_step_ratio": float((run["time_step"] / run["time_step_limit"]).max()),
        "energy_gap": energy_gap(run),
        "wall_time": float(run.attrs["wall_time_s"]),
        "displacement": float(np.nanmax(np.hypot(*(last - first).T))),
        "penetration": penetration(run, scene),
        "asymmetry": asymmetry(run, scene) if symmetric else math.nan,
    }
    if np.isfinite(last).all():
        mass = largest_mass(last[:, 0], last[:, 1], LINK * spacing)
        nearest = scipy.spatial.cKDTree(last).query(last, k=2)[0][:, 1] / spacing
        values |= {
            "area_change": _area(last[mass], spacing) / _area(first, spacing) - 1.0,
            "nearest_p05": float(np.percentile(nearest, 5)),
            "nearest_least": float(nearest.min()),
            "stragglers": 1.0 - float(np.mean(mass)),
        }
    return values


def _area(places: np.ndarray, spacing: float) -> float:
    return outline_area(places[:, 0], places[:, 1], spacing)


def extremes_table(rows: Sequence[Row], read: Callable[[str], xr.Dataset]) -> pd.DataFrame:
    """One row a value and case; ``read`` gives a run by its file name."""
    table = []
    for row in rows:
        values: dict[str, Any] = {"status": REFUSED, "reason": row.refused}
        if row.runs:
            repeats = [read(name) for name in row.runs]
            values = measure_extreme(repeats[0], row.symmetric)
            if len(repeats) > 1:
                values["reproducible"] = float(all(repeat.equals(repeats[0]) for repeat in repeats[1:]))
        table.append({"sweep": row.sweep, "value": row.value, "case": row.case, **values})
    return pd.DataFrame(table, columns=[column.name for column in EXTREMES])


def read_extremes(path: Path | str = SHIPPED) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is none."""
    return read_csv(path, EXTREMES, "the extremes")


def _measure(rows: Sequence[Row], read: Callable[[str], xr.Dataset], settings: MetricSettings) -> dict[str, pd.DataFrame]:
    return {"extremes.csv": extremes_table(rows, read)}


EXPERIMENT = Experiment(
    "extremes",
    "Extremes",
    "How far the solver can be pushed: one key at a time to the ends of its range. "
    "Every run ends valid, diverged or refused, with a reason.",
    Extremes,
    load_extremes,
    _measure,
    {"extremes.csv": Table(EXTREMES, "every run")},
    Trace(
        ("sweep", "value", "case"),
        lambda design: {(row.sweep, row.value, row.case): row.runs for row in design.rows},
        lambda run, settings: {name: value for name, value in measure_extreme(run, False).items() if name != "asymmetry"},
    ),
)
