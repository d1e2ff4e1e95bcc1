"""Units as records name them: of acceleration, and of velocity where a record holds that."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

import numpy as np

from sph.scene.ground_motion.text import MAX_ACCELERATION
from sph.scene.units import GRAVITY, LENGTH, SIZES, Units, factor_in, named, unit_of

Unit = Literal["m/s2", "cm/s2", "gal", "g", "m/s", "cm/s"]
SPEEDS: dict[str, float] = {"m/s": 1.0, "cm/s": 0.01}
"""Units that say that the samples are velocities, m/s."""
SPELLINGS = {"m/s2": ("ms2", "mss", "mps2"), "cm/s2": ("cms2", "cmss", "cmps2"), "gal": ("gal", "gals"), "g": ("g",)}
ACCELERATIONS = Units(
    {spelling: SIZES[unit] for unit, spellings in SPELLINGS.items() for spelling in spellings} | {"%g": 0.01 * GRAVITY},
    rf"{LENGTH}p?s[s2]?|[fi]ps[s2]?|[kcdmnu]?m|ft|ag|[kcdmnu]g|g[0ns]|[kmnu]gals?|%|°|counts?|cnts?|bits?|digits?|volts?|[mu]v|hz|(?:rad|deg|°)s[s2]?",
    ", ".join((*SIZES, "%g")),
)
"""'a_g' is not understood: it is the ground's acceleration in Eurocode 8, or one in g."""


VELOCITIES = Units({"ms": 1.0, "mps": 1.0, "cms": 0.01, "cmps": 0.01}, ACCELERATIONS.others, ", ".join(SPEEDS))


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
    if unit in SPEEDS:
        raise ValueError(
            f"{path}: holds accelerations by its own words or its format, and unit: {unit} is that of velocities; leave it out"
        )
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


def speed_of(path: Path | str, stated: float | None, unit: Unit | None) -> float:
    """The unit (m/s) of a record of velocity, as ``size_of``."""
    if unit is not None and unit not in SPEEDS or stated is None and unit is None:
        raise ValueError(
            f"{path}: holds velocities by its own words, found unit: {unit}; state theirs by unit: {', '.join(SPEEDS)} "
            "(motion.unit in a scene, --unit of a command), or name the file of accelerations"
        )
    size = stated if unit is None else SPEEDS[unit]
    assert size is not None
    if stated is not None and stated != size:
        raise ValueError(f"{path}: is in another unit by its own words than unit: {unit}; leave unit out")
    return size


def differentiated(path: Path | str, time: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Acceleration (n,) in m/s2 of velocities (n,) in m/s at times (n,) in s: central differences.  ValueError where it is too large."""
    acceleration: np.ndarray = np.gradient(velocity, time)
    if np.abs(acceleration).max() > MAX_ACCELERATION:
        raise ValueError(f"{path}: its velocities are those of more than {MAX_ACCELERATION:g} m/s2; is their unit right?")
    return acceleration
