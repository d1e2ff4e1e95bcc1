"""Records as columns (``.csv``): time (s), horizontal and, if there is a third column, vertical acceleration.

A first line may name the columns with their units: ``time (s), ax (cm/s2), ay (cm/s2)``; names without units mean s and m/s2.  A file
without names does not say its unit: the user must.  Columns stand between commas, semicolons, tabs or blanks, as those of ground lines.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sph.scene.cells import cells, names
from sph.scene.ground_motion.text import LARGEST_ACCELERATION, LARGEST_TIME, SHORTEST_INTERVAL, number, read_lines
from sph.scene.ground_motion.units import Unit, size_of, unit_of_column
from sph.scene.units import SECONDS, SIZES, unit_of

NAMES = {2: "time (s) and acceleration (m/s2)", 3: "time (s), horizontal and vertical acceleration (m/s2)"}


def read_csv(path: Path | str, unit: Unit | None = None, columns: tuple[int, ...] = (2, 3)) -> tuple[np.ndarray, ...]:
    """Time (n,) in s and accelerations (n,) in m/s2 of a record with one of the numbers of ``columns``.

    Raises ValueError with file, line and what is expected.
    """
    lines = read_lines(path)
    head: str | None = None
    scales: list[float] | None = None
    rows: list[list[float]] = []
    for at, line in enumerate(lines, 1):
        values = [number(cell) for cell in cells(line)]
        where, shown = f"{path}, line {at}", f"(found {line[:80]!r})"
        if not line.strip():
            continue
        if at == 1 and all(value is None for value in values):
            head = line
            continue
        wanted = (len(rows[0]),) if rows else columns
        if len(values) not in wanted:
            expected = " or ".join(f"{count} columns, {NAMES[count]}" for count in wanted)
            raise ValueError(f"{where}: must have {expected}, has {len(values)} {shown}")
        wanted_names = NAMES[len(values)]
        numbers = [value for value in values if value is not None and math.isfinite(value)]
        if len(numbers) < len(values):
            raise ValueError(f"{where}: must be {('two', 'three')[len(values) - 2]} finite numbers, {wanted_names} {shown}")
        if scales is None and head is None:
            scales = [1.0] + [size_of(f"{path}, line 1 (no names of columns)", None, unit)] * (len(values) - 1)
        scales = scales or _scales(path, names(head or "", line), unit)
        if len(scales) != len(values):
            raise ValueError(f"{path}, line 1: names {len(scales)} columns, the lines below have {len(values)}")
        numbers = [scale * value for scale, value in zip(scales, numbers, strict=True)]
        if abs(numbers[0]) > LARGEST_TIME or max(map(abs, numbers[1:])) > LARGEST_ACCELERATION:
            raise ValueError(f"{where}: must not exceed {LARGEST_TIME:g} s and {LARGEST_ACCELERATION:g} m/s2 {shown}")
        if rows and not numbers[0] - rows[-1][0] >= SHORTEST_INTERVAL:
            raise ValueError(
                f"{where}: time {numbers[0]} s must be greater than {rows[-1][0]} s before it, by {SHORTEST_INTERVAL:g} s at least"
            )
        rows.append(numbers)
    if len(rows) < 2:
        raise ValueError(f"{path}: must hold at least two samples of time (s) and acceleration (m/s2) (found {len(rows)})")
    return tuple(np.array(rows).T)


def _scales(path: Path | str, named: list[str], unit: Unit | None) -> list[float]:
    """Units (s, m/s2) of the columns from the line of names; m/s2, or the user's ``unit``, if no acceleration has one."""
    try:
        seconds, *stated = unit_of(named[0], SECONDS), *map(unit_of_column, named[1:])
    except ValueError as error:
        raise ValueError(f"{path}, line 1: {error}") from error
    if all(size is None for size in stated):
        sizes = [SIZES[unit or "m/s2"]] * len(stated)
    else:
        sizes = [size_of(f"{path}, line 1: {name!r}", size, unit) for name, size in zip(named[1:], stated, strict=True)]
    return [1.0 if seconds is None else seconds, *sizes]
