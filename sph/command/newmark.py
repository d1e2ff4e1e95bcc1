"""What ``sph newmark`` computes and prints: the sliding block under one ground motion."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.scene.ground_motion import SCENES, GroundMotion, motion_of, read_motion
from sph.scene.ground_motion.record import Record
from sph.scene.motion import ConstantAcceleration
from sph.scene.schema import load_scene
from sph.stability.newmark import sliding_block
from sph.study.findings import cut_off, drifting, implausible, in_both, of_record


class Answer(NamedTuple):
    """Numbers of a block in SI units; the names are those of ``sph newmark --json``."""

    peak_acceleration: float  # of the ground, m/s2; negative where it drives the block upslope
    yield_acceleration: float  # m/s2
    upslope_yield_acceleration: float | None  # m/s2; None: the block slides downslope only
    ratio: float  # yield acceleration over the absolute peak
    permanent_displacement: float  # m, positive downslope
    sliding_time: float  # s


def slide(path: Path, overrides: Mapping[str, Any], down: float, up: float | None, peak: float | None) -> tuple[Answer, list[str]]:
    """Slide a block with the yield accelerations ``down`` and ``up`` (m/s2) on the motion in a file, scaled to a peak (m/s2).

    Also returns the diagnostics of the motion, a sentence each.  Raises ValueError for a file that is no motion, for a load that stays,
    and where the ground stands still.
    """
    motion, heed = _motion(path, overrides)
    if motion.peak == 0:
        raise ValueError(f"{path}: the ground stands still, and a sliding block needs a motion")
    if peak is not None:
        motion = motion.scaled(peak)
    heed += [
        diagnostic.sentence() for diagnostic in implausible({"horizontal": motion.acceleration}, "--scale-to, or the unit of the record")
    ]
    block = sliding_block(motion.time, motion.acceleration, down, up)
    extreme = float(motion.acceleration[np.abs(motion.acceleration).argmax()])
    return Answer(extreme, down, up, down / abs(extreme), block.permanent, block.sliding_time), heed


def _motion(path: Path, overrides: Mapping[str, Any]) -> tuple[GroundMotion, list[str]]:
    if path.suffix.lower() not in SCENES:
        motion = read_motion(path, overrides)
        return motion, [diagnostic.sentence() for diagnostic in drifting(motion, "the record, or motion.baseline of a scene with it")]
    scene = load_scene(path, overrides)
    if isinstance(scene.motion, ConstantAcceleration):
        raise ValueError(f"{path}: motion.kind: constant is a load that stays, and a sliding block comes to rest after a motion that ends")
    heed = [diagnostic.sentence() for diagnostic in cut_off(scene) + of_record(scene)]
    if isinstance(scene.motion, Record) and scene.motion.vertical is not None:
        heed.append("motion.vertical does not act on the sliding block, which the horizontal component alone drives")
    return motion_of(scene), heed


def lines(answer: Answer) -> list[str]:
    """Aligned lines of text for an answer."""
    peak, up = answer.peak_acceleration, answer.upslope_yield_acceleration
    rows = [
        ("peak ground acceleration", f"{in_both(abs(peak))}, driving {'downslope' if peak > 0 else 'upslope'}"),
        ("yield acceleration", f"{in_both(answer.yield_acceleration)}, upslope {'unlimited' if up is None else in_both(up)}"),
        ("yield over peak", f"{answer.ratio:.4g}"),
        ("permanent displacement", f"{answer.permanent_displacement:.4g} m"),
        ("time in sliding", f"{answer.sliding_time:.4g} s"),
    ]
    width = max(len(label) for label, _ in rows)
    return [f"{label:<{width}}  {text}" for label, text in rows]
