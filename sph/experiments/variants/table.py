"""The table of a cost-accuracy study: what each variant costs and how far its results lie from the reference.

``COST_ACCURACY`` defines every column; ``cost_accuracy_table`` makes the table from measured runs, ``summary`` puts the cases of a variant
together.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from statistics import median, mode
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sph.experiments.variants.design import Row, settings_text
from sph.experiments.variants.schema import FIDELITY
from sph.measures.metrics import METRIC_BY_NAME, MetricSettings, measure
from sph.output.run import Run
from sph.storage.trajectory import Status, Variable
from sph.study.tables import ROW, number_column, read_csv, text_column

QUANTITIES = {"displacement": "displacement_magnitude", "runout": "runout"}
"""The metrics whose deviations are given, by the name of the deviation."""
WORDS = {"displacement": "A's displacement", "runout": "run-out"}
"""The quantities in words."""

COST_ACCURACY: tuple[Variable, ...] = (
    text_column("parameter", f"what is varied; '{FIDELITY}' for the fidelities of the study"),
    text_column("variant", "its value"),
    text_column("case", "point of the study"),
    text_column("changes", "accuracy: how well the scene is computed; model: what is computed"),
    text_column(
        "settings",
        "scene keys that the variant sets over the scene file, as JSON; a list of lattice shifts: results are means over runs with each, "
        "computing times their sum",
    ),
    text_column("scheme", "how the run is simulated: scene keys, but for what is simulated, that differ from their defaults, as JSON"),
    text_column("machine", "processor and number of cores of the machine that made the table"),
    Variable("timed", ROW, "i1", "1", "1 for the case whose run is repeated: its computing time is the variant's cost"),
    Variable("reference", ROW, "i1", "1", "1 for the variant from which deviations are measured"),
    Variable("repeats", ROW, "i4", "1", "how often the run was made"),
    METRIC_BY_NAME["status"],
    METRIC_BY_NAME["collapse_class"],
    Variable("class_as_reference", ROW, "i1", "1", "1 if the class is that of the reference in the same case"),
    METRIC_BY_NAME["displacement_magnitude"],
    METRIC_BY_NAME["runout"],
    number_column("onset_after_start", "s", "onset_time minus shaking_start; NaN if the probe's motion never begins"),
    METRIC_BY_NAME["energy_error"],
    METRIC_BY_NAME["time_step_ratio"],
    number_column("spacing", "m", "initial particle spacing"),
    Variable("particles", ROW, "i4", "1", "number of particles, those of the box included"),
    Variable("steps", ROW, "i4", "1", "number of time steps made"),
    number_column("wall_time", "s", "computing time of the whole run without compiling, reading and writing: median of the repeats"),
    number_column("wall_time_min", "s", "its smallest value"),
    number_column("wall_time_max", "s", "its largest value"),
    number_column("particle_steps_per_second", "s-1", "particles times time steps over the computing time: median of the repeats"),
    *(
        number_column(f"{name}_deviation{suffix}", "1", f"{metric} over that of {what} in the same case, minus 1; NaN for a diverged run")
        for suffix, what in (("", "the reference"), ("_from_baseline", "the baseline, the fidelity named in the configuration,"))
        for name, metric in QUANTITIES.items()
    ),
    number_column(
        "reproducible", "1", "1 if all repeats gave the same bits of displacement and run-out, 0 if not; NaN for a run made once"
    ),
)
COLUMNS = [row.name for row in COST_ACCURACY]


def measured_run(run: Run, settings: MetricSettings) -> dict[str, Any]:
    """Metrics of one run, its size and its spacing (m)."""
    particles = run.soil.size
    return measure(run, settings) | {
        "particles": particles,
        "steps": int(run.attrs["particle_steps"]) // particles,
        "spacing": run.scene.numerics.spacing,
    }


def cost_accuracy_table(rows: Sequence[Row], runs: Mapping[str, Mapping[str, Any]], baseline: str, machine: str) -> pd.DataFrame:
    """Frame with the columns ``COLUMNS`` from the rows of a cost-accuracy study and what was measured of its runs, by name."""
    records = [_row(row, [[runs[name] for name in repeats] for repeats in row.lattices], machine) for row in rows]
    references = {row["case"]: row for row in records if row["reference"]}
    baselines = {row["case"]: row for row in records if (row["parameter"], row["variant"]) == (FIDELITY, baseline)}
    for row in records:
        row["class_as_reference"] = int(row["collapse_class"] == references[row["case"]]["collapse_class"])
        for name, metric in QUANTITIES.items():
            row[f"{name}_deviation"] = _deviation(row[metric], references[row["case"]][metric])
            row[f"{name}_deviation_from_baseline"] = _deviation(row[metric], baselines[row["case"]][metric])
    return pd.DataFrame(records, columns=COLUMNS)


def _row(row: Row, lattices: Sequence[Sequence[Mapping[str, Any]]], machine: str) -> dict[str, Any]:
    """Row of a variant from the repeats of its run, or of its run on every lattice."""
    first = _mean([runs[0] for runs in lattices])
    times = [[float(run["wall_time"]) for run in runs] for runs in lattices]
    results = [[np.array([run[metric] for metric in QUANTITIES.values()]) for run in runs] for runs in lattices]
    same = all(np.array_equal(result, repeats[0], equal_nan=True) for repeats in results for result in repeats)
    return {name: first[name] for name in COLUMNS if name in first} | {
        "parameter": row.parameter,
        "variant": row.variant,
        "case": row.case,
        "changes": row.changes,
        "settings": settings_text(row.settings),
        "scheme": settings_text(row.scheme),
        "machine": machine,
        "timed": int(row.timed),
        "reference": int(row.reference),
        "repeats": min(map(len, lattices)),
        "onset_after_start": first["onset_time"] - first["shaking_start"],
        "wall_time": sum(map(median, times)),
        "wall_time_min": sum(map(min, times)),
        "wall_time_max": sum(map(max, times)),
        "particle_steps_per_second": median(run["particle_steps_per_second"] for runs in lattices for run in runs),
        "reproducible": float(same) if min(map(len, lattices)) > 1 else math.nan,
    }


def _mean(runs: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """What was measured of a run, or of the same run on several lattices: means, the largest of the errors, the most frequent class."""
    if len(runs) == 1:
        return runs[0]
    diverged = [run["status"] for run in runs if run["status"] == Status.DIVERGED]
    return {
        **runs[0],
        **{name: float(np.mean([run[name] for run in runs])) for name in (*QUANTITIES.values(), "onset_time")},
        **{name: max((run[name] for run in runs), key=abs) for name in ("energy_error", "time_step_ratio")},
        "steps": sum(run["steps"] for run in runs),
        "collapse_class": mode(run["collapse_class"] for run in runs),
        "status": (diverged or [run["status"] for run in runs])[0],
    }


def _deviation(value: float, reference: float) -> float:
    """Relative deviation; of two zeros 0, from zero infinite."""
    if reference == 0:
        return 0.0 if value == 0 else math.nan if math.isnan(value) else math.inf
    return value / reference - 1.0


def read_cost_accuracy(path: Path | str) -> pd.DataFrame:
    """Table of a cost-accuracy study from its CSV; ValueError names a file that is not one, or that holds no row."""
    frame = read_csv(path, COST_ACCURACY, "a cost-accuracy study")
    if frame.empty:
        raise ValueError(f"{path}: the table of a cost-accuracy study without a row")
    return frame


def against(frame: pd.DataFrame, fidelity: str) -> pd.DataFrame:
    """The table with a fidelity for its reference; ValueError names one that was not measured in every case."""
    fidelities = frame[frame["parameter"] == FIDELITY]
    own = fidelities[fidelities["variant"] == fidelity].set_index("case")
    if set(own.index) != set(frame["case"]):
        raise ValueError(f"fidelity: {fidelity!r} must be one of {', '.join(dict.fromkeys(fidelities['variant']))}, measured in every case")
    at = own.loc[frame["case"]]
    compared = frame.assign(
        reference=((frame["parameter"] == FIDELITY) & (frame["variant"] == fidelity)).astype(int),
        class_as_reference=(frame["collapse_class"].to_numpy() == at["collapse_class"].to_numpy()).astype(int),
    )
    for name, metric in QUANTITIES.items():
        compared[f"{name}_deviation"] = [_deviation(*pair) for pair in zip(frame[metric], at[metric], strict=True)]
    return compared


class Summary(NamedTuple):
    """A variant with its cases put together."""

    parameter: str
    variant: str
    settings: str  # as in the table
    scheme: str  # as in the table
    reference: bool
    cost: float  # computing time of the timed case, s
    particle_steps_per_second: float  # of the timed case
    errors: dict[str, float]  # largest absolute deviation over the cases by quantity; NaN if one diverged
    baseline_errors: dict[str, float]  # the same from the baseline
    cases: int  # how many it ran in
    classes_agree: int  # in how many the class is that of the reference
    every_case: bool  # it ran in every case of the cost-accuracy study
    changes: str  # accuracy or model
    time_step_ratio: float  # largest over the cases

    @property
    def name(self) -> str:
        """Parameter and label."""
        return f"{self.parameter}: {self.variant}"

    @property
    def finished(self) -> bool:
        """No case diverged."""
        return not any(math.isnan(error) for error in self.errors.values())

    @property
    def sound(self) -> bool:
        """It computes the same model, with a time step that never exceeded the limit measured on the way."""
        return self.changes == "accuracy" and self.time_step_ratio <= 1.0


def summary(frame: pd.DataFrame) -> list[Summary]:
    """The variants of a table, in its order."""
    cases = frame["case"].nunique()
    by_variant: dict[tuple[str, str], list[dict[Hashable, Any]]] = {}
    for row in frame.to_dict("records"):
        by_variant.setdefault((row["parameter"], row["variant"]), []).append(row)
    variants = []
    for rows in by_variant.values():
        timed = next(row for row in rows if row["timed"] == 1)
        variants.append(
            Summary(
                **{str(name): timed[name] for name in ("parameter", "variant", "settings", "scheme", "changes")},
                reference=bool(timed["reference"]),
                cost=float(timed["wall_time"]),
                particle_steps_per_second=float(timed["particle_steps_per_second"]),
                errors=_largest(rows, ""),
                baseline_errors=_largest(rows, "_from_baseline"),
                cases=len(rows),
                classes_agree=int(sum(row["class_as_reference"] for row in rows)),
                every_case=len(rows) == cases,
                time_step_ratio=float(np.fmax.reduce([row["time_step_ratio"] for row in rows])),
            )
        )
    return variants


def _largest(rows: Sequence[Mapping[Hashable, Any]], suffix: str) -> dict[str, float]:
    return {name: float(np.abs([row[f"{name}_deviation{suffix}"] for row in rows]).max()) for name in QUANTITIES}


def non_dominated(cost: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Indices, by rising cost (n,), of the points that no other beats in both cost and error (n,); NaN never is one."""
    front, best = [], math.inf
    for index in np.lexsort((error, cost)):
        if error[index] < best:
            front.append(int(index))
            best = error[index]
    return np.array(front, dtype=int)
