"""The cost-accuracy study as an experiment: its tables from its runs."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd
import xarray as xr

from sph.experiments.base import Experiment, Table
from sph.experiments.cost_accuracy.convergence import CONVERGENCE, convergence_table
from sph.experiments.cost_accuracy.design import Trade, TradeParameters, load_trade
from sph.experiments.cost_accuracy.table import TRADE, measured_run, trade_table
from sph.measures.metrics import MetricSettings
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"


def _measure(plan: TradeParameters, read: Callable[[str], xr.Dataset], settings: MetricSettings) -> dict[str, pd.DataFrame | xr.Dataset]:
    names = dict.fromkeys(name for row in plan.rows for name in row.runs)
    runs, machine = {name: measured_run(read(name), settings) for name in names}, machine_class()
    frame = trade_table(plan.rows, runs, plan.baseline, machine)
    attrs = read(next(row.runs[0] for row in plan.rows if row.reference)).attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")}
    facts |= {"machine": machine, "timing": TIMING, "baseline": plan.baseline}
    return {
        "convergence.csv": convergence_table(frame, plan.convergence),
        "trade.nc": flat_dataset(frame, TRADE, facts),
        "trade.csv": frame,
    }


EXPERIMENT = Experiment(
    "trade",
    "Cost and accuracy",
    "What each saving of computing time costs: one row a variant and case, with deviations from the reference. "
    "Every column is defined in docs/experiments/cost-accuracy.md.",
    Trade,
    load_trade,
    _measure,
    {
        "trade.nc": Table(TRADE),
        "trade.csv": Table(TRADE, "every variant"),
        "convergence.csv": Table(CONVERGENCE, "order of convergence"),
    },
)
