"""Records of the USGS in SMC format: 11 lines of text, 48 integers, 50 reals, comments, samples in cm/s2.

https://escweb.wr.usgs.gov/nsmp-data/smcfmt.html: the first line names the kind of file; integers are written as 8I10, the 13th is the
sensor's angle from upwards (0 up, 180 down, 90 horizontal; the USGS's gmprocess takes 0 and 180 as vertical too), the 14th its azimuth,
the 16th counts the lines of comments and the 17th the samples; reals as 5E15.7, the 2nd is the sampling rate; samples as eight a line
of ten columns.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, check_header
from sph.scene.ground_motion.text import check_head, fields, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of
from sph.scene.units import SIZES

KINDS = ("1 UNCORRECTED ACCELEROGRAM", "2 CORRECTED ACCELEROGRAM")
TEXTS, INTEGERS, REALS = 11, 6, 10
"""Lines of each kind of header."""
WIDTH = 10
VERTICAL, UPRIGHT, LEVEL = 12, (0, 180), 90
"""Index of the integer with the sensor's angle from upwards, and that of vertical and horizontal sensors, degrees."""


def read_smc(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    if " ".join(lines[0].split()).upper() not in KINDS:
        raise ValueError(f"{path}, line 1: must read {' or '.join(map(repr, KINDS))} (found {lines[0][:80]!r})")
    head = TEXTS + INTEGERS + REALS
    if len(lines) < head:
        raise ValueError(f"{path}: must begin with {head} lines of headers, has {len(lines)} lines")
    integers = fields(path, lines, TEXTS, INTEGERS, 10)
    reals = fields(path, lines, TEXTS + INTEGERS, REALS, 15)
    if len(integers) < 17 or len(reals) < 2:
        raise ValueError(f"{path}, lines {TEXTS + 1}-{head}: must be 48 integers and 50 reals (found {len(integers)} and {len(reals)})")
    check_header(path, lines[:TEXTS], wanted)
    said: Direction | None = "vertical" if integers[VERTICAL] in UPRIGHT else "horizontal" if integers[VERTICAL] == LEVEL else None
    check_direction(f"{path}, lines {TEXTS + 1}-{TEXTS + 2}: the 13th integer, {integers[VERTICAL]:g} degrees from upwards,", said, wanted)
    comments, count, rate = integers[15], integers[16], reals[1]
    if not (0 <= comments <= len(lines) and comments == int(comments) and count == int(count)):
        raise ValueError(f"{path}, lines {TEXTS + 2}-{TEXTS + 3}: no numbers of comments and samples (found {comments:g} and {count:g})")
    check_head(path, count, 1.0 / rate if rate > 0 else np.inf)
    scale = size_of(path, SIZES["cm/s2"], unit)
    return np.arange(int(count)) / rate, samples(path, lines, head + int(comments), WIDTH, scale, int(count))
