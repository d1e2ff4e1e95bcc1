"""What the jobs of a workflow are given and compare their inputs with: scenes as they were planned, and digests of the sources.

Snakemake runs a job again when its parameters change.  By the dates of files alone it would miss one that is replaced by an older
one, as by ``cp -p``, unzip or ``rsync -a``: so the parameters hold the contents of the files that a scene and the program are read from.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import sph
from sph.output.run import Run
from sph.scene.configuration import MAX_LINES, differences, one_line, scene_files
from sph.scene.schema import Scene, make_scene
from sph.scene.scheme import filled
from sph.storage import trajectory
from sph.storage.files import content_digest
from sph.storage.netcdf import Group
from sph.storage.sources import sources_digest

LIBRARY = Path(sph.__file__).parent
SHOWN = 80
"""Most characters of a value in the list of keys that differ."""


class Planned(NamedTuple):
    """A scene as it was planned."""

    scene: dict[str, Any]  # as a mapping, with what its scheme fills in
    files: dict[str, str]  # digest of the content of every file that it is read from

    def build(self) -> Scene:
        """The scene; ValueError where a file has changed since it was planned."""
        scene = make_scene(self.scene)
        changed = [name for name, digest in self.files.items() if content_digest(Path(name)) != digest]
        if changed:
            raise ValueError(f"{', '.join(changed)}: has changed since this job was planned; give the same command again")
        return scene

    def read(self, path: Path | str) -> Run:
        """The run, or the trials of the search, of this scene; ValueError for a file of another one."""
        stored = trajectory.read(path)
        return Run(stored, self.check(stored.attrs, path), str(path))

    def check(self, attrs: Mapping[str, Any], path: Path | str) -> Scene:
        """The scene; ValueError names the keys in which that among a file's attributes differs from it, and the remedy."""
        scene = self.build()
        differ = differing(attrs, scene, path)
        if differ:
            raise ValueError(
                f"{path}: was made from another scene than the one planned; delete it and give the same command again, which makes it "
                "again; they differ in\n  " + "\n  ".join(differ)
            )
        return scene


def differing(attrs: Mapping[str, Any], scene: Scene, path: Path | str) -> list[str]:
    """Keys in which the scene among a file's attributes differs from a planned one, with both values; names of files do not count."""
    if attrs.get("scene") == scene.stored():
        return []
    stored = trajectory.scene_of(Group({}, attrs), str(path))
    lines = [
        f"{name}: {one_line(repr(there), SHOWN)} in the file, {one_line(repr(here), SHOWN)} planned"
        for name, (there, here) in differences(stored.model_dump(), scene.model_dump()).items()
    ]
    return lines[:MAX_LINES] + [f"and {len(lines) - MAX_LINES} more"] * (len(lines) > MAX_LINES)


def planned(scene: Mapping[str, Any]) -> Planned:
    """A scene, as a mapping, with the contents that its files have when they are first asked for: during the planning."""
    return Planned(dict(filled(scene)), {name: _at_planning(os.path.abspath(name)) for name in scene_files(scene)})


@functools.cache
def _at_planning(name: str) -> str:
    try:
        return content_digest(Path(name))
    except OSError as error:
        raise ValueError(f"file: {one_line(name)}: cannot be read: {error.strerror or error}") from error


def digest(given: Any) -> str:
    """Digest of what a job is given, which a workflow keeps with the result and compares: scenes may hold records of megabytes."""
    return trajectory.text_digest(_told(given))


def _told(given: Any) -> Any:
    """Plain data; of a planned scene what its files hold, wherever they are."""
    if isinstance(given, Planned):
        return [given.scene, list(given.files.values())]
    if isinstance(given, Mapping):
        return {str(name): _told(value) for name, value in given.items()}
    return list(map(_told, given)) if isinstance(given, (list, tuple)) else repr(given)


def sources(*patterns: str, without: str = "") -> str:
    """Digest of what files say to the machine that match patterns, seen from the library (``sph.storage.sources``), ``without`` some.

    Snakemake does not see edits in imported modules by itself.  ValueError for a pattern that matches none, which is a file that has moved.
    """
    return sources_digest(_matching(patterns) - set(LIBRARY.glob(without) if without else ()), LIBRARY)


def contents(*patterns: str) -> str:
    """Digest of all that such files say, comments and docstrings too: for what is made of words."""
    return content_digest(*sorted(_matching(patterns)))


def _matching(patterns: Iterable[str]) -> set[Path]:
    matching = {pattern: [path for path in LIBRARY.glob(pattern) if path.is_file()] for pattern in patterns}
    for pattern, paths in matching.items():
        if not paths:
            raise ValueError(f"sources: {pattern}: no such file in {LIBRARY}")
    return {path for paths in matching.values() for path in paths}
