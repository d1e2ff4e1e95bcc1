"""Digest of sources: what they say to the machine decides a result, what they say to people does not.

Left out are layout and comments, docstrings, what errors are raised with, and the texts that ``WORDS`` lists.
What is found of a text is kept for the user's next processes, of which most would parse the same ones: half a second for the solver's.
"""

from __future__ import annotations

import ast
import hashlib
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from sph.scene.strict_json import parse_json, to_json
from sph.storage.files import whole

WORDS: dict[str, tuple[int | str, ...]] = {
    "key": (0, 2, "source"),  # description and source of a key of the configuration
    "Kind": (0, "label"),  # what figures call a wall
    "Variable": (4, "text"),  # meaning of what is stored
    "number_column": (2, "text"),
    "text_column": (1, "text"),
    "count_column": (1, "text"),
    "_number": (2, "text"),  # meaning of a metric
    "words": (0,),
}
"""Arguments of calls, by place or name, that people alone read, where they are written out as texts."""


def words(text: str) -> str:
    """A text as it is, marked as one that people alone read."""
    return text


KEPT = "sources.json"
"""What is kept, in the folder of the compiled solver: digests by those of the texts and of what decides how they are read."""
MAX_KEPT = 2000
"""Most texts, some releases of the library; the first that were kept go first."""
_READING = hashlib.sha256(sys.version.encode() + Path(__file__).read_bytes())
_known: dict[str, str] = {}


def sources_digest(paths: Iterable[Path], folder: Path, more: str = "") -> str:
    """Digest of files below a folder, of Python without the words, of others as they are; and of what ``more`` says."""
    if not _known:
        _known.update(_kept())
    before = len(_known)
    digest = hashlib.sha256(more.encode())
    for path in sorted(paths):
        digest.update(f"{path.relative_to(folder).as_posix()}\n{_executed(path.read_bytes(), path.suffix)}\n".encode())
    if len(_known) > before:
        _keep()
    return digest.hexdigest()[:16]


def _executed(data: bytes, suffix: str) -> str:
    if suffix != ".py":
        return hashlib.sha256(data).hexdigest()
    text = _READING.copy()
    text.update(data)
    key = text.hexdigest()
    if key not in _known:
        _known[key] = hashlib.sha256(_syntax(ast.parse(data)).encode()).hexdigest()
    return _known[key]


def _place() -> Path:
    chosen, users = os.environ.get("SPH_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")
    return (Path(chosen) if chosen else (Path(users) if users else Path.home() / ".cache") / "sph") / KEPT


def _kept() -> dict[str, str]:
    """What earlier processes of this user have kept; nothing where another one may have written it."""
    with suppress(OSError, RuntimeError, ValueError, TypeError), _place().open("rb") as file:
        found = os.fstat(file.fileno())
        if not hasattr(os, "getuid") or found.st_uid == os.getuid() and not found.st_mode & 0o022:
            return dict(parse_json(file.read().decode()))
    return {}


def _keep() -> None:
    """Keep what is known, where there is a folder for that; it is made with the first code that is compiled."""
    with suppress(OSError, RuntimeError):
        if _place().parent.is_dir():
            latest = [*(_kept() | _known).items()][-MAX_KEPT:]
            with whole(_place()) as temporary:
                temporary.touch(0o600)
                temporary.write_text(to_json(dict(latest)), encoding="utf-8")


def _syntax(part: Any) -> str:
    """A part of a syntax tree without the words, written as nested tuples."""
    if isinstance(part, list):
        return _tuple([_syntax(each) for each in part if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))])
    if not isinstance(part, ast.AST):
        return repr(part)
    fields = vars(part)
    if isinstance(part, ast.Raise) and isinstance(part.exc, ast.Call):
        fields = fields | {"exc": part.exc.func}
    elif isinstance(part, ast.Call) and isinstance(part.func, ast.Name) and part.func.id in WORDS:
        places = WORDS[part.func.id]
        fields = fields | {
            "args": [each for place, each in enumerate(part.args) if place not in places or not _is_text(each)],
            "keywords": [each for each in part.keywords if each.arg not in places or not _is_text(each.value)],
        }
    named = [f"({name!r}, {_syntax(fields[name])})" for name in part._fields if name in fields]
    return _tuple([repr(type(part).__name__), *named])


def _tuple(parts: list[str]) -> str:
    return f"({parts[0]},)" if len(parts) == 1 else f"({', '.join(parts)})"


def _is_text(part: ast.expr) -> bool:
    return isinstance(part, ast.JoinedStr) or isinstance(part, ast.Constant) and isinstance(part.value, str)
