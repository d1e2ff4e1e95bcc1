"""Points of a search: those a round wants, and the table of those that were run."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sph.experiments.trigger.design import Lattice, reached
from sph.experiments.trigger.refinement import Place, leaves
from sph.measures.metrics import GRID, METRIC_BY_NAME, UNDETERMINED
from sph.storage.trajectory import Variable
from sph.study.dimensions import AXES
from sph.study.tables import ROW, count_column, read_csv, text_column

WANTED: tuple[Variable, ...] = (
    text_column("case", "label of the case"),
    *(axis._replace(dims=ROW, dtype="str", text=f"{axis.text}, as written in file names") for axis in AXES),
    count_column("round", "round of the search that asked for the point: how often the cell that it belongs to has been divided"),
)
"""The columns of a point before it is run."""
MEASURED = (
    "status", "collapse_class", "still_moving", "displacement_magnitude", "runout", "failed_fraction", "first_failure_time", "wall_time",
)  # fmt: skip
POINTS: tuple[Variable, ...] = WANTED + tuple(METRIC_BY_NAME[name]._replace(dims=ROW) for name in MEASURED)
"""The columns of a point that was run."""
POINT = ["case", *GRID]

Key = tuple[str, ...]


def names(columns: Sequence[Variable]) -> list[str]:
    """The names of columns."""
    return [column.name for column in columns]


def division(lattice: Lattice, classes: Mapping[Key, str], boundaries: Sequence[str]) -> Callable[[Place], Hashable]:
    """What is found at a place of a lattice: for every boundary whether its class is reached.

    A diverged run is of no class; it differs from every run that has one, so that the search closes in on it from both sides.
    """

    def found(place: Place) -> Hashable:
        name = classes[lattice.case, *lattice.labels(place)]
        return name if name == UNDETERMINED else tuple(reached(name, boundary) for boundary in boundaries)

    return found


def classes_found(points: pd.DataFrame) -> dict[Key, str]:
    """Class of every point, by case and labels."""
    return {tuple(map(str, at)): str(name) for *at, name in points[[*POINT, "collapse_class"]].itertuples(index=False)}


def wanted_points(lattices: Sequence[Lattice], points: pd.DataFrame, boundaries: Sequence[str], number: int) -> pd.DataFrame:
    """The points that a round wants and that are not in the table: corners of the cells divided ``number`` times, sorted by value."""
    classes = classes_found(points)
    wanted: dict[Key, None] = {}
    for lattice in lattices:
        cells = [span.cells for span in lattice.spans.values()]
        for cell in leaves(cells, division(lattice, classes, boundaries), number):
            wanted |= {(lattice.case, *lattice.labels(corner)): None for corner in cell.corners()}
    rows = [dict(zip(POINT, point, strict=True)) | {"round": number} for point in wanted if point not in classes]
    return by_value(pd.DataFrame(rows, columns=names(WANTED)))


def by_value(points: pd.DataFrame) -> pd.DataFrame:
    """A table of points, its cases in their order, in each by the numbers that the labels stand for."""
    order = {case: number for number, case in enumerate(dict.fromkeys(points["case"]))}
    return points.sort_values(POINT, key=lambda column: column.map(order) if column.name == "case" else column.astype(float)).reset_index(
        drop=True
    )


def measured_points(earlier: pd.DataFrame, wanted: pd.DataFrame, metrics: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """The table of the earlier points and those of a round, from the metrics of its runs in its order."""
    rows = [{**point, **found} for point, found in zip(wanted.to_dict("records"), metrics, strict=True)]
    new = pd.DataFrame(rows, columns=names(POINTS))
    return by_value(pd.concat([earlier, new], ignore_index=True) if len(earlier) and len(new) else earlier if len(earlier) else new)


def read_points(path: Path | str) -> pd.DataFrame:
    """Table of points that were run, from its CSV; ValueError names a file that is none."""
    return read_csv(path, POINTS, "the points of a search")


def read_wanted(path: Path | str) -> pd.DataFrame:
    """Table of points to be run, from its CSV; ValueError names a file that is none."""
    return read_csv(path, WANTED, "the points of a round")


def no_points() -> pd.DataFrame:
    """The table before the first round."""
    return pd.DataFrame(columns=names(POINTS))
