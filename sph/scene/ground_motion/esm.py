"""Records of the Engineering Strong-Motion database in ASCII (``.ASC``): one component.

Header DYNA 1.2, as ESM and ITACA (https://esm-db.eu) and Turkey's AFAD (https://tadas.afad.gov.tr) hand it out: 64 lines 'KEY: value',
which end with USER5, then a sample a line in the unit of UNITS.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import check_head, check_peak, last_digit, number, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of, unit_in

KEY = re.compile(r"([A-Z][A-Z0-9_/^]*):\s*(.*?)\s*$")
INTERVAL, COUNT, UNITS, STREAM, KIND, PEAK = "SAMPLING_INTERVAL_S", "NDATA", "UNITS", "STREAM", "DATA_TYPE", "PGA_CM/S^2"
WIDTH = 80


def read_esm(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    head: dict[str, tuple[int, str]] = {}
    for at, line in enumerate(lines, 1):
        found = KEY.match(line)
        if found is None:
            break
        head[found[1]] = at, found[2]
    for key in (INTERVAL, COUNT, UNITS):
        if key not in head:
            raise ValueError(f"{path}, lines 1-{len(head) + 1}: must be an ESM header, lines 'KEY: value', with {key}")
    kind = head.get(KIND, (0, "ACCELERATION"))
    if "ACCELERATION" not in kind[1].upper() or "SPECTR" in kind[1].upper():
        raise ValueError(f"{path}, line {kind[0]}: must be a record of acceleration (found {kind[1]!r}); name the file of the accelerogram")
    interval, count = _number(path, head, INTERVAL), _number(path, head, COUNT)
    check_head(path, count, interval)
    at, words = head[UNITS]
    stated = unit_in(words)
    if stated is None:
        raise ValueError(f"{path}, line {at}: {words!r} is no unit of acceleration that is known here")
    stream = head.get(STREAM, (0, ""))
    said = "vertical" if stream[1].upper() == "U" else direction_of(stream[1])  # AFAD names its streams N, E and U
    check_direction(f"{path}, line {stream[0]}: its stream {stream[1]!r}", said, wanted)
    acceleration = samples(path, lines, len(head), WIDTH, size_of(path, stated, unit), int(count), head[COUNT][0])
    if PEAK in head and number(head[PEAK][1]) is not None:
        peak = abs(_number(path, head, PEAK))
        check_peak(f"{path}, line {head[PEAK][0]}: {PEAK}", 0.01 * peak, acceleration, 0.01 * last_digit(head[PEAK][1]))
    return interval * np.arange(int(count)), acceleration


def _number(path: Path | str, head: dict[str, tuple[int, str]], key: str) -> float:
    at, text = head[key]
    value = number(text)
    if value is None or not np.isfinite(value) or key == COUNT and value != int(value):
        raise ValueError(f"{path}, line {at}: {key} must be a {'whole ' if key == COUNT else ''}number (found {text[:80]!r})")
    return value
