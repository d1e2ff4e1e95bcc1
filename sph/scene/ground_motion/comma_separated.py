"""Records as columns (``.csv``): time (s), horizontal and, if there is a third column, vertical acceleration.

A first line may name the columns with their units: ``time (s), ax (cm/s2), ay (cm/s2)``; then the names decide which columns are read, in
any order and beside others; a single column of velocity without one of acceleration, as ``velocity (m/s)``, is differentiated.
A time without a unit is in s; where a file does not say the unit of an acceleration the user must.
Columns stand between commas, semicolons, tabs or blanks, as those of ground lines.  Lines with '#' are left out, but the last one before
the samples may hold the names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sph.scene.cells import COMMENT, cells, check_commas, names
from sph.scene.ground_motion.columns import columns_of, quantity, velocity_of
from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import MAX_ACCELERATION, MAX_TIME, MIN_INTERVAL, number, read_lines
from sph.scene.ground_motion.units import SPEEDS, VELOCITIES, Unit, differentiated, size_of, speed_of, unit_of_column
from sph.scene.ground_motion.untimed import REMEDY, is_untimed, read_untimed
from sph.scene.units import SECONDS, unit_of

NAMES = {2: "time (s) and acceleration (m/s2)", 3: "time (s), horizontal and vertical acceleration (m/s2)"}


class Table(NamedTuple):
    """How the columns of a file are read."""

    width: int  # columns in a line
    places: tuple[int, ...]  # of time and accelerations
    scales: tuple[float, ...]  # s and m/s2
    is_velocity: bool = False  # m/s, not m/s2


def read_csv(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal", third: bool = True) -> tuple[np.ndarray, ...]:
    """Time (n,) in s and accelerations (n,) in m/s2, the wanted first; where the horizontal is wanted the vertical follows if there is one.

    ``third`` says whether a file without names may have a third column.  Raises ValueError with file, line and what is expected.
    """
    lines = read_lines(path)
    if is_untimed(lines):
        return read_untimed(path, unit, wanted)
    try:
        check_commas(lines)
    except ValueError as error:
        raise ValueError(f"{path}, {error}") from error
    head: tuple[int, str] | None = None
    comments: list[tuple[int, str]] = []
    table: Table | None = None
    rows: list[list[float]] = []
    for at, line in enumerate(lines, 1):
        where, shown = f"{path}, line {at}", f"(found {line[:80]!r})"
        if not line.strip():
            continue
        if line.lstrip().startswith(COMMENT):
            comments += [(at, line.strip(" \t#"))] if table is None else []
            continue
        texts = cells(line)
        values = [number(cell) for cell in texts]
        if table is None and head is None and all(value is None for value in values):
            head = at, line
            continue
        if table is None:
            table = _table(path, head, comments, (at, line), unit, wanted, (2, 3) if third else (2,))
        if len(values) != table.width:
            raise ValueError(f"{where}: must have {table.width} columns, has {len(values)} {shown}")
        read = _finite(where, line, table.places)
        numbers = [scale * value for scale, value in zip(table.scales, read, strict=True)]
        if abs(numbers[0]) > MAX_TIME or max(map(abs, numbers[1:])) > MAX_ACCELERATION:
            raise ValueError(f"{where}: must not exceed {MAX_TIME:g} s and {MAX_ACCELERATION:g} m/s2 {shown}")
        if rows and not numbers[0] - rows[-1][0] >= MIN_INTERVAL:
            raise ValueError(f"{where}: time {numbers[0]} s must be greater than {rows[-1][0]} s before it, by {MIN_INTERVAL:g} s at least")
        rows.append(numbers)
    if len(rows) < 2:
        raise ValueError(f"{path}: must hold at least two samples of time (s) and acceleration (m/s2) (found {len(rows)})")
    time, *found = np.array(rows).T
    if table is not None and table.is_velocity:
        found = [differentiated(path, time, found[0])]
    return time, *found


def _finite(where: str, line: str, places: Sequence[int]) -> list[float]:
    """The numbers at some places of a line; ValueError where one is none."""
    values = [number(cell) for cell in cells(line)]
    read = [value for value in (values[place] for place in places) if value is not None and math.isfinite(value)]
    if len(read) < len(places):
        count = ("two", "three")[len(places) - 2]
        raise ValueError(f"{where}: must be {count} finite numbers, {NAMES[len(places)]} (found {line[:80]!r})")
    return read


def _table(
    path: Path | str,
    head: tuple[int, str] | None,
    comments: list[tuple[int, str]],
    first: tuple[int, str],
    unit: Unit | None,
    wanted: Direction,
    counts: tuple[int, ...],
) -> Table:
    """How columns are read, by the names above their first line, or by their places where there are none."""
    at, line = first
    width = len(cells(line))
    if head is None and comments:
        above = names(comments[-1][1], line)
        head = comments[-1] if len(above) == width and "time" in map(quantity, above) else None
    if head is None:
        if width not in counts:
            expected = " or ".join(f"{count} columns, {NAMES[count]}" for count in counts)
            untimed = "" if width in (2, 3) else f"; if these are samples without times, {REMEDY}"
            raise ValueError(f"{path}, line {at}: must have {expected}, has {width} (found {line[:80]!r}){untimed}")
        _finite(f"{path}, line {at}", line, range(width))
        if unit in SPEEDS and width == 2:
            return Table(width, (0, 1), (1.0, SPEEDS[unit]), True)
        size = size_of(f"{path}, line {at} (no names of columns)", None, unit)
        places = (0, 1, 2)[:width]
        if width == 3 and wanted == "vertical":
            places = (0, 2)
        return Table(width, places, (1.0, *[size] * (len(places) - 1)))
    named, where = names(head[1], line), f"{path}, line {head[0]}"
    if len(named) != width:
        raise ValueError(f"{where}: names {len(named)} columns, the lines below have {width}")
    velocity = velocity_of(named) if wanted == "horizontal" else None
    try:
        if velocity is not None:
            place = velocity.horizontal
            assert place is not None
            seconds, stated_speed = unit_of(named[velocity.time], SECONDS), unit_of(named[place], VELOCITIES)
            size = speed_of(f"{named[place]!r}", stated_speed, unit)
            return Table(width, (velocity.time, place), (1.0 if seconds is None else seconds, size), True)
        time, horizontal, vertical = columns_of(named)
        own, other = (horizontal, vertical) if wanted == "horizontal" else (vertical, horizontal)
        if own is None:
            assert other is not None
            check_direction(f"{named[other]!r}", direction_of(named[other]), wanted)
            own = other
        places = (own,) if vertical in (None, own) else (own, vertical)
        seconds, stated = unit_of(named[time], SECONDS), [unit_of_column(named[place]) for place in places]
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error
    sizes = [size_of(f"{where}: {named[place]!r}", size, unit) for place, size in zip(places, stated, strict=True)]
    return Table(width, (time, *places), (1.0 if seconds is None else seconds, *sizes))
