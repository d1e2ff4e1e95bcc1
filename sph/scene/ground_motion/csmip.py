"""Records of California's strong-motion program (CSMIP) as volume 1 (``.V1``, ``.RAW``) and volume 2 (``.V2``): a component a channel.

A channel of volume 1, uncorrected acceleration, begins with 13 lines of text, one of volume 2 with 25, the first of which says
'Corrected accelerogram'; 100 integers in columns of 5 follow, the 27th of which is the azimuth of the sensor (500 up, 600 down), and reals
in columns of 10, of which the 61st of volume 2 is the interval (s).  The line '7500 points of accel data equally spaced at .010 sec, in
cm/sec2. (8f10.6)' stands above the samples; in volume 2 velocity and displacement follow, which are left out (so reads it the USGS's
gmprocess, ``io/dmg``, too).  Older files of volume 1, which hold pairs of time and acceleration, are refused.
"""

from __future__ import annotations

import re
from pathlib import Path

from sph.scene.ground_motion.component import Component
from sph.scene.ground_motion.direction import Direction, direction_of
from sph.scene.ground_motion.text import check_head, check_length, check_peak, last_digit, number, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of, unit_in
from sph.scene.units import SIZES

FIRST = re.compile(r"\s*(un)?corrected\s+accelerogram\b", re.I)
CHANNEL = re.compile(r"\s*chan\w*\s+(\d+)\s*:\s*(.*?)\s*$", re.I)
SAMPLES = re.compile(r"\s*(\d+)\s+points\s+of\s+accel\w*\s+data\s+equally\s+spaced\s+at\s+(\d*\.?\d+)\s*sec\.?(.*)", re.I)
FORMAT = re.compile(r"\(\s*\d*\s*[EFG](\d+)\.\d+\s*\)", re.I)
BEHIND = re.compile(r"\s*/&|.*\bend of data\b|.*\bpoints of\b", re.I)
"""A line behind the samples: the end of the channel, or the head of the velocity."""
PEAK = re.compile(r"\s*peak\s+acceleration\s*=\s*(-?\d*\.?\d+)\s*cms?/s(?:ec)?/s(?:ec)?\b", re.I)
LENGTH = re.compile(r".*record\s+length\s*=\s*(\d*\.?\d+)\s*sec", re.I)
TEXTS, INTEGERS = {1: 13, 2: 25}, 7
"""Lines of text by volume, and of integers."""
WIDTHS = {1: 9, 2: 10}
"""Columns of a sample by volume where the line above them does not say it."""
AZIMUTH, INTERVAL = (1, 50, 55), (7, 40, 50)
"""Line, first and last column of the 27th integer and of the 61st real."""
UPRIGHT = (500.0, 600.0)


def read_csmip(path: Path | str, unit: Unit | None = None) -> list[Component]:
    """Components of a file; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    found = FIRST.match(lines[0])
    if found is None:
        raise ValueError(
            f"{path}, line 1: must begin with 'Corrected accelerogram' or 'Uncorrected accelerogram' (found {lines[0][:80]!r})"
        )
    volume = 1 if found[1] else 2
    starts = [at for at, line in enumerate(lines) if (head := FIRST.match(line)) and bool(head[1]) == bool(found[1])]
    ends = [*starts[1:], len(lines)]
    return [_channel(path, lines[:end], start, volume, unit) for start, end in zip(starts, ends, strict=True)]


def _channel(path: Path | str, lines: list[str], start: int, volume: int, unit: Unit | None) -> Component:
    """The channel from line index ``start`` to the end of the lines."""
    at = next((at for at in range(start, len(lines)) if SAMPLES.match(lines[at])), None)
    if at is None:
        raise ValueError(
            f"{path}, line {start + 1}: has no line 'n points of accel data equally spaced at .010 sec' below it; "
            "write the record as .csv with its times"
        )
    found = SAMPLES.match(lines[at])
    assert found is not None
    where, count, interval = f"{path}, line {at + 1}", int(found[1]), float(found[2])
    words = FORMAT.sub("", found[3]).strip(" ,")
    stated = unit_in(words)
    if stated is None:
        raise ValueError(f"{where}: {words!r} names no unit of acceleration that is known here")
    texts = lines[start : min(start + TEXTS[volume], at)]
    interval = _interval(path, lines, start, at, volume, interval, last_digit(found[2]))
    check_head(path, count, interval)
    width = FORMAT.search(found[3])
    end = next((index for index in range(at + 1, len(lines)) if BEHIND.match(lines[index])), len(lines))
    acceleration = samples(
        path, lines[:end], at + 1, int(width[1]) if width else WIDTHS[volume], size_of(path, stated, unit), count, at + 1
    )
    for index, line in enumerate(texts, start + 1):
        if volume == 1 and (length := LENGTH.match(line)):
            check_length(f"{path}, line {index}: the header", float(length[1]), count, interval)
        if volume == 2 and (peak := PEAK.match(line)):
            size = SIZES["cm/s2"]
            check_peak(f"{path}, line {index}: the header", size * abs(float(peak[1])), acceleration, size * last_digit(peak[1]))
    name = next((found[2] for found in map(CHANNEL.match, texts) if found), "no name")
    return Component(name, _direction(name, _field(lines, start + TEXTS[volume], AZIMUTH)), interval, acceleration)


def _interval(path: Path | str, lines: list[str], start: int, at: int, volume: int, line: float, rounding: float) -> float:
    """Interval (s): that of the line of samples, or the same with more digits in the reals of volume 2."""
    first = start + TEXTS[volume] + INTEGERS
    stated = _field(lines[:at], first, INTERVAL) if volume == 2 else None
    if stated is None or not stated > 0.0:
        return line
    if abs(stated - line) > 1.001 * rounding:
        raise ValueError(f"{path}, line {at + 1}: states an interval of {line:g} s, line {first + 1 + INTERVAL[0]} of {stated:g} s")
    return stated


def _field(lines: list[str], first: int, place: tuple[int, int, int]) -> float | None:
    line, begin, end = place
    return number(lines[first + line][begin:end]) if first + line < len(lines) else None


def _direction(name: str, azimuth: float | None) -> Direction | None:
    """Direction of a channel by its name, '90 Deg', 'Up' or 'H1', and by the azimuth of its sensor."""
    said = "horizontal" if re.search(r"\d\s*deg", name, re.I) else direction_of(name)
    if said == "vertical" or azimuth in UPRIGHT:
        return "vertical"
    return "horizontal" if said or azimuth is not None and 0.0 < azimuth <= 360.0 else None
