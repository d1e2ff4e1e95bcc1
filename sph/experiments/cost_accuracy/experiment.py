"""The cost-accuracy study as an experiment: its tables from its runs."""

from __future__ import annotations

import functools
from collections.abc import Callable

import pandas as pd
import xarray as xr

from sph.experiments.base import Experiment, Table, Trace
from sph.experiments.cost_accuracy.convergence import CONVERGENCE, convergence_table
from sph.experiments.cost_accuracy.design import Trade, TradeParameters, load_trade
from sph.experiments.cost_accuracy.table import TRADE, measured_run, trade_table
from sph.measures.metrics import MetricSettings
from sph.study.machine import machine_class
from sph.study.tables import flat_dataset

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"

OF_ALL = {"wall_time", "particle_steps_per_second"}
"""Columns that are medians over repeats."""
TRACE = Trace(
    ("parameter", "variant", "case"),
    lambda design: {(row.parameter, row.variant, row.case): row.runs for row in design.rows},
    lambda run, settings: {name: value for name, value in measured_run(run, settings).items() if name not in OF_ALL},
)


def _measure(
    name: str, plan: TradeParameters, read: Callable[[str], xr.Dataset], settings: MetricSettings
) -> dict[str, pd.DataFrame | xr.Dataset]:
    names = dict.fromkeys(name for row in plan.rows for name in row.runs)
    runs, machine = {name: measured_run(read(name), settings) for name in names}, machine_class()
    frame = trade_table(plan.rows, runs, plan.baseline, machine)
    attrs = read(next(row.runs[0] for row in plan.rows if row.reference)).attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")}
    facts |= {"machine": machine, "timing": TIMING, "baseline": plan.baseline}
    return {
        "convergence.csv": convergence_table(frame, plan.convergence),
        f"{name}.nc": flat_dataset(frame, TRADE, facts),
        f"{name}.csv": frame,
    }


def _experiment(name: str, title: str, about: str) -> Experiment:
    tables = {
        f"{name}.nc": Table(TRADE),
        f"{name}.csv": Table(TRADE, "every variant"),
        "convergence.csv": Table(CONVERGENCE, "order of convergence"),
    }
    about = f"{about} Every column is defined in docs/reference/files.md."
    return Experiment(name, title, about, Trade, load_trade, functools.partial(_measure, name), tables, TRACE)


EXPERIMENT = _experiment(
    "trade",
    "Cost and accuracy",
    "What each saving of computing time costs: one row a variant and case, with deviations from the reference.",
)
RESOLUTION = _experiment(
    "resolution",
    "Cost and accuracy of the scheme for one's own slopes",
    "What finer particles bring, and what chance decides: one row a variant and case, with deviations from the finest.",
)
