"""Lines of a section that follow from a few numbers: a plain slope, what lies at a depth below the ground, a berm before the toe."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sph.scene.ground_line import GroundLine
from sph.scene.places import Point

BERM_SIDE = 1.5
"""Run over rise of the outer side of a berm."""
STEP = 0.01
"""Width that a vertical step of the ground gets where a line may not be vertical, m."""
SAMPLES = 5000
"""Points at which the foot of a berm is sought."""


def plain_slope(height: float, angle: float, behind: float, ahead: float) -> list[Point]:
    """A slope (m, degree) that falls to the right between level ground, with its toe at (0, 0) m."""
    run = height / math.tan(math.radians(angle))
    return [(-run - behind, height), (-run, height), (0.0, 0.0), (ahead, 0.0)]


def at_depth(points: Sequence[Point], depth: float) -> list[Point]:
    """A line at a depth (m) below the ground, x increasing, without vertical steps."""
    x, y = np.array(points if points[0][0] <= points[-1][0] else points[::-1]).T
    for number in np.flatnonzero(np.diff(x) <= 0.0):
        x[number + 1] = x[number] + STEP
    return list(zip(x.tolist(), (y - depth).tolist(), strict=True))


class Berm(NamedTuple):
    """A fill on the foot of a slope."""

    ground: list[Point]  # with it, m
    fill: list[Point]  # outline, m
    top: float  # width of its top, m
    back: float  # how far its top lies behind the toe, m
    foot: float  # how far it reaches beyond the toe, m


def berm(line: GroundLine, height: float) -> Berm:
    """A berm of a height (m) above the toe: level from the face of the slope outwards, then falling 1 in ``BERM_SIDE``.

    Its top ends above the face, half a height behind the toe, and is at least half a height wide.  ValueError where the ground before the
    toe is too short for its foot.
    """
    x, y = (np.array(side) for side in line.surface)
    toe, low = line.toe
    level = low + height
    first = next(k for k in range(1, x.size) if x[k] > toe and y[k] >= level)
    inner = float(np.interp(level, y[first - 1 : first + 1], x[first - 1 : first + 1]))
    edge = min(toe, inner - height) + 0.5 * height
    out = np.linspace(edge, 0.0, SAMPLES)
    above = level - (edge - out) / BERM_SIDE - line.ground(out)
    after = int(np.argmax(above <= 0.0))
    if not above[after] <= 0.0:
        raise ValueError(f"the ground ends {toe:.4g} m beyond the toe, before the foot of a berm {height:g} m high")
    foot = float(np.interp(0.0, above[[after, after - 1]], out[[after, after - 1]]))
    base = [
        (foot, float(line.ground(np.array([foot]))[0])),
        *((a, b) for a, b in zip(x, y, strict=True) if foot < a < inner),
        (inner, level),
    ]
    kept = [*((a, b) for a, b in zip(x, y, strict=True) if a < foot), base[0], (edge, level), base[-1]]
    kept += [(a, b) for a, b in zip(x, y, strict=True) if a > inner]

    def surveyed(corners: Sequence[Point]) -> list[Point]:
        return [tuple(round(float(value), 4) for value in line.in_survey(a, b)) for a, b in corners]  # type: ignore[misc]

    return Berm(surveyed(kept)[:: line.direction], surveyed([(edge, level), *base[::-1]]), inner - edge, inner - toe, toe - foot)
