"""Units of acceleration as records name them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from sph.gravity import GRAVITY

Unit = Literal["m/s2", "cm/s2", "gal", "g"]
SIZES: dict[str, float] = {"m/s2": 1.0, "cm/s2": 0.01, "gal": 0.01, "g": GRAVITY}
"""One of each, m/s2."""


def size(name: str) -> float | None:
    """A unit in m/s2, however it is written: 'cm/sec/sec', 'm/s^2', 'G', 'Gal'; None for no unit."""
    plain = re.sub(r"[\s*^{}.]", "", name.lower()).replace("²", "2").replace("sec", "s")
    plain = re.sub(r"(?<=/s)/s$", "2", plain).replace("ms-2", "m/s2").removesuffix("s" if plain == "gals" else "\0")
    return SIZES.get(plain)


def size_of(path: Path | str, stated: float | None, unit: Unit | None) -> float:
    """The unit (m/s2) of a record that states one or not; ``unit`` is the user's word where it does not, and must agree where it does."""
    if stated is None:
        if unit is None:
            raise ValueError(f"{path}: does not say its unit; state it by unit: {', '.join(SIZES)}")
        return SIZES[unit]
    if unit is not None and stated != SIZES[unit]:
        name = next(name for name, value in SIZES.items() if value == stated)
        raise ValueError(f"{path}: is in {name} by its own words, unit: {unit} contradicts it; leave unit out")
    return stated
