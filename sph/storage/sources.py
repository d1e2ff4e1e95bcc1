"""Digest of sources: what they say to the machine decides a result, what they say to people does not.

Left out are layout and comments, docstrings, what errors are raised with, and the texts that ``WORDS`` lists.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

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


def sources_digest(paths: Iterable[Path], folder: Path, more: str = "") -> str:
    """Digest of files below a folder, of Python without the words, of others as they are; and of what ``more`` says."""
    digest = hashlib.sha256(more.encode())
    for path in sorted(paths):
        digest.update(f"{path.relative_to(folder).as_posix()}\n{_executed(path.read_bytes(), path.suffix)}\n".encode())
    return digest.hexdigest()[:16]


@cache
def _executed(data: bytes, suffix: str) -> str:
    said = _syntax(ast.parse(data)).encode() if suffix == ".py" else data
    return hashlib.sha256(said).hexdigest()


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
