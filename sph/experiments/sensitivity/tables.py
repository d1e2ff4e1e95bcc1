"""Tables of the sensitivity analysis: its runs, the ends of the ranges, and points at two fidelities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sph.experiments.sensitivity.design import Point
from sph.experiments.sensitivity.factors import ENDS, Axis, Quantity
from sph.experiments.sensitivity.schema import SAMPLE
from sph.measures.metrics import METRIC_BY_NAME, MetricSettings, measure
from sph.output.run import Run
from sph.storage.trajectory import Status, Variable
from sph.study.tables import ROW, number_column, read_csv, text_column

CONFIRMED: tuple[Variable, ...] = (
    text_column("run", "file of the run under runs/, without suffix"),
    text_column("metric", "metric, as in study.csv"),
    text_column("units", "its unit"),
    text_column("fidelity", "the study's fidelity"),
    text_column("confirmed_at", "the fidelity it is repeated at"),
    number_column("value", "as units", "metric at the study's fidelity; NaN for a diverged run"),
    number_column("confirmed", "as units", "metric at the other one; NaN for a diverged run"),
    number_column("difference", "as units", "value minus confirmed"),
    number_column("relative_difference", "1", "difference over confirmed; NaN where that is 0"),
)
"""The columns of the confirmation."""
TORNADO: tuple[Variable, ...] = (
    text_column("metric", "metric, as in study.csv"),
    text_column("units", "its unit"),
    text_column("factor", "factor that is moved, all others at their base value"),
    text_column("factor_units", "its unit; level: numbers of levels, from 1, in the order of the configuration"),
    *(
        number_column(name, "as factor_units", f"{text} of the factor; of levels the one at which the metric is {most}")
        for name, text, most in zip(ENDS, ("low end", "high end"), ("smallest", "largest"), strict=True)
    ),
    number_column("base_value", "as factor_units", "the factor's value in the scene as it is"),
    number_column("at_base", "as units", "metric of the scene as it is; NaN if that diverged"),
    *(number_column(f"at_{name}", "as units", f"metric at the {name} end; NaN for a diverged run") for name in ENDS),
    number_column("swing", "as units", "range of these values, of levels that of all; NaN if one diverged"),
    Variable("diverged", ROW, "i4", "1", "diverged runs among these"),
)
"""The columns of the effects one at a time."""


def sample_columns(axes: Sequence[Axis], quantities: Sequence[Quantity]) -> tuple[Variable, ...]:
    """All columns of a sample: of every run, its factors and its metrics."""
    return (
        *SAMPLE,
        *(number_column(axis.name, axis.unit, axis.meaning) for axis in axes),
        *(METRIC_BY_NAME[quantity.metric] for quantity in quantities),
    )


def sample_row(run: str, point: Point, made: Run, columns: Sequence[Variable], metrics: MetricSettings) -> dict[str, Any]:
    """Row of a sample with the columns of ``sample_columns``, in which the factors, a value of ``point`` each, follow ``SAMPLE``."""
    factors = [column.name for column in columns[len(SAMPLE) : len(SAMPLE) + len(point)]]
    values = {"run": run, "reason": made.attrs["status_reason"], **measure(made, metrics)}
    values |= dict(zip(factors, point, strict=True))
    return {column.name: values[column.name] for column in columns}


def read_sample(path: Path | str, axes: Sequence[Axis], quantities: Sequence[Quantity]) -> pd.DataFrame:
    """A sample from its CSV; ValueError names a file that is not one."""
    return read_csv(path, sample_columns(axes, quantities), "a sample")


def described(sample: pd.DataFrame) -> str:
    """Runs of a sample, how many of them diverged and how many had not come to rest, in words for a figure."""
    lost, moving = diverged_runs(sample), int((sample["still_moving"] == 1).sum())
    words = f"{len(sample)} runs, " + (f"{lost} of which diverged and are left out" if lost else "none of which diverged")
    return words + f", {moving} still moving at the end: at least so far" * bool(moving)


def diverged_runs(sample: pd.DataFrame) -> int:
    """Number of diverged runs of a sample."""
    return int((sample["status"] == Status.DIVERGED).sum())


def tornado_table(sample: pd.DataFrame, axes: Sequence[Axis], quantities: Sequence[Quantity]) -> pd.DataFrame:
    """Metrics at both ends of every factor, from the runs of the tornado in their order: the base, then those of each factor."""
    rows, lost = [], (sample["status"] == Status.DIVERGED).to_numpy()
    for quantity in quantities:
        values, first = sample[quantity.metric].to_numpy(), 1
        for axis in axes:
            own = [0, *range(first, first + len(axis.moved))]
            first += len(axis.moved)
            at, ends = values[own], (axis.low, axis.high)
            moved = at[1:]
            if axis.levels:
                known = sorted((value, level) for value, level in zip(at, (axis.base, *axis.moved.values()), strict=True) if value == value)
                (least, low), (most, high) = (known[0], known[-1]) if known else ((math.nan, math.nan),) * 2
                moved, ends = np.array([least, most]), (low, high)
            about = (quantity.metric, quantity.metric_unit, axis.name, "level" if axis.levels else axis.unit)
            rows.append((*about, *ends, axis.base, values[0], *moved, np.ptp(at), lost[own].sum()))
    return pd.DataFrame(rows, columns=[column.name for column in TORNADO])


def confirmation_table(
    sample: pd.DataFrame, confirmed: pd.DataFrame, quantities: Sequence[Quantity], names: tuple[str, str]
) -> pd.DataFrame:
    """The runs of ``confirmed`` beside the same points of ``sample``, which come first in it; ``names`` are the two fidelities."""
    rows = []
    for quantity in quantities:
        pairs = zip(confirmed["run"], sample[quantity.metric], confirmed[quantity.metric], strict=False)
        for run, value, other in pairs:
            relative = (value - other) / other if other else math.nan
            rows.append((run, quantity.metric, quantity.metric_unit, *names, value, other, value - other, relative))
    return pd.DataFrame(rows, columns=[column.name for column in CONFIRMED])
