"""Units of acceleration as records name them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

from sph.scene.units import GRAVITY, LENGTH, SIZES, Units, factor_in, named, unit_of

Unit = Literal["m/s2", "cm/s2", "gal", "g"]
SPELLINGS = {"m/s2": ("ms2", "mss", "mps2"), "cm/s2": ("cms2", "cmss", "cmps2"), "gal": ("gal", "gals"), "g": ("g",)}
ACCELERATIONS = Units(
    {spelling: SIZES[unit] for unit, spellings in SPELLINGS.items() for spelling in spellings} | {"%g": 0.01 * GRAVITY},
    rf"{LENGTH}p?s[s2]?|[fi]ps[s2]?|[kcdmnu]?m|ft|ag|[kcdmnu]g|g[0ns]|[kmnu]gals?|%|°|counts?|cnts?|bits?|digits?|volts?|[mu]v|hz|(?:rad|deg|°)s[s2]?",
    ", ".join((*SIZES, "%g")),
)
"""'a_g' is not understood: it is the ground's acceleration in Eurocode 8, or one in g."""


def unit_of_column(name: str) -> float | None:
    """Unit (m/s2) in the name of a column of accelerations; None without one.  ValueError as ``unit_of``, and for other quantities."""
    if re.search(r"(?<![a-z])(vel|disp)", name, re.I):
        raise ValueError(f"{name.strip()!r} is no acceleration")
    return unit_of(name, ACCELERATIONS)


def unit_in(text: str) -> float | None:
    """Unit (m/s2) that a text names; None unless it is understood, the only one and without a factor."""
    sizes = {None if factor or factor_in(text, ACCELERATIONS) else size for size, factor in named(text, ACCELERATIONS)}
    return sizes.pop() if len(sizes) == 1 else None


def size_of(path: Path | str, stated: float | None, unit: Unit | None) -> float:
    """The unit (m/s2) of a record that states one or not; ``unit`` is the user's word where it does not, and must agree where it does."""
    if stated is None:
        if unit is None:
            raise ValueError(
                f"{path}: does not say its unit; write it there, as in 'ax (cm/s2)', or state it by unit: {', '.join(SIZES)} "
                "(motion.unit in a scene, --unit of a command)"
            )
        return SIZES[unit]
    if unit is not None and stated != SIZES[unit]:
        name = next((name for name, value in SIZES.items() if value == stated), f"{stated:g} m/s2")
        raise ValueError(f"{path}: is in {name} by its own words, unit: {unit} contradicts it; leave unit out")
    return stated
