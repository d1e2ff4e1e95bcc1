"""Maps over some dimensions and the intensity: the cells that a search left undivided, and the share of the others that reaches a class.

A cell whose points agree is taken to be of their class throughout; one whose points do not is of any class from the least to the
worst of them.  So a share has a lower and an upper bound, which close in as cells are divided.  It is a share of the values
that were searched, each scale counted evenly, and no probability: neither of soils nor of ground motions.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from sph.experiments.trigger.design import Lattice, Searched
from sph.experiments.trigger.points import CASE_COLUMN, CLASS_COLUMN, division, names, runs_found
from sph.experiments.trigger.refinement import Cell, leaves
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.storage.trajectory import Variable
from sph.study.dimensions import Dimension
from sph.study.tables import columns_of, count_column, number_column, read_csv, text_column

ENDS = ("lower", "upper")


def cell_columns(searched: Searched) -> tuple[Variable, ...]:
    """The columns of a cell."""
    others = ", ".join(each.name for each in searched.others)
    axes = [each.variable(listed=False) for each in searched.all]
    return (
        CASE_COLUMN,
        *(number_column(f"{axis.name}_{end}", axis.units, f"{axis.text}: {end} end of the cell") for axis in axes for end in ENDS),
        number_column("share", "1", f"share of the range of {others} that the cell covers, on their scales"),
        text_column("least_class", f"mildest class of the points in the cell and on its faces; {UNDETERMINED} if all diverged"),
        text_column("worst_class", "worst class of these points, likewise"),
        count_column("points", "number of these points"),
        count_column("diverged", "diverged ones among them"),
    )


def share_columns(searched: Searched) -> tuple[Variable, ...]:
    """The columns of a share; an interval of intensities is one in which the cells do not change."""
    axis, others = searched.intensity.variable(listed=False), ", ".join(each.name for each in searched.others)
    return (
        CASE_COLUMN,
        CLASS_COLUMN,
        *(number_column(f"{axis.name}_{end}", axis.units, f"{end} end of the interval of intensities") for end in ENDS),
        number_column("share_lower", "1", f"share of the range of {others} in cells of which all points reach the class"),
        number_column("share_upper", "1", "the same in cells of which at least one point reaches it or diverged"),
    )


def map_cells(
    lattices: Sequence[Lattice], points: pd.DataFrame, boundaries: Sequence[str], levels: int, searched: Searched
) -> pd.DataFrame:
    """One row per cell that is not divided, with the columns ``cell_columns``."""
    runs = runs_found(points)
    rows = []
    for lattice in lattices:
        own = points[points["case"] == lattice.case]
        values = {name: own[name].astype(float).to_numpy() for name in lattice.names}
        counts = [span.cells for span in lattice.spans.values()]
        for cell in leaves(counts, division(lattice, runs, boundaries), levels):
            bounds = _bounds(lattice, cell)
            inside = np.all([(values[name] >= low) & (values[name] <= high) for name, (low, high) in bounds.items()], axis=0)
            classes = [name for name in CLASSES if name in set(own["collapse_class"][inside])] or [UNDETERMINED]
            ends = {f"{name}_{end}": bounds[name][at] for name in lattice.names for at, end in enumerate(ENDS)}
            facts = {"least_class": classes[0], "worst_class": classes[-1], "points": int(inside.sum())}
            diverged = int((own["collapse_class"][inside] == UNDETERMINED).sum())
            others = [lattice.spans[each.name].cells for each in searched.others]
            share = cell.size ** len(others) / np.prod(others)
            rows.append({"case": lattice.case, **ends, "share": float(share), **facts, "diverged": diverged})
    columns = names(cell_columns(searched))
    return pd.DataFrame(rows, columns=columns).sort_values(columns[: columns.index("share")], ignore_index=True)


def _bounds(lattice: Lattice, cell: Cell) -> dict[str, tuple[float, float]]:
    """Ends of a cell as the numbers of its labels."""
    corners = cell.corners()
    lowest, highest = lattice.labels(corners[0]), lattice.labels(corners[-1])
    return {name: (float(low), float(high)) for name, low, high in zip(lattice.names, lowest, highest, strict=True)}


def class_shares(cells: pd.DataFrame, searched: Searched) -> pd.DataFrame:
    """Bounds of the share that reaches each class, over intervals of intensity, with the columns ``share_columns``."""
    rank = {name: number for number, name in enumerate(CLASSES)}
    rows = []
    for case, own in cells.groupby("case", sort=False):
        low, high = (own[f"{searched.intensity_name}_{end}"].to_numpy() for end in ENDS)
        ends = np.unique(np.concatenate([low, high]))
        least, worst = (own[name].map(rank).fillna(-1).to_numpy() for name in ("least_class", "worst_class"))
        open_ended = own["diverged"].to_numpy() > 0
        for name in CLASSES[1:]:
            sure, possible = (least >= rank[name]) & ~open_ended, (worst >= rank[name]) | open_ended
            for begin, end in zip(ends[:-1], ends[1:], strict=True):
                across = own["share"].to_numpy() * ((low <= begin) & (high >= end))
                rows.append((case, name, begin, end, float(across[sure].sum()), float(across[possible].sum())))
    return pd.DataFrame(rows, columns=names(share_columns(searched)))


def read_shares(path: Path | str) -> pd.DataFrame:
    """Table of shares from its CSV; ValueError names a file that is not one."""
    intensity = next((name.removesuffix("_lower") for name in columns_of(path)[2:3]), "")
    return read_csv(path, share_columns(Searched((Dimension(intensity, "-", "", False),), intensity)), "shares of classes")
