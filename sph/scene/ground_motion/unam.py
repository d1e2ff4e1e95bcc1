"""Records in Mexico's standard file of acceleration (``.asa``, ``.txt``) of the Instituto de Ingeniería, UNAM: up to six components in gal.

'ARCHIVO ESTANDAR DE ACELERACION' in the 7th of 109 lines of header, 'KEY : value' with one value for each channel between slashes
('/0.01/0.01/0.01'), then a line of samples for every time (so read it the USGS's gmprocess, ``io/unam``, and other readers).  A vertical
channel has the orientation V, a horizontal one a bearing as N90E.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.component import Component
from sph.scene.ground_motion.direction import Direction, direction_of
from sph.scene.ground_motion.text import check_head, check_peak, last_digit, number, read_lines, rows
from sph.scene.ground_motion.units import Unit, size_of, unit_in
from sph.scene.units import SIZES

FIRST = re.compile(r".*ARCHIVO EST[AÁ]NDAR DE ACELERACI[OÓ]N", re.I)
HEAD = 109
"""Lines of the header."""
ORIENTATION, INTERVAL, COUNT = "ORIENTACION C1-C6", "INTERVALO DE MUESTREO, C1-C6", "NUM. TOTAL DE MUESTRAS, C1-C6"
PEAK, UNITS = "ACEL. MAX.(Gal), C1-C6", "UNIDADES DE LOS DATOS"
"""Beginnings of the lines that are read."""
BEARING = re.compile(r"[NS]\s*\d+\s*[EWO]", re.I)


def read_unam(path: Path | str, unit: Unit | None = None) -> list[Component]:
    """Components of a file; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    if len(lines) < HEAD or not any(map(FIRST.match, lines[:HEAD])):
        raise ValueError(f"{path}, lines 1-{HEAD}: must be the header of an 'ARCHIVO ESTANDAR DE ACELERACION' (found {len(lines)} lines)")
    at, names = _values(path, lines, ORIENTATION)
    if not names:
        raise ValueError(f"{path}, line {at}: must name the channels, as in '/N90E/V/N00E' (found {lines[at - 1][:80]!r})")
    (at, intervals), (head, counts) = (_numbers(path, lines, key, len(names)) for key in (INTERVAL, COUNT))
    if len({*intervals}) > 1 or len({*counts}) > 1:
        raise ValueError(f"{path}, lines {at} and {head}: all channels must have one interval and one number of samples")
    if counts[0] != int(counts[0]):
        raise ValueError(f"{path}, line {head}: must be whole numbers (found {lines[head - 1][:80]!r})")
    check_head(path, counts[0], intervals[0])
    scale = size_of(path, _unit(path, lines), unit)
    columns = rows(path, lines, HEAD, len(names), scale, int(counts[0]), head).T
    if any(line.startswith(PEAK) for line in lines[:HEAD]):
        at, peaks = _values(path, lines, PEAK)
        for text, column in zip(peaks, columns, strict=False):
            if (peak := number(text)) is not None:
                check_peak(f"{path}, line {at}: {PEAK}", 0.01 * abs(peak), column, 0.01 * last_digit(text))
    return [Component(name, _direction(name), intervals[0], column) for name, column in zip(names, columns, strict=True)]


def _unit(path: Path | str, lines: list[str]) -> float:
    """Unit (m/s2) that the header states; gal, that of the format, where it states none."""
    for at, line in enumerate(lines[:HEAD], 1):
        words = line.partition(":")[2].strip()
        if line.startswith(UNITS) and words:
            if (stated := unit_in(words)) is None:
                raise ValueError(
                    f"{path}, line {at}: {words[:80]!r} is no unit of acceleration that is known here; write the record as .csv"
                )
            return stated
    return SIZES["gal"]


def _direction(name: str) -> Direction | None:
    return "horizontal" if BEARING.match(name) else direction_of(name)


def _values(path: Path | str, lines: list[str], key: str) -> tuple[int, list[str]]:
    """Number of the line that begins with a key, and its values for the channels that there are."""
    at = next((at for at, line in enumerate(lines[:HEAD], 1) if line.startswith(key)), None)
    if at is None:
        raise ValueError(f"{path}, lines 1-{HEAD}: must have a line {key!r}")
    return at, [text.strip() for text in lines[at - 1].partition(":")[2].split("/") if text.strip()]


def _numbers(path: Path | str, lines: list[str], key: str, count: int) -> tuple[int, list[float]]:
    at, texts = _values(path, lines, key)
    values = [value for value in map(number, texts) if value is not None and np.isfinite(value)]
    if not len(texts) == len(values) == count:
        raise ValueError(f"{path}, line {at}: must be {count} numbers, one a channel (found {lines[at - 1][:80]!r})")
    return at, values
