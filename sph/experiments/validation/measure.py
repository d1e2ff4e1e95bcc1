"""The table of the suite: every quantity beside its reference, with error, order of convergence and verdict; the pictures and the book."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.steps import Runs, Step
from sph.experiments.validation.book import Page, code_of, costs_of, save_book
from sph.experiments.validation.cases import CASES
from sph.experiments.validation.design import EXPERIMENT, Case
from sph.experiments.validation.level import Found, Level, Result, read_result
from sph.experiments.validation.slopes import read_search
from sph.stability.extrapolation import extrapolate
from sph.storage.trajectory import Status, Variable
from sph.study.tables import number_column, read_csv, text_column
from sph.study.verdicts import HOLDS, MISSES

FOLDER = EXPERIMENT.folder
SHIPPED_VALIDATION = Path(__file__).parents[1] / "measured" / "validation.csv"
"""Table measured for this release, by ``snakemake validation``."""
NO_ORDER_BELOW = 1e-6
"""Errors below this are rounding: no order of convergence is given."""


VALIDATION: tuple[Variable, ...] = (
    text_column("case", "name of the case"),
    text_column("title", "what is tested"),
    text_column("quantity", "name of the quantity"),
    text_column("kind", "what it is a number of, such as factor_of_safety, runout or displacement"),
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
        "observed order of convergence, from the two finest levels; NaN if the error is only rounding or changes sign, or a run diverged",
    ),
    number_column("cost", "s", "computing time of all runs of the case on one core"),
    text_column("reason", "why this tolerance"),
    text_column("source", "where the reference comes from"),
    text_column(
        "code", "version and digest of the solver that made the runs of the case, and the day; empty for a case of functions alone"
    ),
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
                "kind": asked.kind.value,
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
    """Table of a suite from its CSV; ValueError names a file that is not one."""
    return read_csv(path, VALIDATION, "a validation")


def measure_case(plan: Mapping[str, Any], runs: Runs) -> tuple[pd.DataFrame, Figure]:
    """A reference case: what is computed at every resolution beside the value that it has to meet.

    One row per quantity, and the picture; the runs in the plan's order, none for a case of functions alone.
    """
    case = Case(**plan["case"])
    levels: dict[str, Level] = {}
    for number, (level, run, planned) in enumerate(plan["runs"]):
        if case.by == "computation":
            result = Result(planned.build(), xr.Dataset())
        else:
            result = (read_result if case.by == "simulation" else read_search)(runs.paths[number])
            planned.check(result.data.attrs, runs.paths[number])
        levels[level] = {**levels.get(level, {}), run: result}
    code = "" if case.by == "computation" else str(code_of(runs.paths))
    return pd.DataFrame(case_rows(plan["name"], case, levels, plan["sizes"])).assign(code=code), CASES[plan["name"]][1](levels)


def join_cases(cases: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Reference cases: every quantity beside the value that it has to meet, with its error, tolerance, order of convergence and verdict.
    Every column is defined in docs/experiments/validation.md.
    """
    return pd.concat(cases, ignore_index=True)


def write_book(plans: Sequence[Mapping[str, Any]], table: pd.DataFrame, pictures: Sequence[str], runs: Runs) -> Callable[..., None]:
    """The verification book: what is missed, then a page per reference case, as Markdown and PDF.

    The runs of all plans in their order, none for a case of functions alone, and a picture a plan.
    """
    paths, pages = iter(runs.paths), []
    for plan in plans:
        simulated = plan["case"]["by"] != "computation"
        files = [next(paths) for _ in plan["runs"]] if simulated else []
        costs, code = costs_of([level for level, _, _ in plan["runs"]], files) if files else [], code_of(files) if files else None
        scene = plan["runs"][0][2].build() if simulated else None
        pages.append(Page(plan["name"], plan["case"], table[table["case"] == plan["name"]], costs, code, scene))
    return functools.partial(save_book, pages, pictures)


READERS: dict[str, Callable[[Any, Mapping[str, Any]], Any]] = {
    "table": lambda path, given: read_validation(path),
    "cases": lambda paths, given: [read_validation(path) for path in paths],
    "pictures": lambda paths, given: paths,
}
STEPS = (
    Step(
        "validation_case",
        measure_case,
        writes={"cases/{case}.csv": "", "figures/{case}": "case {case}"},
        given=lambda suite, case: {"plan": suite.plan(case)},
        runs=lambda suite, case: suite.files(case),
        searches=True,
    ),
    Step(
        "validation_table",
        join_cases,
        writes={"validation.csv": "all cases"},
        needs=lambda suite: {"cases": [f"{FOLDER}/cases/{case}.csv" for case in suite.cases]},
    ),
    Step(
        "validation_book",
        write_book,
        {"table": "validation.csv"},
        {"book.md": "", "book.pdf": ""},
        lambda suite: {"plans": [suite.plan(case) for case in suite.cases]},
        lambda suite: {"pictures": [f"{FOLDER}/figures/{case}.png" for case in suite.cases]},
        lambda suite: [run for case in suite.cases for run in suite.files(case)],
        searches=True,
    ),
)
"""The jobs of the suite."""
