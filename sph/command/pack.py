"""What ``sph pack`` writes: a study with every file that it names in one archive, which runs elsewhere by one command.

``snakemake --archive`` takes what git tracks below the working folder: the program, but no scene, ground line or record of one's own.
Files keep their places relative to the working folder, or to the program's for those that are found there, so that what names them need
not be changed; a name that would not lead to its file in the archive is refused.
"""

from __future__ import annotations

import os
import platform
import shlex
import zipfile
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Any, Literal

import sph
from sph.command.outputs import check_writable
from sph.command.study import CONFIGURATION, find_study
from sph.scene.configuration import CONTENT_KEYS, found_file, read_yaml
from sph.solver.compiled.jit import solver_digest
from sph.storage.files import whole
from sph.storage.trajectory import PACKAGES
from sph.study.sampling import read_cases

README = "README.txt"
"""In the archive: the file with the commands."""
LIBRARY = Path(os.path.abspath(sph.__file__)).parents[1]
NOTHING = ("null", "~", "")
"""Values of a dimension that name no file."""
README_TEXT = """\
{title}
{line}

This folder holds a study of slopes under earthquake shaking, with every file that it needs.
It was packed by sph-slope {version}, whose solver has the digest {digest}, with
{packages}.
The same versions give the same numbers to the last bit on the same kind of processor.

1. Install sph-slope {version}. In a clone of it, here ~/sph-slope:

   python3 -m venv .venv && .venv/bin/pip install -c constraints.txt -e ".[workflow]"

2. Run the study. In the folder of this file:

   ~/sph-slope/.venv/bin/snakemake --snakefile ~/sph-slope/Snakefile --cores 2 --configfile {configuration}

   With -n it only lists what would be run. The page with the answer is then
   {page}
{results}
3. Look at the scene before it is run:

   ~/sph-slope/.venv/bin/sph check {scene} --plot scene.png
"""
RESULTS_TEXT = """
   The results are included. To continue from them, first run this command once with --touch added, since files from
   an archive look older than the program. To check that the results belong to this study and version, run

   ~/sph-slope/.venv/bin/sph explain {configuration}
"""


Role = Literal["content", "scene", "configuration", "cases", "hazard"]
"""What a named file is: content is looked for beside the scene that names it, else in the working folder, all else there or beside the
library."""


def named_files(data: Any, key: tuple[str, ...] = ()) -> Iterator[tuple[str, str, Role]]:
    """Every file that a configuration or a scene names: the dotted key, the name, and what it is."""
    if isinstance(data, str):
        role = _role(key)
        if role is not None and data not in NOTHING:
            yield ".".join(key), data, role
    elif isinstance(data, Mapping):
        holds_content = any(data.get(name) is not None for name in CONTENT_KEYS)
        for name, value in data.items():
            if not (holds_content and name == "file"):
                yield from named_files(value, (*key, str(name)))
    elif isinstance(data, (list, tuple)):
        for item in data:
            yield from named_files(item, key)


def _role(key: tuple[str, ...]) -> Role | None:
    """What a text is, by the keys down to it; None where it names no file."""
    if key[-1:] == ("file",) or key and key[-1].endswith(".file"):
        return "content"
    if key[-1:] == ("scene",) and (len(key) == 1 or len(key) == 3 and key[0] in ("cases", "parameters")):
        return "scene"
    if key[:1] == ("experiments",) and len(key) == 2:
        return "configuration"
    return "cases" if key == ("cases",) else "hazard" if key == ("hazard",) else None


