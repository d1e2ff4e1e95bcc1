"""Records of K-NET and KiK-net in ASCII (``.EW``, ``.NS``, ``.UD``, ``.EW1`` ...).

https://www.kyoshin.bosai.go.jp: 17 lines of head, then counts of the recorder; the scale factor in the head turns them into gal.
They are as recorded: the offset of the recorder is in them, see ``baseline``; the peak in the head is that without their mean.  KiK-net
has two instruments at a station: the directions 1 to 3 (NS, EW, UD; ``.NS1`` ...) are of the borehole, 4 to 6 (``.NS2`` ...) of the
surface.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import MAX_ACCELERATION, check_head, check_peak, last_digit, number, read_lines
from sph.scene.ground_motion.units import Unit, size_of
from sph.scene.units import SIZES

HEAD, RATE, DURATION, DIRECTION, FACTOR, PEAK = 17, 10, 11, 12, 13, 14
"""Lines of the head; indices of its lines with sampling rate, duration, direction, scale factor and peak."""
WRITTEN = {
    RATE: (r"Sampling Freq\(Hz\)\s+(\d+)", "Sampling Freq(Hz) 100Hz"),
    DURATION: (r"Duration Time\(s\)\s+(\d+\.?\d*)", "Duration Time(s) 300"),
    FACTOR: (r"Scale Factor\s+(\d+)\(gal\)/(\d+)", "Scale Factor 2000(gal)/8388608"),
    PEAK: (r"Max\. Acc\. \(gal\)\s+(\d+\.?\d*)", "Max. Acc. (gal) 4.383"),
}
"""How lines with numbers are written, and an example."""
CHANNELS: dict[str, Direction] = {str(channel): "vertical" if channel in (3, 6) else "horizontal" for channel in range(1, 7)}
"""Directions of KiK-net."""
IN_BOREHOLE = ("1", "2", "3")
"""Those of the instrument in the borehole."""


def read_knet(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = [line.rstrip() for line in read_lines(path)]
    if len(lines) <= HEAD or not lines[0].startswith("Origin Time") or not lines[HEAD - 1].startswith("Memo"):
        raise ValueError(f"{path}, lines 1-{HEAD}: must be a K-NET head, 'Origin Time' to 'Memo.'")
    name = lines[DIRECTION][len("Dir.") :].strip()
    said = CHANNELS.get(name) or direction_of(name)
    if said is None:
        raise ValueError(f"{path}, line {DIRECTION + 1}: must be a direction, N-S, E-W, U-D or 1 to 6 (found {lines[DIRECTION][:80]!r})")
    check_direction(f"{path}, line {DIRECTION + 1}: {lines[DIRECTION]!r}", said, wanted)
    counts: list[float] = []
    for index in range(HEAD, len(lines)):
        values = [number(word) for word in lines[index].split()]
        if None in values:
            raise ValueError(f"{path}, line {index + 1}: must be numbers (found {lines[index][:80]!r})")
        counts += [value for value in values if value is not None]
    ((rate,), (seconds,), (full_scale, full_count), (peak,)) = (_numbers(path, lines, index) for index in WRITTEN)
    check_head(path, len(counts), 1.0 / rate if rate > 0 else np.inf)
    if abs(len(counts) / rate - seconds) > 1.0:  # durations are in whole seconds
        raise ValueError(
            f"{path}: must hold the {seconds * rate:,.0f} samples that its head announces (lines {RATE + 1} and {DURATION + 1}), "
            f"holds {len(counts):,}; is it whole?"
        )
    if not (full_scale > 0 and full_count > 0):
        raise ValueError(f"{path}, line {FACTOR + 1}: must be a scale factor above 0 (found {lines[FACTOR]!r})")
    acceleration = np.array(counts) * (size_of(path, SIZES["gal"], unit) * full_scale / full_count)
    if not np.abs(acceleration).max() <= MAX_ACCELERATION:
        raise ValueError(f"{path}: must be finite accelerations up to {MAX_ACCELERATION:g} m/s2")
    rounding = last_digit(lines[PEAK].split()[-1])
    check_peak(f"{path}, line {PEAK + 1}: the head", 0.01 * peak, acceleration - acceleration.mean(), 0.01 * rounding)
    return np.arange(len(counts)) / rate, acceleration


def in_borehole(path: Path | str) -> bool:
    """Whether a record is of the instrument in the borehole of a KiK-net station, by its ending or its direction."""
    lines = read_lines(path)
    return Path(path).suffix.endswith("1") or len(lines) > DIRECTION and lines[DIRECTION][len("Dir.") :].strip() in IN_BOREHOLE


def _numbers(path: Path | str, lines: list[str], index: int) -> list[float]:
    pattern, example = WRITTEN[index]
    found = re.match(pattern, lines[index])
    if found is None:
        raise ValueError(f"{path}, line {index + 1}: must be as in {example!r} (found {lines[index][:80]!r})")
    return [float(text) for text in found.groups()]
