"""The table of the assumptions: the effect of each change, over the scene as it is.

The table measured for this release is part of the package (``SHIPPED``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from sph.experiments.base import Trace
from sph.experiments.limits.design import run_name
from sph.experiments.steps import table_step
from sph.measures.metrics import METRIC_BY_NAME, MetricSettings, measure
from sph.output.run import Run
from sph.storage.trajectory import Variable
from sph.study.tables import ROW, read_csv

SHIPPED = Path(__file__).parents[1] / "measured" / "limits.csv"
"""Table measured for this release."""
QUANTITIES = ("displacement_magnitude", "runout")

LIMITS: tuple[Variable, ...] = (
    Variable("change", ROW, "str", "1", "change to the scene"),
    Variable("case", ROW, "str", "1", "point of the study"),
    *(METRIC_BY_NAME[name] for name in ("collapse_class", *QUANTITIES)),
    *(
        Variable(f"{name}_change", ROW, "f8", "1", f"{name} over that of the scene as it is, minus 1; NaN where that is 0")
        for name in QUANTITIES
    ),
)
"""The columns."""


def limits_table(rows: Sequence[tuple[str, str]], runs: Sequence[Run], settings: MetricSettings) -> pd.DataFrame:
    """One row per change and case, from the runs in the rows' order; the first change is the reference."""
    frame = pd.DataFrame(
        [{"change": change, "case": case, **measure(run, settings)} for (change, case), run in zip(rows, runs, strict=True)]
    )
    reference = frame[frame["change"] == rows[0][0]].set_index("case")
    for name in QUANTITIES:
        as_it_is = frame["case"].map(reference[name])
        frame[f"{name}_change"] = (frame[name] / as_it_is.where(as_it_is != 0)) - 1.0
    return frame[[row.name for row in LIMITS]]


def read_limits(path: Path | str = SHIPPED) -> pd.DataFrame:
    """Table from its CSV; ValueError names a file that is not one."""
    return read_csv(path, LIMITS, "the limits")


def measure_limits(rows: Sequence[tuple[str, str]], read: Callable[[str], Run], settings: MetricSettings) -> pd.DataFrame:
    """Effect of the assumptions: A's displacement and the run-out with one choice changed at a time, over those of the unchanged scene."""
    return limits_table(rows, [read(run_name(change, case)) for change, case in rows], settings)


TRACE = Trace(LIMITS, ("change", "case"), lambda design: {row: [run_name(*row)] for row in design.rows}, measure)
READERS: dict[str, Callable[..., pd.DataFrame]] = {}
STEPS = (table_step("limits", measure_limits, {"limits.csv": "every change"}),)
