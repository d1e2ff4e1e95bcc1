"""What ``sph newmark`` computes and prints: the sliding block under one ground motion, in either direction."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.checks.finding import Finding, finding
from sph.checks.messages import line
from sph.checks.motion import cut_off, drifting, implausible, sampled, sparse
from sph.command.motion import CURE, laid_over, read_treated
from sph.command.terminal import aligned, say
from sph.scene.ground_motion import SCENES, GroundMotion, check_record
from sph.scene.ground_motion.record import Record
from sph.scene.loading import motion_of
from sph.scene.motion import ConstantAcceleration
from sph.scene.names import check_known
from sph.scene.schema import load_scene
from sph.scene.strict_json import to_json
from sph.scene.units import in_both
from sph.stability.newmark import SlidingBlock, sliding_block

RECORDED, TURNED, BOTH = "recorded", "turned", "both"
DIRECTIONS = (RECORDED, TURNED, BOTH)
"""Polarity of the motion: as it is, reversed, or the one of the two that drives the block further."""
MATTERS = 0.05
"""Relative difference of two displacements from which on it is told what makes it."""


class Answer(NamedTuple):
    """Numbers of a block in SI units; the names are those of ``sph newmark --json``."""

    peak_acceleration: float  # of the ground, m/s2; negative where it drives the block upslope
    yield_acceleration: float  # m/s2
    upslope_yield_acceleration: float | None  # m/s2; None: the block slides downslope only
    ratio: float  # yield acceleration over the absolute peak
    permanent_displacement: float  # m, positive downslope
    sliding_time: float  # s
    direction: str  # of the motion: recorded or turned
    other_displacement: float | None  # permanent, in the other direction, where both were asked for, m


def newmark(
    path: Path,
    changes: Mapping[str, Any],
    down: float,
    up: float | None,
    peak: float | None,
    treatment: Mapping[str, Any],
    direction: str,
    as_json: bool,
) -> str:
    """The displacement of a block, as ``slide``, in words or for machines."""
    check_known("--direction", [direction], DIRECTIONS)
    answer, heed = slide(path, changes, down, up, peak, treatment, direction)
    say(*(line(each) for each in heed))
    return to_json(answer._asdict(), indent=1) if as_json else lines(answer)


def slide(
    path: Path,
    overrides: Mapping[str, Any],
    down: float,
    up: float | None,
    peak: float | None,
    treatment: Mapping[str, Any] | None = None,
    direction: str = RECORDED,
) -> tuple[Answer, list[Finding]]:
    """Slide a block with the yield accelerations ``down`` and ``up`` (m/s2) on the motion in a file, scaled to a peak (m/s2).

    ``treatment`` is that of ``sph.command.motion.read_treated``, ``direction`` one of ``DIRECTIONS``.  Also returns the findings on the
    motion: an offset and a direction are told where the displacement rests on them.  Raises ValueError for a file that is not a motion,
    for a sustained load, and where the ground does not move.
    """
    motion, heed, recorded = _motion(path, overrides, treatment or {})
    if motion.peak == 0:
        raise ValueError(f"{path}: the ground does not move; a sliding block needs a ground motion")
    if peak is not None:
        motion = motion.scaled(peak)

    def block(sign: float, offset: float = 0.0) -> SlidingBlock:
        return sliding_block(motion.time, sign * (motion.acceleration - offset), down, up)

    blocks = {RECORDED: block(1.0), TURNED: block(-1.0)}
    chosen = max(blocks, key=lambda name: abs(blocks[name].permanent)) if direction == BOTH else direction
    other = next(name for name in blocks if name != chosen)
    moved, sign = blocks[chosen], 1.0 if chosen == RECORDED else -1.0
    if recorded:
        mean = float(np.trapezoid(motion.acceleration, motion.time)) / float(motion.time[-1] - motion.time[0])
        without = block(sign, mean).permanent
        if _differ(moved.permanent, without):
            heed = [each for each in heed if each.code not in ("record-offset", "record-drift")]
            heed.append(finding("record-offset", *CURE, slip=moved.permanent, slip_without=without, mean=mean, difference=MATTERS))
        if direction != BOTH and abs(blocks[other].permanent) > abs(moved.permanent) and _differ(moved.permanent, blocks[other].permanent):
            slips = {"reversed": blocks[other].permanent, "as_recorded": moved.permanent}
            heed.append(finding("record-polarity", "--direction both", subject="", **slips))
    heed += implausible({"horizontal": motion.acceleration}, "--scale-to", "--unit")
    extreme = sign * float(motion.acceleration[np.abs(motion.acceleration).argmax()])
    beside = blocks[other].permanent if direction == BOTH else None
    return Answer(extreme, down, up, down / abs(extreme), moved.permanent, moved.sliding_time, chosen, beside), heed


def _differ(one: float, other: float) -> bool:
    return abs(one - other) > MATTERS * max(abs(one), abs(other))


def _motion(path: Path, overrides: Mapping[str, Any], treatment: Mapping[str, Any]) -> tuple[GroundMotion, list[Finding], bool]:
    """The motion in a file, the findings on it, and whether it was recorded."""
    if path.suffix.lower() not in SCENES:
        check_record(path, SCENES)
        if overrides:
            raise ValueError(f"{path}: is a record, in which --set has no keys to change (found {', '.join(overrides)})")
        time, columns = read_treated(path, treatment)
        motion, recorded, vertical = GroundMotion(time, columns[0]), True, len(columns) > 1
        heed = sparse(float(np.diff(time).max()))
    else:
        scene = load_scene(path, laid_over(path, overrides, treatment))
        if isinstance(scene.motion, ConstantAcceleration):
            raise ValueError(
                f"{path}: motion.kind: constant is a sustained load, under which a sliding block never stops; use a motion that ends"
            )
        motion, heed, recorded = motion_of(scene), cut_off(scene) + sampled(scene), isinstance(scene.motion, Record)
        vertical = isinstance(scene.motion, Record) and scene.motion.vertical is not None
    if recorded:
        heed += drifting(motion, *CURE)
    if vertical:
        heed.append(finding("vertical-unused"))
    return motion, heed, recorded


def lines(answer: Answer) -> str:
    """Aligned lines of text for an answer."""
    peak, up = answer.peak_acceleration, answer.upslope_yield_acceleration
    rows = [
        ("peak ground acceleration", f"{in_both(abs(peak))}, driving {'downslope' if peak > 0 else 'upslope'}"),
        ("yield acceleration", f"{in_both(answer.yield_acceleration)}, upslope {'unlimited' if up is None else in_both(up)}"),
        ("yield over peak", f"{answer.ratio:.4g}"),
        ("permanent displacement", f"{answer.permanent_displacement:.4g} m"),
        ("time sliding", f"{answer.sliding_time:.4g} s"),
    ]
    if answer.direction == TURNED or answer.other_displacement is not None:
        beside = "" if answer.other_displacement is None else f", the larger; {answer.other_displacement:.4g} m with the opposite polarity"
        rows.append(("polarity", ("as recorded" if answer.direction == RECORDED else "reversed") + beside))
    return aligned(rows)
