"""Records in COSMOS format (``.v1``, ``.v2``, ``.v1c``, ``.v2c``), in which CESMD and others hand them out: one component.

COSMOS Strong-Motion Data Format, version 1.20 (2001): lines of text, the first of which says "Corrected acceleration"; then blocks, each
below a line with the number of its values and their Fortran format: integers, reals, comments, and the samples with their unit.  The
62nd real is the interval of the samples in ms, the 63rd their duration in s, the 64th their peak; a value that is not known is -999.
The line above the samples states their duration in whole seconds, in some files their interval.  The 54th integer is the azimuth of the
sensor, the 55th that in the structure, where the other is not known: degrees from north (1 to 360), or a code of its table of sensor
orientations, 400 up, 401 down, 402 vertical of either sense, from 500 to 701 radial, transverse, longitudinal, tangential and other
horizontal ones (so has the USGS's gmprocess them, ``io/cosmos``).  Histories of velocity and displacement behind the acceleration are
left out.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, check_header
from sph.scene.ground_motion.text import check_head, check_peak, fields, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of, unit_in
from sph.scene.units import SIZES

FIRST = re.compile(r"\s*(un)?corrected\s+acceleration", re.I)
FORMAT = r"format\s*=\s*\(\s*(\d*)\s*P?\s*[EFGI](\d+)"
INTEGERS = re.compile(rf"\s*(\d+)\s+integer-header\s+values\s+follow\s+on\s+(\d+)\s+lines?\s*,?\s*{FORMAT}", re.I)
REALS = re.compile(rf"\s*(\d+)\s+real-header\s+values\s+follow\s+on\s+(\d+)\s+lines?\s*,?\s*{FORMAT}", re.I)
SAMPLES = re.compile(rf"\s*(\d+)\s+acceleration\s+pts.*?units\s*=\s*(.+?)\s*,?\s*{FORMAT}", re.I)
CODE = re.compile(r"\(\s*(\d+)\s*\)")
CODES = {2: SIZES["g"], 4: SIZES["cm/s2"]}
"""Units of acceleration by the number behind their name in the line above the samples, m/s2."""
EVERY = re.compile(r"(?:at|every|dt\s*=|interval\s*=?)\s*(\d*\.?\d+)\s*(m?)s(?:ec)?", re.I)
DURATION = re.compile(r"(?:approx\w*\.?\s*)(\d*\.?\d+)\s*sec", re.I)
AZIMUTHS: tuple[int, ...] = (53, 54)
"""Indices of the integers with the azimuth of the sensor from north, and in the structure."""
ORIENTATIONS: dict[Direction, tuple[int, ...]] = {"vertical": (400, 401, 402), "horizontal": (*range(1, 361), 500, 501, 600, 601, 700, 701)}
"""Their values for a vertical and for a horizontal sensor."""
RECORDED_INTERVAL, INTERVAL, LENGTH, PEAK = 33, 61, 62, 63
"""Indices of the reals with the interval of the recorder (s or ms), that of the samples (ms), their duration (s) and peak."""
UNKNOWN = -999.0
"""A real that is not known; some files write -999.9."""
ROUNDED = 1.0
"""Difference of durations (s), which are rounded to whole seconds, from which on the header is another's."""