class Packing:
    """The files of an archive, collected from those that name them."""

    def __init__(self) -> None:
        self.sources: dict[str, Path] = {}
        """files by their place in the archive"""

    def add(self, path: Path, where: str) -> str:
        """Place of a file in the archive; ValueError, which begins with ``where``, where it cannot have it."""
        path = Path(os.path.abspath(path))
        roots = sorted((Path.cwd(), LIBRARY), key=lambda root: -len(root.parts))  # the inner one first
        root = next((root for root in roots if path.is_relative_to(root)), None)
        if root is None:
            raise ValueError(f"{where}: {path} lies outside the working folder {Path.cwd()}; copy it below that folder, and name it there")
        place = path.relative_to(root).as_posix()
        first = self.sources.setdefault(place, path)
        if first != path and first.read_bytes() != path.read_bytes():
            raise ValueError(f"{path}: would be {place} in the archive, and so would {first}, which differs; rename one of them")
        if place == README:
            raise ValueError(f"{path}: would be {place} in the archive, which has a file of its own with that name; rename it")
        return place

    def add_named(self, named: tuple[str, str, Role], within: Path, scene: str | None = None) -> str:
        """Place of a file that is named in the file ``within``: in a configuration, or in a ``scene`` of that place.

        ValueError for a file that is not there, and for a name that would not lead to it from the archive.
        """
        key, name, role = named
        where, folders = f"{within}: {key}", {Path.cwd(): PurePosixPath()}
        if scene is not None:
            folders = {within.parent: PurePosixPath(scene).parent} | folders
        if role != "content":
            folders[LIBRARY] = PurePosixPath()
        path = found_file(list(folders), name, where)
        place = self.add_text(path, where, role == "scene") if role in ("scene", "configuration") else self.add(path, where)
        seen_from = next(seen_from for folder, seen_from in folders.items() if folder / name == path)
        if os.path.isabs(name) or os.path.normpath(seen_from / name) != place:
            raise ValueError(f"{where}: {name!r}: would not lead to its file elsewhere; write {os.path.relpath(place, seen_from)}")
        for number, case in enumerate(read_cases([Path()], str(path)) if role == "cases" else (), 1):
            for key, name, of_case in named_files(case):
                self.add_named((f"{key} of case {number}", name, of_case), path)
        return place

    def add_text(self, path: Path, where: str, is_scene: bool = False) -> str:
        """Place of a configuration or a scene, with all that it names."""
        known = len(self.sources)
        place = self.add(path, where)
        if len(self.sources) > known:
            for named in named_files(read_yaml(path)):
                self.add_named(named, path, place if is_scene else None)
        return place


def pack(configuration: Path, out: Path | None = None, results: bool = False) -> tuple[Path, int]:
    """Write the archive of a study, ``<study>.zip`` by default; its path, and the number of files in it.

    ValueError for a study that is refused, a file that is not there or cannot have its place, and for an archive that would replace one of
    them or lie among the results.
    """
    laid_over = "scene" not in read_yaml(configuration)
    if laid_over and not CONFIGURATION.is_file():
        raise ValueError(
            f"{configuration}: scene: is missing, and there is no {CONFIGURATION} in {Path.cwd()}; "
            "name the scene, or go to the folder with it"
        )
    plan = find_study(configuration).plan
    name = plan.study.study
    path, folder = out or Path(f"{name}.zip"), Path("results", name)
    if path.suffix.lower() != ".zip":
        raise ValueError(f"--out {path}: the name must end in .zip")
    packing = Packing()
    place = shlex.quote(packing.add_text(configuration, "STUDY"))
    if laid_over:
        packing.add_text(CONFIGURATION, str(configuration))
    scene = packing.add_named(("scene", plan.study.scene, "scene"), configuration)
    if results:
        files = [file for file in sorted(folder.rglob("*")) if file.is_file() and not file.name.startswith(".")]
        if not files:
            raise ValueError(f"--results: {folder}: holds no results; run the study first, or leave --results out")
        for file in files:
            packing.add(file, "--results")
        if Path(os.path.abspath(path)).is_relative_to(folder.absolute()):
            raise ValueError(f"--out {path}: lies among the results to be packed; choose another folder")
    check_writable(path, packing.sources.values())
    readme = README_TEXT.format(
        title=(title := f"Study {name}"),
        line="=" * len(title),
        version=sph.__version__,
        digest=solver_digest(),
        packages=", ".join((f"Python {platform.python_version()}", *(f"{package} {version(package)}" for package in PACKAGES))),
        configuration=place,
        page=f"{plan.folder}/report.html",
        results=RESULTS_TEXT.format(configuration=place) if results else "",
        scene=shlex.quote(scene),
    )
    with whole(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as archive:
        archive.writestr(f"{name}/{README}", readme)
        for place, source in sorted(packing.sources.items()):
            archive.write(source, f"{name}/{place}")
    return path, len(packing.sources) + 1
