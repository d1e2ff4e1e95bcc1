"""Files that exist are whole: written under a temporary name by one process at a time, then renamed.

The temporary name is the file's own (``.NAME.part``), so that what a killed process leaves is overwritten by the next one instead
of piling up; a lock (``.NAME.lock``) keeps two processes from sharing it.  Of a long NAME these have a digest, so that every name that
the file system takes will do.
"""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

MAX_HIDDEN = 140
"""Longest name of a hidden file, bytes; the file systems in use take 255, those that encrypt names 143."""


@contextmanager
def whole(path: Path | str) -> Iterator[Path]:
    """The temporary name to write under: renamed to ``path`` at the end, deleted if that is not reached.

    OSError names the file, the cause and the remedy; an earlier file of the name is then as it was.
    """
    path = Path(path)
    temporary = beside(path, "part")
    with alone(path, "lock"):
        try:
            yield temporary
            _to_disk(temporary)
            os.replace(temporary, path)
        except (OSError, RuntimeError) as error:  # netCDF calls a full disk a RuntimeError
            raise unwritable(path, error) from error
        finally:
            temporary.unlink(missing_ok=True)


def beside(path: Path, role: str) -> Path:
    """Hidden file of a role beside a file."""
    name = f".{path.name}.{role}"
    if len(os.fsencode(name)) > MAX_HIDDEN:
        name = f".{hashlib.sha256(os.fsencode(path.name)).hexdigest()[:16]}.{role}"
    return path.with_name(name)


def check_name(path: Path) -> None:
    """ValueError for a name that the file system does not take, with the longest that it does."""
    try:
        os.lstat(path)
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            return
        size, longest = len(os.fsencode(path.name)), os.pathconf(path.parent, "PC_NAME_MAX")
        if size > longest:
            raise ValueError(f"{path}: the name takes {size} bytes, at most {longest} are possible there; choose a shorter one") from error


def content_digest(*paths: Path) -> str:
    """Digest of names and contents of files."""
    digest = hashlib.sha256()
    for path in paths:
        with path.open("rb") as file:
            digest.update(os.fsencode(path.name) + b"\0" + hashlib.file_digest(file, "sha256").digest())
    return digest.hexdigest()[:16]


ROLES = ("part", "lock", "run", "checkpoint")
"""Roles of the hidden files that writing a file makes, and deletes, beside it."""


def same_file(one: Path | str, other: Path | str) -> bool:
    """Whether two names are of one file, also through links; False where one of them does not exist."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return False


def tidy(path: Path) -> None:
    """Delete what a killed process left beside a file; for who is alone at it."""
    for role in ("part", "lock"):
        beside(path, role).unlink(missing_ok=True)


@contextmanager
def alone(path: Path, role: str, wait: Callable[[], None] | None = None) -> Iterator[bool]:
    """Hold the lock on a file for one purpose; yields whether another process held it before, and was killed or waited for.

    The lock is a file beside it, made with its folder and deleted at the end.  A killed process holds nothing, but leaves that file.
    ``wait`` is called before waiting.
    """
    lock = beside(path, role)
    followed, waited = lock.exists(), False
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        check_name(path)
        lock.touch()
    except OSError as error:
        raise unwritable(path, error) from error
    # Who held it may have deleted the file meanwhile: the lock then makes it anew.
    held = FileLock(lock)
    with suppress(OSError):  # a file system without locks: whoever starts two processes on one file must keep them apart
        try:
            held.acquire(blocking=False)
        except Timeout:
            if wait is not None:
                wait()
            waited = True
            held.acquire()
    try:
        yield followed or waited
    finally:
        with suppress(OSError):  # Windows deletes no file that is open
            lock.unlink(missing_ok=True)
        held.release()


def unwritable(path: Path, error: Exception) -> OSError:
    """The error of a file that cannot be written: cause, room left and remedy."""
    cause = (error.strerror if isinstance(error, OSError) else None) or error
    try:
        room = f", {shutil.disk_usage(path.parent).free / 1e6:.1f} MB free in {path.parent}"
    except OSError:
        room = ""
    return OSError(f"{path}: cannot be written ({cause}{room}); fix that or choose another place, then give the same command again")


def _to_disk(path: Path) -> None:
    """Wait until the disk has it: a full disk may show only now, and a rename must not overtake the data."""
    with open(path, "r+b") as handle:
        os.fsync(handle.fileno())