def read_cosmos(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    if not FIRST.match(lines[0]):
        raise ValueError(
            f"{path}, line 1: must begin with 'Corrected acceleration' or 'Uncorrected acceleration', as COSMOS files do, or with "
            f"'Corrected accelerogram' or 'Uncorrected accelerogram', as those of CSMIP (found {lines[0][:80]!r})"
        )
    heads = [index for index, line in enumerate(lines) if REALS.match(line)]
    blocks = [index for index, line in enumerate(lines) if SAMPLES.match(line)]
    if not heads or not blocks or heads[0] > blocks[0]:
        raise ValueError(f"{path}: is not in COSMOS format: it has no line 'n Real-header values follow' above a line 'n acceleration pts'")
    if len(blocks) > 1:
        at = ", ".join(str(index + 1) for index in blocks)
        raise ValueError(f"{path}: holds {len(blocks)} components (lines {at}), must hold one; put each into a file of its own")
    found = SAMPLES.match(lines[blocks[0]])
    assert found is not None
    count, words, each, width = int(found[1]), CODE.sub("", found[2]).strip(), int(found[3] or 1), int(found[4])
    stated = unit_in(words)
    if stated is None:
        raise ValueError(f"{path}, line {blocks[0] + 1}: {words!r} is no unit of acceleration that is known here")
    if (code := CODE.search(found[2])) and CODES.get(int(code[1]), stated) != stated:
        raise ValueError(f"{path}, line {blocks[0] + 1}: {found[2]!r}: name and number are of different units; write the right one")
    check_header(path, lines[: heads[0]], wanted)
    integers = _header(path, lines, INTEGERS, heads[0])
    for index in (index for index in AZIMUTHS if index < len(integers)):
        said = next((name for name, codes in ORIENTATIONS.items() if integers[index] in codes), None)
        check_direction(f"{path}: the {index + 1}th integer of its header, {integers[index]:g},", said, wanted)
        if said is not None:
            break
    reals = _header(path, lines, REALS, heads[0] + 1)
    interval = _interval(
        path, reals, f"lines {heads[0] + 2}-{heads[0] + 1 + _height(lines[heads[0]])} and {blocks[0] + 1}", lines[blocks[0]], count
    )
    check_head(path, count, interval)
    last = blocks[0] + 1 + math.ceil(count / max(each, 1))
    size = size_of(path, stated, unit)
    acceleration = samples(path, lines[:last], blocks[0] + 1, width, size, count)
    if len(reals) > PEAK and abs(reals[PEAK] - UNKNOWN) >= 1.0 and reals[PEAK]:
        check_peak(f"{path}: the 64th real of its header", abs(reals[PEAK]) * size, acceleration)
    return interval * np.arange(count), acceleration


def _height(head: str) -> int:
    """Lines of the block of reals below its head."""
    found = REALS.match(head)
    return int(found[2]) if found else 0


def _header(path: Path | str, lines: list[str], head: re.Pattern[str], end: int) -> list[float]:
    """Values of the block of a header below the last line of its kind before a line; none without one."""
    index = next((index for index in reversed(range(end)) if head.match(lines[index])), None)
    found = head.match(lines[index]) if index is not None else None
    if index is None or found is None:
        return []
    return fields(path, lines, index + 1, min(int(found[2]), len(lines) - index - 1), int(found[4]))


def _interval(path: Path | str, reals: list[float], where: str, line: str, count: int) -> float:
    """Interval of the samples (s), which agrees with all that the header says of it; ValueError where it does not say it.

    Where the 62nd real is not known, it is that of the line above the samples, or of their duration in the 63rd real, or that of the
    recorder if it gives the duration which the line above the samples states.
    """
    interval, length, recorded = (reals[index] if index < len(reals) else 0.0 for index in (INTERVAL, LENGTH, RECORDED_INTERVAL))
    every, approx = EVERY.search(line), DURATION.search(line)
    stated = [1e-3 * interval] if interval > 0 else []
    stated += [float(every[1]) * (1e-3 if every[2] else 1.0)] if every else []
    durations = [length] if length > 0 else []
    durations += [float(approx[1])] if approx else []
    if not stated:
        stated += [each for each in (recorded, 1e-3 * recorded) if approx and recorded > 0 and _as_long(count * each, float(approx[1]))]
        if len(stated) != 1 and length > 0:
            stated = [length / count]
    if len(stated) == 0 or len({f"{each:.6g}" for each in stated}) > 1 or not all(_as_long(count * stated[0], each) for each in durations):
        said = ", ".join([f"{each:g} s" for each in stated] or ["none"])
        raise ValueError(
            f"{path}, {where}: the header must state the interval of the samples in ms as 62nd real, as long as the duration beside it "
            f"(found intervals: {said}; {count:,} samples; durations: {', '.join(f'{each:g} s' for each in durations) or 'none'}); "
            "write the record as .csv with its times"
        )
    return float(f"{stated[0]:.9g}")


def _as_long(duration: float, other: float) -> bool:
    return abs(duration - other) <= ROUNDED
