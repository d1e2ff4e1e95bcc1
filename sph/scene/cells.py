"""Cells of the lines of a table, and the words of its columns: ground lines and records come with any of the usual separators."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

MARKS = (";", "\t", ",")
"""Separators, the first of which in a line counts; without any, cells stand between blanks."""
COMMENT = "#"
"""Begins a line that is no row of a table."""
INDEX = {"index", "idx", "no", "nr", "i", "id", "row", "point", "pt", "sample", "samples", "unnamed"}
"""Words of a column that counts its rows."""
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(,\d{3})+")
"""A number that has either a decimal comma or separators of thousands."""
COMMA = re.compile(r"[-+]?(\d+,\d*|,\d+)([eEdD][-+]?\d+)?")
POINT = re.compile(r"[-+]?(\d[\d,]*\.\d*|\.\d+)([eEdD][-+]?\d+)?")


def cells(line: str) -> list[str]:
    """Cells of a line, without quotes; between semicolons and tabs a comma is a decimal one."""
    mark = _mark(line)
    plain = line.replace(",", ".") if mark in (";", "\t") else line
    return [cell.strip(' "') for cell in plain.strip().strip(mark or " ").split(mark)]


def names(head: str, line: str) -> list[str]:
    """Names in the head above a line of cells; between blanks a name keeps the brackets behind it: ``time (s) ax (g)``."""
    if any(mark in head + line for mark in MARKS):
        named = [name.strip(' "') for name in re.split("[,;\t]", head)]
        while len(named) > len(cells(line)) and not named[-1]:
            named.pop()
        return named
    return [name.strip(' "') for name in re.findall(r"[^\s(\[{]+(?:\s*[(\[{][^)\]}]*[)\]}]\S*)?|\S+", head)]


def words(name: str) -> list[str]:
    """Words of a column's name in small letters, those in brackets and digits left out: 'AccX_1 (g)' has 'acc' and 'x'."""
    plain = re.sub("(?<=[a-z]{2})(?=[A-Z])", " ", re.sub(r"[(\[{].*?[)\]}]", " ", unicodedata.normalize("NFKC", name)))
    return re.findall(r"[^\W\d_]+", plain.casefold())


def counts_rows(name: str) -> bool:
    """Whether a column counts the rows: it has no name, or that of an index."""
    said = words(name)
    return not re.search(r"[^\W_]", name) or bool(said) and INDEX.issuperset(said)


def listed(named: Iterable[str]) -> str:
    """Names of columns for a message."""
    return ", ".join(repr(name[:80]) for name in named)


def check_commas(lines: Iterable[str]) -> None:
    """Refuse a table between semicolons or tabs whose commas may be decimal ones or separate thousands; ValueError names the line."""
    thousands: list[str] = []
    commas: list[str] = []
    points: list[str] = []
    for at, line in enumerate(lines, 1):
        mark = _mark(line)
        if mark not in (";", "\t") or line.lstrip().startswith(COMMENT):
            continue
        for cell in (cell.strip(' "') for cell in line.split(mark)):
            form = next((each for form, each in ((THOUSANDS, thousands), (COMMA, commas), (POINT, points)) if form.fullmatch(cell)), None)
            if form is not None and not form:
                form.append(f"line {at}: {cell!r}")
    if (thousands or commas) and points or thousands and not commas:
        beside = f" beside {points[0]}" if points else ""
        raise ValueError(
            f"{(thousands or commas)[0]}{beside}: its comma may be a decimal one or separate thousands; "
            "write numbers without separators of thousands and with a decimal point, as 1234.5"
        )


def _mark(line: str) -> str | None:
    return next((mark for mark in MARKS if mark in line), None)
