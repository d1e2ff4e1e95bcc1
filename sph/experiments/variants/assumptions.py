"""The table of the assumptions: the effect of each change, over the scene as it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from sph.experiments.variants.design import Measured
from sph.measures.metrics import METRIC_BY_NAME, MetricSettings, measure
from sph.output.run import Run
from sph.storage.trajectory import Variable
from sph.study.tables import number_column, read_csv, text_column

SHIPPED = Path(__file__).parents[1] / "measured" / "assumptions.csv"
"""Table measured for this release."""
QUANTITIES = ("displacement_magnitude", "runout")

ASSUMPTIONS: tuple[Variable, ...] = (
    text_column("change", "change to the scene"),
    text_column("case", "point of the study"),
    *(METRIC_BY_NAME[name] for name in ("collapse_class", *QUANTITIES)),
    *(number_column(f"{name}_change", "1", f"{name} over that of the scene as it is, minus 1; NaN where that is 0") for name in QUANTITIES),
)
"""The columns."""


def measure_assumptions(plan: Measured, runs: Mapping[str, Run], settings: MetricSettings) -> pd.DataFrame:
    """Effect of the assumptions: A's displacement and the run-out with one choice changed at a time, over those of the unchanged scene."""
    frame = pd.DataFrame([{"change": row.variant, "case": row.case, **measure(runs[row.runs[0]], settings)} for row in plan.rows])
    reference = frame[[row.reference for row in plan.rows]].set_index("case")
    for name in QUANTITIES:
        as_it_is = frame["case"].map(reference[name])
        frame[f"{name}_change"] = (frame[name] / as_it_is.where(as_it_is != 0)) - 1.0
    return frame[[row.name for row in ASSUMPTIONS]]


def read_assumptions(path: Path | str = SHIPPED) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is not one."""
    return read_csv(path, ASSUMPTIONS, "the assumptions")
