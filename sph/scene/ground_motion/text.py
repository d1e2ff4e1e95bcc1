"""Text of a record, whatever the system it was written on: lines, and blocks of samples; every refusal names file and line."""

from __future__ import annotations

import codecs
import math
import re
from pathlib import Path

import numpy as np

MAX_RECORD = 100_000_000
"""Largest file of a record, bytes."""
MAX_TIME, MAX_ACCELERATION, MIN_INTERVAL = 1e6, 1e6, 1e-9
"""Largest time (s) and acceleration (m/s2) of a record, either sign, and the shortest interval between its samples (s)."""
SAME_PEAK, SAME_LENGTH = 0.01, 0.005
"""Relative difference of peaks and of durations from which on a header is another record's."""


def read_lines(path: Path | str) -> list[str]:
    """Lines of a text in UTF-8, UTF-16 with its mark, or Latin-1, that end in LF, CR LF or CR; ValueError names the file."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_RECORD + 1)
        if len(data) > MAX_RECORD:
            raise ValueError(f"it is larger than {MAX_RECORD:,} bytes")
        text = _decoded(data)
        if "\0" in text:
            raise ValueError("it is binary")
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as text: {error}") from error
    return re.split(r"\r\n|\r|\n", text)


def _decoded(data: bytes) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def number(text: str) -> float | None:
    """A number, also with the exponent D of Fortran; None for anything else, 1_0 among it."""
    if "_" in text:
        return None
    try:
        return float(text.replace("D", "E").replace("d", "e"))
    except ValueError:
        return None


def fields(path: Path | str, lines: list[str], first: int, count: int, width: int) -> list[float]:
    """The numbers in some lines of headers, in columns of a width."""
    values = []
    for index in range(first, first + count):
        line = lines[index].rstrip()
        words = [line[at : at + width] for at in range(0, len(line), width)]
        for word in words:
            value = number(word)
            if value is None or not np.isfinite(value):
                raise ValueError(f"{path}, line {index + 1}: must be numbers in columns of {width} (found {line[:80]!r})")
            values.append(value)
    return values


def samples(
    path: Path | str, lines: list[str], first: int, width: int, scale: float, announced: int, head: int | None = None
) -> np.ndarray:
    """Samples (n,) in m/s2 from line index ``first`` on: numbers apart, or in columns of a width where they touch.

    ``scale`` turns them into m/s2; ValueError for what is no finite number, and for another count than the ``announced`` one, which the
    line of number ``head`` states if it is given.
    """
    found: list[float] = []
    for index in range(first, len(lines)):
        words = lines[index].split()
        values = [number(word) for word in words]
        if None in values:
            line = lines[index].rstrip()
            values = [number(line[at : at + width]) for at in range(0, len(line), width)]
        for value in values:
            if value is None or not abs(value * scale) <= MAX_ACCELERATION:
                raise ValueError(
                    f"{path}, line {index + 1}: must be finite numbers up to {MAX_ACCELERATION:g} m/s2 (found {lines[index][:80]!r})"
                )
            found.append(value)
    check_count(path, announced, len(found), head)
    return scale * np.array(found)


def rows(path: Path | str, lines: list[str], first: int, width: int, scale: float, announced: int, head: int) -> np.ndarray:
    """Rows (n, width) of accelerations in m/s2, a line each, from line index ``first`` on; otherwise as ``samples``."""
    found: list[list[float]] = []
    for index in range(first, len(lines)):
        words = lines[index].split()
        values = [scale * value for value in map(number, words) if value is not None and abs(value * scale) <= MAX_ACCELERATION]
        if words and not len(words) == len(values) == width:
            raise ValueError(
                f"{path}, line {index + 1}: must be {width} finite numbers up to {MAX_ACCELERATION:g} m/s2 (found {lines[index][:80]!r})"
            )
        found += [values] if words else []
    check_count(path, announced, len(found), head)
    return np.array(found)


def check_count(path: Path | str, announced: int, found: int, head: int | None = None) -> None:
    """Refuse another number of samples than the header states, in the line of number ``head`` if that is known."""
    if found != announced:
        where = path if head is None else f"{path}, line {head}"
        raise ValueError(f"{where}: must hold the {announced:,} samples that its header states, holds {found:,}; is it whole?")


def last_digit(text: str) -> float:
    """Half of the last digit of a number without exponent, by which it is rounded: 0.005 of '27.11'."""
    return 0.5 * 10.0 ** -len(text.partition(".")[2])


def check_peak(where: str, stated: float, acceleration: np.ndarray, rounding: float = 0.0) -> None:
    """Refuse samples (n,) in m/s2 whose peak is not the one that ``where`` states, m/s2, within ``SAME_PEAK`` and its rounding."""
    peak = float(np.abs(acceleration).max())
    if abs(peak - stated) > SAME_PEAK * stated + rounding:
        raise ValueError(
            f"{where} states a peak of {stated:.4g} m/s2, its samples have {peak:.4g} m/s2; is the unit right, and the file whole?"
        )


def check_length(where: str, stated: float, count: int, interval: float) -> None:
    """Refuse samples that do not last as long as ``where`` states, s, within ``SAME_LENGTH`` and two intervals."""
    if abs(count * interval - stated) > SAME_LENGTH * stated + 2.0 * interval:
        raise ValueError(
            f"{where} states {stated:g} s, and {count:,} samples every {interval:g} s last {count * interval:g} s; "
            "write the record as .csv with its times"
        )


def check_head(path: Path | str, count: float, interval: float) -> None:
    """Refuse a number of samples below two, and an interval (s) that is none."""
    if not count >= 2:
        raise ValueError(f"{path}: must hold at least two samples (its head announces {count:g})")
    if not (math.isfinite(interval) and interval >= MIN_INTERVAL and count * interval <= MAX_TIME):
        raise ValueError(
            f"{path}: the interval of its samples must be from {MIN_INTERVAL:g} s on, its end at most {MAX_TIME:g} s "
            f"(its head has {count:,.0f} samples every {interval:g} s)"
        )
