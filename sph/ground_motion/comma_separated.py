"""Records as comma-separated values: time (s), horizontal and, if there is a third column, vertical acceleration.

A first line may name the columns with their units: ``time (s), ax (cm/s2), ay (cm/s2)``; without units they are m/s2.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from sph.ground_motion.text import LARGEST_ACCELERATION, LARGEST_TIME, SHORTEST_INTERVAL, number, read_lines
from sph.ground_motion.units import SIZES, Unit, size, size_of

NAMES = {2: "time (s) and acceleration (m/s2)", 3: "time (s), horizontal and vertical acceleration (m/s2)"}


def read_csv(path: Path | str, unit: Unit | None = None, columns: tuple[int, ...] = (2, 3)) -> tuple[np.ndarray, ...]:
    """Time (n,) in s and accelerations (n,) in m/s2 of a record with one of the numbers of ``columns``.

    Raises ValueError with file, line and what is expected.
    """
    lines = read_lines(path)
    scales: list[float] | None = None
    rows: list[list[float]] = []
    for at, line in enumerate(lines, 1):
        cells = line.split(",")
        values = [number(cell) for cell in cells]
        where, shown = f"{path}, line {at}", f"(found {line[:80]!r})"
        if not line.strip():
            continue
        if at == 1 and all(value is None for value in values):
            scales = _scales(path, cells, unit)
            continue
        wanted = (len(rows[0]),) if rows else columns
        if len(values) not in wanted:
            expected = " or ".join(f"{count} columns, {NAMES[count]}" for count in wanted)
            raise ValueError(f"{where}: must have {expected}, has {len(values)} {shown}")
        names = NAMES[len(values)]
        numbers = [value for value in values if value is not None and math.isfinite(value)]
        if len(numbers) < len(values):
            raise ValueError(f"{where}: must be {('two', 'three')[len(values) - 2]} finite numbers, {names} {shown}")
        if abs(numbers[0]) > LARGEST_TIME or max(map(abs, numbers[1:])) > LARGEST_ACCELERATION:
            raise ValueError(f"{where}: must not exceed {LARGEST_TIME:g} s and {LARGEST_ACCELERATION:g} m/s2 {shown}")
        if rows and not numbers[0] - rows[-1][0] >= SHORTEST_INTERVAL:
            raise ValueError(
                f"{where}: time {numbers[0]} s must be greater than {rows[-1][0]} s before it, by {SHORTEST_INTERVAL:g} s at least"
            )
        rows.append(numbers)
    if len(rows) < 2:
        raise ValueError(f"{path}: must hold at least two samples of time (s) and acceleration (m/s2) (found {len(rows)})")
    time, *accelerations = np.array(rows).T
    if scales is None:
        scales = [SIZES[unit or "m/s2"]]
    if len(scales) == 1:
        scales *= len(accelerations)
    if len(scales) != len(accelerations):
        raise ValueError(f"{path}, line 1: names {len(scales) + 1} columns, the lines below have {len(accelerations) + 1}")
    return time, *(scale * column for scale, column in zip(scales, accelerations, strict=True))


def _scales(path: Path | str, names: list[str], unit: Unit | None) -> list[float]:
    """Units (m/s2) of the columns after the first from the line of names; one for all if no name has one."""
    inside = [re.search(r"[(\[]([^()\[\]]*)[)\]]\s*$", name) for name in names]
    if inside[0] and inside[0][1].strip().lower() not in ("s", "sec", "second", "seconds"):
        raise ValueError(f"{path}, line 1: time must be in s (found {names[0].strip()!r})")
    scales = []
    for name, found in zip(names[1:], inside[1:], strict=True):
        stated = size(found[1] if found else name)
        if found and stated is None:
            raise ValueError(f"{path}, line 1: {found[1]!r} is no unit of acceleration; must be one of {', '.join(SIZES)}")
        scales.append(stated)
    if all(stated is None for stated in scales):
        return [SIZES[unit or "m/s2"]]
    return [size_of(path, stated, unit) for stated in scales]
