"""Records in COSMOS format (``.v1``, ``.v2``, ``.v1c``, ``.v2c``), in which CESMD and others hand them out: one component.

COSMOS Strong-Motion Data Format, version 1.20 (2001): lines of text, the first of which says "Corrected acceleration"; then blocks, each
below a line with the number of its values and their Fortran format: integers, reals, comments, and the samples with their unit.  The
62nd real is the interval of the samples in ms; where it is not known, the 34th, that of the recorder.  Histories of
velocity and displacement behind the acceleration are left out.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from sph.scene.ground_motion.text import check_head, fields, read_lines, samples
from sph.scene.ground_motion.units import Unit, size_of, unit_in

FIRST = re.compile(r"\s*(un)?corrected\s+acceleration", re.I)
FORMAT = r"format\s*=\s*\(\s*(\d*)\s*P?\s*[EFGI](\d+)"
REALS = re.compile(rf"\s*(\d+)\s+real-header\s+values\s+follow\s+on\s+(\d+)\s+lines?\s*,\s*{FORMAT}", re.I)
SAMPLES = re.compile(rf"\s*(\d+)\s+acceleration\s+pts.*?units\s*=\s*(.+?)\s*,\s*{FORMAT}", re.I)
INTERVAL, RECORDED_INTERVAL = 61, 33
"""Indices of the reals with the interval of the samples and that of the recorder, ms."""


def read_cosmos(path: Path | str, unit: Unit | None = None) -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and acceleration (n,) in m/s2; ValueError with file and line, where there is one."""
    lines = read_lines(path)
    if not FIRST.match(lines[0]):
        raise ValueError(
            f"{path}, line 1: must begin with 'Corrected acceleration' or 'Uncorrected acceleration' (found {lines[0][:80]!r})"
        )
    heads = [index for index, line in enumerate(lines) if REALS.match(line)]
    blocks = [index for index, line in enumerate(lines) if SAMPLES.match(line)]
    if not heads or not blocks or heads[0] > blocks[0]:
        raise ValueError(f"{path}: is not in COSMOS format: it has no line 'n Real-header values follow' above a line 'n acceleration pts'")
    if len(blocks) > 1:
        at = ", ".join(str(index + 1) for index in blocks)
        raise ValueError(f"{path}: holds {len(blocks)} components (lines {at}), must hold one; put each into a file of its own")
    interval = _interval(path, lines, heads[0])
    found = SAMPLES.match(lines[blocks[0]])
    assert found is not None
    count, words, each, width = int(found[1]), re.sub(r"\(\s*\d+\s*\)", "", found[2]), int(found[3] or 1), int(found[4])
    stated = unit_in(words)
    if stated is None:
        raise ValueError(f"{path}, line {blocks[0] + 1}: {words.strip()!r} is no unit of acceleration that is known here")
    check_head(path, count, interval)
    last = blocks[0] + 1 + math.ceil(count / max(each, 1))
    acceleration = samples(path, lines[:last], blocks[0] + 1, width, size_of(path, stated, unit), count)
    return interval * np.arange(count), acceleration


def _interval(path: Path | str, lines: list[str], head: int) -> float:
    """Interval of the samples (s) from the reals below a line; ValueError where they do not say it."""
    found = REALS.match(lines[head])
    assert found is not None
    reals = fields(path, lines, head + 1, min(int(found[2]), len(lines) - head - 1), int(found[4]))
    known = [reals[index] for index in (INTERVAL, RECORDED_INTERVAL) if index < len(reals) and reals[index] > 0]
    if not known:
        raise ValueError(
            f"{path}, lines {head + 2}-{head + 1 + int(found[2])}: must hold the interval of the samples in ms as 62nd or 34th real"
        )
    return float(f"{1e-3 * known[0]:.9g}")
