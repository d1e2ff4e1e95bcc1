"""Units, of an acceleration and in the heads of a table's columns: understood, or refused.

A unit stands in brackets ('ACC (gal) NS', 't [ms]') or as words of its own ('acc_g', 'acc cm/s2', 'AccG'); letters within a word are
none ('gx', 'NS', 'distance').  A factor beside it ('Gal x 10', 'g/100', '1E-3 cm/s2') is refused, since it may be meant either way: the
numbers are multiples of the unit, or have been multiplied.  Only percent of a unit is one of its own ('%g').
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
    """An acceleration (m/s2) in m/s2 and g, as every command, table and page says one; with its error where that is given.

    One that was chosen in g, which has two digits in g and more in m/s2, is said in g first.
    """
    if error is None:
        si, g = f"{value:.4g}", f"{value / GRAVITY:.3g}"
        digits_si, digits_g = (len(number.replace(".", "").lstrip("-0")) for number in (si, g))
        return f"{g} g ({si} m/s2)" if digits_g <= 2 < digits_si else f"{si} m/s2 ({g} g)"
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
    ("(per ?cent|pct|%)( of)?", "%"),
    (r"milli(?=[-\s]*[a-z])", "m"),
    (r"micro(?=[-\s]*[a-z])|μ", "u"),
    (r"centi(?=[-\s]*[a-z])", "c"),
    (r"kilo(?=[-\s]*[a-z])", "k"),
    ("sec(ond)?s?|seg(undo)?s?(?![a-z])", "s"),
    ("met(er|re)s?", "m"),
    ("feet|foot", "ft"),
    (r"(?<![a-z])g['’]?s(?![a-z])", "g"),
    (r"(?<![a-z])per(?![a-z])", " "),
    ("squared", "2"),
)
"""Spellings, and what they are read as."""
LENGTH = "(?:[kcdmnu]?m|ft|inch(?:es)?|in|yd)"
"""Units of length, for patterns."""
WORD = re.compile(r"\d+|[^\W\d_][^\W_]*|[%°]")
BRACKETS = re.compile(r"[(\[{]([^()\[\]{}]*)[)\]}]")
MARK = "¤"
"""Stands in a head in place of its unit."""
OPERATED = re.compile(
    r"[*×·⋅∙✕]|(?<![a-z])x[\s_]*(?:\d{2,}|\d*[.,]\d|\d\s*[e^])|¤[\s_)\]}(\[{]*x[\s_]*\d|(?<![a-z\d])\d+[\s_]*x(?![a-z])"  # x 10, 10 x
    r"|/\s*\d|(?<![a-z\d])\d+\s*/|\^|(?<![a-z\d])10\s*[-+−]\s*\d"  # /100, 1/100, 10^-3
    r"|(?<![a-z\d])\d[\d.,]*\s*[ed]\s*[-+−]?\d|(?<![a-z\d])e[-+−]\d"  # 1E-3
    r"|%|‰|(?<![a-z])(?:ten|tens|tenths?|hundred\w*|thousand\w*|[mb]illion\w*|per ?mille|promille|ppm"
    r"|milli|micro|centi|kilo|deci|de[ck]a|hecto|mega|giga|log(?:10)?|ln|lg|sqrt|(?:times|factors?|scaled?)\W*(?:by\W*)?\d\w*)(?![a-z])"
)
"""What multiplies or divides the numbers of a column, or takes another function of them."""
BESIDE = re.compile(
    r"(?<![a-z\d.,])(?:\d+[.,]\d+|[.,]\d+|10+)(?![a-z\d.,])"  # a decimal or a power of ten by itself
    r"|(?<![a-z\d])\d+[\s_]*¤|¤[\s_^]*\d|¤\s*/\s*[a-z]|[(\[{]\s*[-+−±~]\s*¤"  # 2 g, g 2, g/s, (-g)
)
"""What may do so in the head of a column, if not in a line of text."""


class Units(NamedTuple):
    """Units of a quantity, spelt as one word: 'ms2', 'cmss'."""

    known: Mapping[str, float]
    """size in SI by spelling"""
    others: str
    """pattern of units that are not understood, and of what may be one"""
    allowed: str
    """what a user may write"""


SECONDS = Units({"s": 1.0, "ms": 1e-3}, "[nu]s|m|mins?|minutes?|h|hrs?|hours?|d|days?|samples?|counts?|hz", "s or ms")


class Head(NamedTuple):
    """What the head of a column says."""

    size: float | None
    """its unit in SI; None without one"""
    rest: str
    """the head in small letters without its unit"""


def read_head(name: str, units: Units) -> Head:
    """The unit in the head of a column, and what is left of the head.

    Raises ValueError for units that are not known, for two, for brackets without one, and for what may be a factor on the numbers.
    """
    plain = _plain(name)
    inside = list(BRACKETS.finditer(plain))
    spans = [(each.start(1) + start, each.start(1) + end, size) for each in inside for start, end, size in _spans(each[1], units)]
    spans = spans or list(_spans(plain, units))
    sizes = {size for *_, size in spans}
    size = next(iter(sizes), None)
    if size is None and (spans or inside) or len(sizes) > 1:
        raise ValueError(
            f"the unit in {name.strip()[:80]!r} is not understood; it must be {units.allowed}, without a factor and best in brackets, "
            "which hold nothing else; convert numbers that are in another unit"
        )
    marked = _marked(plain, spans)
    if OPERATED.search(marked) or BESIDE.search(marked):
        raise ValueError(
            f"{name.strip()[:80]!r} may state a factor on the numbers below it; convert them to {units.allowed}, and name that unit alone"
        )
    return Head(size, marked.replace(MARK, " "))


def unit_of(name: str, units: Units) -> float | None:
    """Size in SI of the unit that the name of a column holds; None without one.  ValueError as ``read_head``."""
    return read_head(name, units).size


def factor_in(text: str, units: Units) -> str | None:
    """What in a line of text multiplies or divides the numbers that it announces, as 'x 1000'; None without it."""
    plain = _plain(text)
    found = OPERATED.search(_marked(plain, list(_spans(plain, units))))
    return found[0].replace(MARK, "").strip() if found else None


def named(text: str, units: Units) -> Iterator[tuple[float | None, bool]]:
    """Units in a text: sizes, None for what is not understood, and whether a number stands beside them ('0.1 g', 'g/100')."""
    plain = _plain(text)
    for start, end, size in _spans(plain, units):
        yield size, bool(re.search(r"(?<![^\W_])\d+[\W_]*$", plain[:start]) or re.match(r"[\W_]*\d", plain[end:]))


def _plain(text: str) -> str:
    """A text in small letters, its units in one spelling."""
    plain = unicodedata.normalize("NFKC", re.sub("(?<=[a-z]{2})(?=[A-Z])", " ", text)).lower()
    for spelling, same in SAME:
        plain = re.sub(spelling, same, plain)
    return plain


def _marked(plain: str, spans: list[tuple[int, int, float | None]]) -> str:
    """A text with a mark in place of each unit."""
    for start, end, _ in reversed(spans):
        plain = plain[:start] + MARK + plain[end:]
    return plain


def _spans(plain: str, units: Units) -> Iterator[tuple[int, int, float | None]]:
    """Start, end and size of the units in a text; None for what is not understood."""
    words = list(WORD.finditer(plain))
    at = 0
    while at < len(words):
        for end in range(min(at + LONGEST, len(words)), at, -1):
            word = "".join(each[0] for each in words[at:end])
            if word in units.known or re.fullmatch(units.others, word):
                yield words[at].start(), words[end - 1].end(), units.known.get(word)
                at = end - 1
                break
        at += 1
