"""The suite of all cases: their runs, their table, and what the workflow makes of the files of the runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from cases import CASES
from cases.book import Page, code_of, costs_of, save_book
from cases.case import COMPUTATION, Case, Found, Level, Result, read_result
from sph.experiments.base import file_name
from sph.scene.schema import make_scene
from sph.stability.extrapolation import extrapolate
from sph.storage.trajectory import Variable
from sph.study.planned import planned
from sph.study.runs import BaseScene, PlannedRun
from sph.study.tables import number_column, read_csv, text_column, write_csv
from sph.study.verdicts import HOLDS, MISSES

FOLDER = "results/validation"
"""Where the workflow puts what it makes, relative to the working folder."""
SHIPPED_VALIDATION = Path(__file__).parents[2] / "sph" / "experiments" / "measured" / "validation.csv"
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


def read_validation(path: Path | str) -> pd.DataFrame:
    """Table of the suite from its CSV; ValueError names a file that is not one."""
    return read_csv(path, VALIDATION, "a validation")


def observed_order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Order of convergence from the two finest levels; NaN for one level, for errors of two signs and for rounding."""
    if len(errors) < 2 or not min(abs(error) for error in errors[-2:]) >= NO_ORDER_BELOW or errors[-2] * errors[-1] < 0:
        return math.nan
    return math.log(errors[-2] / errors[-1]) / math.log(sizes[-2] / sizes[-1])


def at_spacing_zero(coarse: Mapping[str, Found], fine: Mapping[str, Found], ratio: float) -> dict[str, Found]:
    """What two levels with spacings of a ratio give at spacing 0, by quantity."""
    return {name: found._replace(computed=extrapolate(coarse[name].computed, found.computed, ratio)) for name, found in fine.items()}


def case_rows(name: str, case: Case, levels: Mapping[str, Level]) -> list[dict[str, object]]:
    """Rows of a case's table from the results of its levels, by label from coarse to fine."""
    found, labels = [case.found(level) for level in levels.values()], list(levels)
    sizes = [case.size_of(level) for level in levels.values()]
    if case.compared == "extrapolated":
        found.append(at_spacing_zero(found[-2], found[-1], sizes[-2] / sizes[-1]))
        labels.append("extrapolated")
    cost = sum(float(result.data.attrs.get("wall_time_s", 0.0)) for level in levels.values() for result in level.values())
    rows: list[dict[str, object]] = []
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
                "verdict": HOLDS if finest.within(asked.tolerance) else MISSES,
                "levels": ", ".join(labels),
                "errors": ", ".join(f"{error:.3g}" for error in errors),
                "order": observed_order(sizes, errors[: len(sizes)]),
                "cost": cost,
                "reason": asked.reason,
                "source": case.source,
            }
        )
    return rows


def runs_of(name: str) -> dict[tuple[str, str], PlannedRun]:
    """The runs of a case whose files the workflow makes, by level and name; a case of functions alone has none."""
    case = CASES[name]
    scenes = {} if case.by == COMPUTATION else case.scenes()
    return {
        (level, run): PlannedRun(BaseScene(scene), id=f"{name}/{run}/{file_name(level)}", folder=FOLDER, by=case.by, group=name)
        for (level, run), scene in scenes.items()
    }


def levels_of(name: str, paths: Sequence[Path | str]) -> dict[str, Level]:
    """Results of a case, by level and run, from the files of its runs in order.

    Raises ValueError for a file that was made from another scene than that of the case.
    """
    case, levels = CASES[name], dict[str, dict[str, Result]]()
    for number, ((level, run), scene) in enumerate(case.scenes().items()):
        if case.by == COMPUTATION:
            result = Result(make_scene(scene), xr.Dataset())
        else:
            result = read_result(paths[number])
            planned(scene).check(result.data.attrs, paths[number])
        levels.setdefault(level, {})[run] = result
    return {**levels}


def measure_case(name: str, paths: Sequence[Path | str]) -> tuple[pd.DataFrame, Figure]:
    """A row per quantity of a case, and its picture, from the files of its runs in order; none for a case of functions alone."""
    levels = levels_of(name, paths)
    code = "" if CASES[name].by == COMPUTATION else str(code_of(paths))
    return pd.DataFrame(case_rows(name, CASES[name], levels)).assign(code=code), CASES[name].draw(levels)


def page_of(name: str, table: pd.DataFrame, paths: Sequence[Path | str]) -> Page:
    """The page of a case, from the table of all and the files of its runs in order."""
    case, rows = CASES[name], table[table["case"] == name]
    if case.by == COMPUTATION:
        return Page(name, case, rows, [], None, None)
    scenes = case.scenes()
    scene = make_scene(next(iter(scenes.values())))
    return Page(name, case, rows, costs_of([level for level, _ in scenes], paths), code_of(paths), scene)


def write_suite(
    tables: Sequence[Path | str],
    pictures: Sequence[Path | str],
    runs: Sequence[Path | str],
    path_to_table: Path | str,
    path_to_markdown: Path | str,
    path_to_pdf: Path | str,
) -> None:
    """Join the tables of all cases and write the verification book, with a picture a case; ``runs`` are those of all cases in order."""
    table = pd.concat(map(read_validation, tables), ignore_index=True)
    write_csv(table, path_to_table)
    paths = iter(runs)
    pages = [page_of(name, table, [next(paths) for _ in runs_of(name)]) for name in CASES]
    save_book(pages, pictures, path_to_markdown, path_to_pdf)
