"""Records of K-NET and KiK-net in ASCII (``.EW``, ``.NS``, ``.UD``, ``.EW1`` ...).

https://www.kyoshin.bosai.go.jp: 17 lines of head, then counts of the recorder; the scale factor in the head turns them into gal.
They are as recorded: the offset of the recorder is in them, see ``baseline``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import LARGEST_ACCELERATION, check_head, number, read_lines
from sph.scene.ground_motion.units import Unit, size_of
from sph.scene.units import SIZES

HEAD, RATE, DURATION, DIRECTION, FACTOR = 17, 10, 11, 12, 13
"""Lines of the head; indices of its lines with sampling rate, duration, direction and scale factor."""
WRITTEN = {
    RATE: (r"Sampling Freq\(Hz\)\s+(\d+)", "Sampling Freq(Hz) 100Hz"),
    DURATION: (r"Duration Time\(s\)\s+(\d+\.?\d*)", "Duration Time(s) 300"),
    FACTOR: (r"Scale Factor\s+(\d+)\(gal\)/(\d+)", "Scale Factor 2000(gal)/8388608"),
}
"""How lines with numbers are written, and an example."""


def read_knet(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = [line.rstrip() for line in read_lines(path)]
    if len(lines) <= HEAD or not lines[0].startswith("Origin Time") or not lines[HEAD - 1].startswith("Memo"):
        raise ValueError(f"{path}, lines 1-{HEAD}: must be a K-NET head, 'Origin Time' to 'Memo.'")
    check_direction(f"{path}, line {DIRECTION + 1}: {lines[DIRECTION]!r}", direction_of(lines[DIRECTION][len("Dir.") :]), wanted)
    counts: list[float] = []
    for index in range(HEAD, len(lines)):
        values = [number(word) for word in lines[index].split()]
        if None in values:
            raise ValueError(f"{path}, line {index + 1}: must be numbers (found {lines[index][:80]!r})")
        counts += [value for value in values if value is not None]
    ((rate,), (seconds,), (full_scale, full_count)) = (_numbers(path, lines, index) for index in WRITTEN)
    check_head(path, len(counts), 1.0 / rate if rate > 0 else np.inf)
    if abs(len(counts) / rate - seconds) > 1.0:  # durations are in whole seconds
        raise ValueError(
            f"{path}: must hold the {seconds * rate:,.0f} samples that its head announces (lines {RATE + 1} and {DURATION + 1}), "
            f"holds {len(counts):,}; is it whole?"
        )
    if not (full_scale > 0 and full_count > 0):
        raise ValueError(f"{path}, line {FACTOR + 1}: must be a scale factor above 0 (found {lines[FACTOR]!r})")
    acceleration = np.array(counts) * (size_of(path, SIZES["gal"], unit) * full_scale / full_count)
    if not np.abs(acceleration).max() <= LARGEST_ACCELERATION:
        raise ValueError(f"{path}: must be finite accelerations up to {LARGEST_ACCELERATION:g} m/s2")
    return np.arange(len(counts)) / rate, acceleration


def _numbers(path: Path | str, lines: list[str], index: int) -> list[float]:
    pattern, example = WRITTEN[index]
    found = re.match(pattern, lines[index])
    if found is None:
        raise ValueError(f"{path}, line {index + 1}: must be as in {example!r} (found {lines[index][:80]!r})")
    return [float(text) for text in found.groups()]
