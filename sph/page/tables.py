"""Tables of the page: of the runs, of the scene, from CSV files, and those of the release."""

from __future__ import annotations

import csv
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel

from sph.command.reference import TABLES
from sph.experiments.cost_accuracy.advice import percent
from sph.storage.trajectory import Variable
from sph.study.dimensions import Dimension

MOST_ROWS = 500
"""Most rows that the page shows of a CSV file."""
KEYS = (
    "duration", "geometry.", "walls.", "soil.", "coupling.S_R", "coupling.gamma", "motion.",
    "numerics.spacing", "numerics.smoothing_ratio", "numerics.time_step",
)  # fmt: skip
"""Beginnings of the scene keys that the page shows at once."""
MOST_NUMBERS = 100
"""Most numbers that the page shows of a list of them: those of a record are counted."""
NOTHING = "–"
"""Stands for NaN."""


class Code(str):
    """A cell that is a name in the program."""


class Table(NamedTuple):
    """Words of a table."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    source: str = ""  # file it was read from

    @property
    def wordy(self) -> bool:
        """Whether a cell holds a sentence: on a narrow screen every row then becomes a card."""
        return any(len(cell) > 70 for row in self.rows for cell in row)


def reference_table(name: str, caption: str) -> Table:
    """A table of the documentation, by its name there; without rows while nothing is measured."""
    head, rows, note = TABLES[name]()
    return Table(caption, head, [(Code(first), *cells) for first, *cells in rows], note)


def csv_table(path: Path | str, caption: str, variables: Iterable[Variable] = ()) -> Table:
    """Table of a CSV file, numbers to four digits, headings with the units that are declared; ValueError names a file that is none."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file, strict=True)
    except (OSError, ValueError, csv.Error) as error:
        raise ValueError(f"{path}: cannot be read as a table: {error}; delete it and run again what wrote it") from error
    if any(len(row) != len(head) for row in rows):
        raise ValueError(f"{path}: cannot be read as a table: its rows have not all {len(head)} columns; run again what wrote it")
    note = f"The first {MOST_ROWS} of {len(rows)} rows." if len(rows) > MOST_ROWS else ""
    units = {row.name: f"{row.name} ({row.units})" for row in variables if row.units != "1"}
    return Table(
        caption, [units.get(name, name) for name in head], [[short(cell) for cell in row] for row in rows[:MOST_ROWS]], note, str(path)
    )


def short(cell: str) -> str:
    """A cell of a CSV file for reading: numbers as written if they are short, else to four digits; NaN as a dash."""
    if cell == "NaN":
        return NOTHING
    try:
        return cell if len(cell) <= 7 else f"{float(cell):.4g}"
    except ValueError:
        return cell


def metres(value: float) -> str:
    """A length in m, to three digits or a millimetre."""
    digits = 3 if abs(value) < 1 else 2 if abs(value) < 10 else 1
    return NOTHING if math.isnan(value) else f"{value:.{digits}f}"


def _share(value: float) -> str:
    return NOTHING if math.isnan(value) else percent(value)


def _status(row: Mapping[Any, Any]) -> str:
    return str(row["status"]) + (", still\N{NO-BREAK SPACE}moving" if row["still_moving"] and not row["diverged"] else "")


class Column(NamedTuple):
    """A column of the table of runs."""

    heading: str
    words: Callable[[Mapping[Any, Any]], str]  # of a row of a study's table
    result: bool = False  # also shown beside the drawing of the run


def run_columns(dimensions: Iterable[Dimension], probe: str) -> list[Column]:
    """Columns of the table of runs."""
    return [
        *(Column(found.label, operator.itemgetter(found.name)) for found in dimensions),
        Column("class", operator.itemgetter("collapse_class")),
        Column("status", _status),
        Column(f"displacement of {probe} (m)", lambda row: metres(row["displacement_magnitude"]), True),
        Column("run-out (m)", lambda row: metres(row["runout"]), True),
        Column("expected error of displacement", lambda row: _share(row["expected_displacement_error"]), True),
        Column("expected error of run-out", lambda row: _share(row["expected_runout_error"]), True),
        Column("computing time (s)", lambda row: f"{row['wall_time']:.3g}"),
    ]


def key_rows(section: BaseModel, path: str = "") -> Iterator[tuple[str, str, str, str]]:
    """Rows (key, value, unit, meaning) of a scene or a part of it."""
    for name, field in type(section).model_fields.items():
        value, extra = getattr(section, name), field.json_schema_extra
        if isinstance(value, BaseModel):
            yield from key_rows(value, f"{path}{name}.")
        else:
            unit = str(extra.get("unit", "-")) if isinstance(extra, dict) else "-"
            text = "null" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
            if isinstance(value, tuple) and len(value) > MOST_NUMBERS:
                text = f"{len(value):,} numbers"
            yield f"{path}{name}", text, unit, field.description or ""


def scene_table(section: BaseModel, varied: Mapping[str, str]) -> Table:
    """Every key of a scene; ``varied`` says of keys which values the study gives them."""
    rows = [(Code(key), varied.get(key, value), unit, text) for key, value, unit, text in key_rows(section)]
    return Table("Every key of the scene", ("key", "value", "unit", "meaning"), rows)


def chosen_keys(table: Table) -> Table:
    """The rows of the table of a scene that describe the problem: ``KEYS``."""
    return table._replace(caption="What is simulated", rows=[row for row in table.rows if row[0].startswith(KEYS)])
