"""Which way a component points, by the words of files, headers and columns: a vertical one is no horizontal motion, nor the reverse."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

Direction = Literal["horizontal", "vertical"]
CHANNEL = "[a-z][hnlg]"
"""Band and instrument of a channel's code, as in HNZ."""
WORDS: dict[Direction, re.Pattern[str]] = {
    "vertical": re.compile(rf"up|ud[12]?|updown|upward|downward|down|dn|dwn|vert|vertical|vrt|ver|v|[au]?z|acc?z|{CHANNEL}z"),
    "horizontal": re.compile(rf"ew[12]?|ns[12]?|[new]|north|south|east|west|h\d?|hor|horizontal|radial|transverse|{CHANNEL}[ne123]"),
}
HEADED = re.compile(r"(?:comp(?:onent)?|chan(?:nel)?|dir(?:ection)?|orientation)\b[\s\d.:=#]*([a-z]+)", re.I)
"""Component in the text of a header: 'Chan  3: Up', 'Component = Vertical'."""


def direction_of(text: str) -> Direction | None:
    """Direction that a text names, the vertical first; None where it names none."""
    together = re.sub(r"\b([enu])-([wsd])\b", r"\1\2", text.casefold())  # E-W, N-S, U-D
    found = re.split(r"[\W_]+", together)
    return next((name for name, pattern in WORDS.items() if any(map(pattern.fullmatch, found))), None)


def check_header(path: Path | str, lines: list[str], wanted: Direction) -> None:
    """Refuse a component that a line of a header's text names as the other direction's."""
    for at, line in enumerate(lines, 1):
        for found in HEADED.finditer(line):
            check_direction(f"{path}, line {at}: {line.strip()[:80]!r}", direction_of(found[1]), wanted)


def check_name(path: Path | str, wanted: Direction) -> None:
    """Refuse a file whose ending, or the last word of whose name, is the other direction's: ``.UD``, ``ELC-UP.AT2``, ``x_vert.csv``."""
    path = Path(path)
    *before, last = re.split(r"[\W_]+", path.stem)
    said = direction_of(path.suffix) or ("vertical" if (before or len(last) > 1) and direction_of(last) == "vertical" else None)
    check_direction(f"{path}: its name", said, wanted)


def check_direction(where: str, said: Direction | None, wanted: Direction) -> None:
    """Refuse a component that by ``where`` points the other way than is wanted; ValueError with the remedy."""
    if said in (None, wanted):
        return
    remedy = "name the file of a horizontal component in motion.file; a vertical one goes under motion.vertical: {file: ...}"
    raise ValueError(f"{where} says that it holds a {said} component, and the {wanted} one is wanted here: {remedy}")
