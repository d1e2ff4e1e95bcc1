"""Points of a search: those a round wants, and the table of those that were run."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sph.experiments.trigger.boundaries import reached
from sph.experiments.trigger.design import Lattice, names_in
from sph.experiments.trigger.refinement import UNSHAKEN, Place, leaves
from sph.measures.metrics import METRIC_BY_NAME, UNDETERMINED
from sph.measures.places import place_columns, places_in
from sph.storage.trajectory import Variable
from sph.study.dimensions import Dimension, is_number
from sph.study.tables import FINDINGS, ROW, columns_of, count_column, read_csv, text_column

CASE_COLUMN = text_column("case", "label of the case")
CLASS_COLUMN = text_column("collapse_class", "the class, or a worse one, that is reached")
ROUND_COLUMN = count_column("round", "round of the search that asked for the point: how often the cell that it belongs to has been divided")
MEASURED = (
    "status", "collapse_class", "still_moving", "displacement_magnitude", "runout", "failed_fraction", "first_failure_time", "wall_time",
)  # fmt: skip

Key = tuple[str, ...]


def names(columns: Sequence[Variable]) -> list[str]:
    """The names of columns."""
    return [column.name for column in columns]


def label_columns(dimensions: Sequence[Dimension]) -> tuple[Variable, ...]:
    """The columns of a point's case and values, as written."""
    axes = (each.variable(listed=False) for each in dimensions)
    return (CASE_COLUMN, *(axis._replace(dims=ROW, dtype="str", text=f"{axis.text}, as written in file names") for axis in axes))


def wanted_columns(dimensions: Sequence[Dimension]) -> tuple[Variable, ...]:
    """The columns of a point before it is run."""
    return (*label_columns(dimensions), ROUND_COLUMN)


def point_columns(dimensions: Sequence[Dimension], places: Iterable[str] = ()) -> tuple[Variable, ...]:
    """The columns of a point that was run."""
    return (*wanted_columns(dimensions), *(METRIC_BY_NAME[name] for name in MEASURED), FINDINGS, *place_columns(places))


def division(lattice: Lattice, runs: Mapping[Key, Mapping[Any, Any]], boundaries: Sequence[str]) -> Callable[[Place], Hashable]:
    """What is found at a place of a lattice: which boundaries its run comes to; without shaking to none.

    A diverged run is on no side of them; it differs from every run that is, so that the search closes in on it from both sides.
    """

    def outcome(place: Place) -> Hashable:
        if place == UNSHAKEN:
            return tuple(False for _ in boundaries)
        run = runs[lattice.case, *lattice.labels(place)]
        return UNDETERMINED if run["collapse_class"] == UNDETERMINED else tuple(reached(run, boundary) for boundary in boundaries)

    return outcome


def runs_found(points: pd.DataFrame) -> dict[Key, Mapping[Any, Any]]:
    """The row of every point, by case and labels."""
    at = ["case", *names_in(points.columns)]
    return {tuple(str(row[name]) for name in at): row for row in points.to_dict("records")}


def wanted_points(lattices: Sequence[Lattice], points: pd.DataFrame, boundaries: Sequence[str], number: int) -> pd.DataFrame:
    """The points that a round wants and that are not in the table: corners of the cells divided ``number`` times, sorted by value."""
    runs = runs_found(points)
    wanted: dict[Key, None] = {}
    for lattice in lattices:
        cells = [span.cells for span in lattice.spans.values()]
        for cell in leaves(cells, division(lattice, runs, boundaries), number, lattice.goes_lower):
            wanted |= {(lattice.case, *lattice.labels(corner)): None for corner in cell.corners() if corner != UNSHAKEN}
    columns = ["case", *lattices[0].names]
    rows = [dict(zip(columns, point, strict=True)) | {"round": number} for point in wanted if point not in runs]
    return by_value(pd.DataFrame(rows, columns=[*columns, "round"]))


def by_value(points: pd.DataFrame) -> pd.DataFrame:
    """A table of points, its cases and words in their order, in each by the numbers that the labels stand for."""

    def rank(column: pd.Series) -> pd.Series:
        if column.name != "case" and column.map(is_number).all():
            return column.astype(float)
        return column.map({label: number for number, label in enumerate(dict.fromkeys(column))})

    return points.sort_values(["case", *names_in(points.columns)], key=rank).reset_index(drop=True)


def measured_points(
    earlier: pd.DataFrame, wanted: pd.DataFrame, metrics: Sequence[Mapping[str, Any]], places: Iterable[str] = ()
) -> pd.DataFrame:
    """The table of the earlier points and those of a round, from the metrics of its runs in its order."""
    rows = [{**point, **run} for point, run in zip(wanted.to_dict("records"), metrics, strict=True)]
    new = pd.DataFrame(rows, columns=[*wanted.columns, *MEASURED, FINDINGS.name, *names(place_columns(places))])
    return by_value(pd.concat([earlier, new], ignore_index=True) if len(earlier) and len(new) else earlier if len(earlier) else new)


def read_points(path: Path | str) -> pd.DataFrame:
    """Table of points that were run, from its CSV; ValueError names a file that is not one."""
    return read_csv(path, columns_in(path, point_columns((), places_in(columns_of(path)))), "the points of a search")


def read_wanted(path: Path | str) -> pd.DataFrame:
    """Table of points to be run, from its CSV; ValueError names a file that is not one."""
    return read_csv(path, columns_in(path, wanted_columns(())), "the points of a round")


def columns_in(path: Path | str, others: Sequence[Variable]) -> tuple[Variable, ...]:
    """The columns of a table of a search: the dimensions that its own first line names after its case, and ``others``."""
    first, *rest = others
    return (first, *(text_column(name, "") for name in names_in(columns_of(path))), *rest)


def no_points() -> pd.DataFrame:
    """The table before the first round."""
    return pd.DataFrame(columns=["case", "collapse_class"])
