"""The table of the suite: every quantity beside its reference, with error, order of convergence and verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from sph.stability.extrapolation import extrapolate
from sph.storage.trajectory import Status, Variable
from sph.study.tables import number_column, read_csv, text_column
from sph.study.verdicts import HOLDS, MISSES
from sph.validation import CASES
from sph.validation.level import Found, Level
from sph.validation.suite import Case

SHIPPED_VALIDATION = Path(__file__).with_name("measured") / "validation.csv"
"""Table measured for this release, by ``snakemake validation``."""
NO_ORDER_BELOW = 1e-6
"""Errors below this are rounding: no order of convergence is given."""


VALIDATION: tuple[Variable, ...] = (
    text_column("case", "name of the case"),
    text_column("title", "what is tested"),
    text_column("quantity", "name of the quantity"),
    text_column("text", "the quantity in words"),
    text_column("units", "its unit"),
    number_column("computed", "see units", "value on the finest level, or extrapolated from the two finest"),
    number_column("reference", "see units", "value to meet"),
    number_column("error", "1", "difference over the reference; where that is 0 the difference, in units"),
    number_column("tolerance", "1", "largest error allowed on the value computed"),
    text_column("verdict", f"{HOLDS} or {MISSES}"),
    text_column("levels", "resolutions, from coarse to fine"),
    text_column("errors", "errors of the levels, from coarse to fine, then of what they are extrapolated to"),
    number_column(
        "order",
        "1",
        "observed order of convergence, from the two finest levels; NaN where the error is rounding or changes its sign, or a run diverged",
    ),
    number_column("cost", "s", "computing time of all runs of the case on one core"),
    text_column("reason", "why this tolerance"),
    text_column("source", "where the reference comes from"),
)
"""The columns."""


def observed_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Order of convergence from the two finest levels; NaN for one level, for errors of two signs and for rounding."""
    if len(errors) < 2 or not min(abs(error) for error in errors[-2:]) >= NO_ORDER_BELOW or errors[-2] * errors[-1] < 0:
        return math.nan
    return math.log(errors[-2] / errors[-1]) / math.log(sizes[-2] / sizes[-1])


def case_rows(name: str, case: Case, levels: Mapping[str, Level], sizes: Sequence[float]) -> list[dict[str, object]]:
    """Rows of a case's table from the results of its levels, by label from coarse to fine.

    Raises ValueError where the measure and the configuration do not name the same quantities.
    """
    found, labels = [measured(name, level) for level in levels.values()], list(levels)
    if case.compared == "extrapolated":
        found.append(at_spacing_zero(found[-2], found[-1], sizes[-2] / sizes[-1]))
        labels.append("extrapolated")
    if set(found[-1]) != set(case.quantities):
        raise ValueError(f"{name}: quantities {sorted(case.quantities)} are asked for, {sorted(found[-1])} are measured")
    cost = sum(float(result.data.attrs.get("wall_time_s", 0.0)) for level in levels.values() for result in level.values())
    rows = []
    for quantity, asked in case.quantities.items():
        finest = found[-1][quantity]
        errors = [of_level[quantity].error for of_level in found]
        rows.append(
            {
                "case": name,
                "title": case.title,
                "quantity": quantity,
                "text": finest.text,
                "units": finest.units,
                "computed": finest.computed,
                "reference": finest.reference,
                "error": finest.error,
                "tolerance": asked.tolerance,
                "verdict": verdict(finest, asked.tolerance),
                "levels": ", ".join(labels),
                "errors": ", ".join(f"{error:.3g}" for error in errors),
                "order": observed_order(sizes, errors[: len(sizes)]),
                "cost": cost,
                "reason": asked.reason,
                "source": case.source,
            }
        )
    return rows


def at_spacing_zero(coarse: Mapping[str, Found], fine: Mapping[str, Found], ratio: float) -> dict[str, Found]:
    """What two levels with spacings of a ratio give at spacing 0, by quantity."""
    return {name: found._replace(computed=extrapolate(coarse[name].computed, found.computed, ratio)) for name, found in fine.items()}


def measured(name: str, level: Level) -> dict[str, Found]:
    """What a case measures on a level; NaN for all of it where a run diverged."""
    found = CASES[name][0](level)
    if any(result.data.attrs.get("status") == Status.DIVERGED for result in level.values()):
        return {quantity: each._replace(computed=math.nan) for quantity, each in found.items()}
    return found


def verdict(found: Found, tolerance: float) -> str:
    """Whether a number meets its reference; NaN misses."""
    return HOLDS if abs(found.error) <= tolerance else MISSES


def read_validation(path: Path | str) -> pd.DataFrame:
    """Table of a suite from its CSV; ValueError names a file that is none."""
    return read_csv(path, VALIDATION, "a validation")
