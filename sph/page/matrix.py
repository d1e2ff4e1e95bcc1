"""The results of a study as a matrix: two dimensions as rows and columns, a panel for each value of the rest, a cell for each run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import pandas as pd
from matplotlib.colors import to_hex, to_rgb

from sph.checks.after_run import at_least, is_at_least, is_held
from sph.figures.study import arranged
from sph.figures.style import LEAST, class_colours, metres
from sph.measures.metrics import CLASSES, STABLE
from sph.measures.places import places_in
from sph.page.second_spacing import differs
from sph.storage.trajectory import Status
from sph.study.dimensions import AMPLITUDE, SAME_LEVEL, Dimension

MAX_CELLS = 80
"""Most runs of which each has a cell."""
MAX_BESIDE = 4
"""Most columns beside a wide picture."""
DECIDES = "*"
"""Marks a run that stands at one of two spacings and fails at the other."""
HATCHED = "repeating-linear-gradient(135deg, #ffffff 0 7px, #d9d9d9 7px 9px)"
"""Paper of runs that stand and may not, which is not that of those that are known to stand."""
LEGIBLE = 0.4
"""Luminance from which on text on a colour is dark."""
DIVERGED, UNSHAKEN, TO_COME, MAY_FAIL = "diverged", "fails unshaken", "still to come", "stands with few rows, may fail"
"""Classes of cells besides those of the metric."""


class Cell(NamedTuple):
    """A run."""

    name: str  # of its file
    words: str
    kind: str  # a class of the metric, or one of those above
    said: str  # what a pointer on it says
    shown: bool  # whether the page has the run
    runout: str = ""  # in a study with places, where there is one


class Panel(NamedTuple):
    """The runs that differ in two dimensions alone."""

    title: str
    head: Sequence[str]
    rows: Sequence[tuple[str, Sequence[Cell]]]


class Matrix(NamedTuple):
    """All runs of a study."""

    caption: str
    columns: str  # the dimension of the columns
    panels: Sequence[Panel]
    colours: Mapping[str, tuple[str, str]]  # of paper and ink, by the classes that there are

    @property
    def wide(self) -> bool:
        """Whether it leaves little room beside it."""
        return max(len(panel.head) for panel in self.panels) > MAX_BESIDE


def matrix(
    table: pd.DataFrame, dimensions: Sequence[Dimension], probe: str, shown: Sequence[str], design: float | None = None
) -> Matrix | None:
    """The matrix of a study's ``table``, whose index are the names of runs, of which the page has those ``shown`` and some may have the
    class ``TO_COME``; None for a list of runs, and where there are too many.  The amplitude of the ``design`` (m/s2) is marked."""
    found = arranged(table, dimensions, len(table))
    if not found.grid or len(table) > MAX_CELLS:
        return None
    panels = []
    for title, along, runs in found.panels:
        head = list(dict.fromkeys(runs[along.name]))
        rows = [("", _cells(runs, along, head, shown))]
        if (other := found.other) is not None:
            groups = runs.groupby(other.name, sort=False)
            rows = [(other.said(str(value)), _cells(of, along, head, shown)) for value, of in groups]
        of_design = [
            along.name == AMPLITUDE and design is not None and math.isclose(float(value), design, rel_tol=SAME_LEVEL) for value in head
        ]
        heads = [along.shown(value) + ", design" * mark for value, mark in zip(head, of_design, strict=True)]
        panels.append(Panel(title, heads, rows))
    kinds = {cell.kind for panel in panels for _, cells in panel.rows for cell in cells}
    done = table[table["collapse_class"] != TO_COME]
    unknown = bool((at_least(done) & (done["displacement_magnitude"] < LEAST)).any())
    decides = bool(differs(done).any())
    beside = ", beside it the run-out," * any(cell.runout for panel in panels for _, cells in panel.rows for cell in cells)
    caption = f"Displacement of {probe} (m){beside} in each run" + ", with a question mark where it might be more," * unknown
    caption += f", with {DECIDES} where the spacing decides whether it stands," * decides
    return Matrix(caption, found.panels[0].along.label, panels, {
        kind: colours for kind, colours in _colours().items() if kind in kinds
    })  # fmt: skip


def _cells(runs: pd.DataFrame, along: Dimension, values: Sequence[str], shown: Sequence[str]) -> list[Cell]:
    """The cells of a row, in the order of the values of its columns."""
    of = {row[along.name]: (str(name), row) for name, row in zip(runs.index, runs.to_dict("records"), strict=True)}
    unsure = set(map(str, runs.index[differs(runs)]))
    cells = [_cell(*of[value], shown) for value in values]
    return [cell._replace(words=f"{cell.words}{DECIDES}") if cell.name in unsure else cell for cell in cells]


def _cell(name: str, row: Mapping[Any, Any], shown: Sequence[str]) -> Cell:
    kind = row["collapse_class"]
    if kind == TO_COME:
        return Cell(name, "…", TO_COME, "this run is not done yet", False)
    if row["diverged"]:
        return Cell(name, "×", DIVERGED, "diverged: no results", name in shown)
    if row["status"] == Status.FAILED_UNSHAKEN:
        kind = UNSHAKEN
    elif kind == STABLE and is_held(row):
        kind = MAY_FAIL
    bounded, moved = is_at_least(row), row["displacement_magnitude"]
    said = kind if math.isnan(row["runout"]) else f"{kind}; run-out {metres(row['runout'], bounded)} m"  # a block has none
    goes = metres(row["runout"], bounded) if row["runout"] > 0.0 and places_in(map(str, row)) else ""
    return Cell(name, metres(moved, bounded), kind, said, name in shown, goes)


def _colours() -> dict[str, tuple[str, str]]:
    colours = dict(zip(CLASSES, class_colours(), strict=True))
    papers = {name: to_hex(colour) for name, colour in colours.items()} | {UNSHAKEN: "#c9ced6", DIVERGED: "#ffffff", TO_COME: "#ffffff"}
    inks = {name: (paper, "#000000" if _luminance(paper) > LEGIBLE else "#ffffff") for name, paper in papers.items()}
    return {STABLE: inks[STABLE], MAY_FAIL: (HATCHED, "#000000"), **inks}


def _luminance(colour: str) -> float:
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), to_rgb(colour), strict=True))
