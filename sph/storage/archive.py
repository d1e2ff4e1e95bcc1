"""One archive of many files, zip or tar: the same files give the same bytes, whoever packs them and when."""

from __future__ import annotations

import gzip
import io
import shutil
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO

from sph.storage.files import whole

ENDINGS = (".zip", ".tar.gz")
"""Of the names of archives; they say the kind."""
DATE = (1980, 1, 1, 0, 0, 0)
"""Of every file in a zip: the earliest that it can hold."""
SECONDS = 315_532_800
"""The same since 1970, for a tar."""
MODE = 0o644


def write_archive(path: Path, members: Mapping[str, Path | bytes]) -> None:
    """Write an archive, whole or not at all, of files by name: those of disk, or their content; sorted, of one date and without owners.

    ValueError for another ending than those of ``ENDINGS``; OSError for a file that cannot be read or written.
    """
    check_ending(path)
    with whole(path) as temporary:
        if path.name.lower().endswith(".zip"):
            _write_zip(temporary, members)
        else:
            _write_tar(temporary, members)


def check_ending(path: Path) -> None:
    """ValueError for a name that does not end as an archive's."""
    if not path.name.lower().endswith(ENDINGS):
        raise ValueError(f"{path}: the name must end in {' or '.join(ENDINGS)}")


def _write_zip(path: Path, members: Mapping[str, Path | bytes]) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        for name in sorted(members):
            info = zipfile.ZipInfo(name, DATE)
            info.compress_type, info.create_system, info.external_attr = zipfile.ZIP_DEFLATED, 3, MODE << 16  # of Unix, everywhere
            info.file_size = _size(members[name])
            with _opened(members[name]) as source, archive.open(info, "w") as target:
                shutil.copyfileobj(source, target)


def _write_tar(path: Path, members: Mapping[str, Path | bytes]) -> None:
    with (
        path.open("wb") as file,
        gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive,
    ):
        for name in sorted(members):
            info = tarfile.TarInfo(name)
            info.size, info.mtime, info.mode = _size(members[name]), SECONDS, MODE
            with _opened(members[name]) as source:
                archive.addfile(info, source)


def _size(member: Path | bytes) -> int:
    return len(member) if isinstance(member, bytes) else member.stat().st_size


def _opened(member: Path | bytes) -> IO[bytes]:
    return io.BytesIO(member) if isinstance(member, bytes) else member.open("rb")
