"""Earthquake, station and component of a record, as its file says them."""

from __future__ import annotations

import re
from pathlib import Path

from sph.scene.ground_motion.text import read_lines

MAX_TITLE = 80
"""Most characters of a title."""
TOP = 80
"""Lines among which heads are looked for."""
PEER = (".at2",)
KEYS = {
    "ESM": (("EVENT_NAME", "EVENT_DATE_YYYYMMDD"), ("STATION_NAME", "STATION_CODE"), ("STREAM",)),
    "K-NET": (("Origin Time",), ("Station Code",), ("Dir.",)),
    "own": (("record",),),
}
"""Words of the head of ESM's files, of K-NET's and of a comment of any text, ``# record: Kobe 1995, KJMA``, behind which earthquake,
station and component stand; of each the first that says something."""


def record_title(path: Path | str) -> str | None:
    """Earthquake, station and component in the head of a record's file; None where it names none.  ValueError as ``read_lines``."""
    lines = read_lines(path)[:TOP]
    if Path(path).suffix.lower() in PEER:  # the second line is: event, date, station, component
        return _short(lines[1]) if len(lines) > 1 else None
    for parts in KEYS.values():
        found = [next(filter(None, (_said(lines, key) for key in keys)), "") for keys in parts]
        if found[0]:
            return _short(", ".join(filter(None, found)))
    return None


def _said(lines: list[str], key: str) -> str:
    pattern = re.compile(rf"[#\s]*{re.escape(key)}\s*[:\s]\s*(.*)$")
    return next((match[1].strip() for line in lines if (match := pattern.match(line))), "")


def _short(words: str) -> str | None:
    return " ".join(words.strip(" \t,").split())[:MAX_TITLE] or None
