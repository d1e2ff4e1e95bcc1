"""Records of Turkey's strong-motion network as text (``.txt``): three components in gal.

'STRONG GROUND MOTION RECORDS OF TURKIYE' and 17 further lines of header: the 13th ends with the number of samples, the 14th with their
interval (s), the 18th names the columns N-S, E-W and U-D (so read it the USGS's gmprocess, ``io/nsmn``, too).  Newer files of AFAD are
those of ``esm``.
"""

from __future__ import annotations

import re
from pathlib import Path

from sph.scene.ground_motion.component import Component
from sph.scene.ground_motion.direction import direction_of
from sph.scene.ground_motion.text import check_head, read_lines, rows
from sph.scene.ground_motion.units import Unit, size_of
from sph.scene.units import SIZES

FIRST = re.compile(r"\s*STRONG GROUND MOTION RECORDS OF TURK", re.I)
HEAD, COUNT, INTERVAL, NAMES = 18, 13, 14, 18
"""Lines of the header; numbers of those with the count of the samples, their interval and the names of the columns."""
WRITTEN = {
    COUNT: (r".*:\s*(\d+)\s*$", "'NUMBER OF DATA: 12000'"),
    INTERVAL: (r"\s*SAMPLING\s+INTERVAL.*:\s*(\d*\.?\d+)\s*(?:s|sec)?\s*$", "'SAMPLING INTERVAL (sec): 0.01'"),
}
"""How lines with numbers are written, and an example."""


def read_afad(path: Path | str, unit: Unit | None = None) -> list[Component]:
    """Components of a file; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    if len(lines) < HEAD:
        raise ValueError(f"{path}: must begin with {HEAD} lines of header, has {len(lines)} lines")
    count, interval = (_number(path, lines, at) for at in WRITTEN)
    check_head(path, count, interval)
    names = lines[NAMES - 1].split()
    directions = [direction_of(name) for name in names]
    if sorted(map(str, directions)) != ["horizontal", "horizontal", "vertical"]:
        raise ValueError(f"{path}, line {NAMES}: must name the columns, 'N-S E-W U-D' (found {lines[NAMES - 1][:80]!r})")
    columns = rows(path, lines, HEAD, len(names), size_of(path, SIZES["gal"], unit), int(count), COUNT).T
    return [Component(*each[:2], interval, each[2]) for each in zip(names, directions, columns, strict=True)]


def _number(path: Path | str, lines: list[str], at: int) -> float:
    pattern, example = WRITTEN[at]
    found = re.match(pattern, lines[at - 1], re.I)
    if found is None:
        raise ValueError(f"{path}, line {at}: must be as in {example} (found {lines[at - 1][:80]!r})")
    return float(found[1])
