"""Records of New Zealand's GeoNet (``.V1A``, ``.V2A``), uncorrected and corrected: three components.

GNS Science, Accelerogram Data File Format (2012): for each component 16 lines of text and ten lines of ten numbers in columns of 8, then
acceleration (mm/s2), velocity and displacement, ten a line in columns of 8.  Of the hundred numbers the 34th to 36th count the samples of
each, the 64th is their duration and the 66th their interval (s).  The 11th line of text states the unit of raw readings, the 13th the
component (N10E, Up), the 14th the peak acceleration.  Velocity and displacement are left out.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from sph.scene.ground_motion.component import Component
from sph.scene.ground_motion.direction import Direction, direction_of
from sph.scene.ground_motion.text import check_head, check_length, check_peak, fields, last_digit, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of

FIRST = re.compile(r"\s*(un)?corrected\s+accelerogram\b", re.I)
TEXTS, NUMBERS, EACH, WIDTH = 16, 10, 10, 8
"""Lines of text and of numbers in the header of a component; numbers a line, and columns of a number."""
COUNTS, LENGTH, INTERVAL = slice(33, 36), 63, 65
"""Indices of the numbers with the counts of the samples, with their duration and interval (s)."""
READINGS, COMPONENT, PEAK = 10, 12, 13
"""Indices of the lines of text with the unit of raw readings, the component and the peak."""
UNIT = 1e-3
"""mm/s2, m/s2."""
BEARING = re.compile(r"[NS]\d+[EW]", re.I)


def read_geonet(path: Path | str, unit: Unit | None = None) -> list[Component]:
    """Components of a file; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    while lines and not lines[-1].strip():
        lines.pop()
    first, found = 0, []
    while first < len(lines):
        component, first = _component(path, lines, first, unit)
        found.append(component)
    if not found:
        raise ValueError(f"{path}, line 1: is empty, must begin with 'Corrected accelerogram' or 'Uncorrected accelerogram'")
    return found


def _component(path: Path | str, lines: list[str], first: int, unit: Unit | None) -> tuple[Component, int]:
    """The component from line index ``first`` on, and the index of the line behind it."""
    if not FIRST.match(lines[first]) or len(lines) < first + TEXTS + NUMBERS:
        raise ValueError(
            f"{path}, line {first + 1}: must begin the {TEXTS + NUMBERS} lines of header of a component, 'Corrected accelerogram' or "
            f"'Uncorrected accelerogram' (found {lines[first][:80]!r})"
        )
    texts, behind = lines[first : first + TEXTS], first + TEXTS + NUMBERS
    numbers = fields(path, lines, first + TEXTS, NUMBERS, WIDTH)
    if len(numbers) != EACH * NUMBERS:
        raise ValueError(f"{path}, lines {first + TEXTS + 1}-{behind}: must be {EACH * NUMBERS} numbers, {EACH} a line")
    head, counts, interval = first + TEXTS + 4, numbers[COUNTS], numbers[INTERVAL]
    if any(count != int(count) or count < 0 for count in counts):
        raise ValueError(f"{path}, line {head}: must count the samples (found {lines[head - 1][:80]!r})")
    check_head(path, counts[0], interval)
    check_length(f"{path}, line {first + TEXTS + 7}: the header", numbers[LENGTH], int(counts[0]), interval)
    name = re.match(r"\s*Component\s+(\S+)", texts[COMPONENT], re.I)
    peak = re.match(r"\s*Acceleration:\s*peak\s+(-?\d*\.?\d+)\s*mm/s/s", texts[PEAK], re.I)
    if name is None or peak is None:
        at = first + 1 + (COMPONENT if name is None else PEAK)
        raise ValueError(
            f"{path}, line {at}: must be as in {'Component N10E' if name is None else 'Acceleration: peak 2364.6 mm/s/s at 48.14 sec'!r} "
            f"(found {lines[at - 1][:80]!r})"
        )
    blocks = [math.ceil(count / EACH) for count in counts]
    last = behind + blocks[0]
    raw = re.search(r"in\s+units\s+of\s+(\d*\.?\d+)\s*mm/s/s", texts[READINGS], re.I)
    scale = size_of(path, UNIT, unit) * (float(raw[1]) if raw else 1.0)
    acceleration = samples(path, lines[:last], behind, WIDTH, scale, int(counts[0]), head)
    stated = UNIT * abs(float(peak[1]))
    check_peak(f"{path}, line {first + 1 + PEAK}: the header", stated, acceleration, UNIT * last_digit(peak[1]) + 0.5 * scale)
    if len(lines) < behind + sum(blocks):
        raise ValueError(f"{path}, line {head}: states {sum(blocks):,} lines of samples, {len(lines) - behind:,} follow; is it whole?")
    direction: Direction | None = "horizontal" if BEARING.match(name[1]) else direction_of(name[1])
    return Component(name[1], direction, interval, acceleration), behind + sum(blocks)
