"""Tables and figures of a cost-accuracy study, from its runs."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd
import xarray as xr

from sph.experiments.base import Trace
from sph.experiments.steps import Step, table_step
from sph.experiments.variants.convergence import CONVERGENCE, convergence_table
from sph.experiments.variants.design import Measured
from sph.experiments.variants.figures import figure_convergence, figure_tradeoff
from sph.experiments.variants.table import COST_ACCURACY, cost_accuracy_table, measured_run, read_cost_accuracy
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset, read_csv

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"

OF_ALL = {"wall_time", "particle_steps_per_second"}
"""Columns that are medians over repeats."""
TRACE = Trace(
    COST_ACCURACY,
    ("parameter", "variant", "case"),
    lambda design: {(row.parameter, row.variant, row.case): row.runs for row in design.rows},
    lambda run, settings: {name: value for name, value in measured_run(run, settings).items() if name not in OF_ALL},
)
READERS = {
    "table": lambda path, given: read_cost_accuracy(path),
    "convergence": lambda path, given: read_csv(path, CONVERGENCE, "the convergence"),
}


def measure_cost_accuracy(
    plan: Measured, read: Callable[[str], Run], settings: MetricSettings
) -> tuple[xr.Dataset, pd.DataFrame, pd.DataFrame]:
    """What each choice of the numerics costs and changes: one row per variant and case, with deviations from the reference. Every column
    is defined in docs/reference/files.md.
    """
    names = dict.fromkeys(name for row in plan.rows for name in row.runs)
    runs, machine = {name: measured_run(read(name), settings) for name in names}, machine_class()
    frame = cost_accuracy_table(plan.rows, runs, plan.baseline, machine)
    attrs = read(next(row.runs[0] for row in plan.rows if row.reference)).attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")}
    facts |= {"machine": machine, "timing": TIMING, "baseline": plan.baseline}
    return flat_dataset(frame, COST_ACCURACY, facts), frame, convergence_table(frame, plan.convergence)


def steps(name: str) -> tuple[Step, ...]:
    """The jobs of a cost-accuracy study."""
    rule, table, convergence = name.replace("-", "_"), {"table": f"{name}.csv"}, {"convergence": "convergence.csv"}
    files = {f"{name}.nc": "", f"{name}.csv": "every variant", "convergence.csv": "order of convergence"}
    return (
        table_step(rule, measure_cost_accuracy, files),
        Step(f"{rule}_figure_tradeoff", figure_tradeoff, table, {"figures/tradeoff": "figure tradeoff"}),
        Step(f"{rule}_figure_convergence", figure_convergence, convergence | table, {"figures/convergence": "figure convergence"}),
    )


STEPS = steps("cost-accuracy")
