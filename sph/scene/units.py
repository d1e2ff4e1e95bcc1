"""Units in the names of a table's columns: understood, or refused.

A unit stands in brackets ('ACC (gal) NS', 't [ms]') or as words of its own ('acc_g', 'acc cm/s2', 'AccG'); letters within a word are
none ('gx', 'NS', 'distance').
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping
from typing import NamedTuple

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
