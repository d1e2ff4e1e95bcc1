"""What a second spacing changes: class, displacement, run-out and distance from places of runs at both, extrapolated, with a verdict.

A study is repeated as a whole at its second fidelity, or, where that is the one it runs at, the few runs are that decide in what shaking
the slope fails.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from sph.measures.metrics import CLASSES, UNDETERMINED, MetricSettings, measure
from sph.measures.places import PASSED, column_of
from sph.output.run import Run
from sph.storage.trajectory import Status, Variable
from sph.study.dimensions import ALTERNATIVE, AMPLITUDE, BASE
from sph.study.tables import Layout, number_column, read_csv, read_table, text_column

RELATIVE = 0.1
"""Change of a value between the two spacings, over that at the finer, up to which they agree."""
CONVERGED, NOT_CONVERGED, UNKNOWN = f"agrees within {100.0 * RELATIVE:g} %", "not converged", "undetermined"
"""Verdicts; undetermined: a run diverged.  Two close spacings may agree and both be wrong by more."""
LENGTHS = ("displacement_magnitude", "runout")
DECIDING, MOST_DECIDING = "deciding.csv", 3
"""Table of the runs that are repeated where not all are, and how many there are at most."""
DECIDING_COLUMNS = (text_column("run", "name of a run that decides in what shaking the slope fails"),)


def spacing_columns() -> tuple[Variable, ...]:
    """The columns of the table."""
    return (
        text_column("run", "name of the run: its files are runs/<run>.nc at both fidelities"),
        text_column("collapse_class", "class of the run at the spacing of the study"),
        text_column("second_class", "class of the run at the second spacing"),
        text_column("quantity", f"{' or '.join(LENGTHS)}, or the run-out past a place"),
        number_column("spacing", "m", "spacing of the study"),
        number_column("value", "m", "value of the quantity at that spacing"),
        number_column("second_spacing", "m", "spacing of the second fidelity"),
        number_column("second_value", "m", "value of the quantity at that spacing"),
        number_column(
            "extrapolated", "m", "value extrapolated linearly to spacing 0; NaN where the class of the run differs between the two"
        ),
        number_column("extrapolation_error", "m", "half the step from the value at the finer spacing to the extrapolated one"),
        text_column(
            "verdict",
            f"{CONVERGED}: the class is the same, and the two values differ by at most {RELATIVE:.0%} of that at the finer spacing (past a "
            "place: of the run-out), or by less than what counts as motion (metrics.onset_threshold; for a run-out half the coarser "
            "spacing); else "
            f"{NOT_CONVERGED}; {UNKNOWN}: a run diverged",
        ),
    )


def deciding_runs(study: str, names: Sequence[str], layout: Layout) -> pd.DataFrame:
    """The runs that decide in what shaking the slope as it is fails, of a study with runs of these ``names``: of the weakest two levels in
    which one fails, and of the strongest below in which none does, each the one whose probe moves farthest.
    """
    table = read_table(study, layout)
    table.index = pd.Index(names)
    own = table[table[ALTERNATIVE] == BASE] if ALTERNATIVE in table else table
    own = own[(own["diverged"] == 0) & (own["status"] != Status.FAILED_UNSHAKEN)]
    shaking, fails = own[AMPLITUDE].astype(float), own["collapse_class"] != CLASSES[0]
    failing = sorted(set(shaking[fails]))
    standing = sorted(level for level in set(shaking) if not level >= min(failing, default=math.inf))
    chosen = [own[fails & (shaking == level)] for level in failing[:2]] + [own[shaking == level] for level in standing[-1:]]
    return pd.DataFrame({"run": [runs["displacement_magnitude"].idxmax() for runs in chosen]}, dtype=str)


def read_deciding(path: Any) -> list[str]:
    """The names in that table; ValueError names a file that is not one."""
    return list(read_csv(path, DECIDING_COLUMNS, "the runs that decide")["run"])


def spacing_table(
    study: str, runs: Mapping[Any, Run], names: Sequence[str], spacings: tuple[float, float], settings: MetricSettings, layout: Layout
) -> pd.DataFrame:
    """Runs of the study at a second spacing: class, displacement, run-out and run-out past places at both, on a line to spacing 0, and
    whether they agree. Every column is defined in docs/reference/files.md.
    """
    rows, quantities = [], (*LENGTHS, *(column_of(place, PASSED) for place in settings.places))
    table = dict(zip(names, read_table(study, layout).to_dict("records"), strict=True))
    for name, run in runs.items():
        own, second = table[name], measure(run, settings)
        rows += [
            (name, *(each["collapse_class"] for each in (own, second)), quantity)
            + compared(own, second, quantity, spacings, settings.onset_threshold)
            for quantity in quantities
            if own["collapse_class"] == UNDETERMINED or not math.isnan(own[quantity])
        ]
    return pd.DataFrame(rows, columns=[column.name for column in spacing_columns()])


def compared(
    own: Mapping[Any, Any], second: Mapping[Any, Any], quantity: str, spacings: tuple[float, float], moved: float
) -> tuple[float, float, float, float, float, float, str]:
    """The columns of a quantity but its name, from the metrics of a run at both ``spacings`` (m); ``moved`` (m) counts as motion."""
    values = float(own[quantity]), float(second[quantity])
    (fine, at_fine), (coarse, at_coarse) = sorted(zip(spacings, values, strict=True))
    classes = {own["collapse_class"], second["collapse_class"]}
    step = (at_fine - at_coarse) * fine / (coarse - fine)
    if UNDETERMINED in classes:
        verdict = UNKNOWN
    else:
        least = moved if quantity == LENGTHS[0] else 0.5 * coarse
        goes = at_fine if quantity in LENGTHS else float((own if spacings[0] == fine else second)["runout"])
        near = abs(at_fine - at_coarse) <= max(RELATIVE * abs(goes), least)
        verdict = CONVERGED if near and len(classes) == 1 else NOT_CONVERGED
    if len(classes) > 1:
        step = math.nan
    lowest = -math.inf if quantity not in LENGTHS else 0.0
    extrapolated = max(at_fine + step, lowest) if not math.isnan(step) else math.nan
    return spacings[0], values[0], spacings[1], values[1], extrapolated, 0.5 * abs(step), verdict


def read_spacing(path: Any) -> pd.DataFrame:
    """The table from its CSV; ValueError names a file that is not one."""
    return read_csv(path, spacing_columns(), "the second spacing")
