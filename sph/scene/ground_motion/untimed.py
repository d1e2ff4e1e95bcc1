"""Records as samples without times (``.th``, ``.acc``, ``.csv``, ``.txt``): their number and interval in the head, then the samples.

The head is lines of text, if any, and a line as '4000 0.005', '4000, 0.005', '4000 0.005 NPTS, DT' or 'NPTS= 4000, DT= 0.005 SEC'; the
samples follow, as many a line as one likes.  Below such a head there may also be pairs of time and acceleration, as DEEPSOIL has them.
The unit is that which a line of the text names ('acceleration in g', 'units: gal'), or that which the user states; m/s and cm/s are
those of velocities, which are differentiated.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_header
from sph.scene.ground_motion.text import check_head, number, read_lines, samples
from sph.scene.ground_motion.units import ACCELERATIONS, SPEEDS, Unit, differentiated, size_of, speed_of, unit_in
from sph.scene.units import factor_in

NUMBER = r"([-+]?\d*\.?\d+(?:[eEdD][-+]?\d+)?)"
COUNTED = (
    re.compile(rf"\s*(\d+)\s*[,;\s]\s*{NUMBER}\s*(?:s(?:ec)?\.?)?\s*(?:NPTS\s*,?\s*DT)?\s*$", re.I),
    re.compile(rf"\s*NPTS\s*[=:]?\s*(\d+)\s*,?\s*DT\s*[=:]?\s*{NUMBER}\s*(?:s(?:ec)?\.?)?\s*,?\s*$", re.I),
)
WIDTH = 15
"""Columns of a sample where samples touch (Fortran E15.7)."""
REMEDY = "write a line with the number of the samples and their interval (s) above them, as '4000 0.005', or give each its time"


class Counted(NamedTuple):
    """The line of a head that counts the samples."""

    at: int  # its index
    number: int
    interval: float  # s


def counted(lines: list[str]) -> Counted | None:
    """The line that counts the samples, the first that begins with a number or with NPTS; None where the first holds no such pair."""
    for at, line in enumerate(lines):
        found = next((match for pattern in COUNTED if (match := pattern.match(line))), None)
        if found is not None:
            return Counted(at, int(found[1]), float(found[2].upper().replace("D", "E")))
        if re.match(r"\s*[-+]?\.?\d", line) and None not in map(number, re.split(r"[,;\s]+", line.strip(" \t,;"))):
            return None
    return None


def is_untimed(lines: list[str]) -> bool:
    """Whether a text has samples below a line that counts them, and not rows that each begin with a time."""
    head = counted(lines)
    if head is None or head.number < 2:
        return False
    below = [line.replace(",", " ").split() for line in lines[head.at + 1 :] if line.strip()]
    if all(len(row) == 2 for row in below):
        first = number(below[0][0]) if below else None
        return len(below) == head.number and first is not None and 0.0 <= first <= 1.51 * head.interval
    return sum(map(len, below)) == head.number or len(below[0]) not in (2, 3)


def read_untimed(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = [line.replace(",", " ") for line in read_lines(path)]
    head = counted(lines)
    if head is None:
        raise ValueError(f"{path}: holds samples without times, and no line that counts them; {REMEDY}")
    check_head(path, head.number, head.interval)
    check_header(path, lines[: head.at], wanted)
    above = " ".join(lines[: head.at])
    is_velocity = bool(re.search(r"(?<![a-z])vel", above, re.I)) or unit in SPEEDS and not re.search(r"(?<![a-z])acc", above, re.I)
    scale = speed_of(path, None, unit) if is_velocity else size_of(path, _unit(path, lines[: head.at]), unit)
    below = [(at, line) for at, line in enumerate(lines[head.at + 1 :], head.at + 2) if line.strip()]
    if len(below) == head.number and all(len(line.split()) == 2 for _, line in below):
        _check_times(path, below, head.interval)
        lines = [*lines[: head.at + 1], *(line.split()[1] for _, line in below)]
    acceleration = samples(path, lines, head.at + 1, WIDTH, scale, head.number, head.at + 1)
    time = head.interval * np.arange(head.number)
    return time, differentiated(path, time, acceleration) if is_velocity else acceleration


def _unit(path: Path | str, texts: list[str]) -> float | None:
    """Unit (m/s2) that the text above names; None without one.  ValueError for two, and for a factor."""
    said = {at: text for at, text in enumerate(texts, 1) if re.search(r"\bacc|unit|[(\[]", text, re.I)}
    found = {size for text in said.values() if (size := unit_in(text)) is not None}
    factors = [at for at, text in said.items() if factor_in(text, ACCELERATIONS)]
    if len(found) > 1 or factors:
        at = [*factors, *said][0]
        raise ValueError(
            f"{path}, line {at}: {texts[at - 1].strip()[:80]!r}: states a factor or more than one unit; convert the samples to one unit of "
            "acceleration, and name it alone"
        )
    return found.pop() if found else None


def _check_times(path: Path | str, below: list[tuple[int, str]], interval: float) -> None:
    """Refuse times beside the samples that are not those of the head."""
    first = number(below[0][1].split()[0])
    for place, (at, line) in enumerate(below):
        time = number(line.split()[0])
        if time is None or first is None or not abs(time - first - place * interval) <= 0.51 * interval:  # times have few digits
            raise ValueError(
                f"{path}, line {at}: its time must lie {place * interval:g} s after the first, by the interval in the head "
                f"(found {line[:80]!r})"
            )
