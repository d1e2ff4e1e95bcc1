"""Names that a user writes: those that are known, and which of them was meant by one that is not."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable

LONGEST = 80
"""Most characters of a name that is shown."""


def nearest(name: str, known: Iterable[str]) -> str:
    """``; did you mean ...?`` with the known name that is most like a misspelt one, whatever its case; nothing where none is like it."""
    names = {each.lower(): each for each in known}
    close = difflib.get_close_matches(name[:LONGEST].lower(), names, 1)
    return f"; did you mean {names[close[0]]}?" if close else ""


def check_known(where: str, names: Iterable[str | None] | None, known: Collection[str]) -> None:
    """Refuse a name that is not among those known, but for None; ValueError begins with ``where`` and ends with the nearest one."""
    for name in names or ():
        if name is not None and name not in known:
            raise ValueError(f"{where}: {name[:LONGEST]!r} is not one of {', '.join(known)}{nearest(name, known)}")
