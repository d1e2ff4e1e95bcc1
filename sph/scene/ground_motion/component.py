"""Components of a file that holds several, and which of them is meant."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sph.scene.ground_motion.direction import Direction, check_direction


class Component(NamedTuple):
    """One component of a record."""

    name: str  # as the file has it: 'N-S', 'N10E', '90 Deg'
    direction: Direction | None  # None where the file does not say it
    interval: float  # s
    acceleration: np.ndarray  # (n,) m/s2


def chosen(path: Path | str, components: Sequence[Component], wanted: Direction, component: str | None) -> tuple[np.ndarray, ...]:
    """Time (n,) in s from 0 on and the wanted component (n,) in m/s2; behind a horizontal one the vertical, if there is one as long.

    ``component`` is the name or the number, from 1 on, of the horizontal one.  ValueError where none or more than one may be meant.
    """
    listing = ", ".join(f"{number}: {each.name}" for number, each in enumerate(components, 1))
    vertical = [each for each in components if each.direction == "vertical"]
    if wanted == "vertical":
        found = vertical
    elif component is None:
        found = [each for each in components if each.direction != "vertical"]
    else:
        found = [each for number, each in enumerate(components, 1) if _said(component) in (str(number), _said(each.name))]
        if len(found) != 1:
            raise ValueError(
                f"component: {component!r} is {'more than one' if found else 'none'} of the components in {path} ({listing}); "
                "state one by its name or its number"
            )
        check_direction(f"component: {component!r} of {path}", found[0].direction, wanted)
    if len(found) != 1:
        remedy = "state one by its name or its number: motion.component in a scene, --component of a command"
        if wanted == "vertical" or not found:
            remedy = "write the one that is meant as .csv with its times"
        raise ValueError(f"{path}: holds {len(found) or 'no'} {wanted} components ({listing}); {remedy}")
    of = found[0]
    beside = vertical if wanted == "horizontal" and len(vertical) == 1 else []
    alike = [each for each in beside if each.interval == of.interval and each.acceleration.size == of.acceleration.size]
    return of.interval * np.arange(of.acceleration.size), of.acceleration, *(each.acceleration for each in alike)


def _said(name: str) -> str:
    return " ".join(name.casefold().split())
