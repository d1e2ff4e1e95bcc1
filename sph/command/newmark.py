"""What ``sph newmark`` computes and prints: the sliding block under one ground motion."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.gravity import GRAVITY
from sph.ground_motion import read_motion
from sph.stability.newmark import sliding_block


class Answer(NamedTuple):
    """Numbers of a block in SI units; the names are those of ``sph newmark --json``."""

    peak_acceleration: float  # of the ground, m/s2; negative where it drives the block upslope
    yield_acceleration: float  # m/s2
    upslope_yield_acceleration: float | None  # m/s2; None: the block slides downslope only
    ratio: float  # yield acceleration over the absolute peak
    permanent_displacement: float  # m, positive downslope
    sliding_time: float  # s


def slide(path: Path, overrides: Mapping[str, Any], down: float, up: float | None, peak: float | None) -> Answer:
    """Slide a block with the yield accelerations ``down`` and ``up`` (m/s2) on the motion in a file, scaled to a peak (m/s2).

    Raises ValueError for a file that is no motion, and where the ground stands still.
    """
    motion = read_motion(path, overrides)
    if motion.peak == 0:
        raise ValueError(f"{path}: the ground stands still, and a sliding block needs a motion")
    if peak is not None:
        motion = motion.scaled(peak)
    block = sliding_block(motion.time, motion.acceleration, down, up)
    extreme = float(motion.acceleration[np.abs(motion.acceleration).argmax()])
    return Answer(extreme, down, up, down / abs(extreme), block.permanent, block.sliding_time)


def lines(answer: Answer) -> list[str]:
    """Aligned lines of text for an answer."""
    peak, up = answer.peak_acceleration, answer.upslope_yield_acceleration
    rows = [
        ("peak ground acceleration", f"{_both(abs(peak))}, driving {'downslope' if peak > 0 else 'upslope'}"),
        ("yield acceleration", f"{_both(answer.yield_acceleration)}, upslope {'unlimited' if up is None else _both(up)}"),
        ("yield over peak", f"{answer.ratio:.4g}"),
        ("permanent displacement", f"{answer.permanent_displacement:.4g} m"),
        ("time in sliding", f"{answer.sliding_time:.4g} s"),
    ]
    width = max(len(label) for label, _ in rows)
    return [f"{label:<{width}}  {text}" for label, text in rows]


def _both(acceleration: float) -> str:
    return f"{acceleration:.4g} m/s2 ({acceleration / GRAVITY:.3g} g)"
