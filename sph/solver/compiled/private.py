"""A folder whose files are executed is its user's alone: nobody else can have written, or can write, what lies in it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH
ROOT = 0
PRIVATE = 0o600
"""Mode of a file that its user alone reads and writes."""


def make_private(folder: Path) -> None:
    """Make a folder, with those of its parents that are missing, for its user alone."""
    for place in (*reversed(folder.parents), folder):
        with suppress(FileExistsError):
            if not place.is_dir():
                place.mkdir(mode=0o700)
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is no folder")


def refuse_shared(folder: Path) -> None:
    """PermissionError, with the remedy, unless a folder and all in it are this user's, and nobody else may write there.

    The folder that it lies in may be root's too, and is then allowed to be open to all if its sticky bit keeps them from each
    other's files, as in /tmp.  Links on the way to it must be this user's or root's.  Systems without
    users are not asked.
    """
    if not hasattr(os, "getuid"):
        return
    user = os.getuid()
    for link in _links(folder):
        _refuse(link, link.lstat(), user, owners=(user, ROOT), forbidden=0)
    for parent in dict.fromkeys((folder.parent, folder.resolve().parent)):
        found = parent.stat()
        sticky = found.st_uid == ROOT and found.st_mode & stat.S_ISVTX
        _refuse(parent, found, user, owners=(user, ROOT), forbidden=0 if sticky else OTHERS)
    for place in (folder, *folder.rglob("*")):
        with suppress(FileNotFoundError):  # another process's temporary file, since renamed
            _refuse(place, place.stat(), user, owners=(user,), forbidden=OTHERS)


def _refuse(place: Path, found: os.stat_result, user: int, owners: tuple[int, ...], forbidden: int) -> None:
    if found.st_uid not in owners:
        kind = "the link " if stat.S_ISLNK(found.st_mode) else ""
        raise PermissionError(f"what lies there is executed, and {kind}{place} belongs to user {found.st_uid}, not to {user}")
    if found.st_mode & forbidden:
        mode = stat.S_IMODE(found.st_mode)
        raise PermissionError(f"what lies there is executed, and others may write to {place}, mode {mode:o}: chmod -R go-w '{place}'")


def _links(path: Path) -> Iterator[Path]:
    """Symbolic links that are followed on the way to a path that exists."""
    for place in (*reversed(path.parents), path):
        if place.is_symlink():
            yield place
            yield from _links(place.parent / os.readlink(place))


@contextmanager
def for_user_alone() -> Iterator[None]:
    """Files and folders are made for this user alone, whatever the umask."""
    earlier = os.umask(0o077)
    try:
        yield
    finally:
        os.umask(earlier)
