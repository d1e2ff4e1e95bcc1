"""Columns of a record by their names: which hold the time, the horizontal and the vertical acceleration."""

from __future__ import annotations

import re
from typing import NamedTuple

from sph.scene.cells import counts_rows, listed, words
from sph.scene.ground_motion.direction import direction_of
from sph.scene.ground_motion.units import ACCELERATIONS
from sph.scene.units import SECONDS, named

TIME = re.compile(r"t|time|times|zeit|temps|tiempo|tempo|elapsed")
LONGITUDINAL = re.compile(r"l|long|longitudinal")
"""Beside it V is vertical and no velocity, and T without a unit, where it has none either, is transverse and no time."""
ACCELERATION = re.compile(r"a|[xy]|a[xyzhvg]|acc.*|beschl.*|acel.*")
OTHERS = {
    "velocity": re.compile(r"vel.*|v|v[xyz]|speed|geschw.*|vit.*"),
    "displacement": re.compile(r"dis.*|d|d[xyz]|depl.*|pos.*"),
    "spectrum": re.compile(r"spectr.*|pseudo|p?s[avd]|period.*|freq.*|fourier.*|response"),
    "quantity that is not read": re.compile(r"press.*|force|stress|strain|arias|husid|intensity|jerk|temp.*|depth|angle|rot.*|gyro.*"),
}
REMEDY = "name the columns by what they hold, as in 'time (s),acceleration (m/s2)', and leave the others out or name them too"


class Columns(NamedTuple):
    """Places of a record's columns."""

    time: int
    horizontal: int | None
    vertical: int | None


def quantity(name: str) -> str | None:
    """What a name states: index, time, acceleration or a quantity of ``OTHERS``; None where it states none."""
    said = words(name)
    if counts_rows(name):
        return "index"
    if any(map(TIME.fullmatch, said)) and not (said == ["t"] and _in_acceleration(name)):
        return "time"
    other = next((what for what, pattern in OTHERS.items() if any(map(pattern.fullmatch, said))), None)
    if other == "spectrum" or not any(map(ACCELERATION.fullmatch, said)) and other:
        return other
    if any(map(ACCELERATION.fullmatch, said)) or direction_of(name) or _in_acceleration(name):
        return "acceleration"
    return "time" if any(size for size, _ in named(name, SECONDS)) else None


def _in_acceleration(name: str) -> bool:
    return any(size for size, _ in named(name, ACCELERATIONS))


def columns_of(names: list[str]) -> Columns:
    """Places of time and accelerations; ValueError where the names leave more than one choice, or none."""
    beside = [name for name in names if LONGITUDINAL.fullmatch("".join(words(name)))]
    sides = ("l", "v") if any(_in_acceleration(name) for name in beside) else ("l", "t", "v") if beside else ()
    kinds = ["acceleration" if "".join(words(name)) in sides else quantity(name) for name in names]
    times = [place for place, kind in enumerate(kinds) if kind == "time"]
    if len(times) != 1:
        raise ValueError(f"{listed(names)} name {len(times) or 'no'} columns of time, whose unit must be s or ms; {REMEDY}")
    found = [place for place, kind in enumerate(kinds) if kind == "acceleration"]
    if not found:
        found = [place for place, kind in enumerate(kinds) if kind not in ("time", "index")]
        for place in found:
            if kinds[place] or len(found) > 1:
                what = kinds[place] or "quantity that is not known"
                raise ValueError(f"{names[place]!r} is no acceleration but a {what} (columns {listed(names)}); {REMEDY}")
    vertical = [place for place in found if direction_of(names[place]) == "vertical"]
    horizontal = [place for place in found if place not in vertical]
    if not vertical and len(horizontal) == 2 and [_axis(names[place]) for place in horizontal] == ["x", "y"]:
        horizontal, vertical = horizontal[:1], horizontal[1:]
    for what, places in (("horizontal", horizontal), ("vertical", vertical)):
        if len(places) > 1:
            raise ValueError(
                f"{listed(names[place] for place in places)} may each be the {what} acceleration; leave one of them, "
                "and put a second horizontal component into a file of its own"
            )
    if not found:
        raise ValueError(f"{listed(names)} name no column of acceleration; {REMEDY}")
    return Columns(times[0], next(iter(horizontal), None), next(iter(vertical), None))


def velocity_of(names: list[str]) -> Columns | None:
    """Places of time and horizontal velocity where columns hold one velocity and no acceleration; None otherwise."""
    kinds = [quantity(name) for name in names]
    if "acceleration" in kinds or kinds.count("velocity") != 1 or kinds.count("time") != 1:
        return None
    place = kinds.index("velocity")
    return None if direction_of(names[place]) == "vertical" else Columns(kinds.index("time"), place, None)


def _axis(name: str) -> str:
    """x or y where a name is that of an axis ('ax', 'acc y'): y points up beside x."""
    return next((word[-1] for word in words(name) if re.fullmatch(r"(a|acc?)?[xy]", word)), "")
