"""Tables and figures of the cost-accuracy study, from its runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pandas as pd
import xarray as xr

from sph.experiments.base import Trace
from sph.experiments.steps import Step, table_step
from sph.experiments.trade.convergence import CONVERGENCE, convergence_table
from sph.experiments.trade.design import TradeParameters
from sph.experiments.trade.figures import figure_convergence, figure_tradeoff
from sph.experiments.trade.table import TRADE, measured_run, read_trade, trade_table
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset, read_csv

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"

OF_ALL = {"wall_time", "particle_steps_per_second"}
"""Columns that are medians over repeats."""
TRACE = Trace(
    TRADE,
    ("parameter", "variant", "case"),
    lambda design: {(row.parameter, row.variant, row.case): row.runs for row in design.rows},
    lambda run, settings: {name: value for name, value in measured_run(run, settings).items() if name not in OF_ALL},
)
READERS = {
    "table": lambda path, given: read_trade(path),
    "convergence": lambda path, given: read_csv(path, CONVERGENCE, "the convergence"),
}


def cost_accuracy_tables(
    plan: TradeParameters, read: Callable[[str], Run], settings: MetricSettings
) -> tuple[xr.Dataset, pd.DataFrame, pd.DataFrame]:
    """The table of a cost-accuracy study, twice, and its convergence."""
    names = dict.fromkeys(name for row in plan.rows for name in row.runs)
    runs, machine = {name: measured_run(read(name), settings) for name in names}, machine_class()
    frame = trade_table(plan.rows, runs, plan.baseline, machine)
    attrs = read(next(row.runs[0] for row in plan.rows if row.reference)).attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")}
    facts |= {"machine": machine, "timing": TIMING, "baseline": plan.baseline}
    return flat_dataset(frame, TRADE, facts), frame, convergence_table(frame, plan.convergence)


def measure_trade(*given: Any) -> Any:
    """What each saving of computing time costs: one row per variant and case, with deviations from the reference. Every column is defined
    in docs/reference/files.md.
    """
    return cost_accuracy_tables(*given)


def cost_accuracy_steps(name: str, measure: Callable[..., Any]) -> tuple[Step, ...]:
    """The jobs of a cost-accuracy study."""
    table, convergence = {"table": f"{name}.csv"}, {"convergence": "convergence.csv"}
    return (
        table_step(name, measure, {f"{name}.nc": "", f"{name}.csv": "every variant", "convergence.csv": "order of convergence"}),
        Step(f"{name}_figure_tradeoff", figure_tradeoff, table, {"figures/tradeoff": "figure tradeoff"}),
        Step(f"{name}_figure_convergence", figure_convergence, convergence | table, {"figures/convergence": "figure convergence"}),
    )


STEPS = cost_accuracy_steps("trade", measure_trade)
