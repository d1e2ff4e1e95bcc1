"""The files that a command is told to write: refused before any work where they could not be written, or would replace what is read."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

from sph.storage.files import ROLES, beside, check_name, same_file

PICTURES = (".png", ".pdf", ".svg")


def check_writable(path: Path, inputs: Iterable[Path | str], option: str = "--out") -> None:
    """Refuse a file that could not be written after hours of work, and one that the command reads; ValueError names the option."""
    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: the folder {path.parent} does not exist")
    try:
        check_name(path)
    except ValueError as error:
        raise ValueError(f"{option} {error}") from error
    if path.is_dir():
        raise ValueError(f"{option} {path}: is a folder; name a file")
    if path.exists() and not path.is_file() or path == Path("-"):
        raise ValueError(f"{option} {path}: must be a new file, or an ordinary one to be replaced; name another")
    check_apart(path, inputs, option)
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".sph."):
            pass
    except OSError as error:
        raise ValueError(f"{option} {path}: cannot be written: {error.strerror}; remove the cause or choose another place") from error


def check_picture(path: Path, inputs: Iterable[Path | str], option: str = "--out") -> None:
    """Refuse what ``check_writable`` refuses, and an ending that is not that of a picture."""
    if not path.name.lower().endswith(PICTURES):
        raise ValueError(f"{option} {path}: the name must end in {', '.join(PICTURES)}")
    check_writable(path, inputs, option)


def check_apart(path: Path, inputs: Iterable[Path | str], option: str) -> None:
    """Refuse to write over a file that the command reads, by whatever name; ValueError names the option."""
    for given in inputs:
        if any(same_file(own, given) for own in (path, *(beside(path, role) for role in ROLES))):
            raise ValueError(f"{option} {path}: would replace {given}, which the command reads; name another file")
