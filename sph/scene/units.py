"""Units, of an acceleration and in the names of a table's columns: understood, or refused.

A unit stands in brackets ('ACC (gal) NS', 't [ms]') or as words of its own ('acc_g', 'acc cm/s2', 'AccG'); letters within a word are
none ('gx', 'NS', 'distance').
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator

GRAVITY = 9.81
"""Gravitational acceleration, m/s2."""
SIZES: dict[str, float] = {"m/s2": 1.0, "cm/s2": 0.01, "gal": 0.01, "g": GRAVITY}
"""One of each unit of acceleration, m/s2."""


def acceleration(value: Any) -> Any:
    """A text as an acceleration, m/s2: ``0.4g``, ``3.9 m/s2``, ``390 gal`` or a number alone; what is no text as it is.

    ValueError for a text that is none.
    """
    if not isinstance(value, str):
        return value
    number, unit = re.fullmatch(r"\s*([-+.\deE]*(?<![eE]))\s*(.*?)\s*", value, re.S).groups()  # type: ignore[union-attr]
    size = SIZES.get(unicodedata.normalize("NFKC", unit).lower().replace("^", "") or "m/s2")
    try:
        if size is not None:
            return float(number) * size
    except ValueError:
        pass
    raise ValueError("must be an acceleration: a number in m/s2, or one with its unit, as 0.4g, 3.9 m/s2 or 390 gal")


def in_both(value: float, error: float | None = None) -> str:
    """An acceleration (m/s2) in m/s2 and g, as every command, table and page says one; with its error where that is given."""
    if error is None:
        return f"{value:.4g} m/s2 ({value / GRAVITY:.3g} g)"
    return f"{value:.3g} ± {error:.2g} m/s2 ({value / GRAVITY:.3g} ± {error / GRAVITY:.2g} g)"


def beside_g(value: str, unit: str = "m/s2") -> str:
    """A number as written below a head that says its unit: of an acceleration in m/s2 with the same in g in brackets."""
    try:
        return f"{value} ({float(value) / GRAVITY:.3g} g)" if unit == "m/s2" else value
    except ValueError:
        return value


Acceleration = Annotated[float, BeforeValidator(acceleration, json_schema_input_type=float | str)]
"""Type of a key that holds an acceleration: a number in m/s2 or a text with a unit, kept in m/s2."""
LONGEST = 3
"""Most words of a unit: 'cm s -2'."""
SAME = (
    ("milli", "m"),
    ("micro|μ", "u"),
    ("centi", "c"),
    ("kilo", "k"),
    ("sec(ond)?s?", "s"),
    ("met(er|re)s?", "m"),
    ("feet|foot", "ft"),
    (r"(?<![a-z])per(?![a-z])", " "),
    ("squared", "2"),
)
"""Spellings, and what they are read as."""
LENGTH = "(?:[kcdmnu]?m|ft|inch(?:es)?|in|yd)"
"""Units of length, for patterns."""


class Units(NamedTuple):
    """Units of a quantity, spelt as one word: 'ms2', 'cmss'."""

    known: Mapping[str, float]
    """size in SI by spelling"""
    others: str
    """pattern of units that are not understood, and of what may be one"""
    allowed: str
    """what a user may write"""


SECONDS = Units({"s": 1.0, "ms": 1e-3}, "[nu]s|m|mins?|minutes?|h|hrs?|hours?|d|days?|samples?|counts?|hz", "s or ms")


def unit_of(name: str, units: Units) -> float | None:
    """Size in SI of the unit that the name of a column holds; None without one.

    Raises ValueError for units that are not known, for two, for a number beside one, and for brackets without one.
    """
    inside = re.findall(r"[(\[{]([^()\[\]{}]*)[)\]}]", name)
    found = {None if factor else size for text in inside for size, factor in named(text, units)}
    found = found or {None if factor else size for size, factor in named(name, units)}
    size = next(iter(found), None)
    if size is None and (found or inside) or len(found) > 1:
        raise ValueError(
            f"the unit in {name.strip()[:80]!r} is not understood; it must be {units.allowed}, without a factor and best in brackets, "
            "which hold nothing else; convert numbers that are in another unit"
        )
    return size


def named(text: str, units: Units) -> Iterator[tuple[float | None, bool]]:
    """Units in a text: sizes, None for what is not understood, and whether a number stands beside them ('0.1 g', 'g/100')."""
    plain = unicodedata.normalize("NFKC", re.sub("(?<=[a-z]{2})(?=[A-Z])", " ", text)).lower()
    for spelling, same in SAME:
        plain = re.sub(spelling, same, plain)
    words = re.findall(r"\d+|[^\W\d_][^\W_]*|[%°]", plain)
    at = 0
    while at < len(words):
        for end in range(min(at + LONGEST, len(words)), at, -1):
            word = "".join(words[at:end])
            if word in units.known or re.fullmatch(units.others, word):
                yield units.known.get(word), any(beside.isdigit() for beside in words[max(at - 1, 0) : at] + words[end : end + 1])
                at = end - 1
                break
        at += 1
