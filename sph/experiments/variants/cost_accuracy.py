"""Tables and figures of a cost-accuracy study, from its runs."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.variants.convergence import CONVERGENCE, convergence_table
from sph.experiments.variants.design import Measured
from sph.experiments.variants.figures import figure_convergence, figure_tradeoff
from sph.experiments.variants.table import COST_ACCURACY, cost_accuracy_table, measured_run, read_cost_accuracy
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset, read_csv

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"


def measure_cost_accuracy(
    plan: Measured, runs: Mapping[str, Run], settings: MetricSettings
) -> tuple[xr.Dataset, pd.DataFrame, pd.DataFrame]:
    """What each choice of the numerics costs and changes: one row per variant and case, with deviations from the reference. Every column
    is defined in docs/reference/files.md.
    """
    names = dict.fromkeys(name for row in plan.rows for name in row.runs)
    measured, machine = {name: measured_run(runs[name], settings) for name in names}, machine_class()
    frame = cost_accuracy_table(plan.rows, measured, plan.baseline, machine)
    attrs = runs[next(row.runs[0] for row in plan.rows if row.reference)].attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")}
    facts |= {"machine": machine, "timing": TIMING, "baseline": plan.baseline}
    return flat_dataset(frame, COST_ACCURACY, facts), frame, convergence_table(frame, plan.convergence)


def draw_tradeoff(table: str) -> Figure:
    """Error of A's displacement and of the run-out against computing time, a point per variant; hollow where the class differs in a
    case.
    """
    return figure_tradeoff(read_cost_accuracy(table))


def draw_convergence(convergence: str, table: str) -> Figure:
    """A's displacement, run-out and onset against particle spacing, a curve per case; stars are values extrapolated to spacing 0."""
    return figure_convergence(read_csv(convergence, CONVERGENCE, "the convergence"), read_cost_accuracy(table))
