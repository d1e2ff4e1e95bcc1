"""Cells of the lines of a table: ground lines and records come with any of the usual separators."""

from __future__ import annotations

import re

MARKS = (";", "\t", ",")
"""Separators, the first of which in a line counts; without any, cells stand between blanks."""


def cells(line: str) -> list[str]:
    """Cells of a line, without quotes; between semicolons and tabs a comma is a decimal one."""
    mark = next((mark for mark in MARKS if mark in line), None)
    plain = line.replace(",", ".") if mark in (";", "\t") else line
    return [cell.strip(' "') for cell in plain.strip().strip(mark or " ").split(mark)]


def names(head: str, line: str) -> list[str]:
    """Names in the head above a line of cells; between blanks a name keeps the brackets behind it: ``time (s) ax (g)``."""
    if any(mark in head + line for mark in MARKS):
        return [name.strip(' "') for name in re.split("[,;\t]", head)]
    return [name.strip(' "') for name in re.findall(r"[^\s(\[{]+(?:\s*[(\[{][^)\]}]*[)\]}]\S*)?|\S+", head)]
