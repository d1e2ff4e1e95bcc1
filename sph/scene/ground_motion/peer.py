"""Records of the PEER NGA data bases (``.AT2``): three lines of text, NPTS and DT, samples in g, mostly five a line.

The third line names the quantity and its unit, "ACCELERATION TIME SERIES IN UNITS OF G"; the fourth reads "NPTS= 5372, DT= .0100 SEC"
in newer files and "5372 .0100 NPTS, DT" in older ones.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction, direction_of
from sph.scene.ground_motion.text import check_head, read_lines, samples
from sph.scene.ground_motion.units import ACCELERATIONS, Unit, size_of, unit_in
from sph.scene.units import factor_in

HEAD, WIDTH = 4, 15
"""Lines before the samples; columns of a sample (Fortran 5E15.7)."""
OTHERS = re.compile(r"VELOC|\bVEL\b|DISPL|\bDISP?\b|SPECTR|PSEUDO|FOURIER|RESPONSE|\bP?S[AVD]\b|PERIOD", re.I)
"""What a title names that is no accelerogram."""
OTHER_HISTORIES = {".vt2": "velocity", ".dt2": "displacement"}
"""Endings of files that hold the same record as another quantity."""
NUMBER = r"([-+.\dEeDd]+)"


def read_at2(path: Path | str, unit: Unit | None = None, wanted: Direction = "horizontal") -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    head = lines[HEAD - 1] if len(lines) >= HEAD else ""
    found = re.search(rf"NPTS\s*=\s*{NUMBER}\s*,?\s*DT\s*=\s*{NUMBER}(?![-+.\dED]|\s*[MU]S)", head, re.I)
    found = found or re.match(rf"\s*{NUMBER}\s+{NUMBER}\s+NPTS\s*,\s*DT", head, re.I)
    try:
        count, interval = int(found[1]), float(found[2])  # type: ignore[index]
    except (TypeError, ValueError):
        raise ValueError(
            f"{path}, line {HEAD}: must read 'NPTS= 5372, DT= .0100 SEC' or '5372 .0100 NPTS, DT' (found {head[:80]!r})"
        ) from None
    check_head(path, count, interval)
    title = lines[HEAD - 2]
    if OTHERS.search(title):
        raise ValueError(
            f"{path}, line {HEAD - 1}: must be a record of acceleration over time, and neither a spectrum nor velocity nor displacement "
            f"(found {title.strip()[:80]!r}); name the .AT2 file of the accelerogram"
        )
    component = re.split(r"[,\s]+", lines[1].strip(", "))[-1]
    said = direction_of(re.sub(r"(?<=\w)\d$", "", component))
    check_direction(f"{path}, line 2: its component {component!r}", said, wanted)
    words = re.search(r"UNITS?\s+OF\s+([^,]+)", title, re.I)
    stated = unit_in(words[1] if words else title)
    if words is not None and stated is None or factor_in(title, ACCELERATIONS):
        shown = (words[1] if words and stated is None else title).strip()[:80]
        raise ValueError(
            f"{path}, line {HEAD - 1}: {shown!r} is no unit of acceleration that is known here; convert the samples, without a factor"
        )
    acceleration = samples(path, lines, HEAD, WIDTH, size_of(path, stated, unit), count)
    return interval * np.arange(count), acceleration
