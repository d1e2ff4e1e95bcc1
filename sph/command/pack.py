"""What ``sph pack`` writes: a study with every file that it names in one archive, which runs elsewhere by one command.

``snakemake --archive`` takes what git tracks below the working folder: the program, but no scene, ground line or record of one's own.
Files keep their places relative to the working folder, or to the program's for those that are found there; others go to ``files/``.  A name
that would not lead to its file in the archive is replaced where it is written; nothing else is changed.
"""

from __future__ import annotations

import io
import os
import platform
import shlex
import shutil
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path, PurePosixPath

import sph
from sph.command.named_files import NOTHING, Named, Role, named_files, renamed, words_of
from sph.command.outputs import check_writable
from sph.command.study import CONFIGURATION, find_study
from sph.scene.configuration import found_file, read_yaml
from sph.solver.compiled.jit import solver_digest
from sph.storage.files import whole
from sph.storage.trajectory import PACKAGES
from sph.study.plan import OWNER, Plan
from sph.study.sampling import read_cases

FILES, PROGRAM, README = "files", "program", "README.txt"
"""In the archive: folder of files from elsewhere, folder of what says which program it was, and the file with the commands."""
CONSTRAINTS = "constraints.txt"
DATE = (1980, 1, 1, 0, 0, 0)
"""Of every file in an archive, the earliest that it can hold: the same files give the same bytes, whoever packs them and when."""
LIBRARY = Path(os.path.abspath(sph.__file__)).parents[1]
README_TEXT = """\
{title}
{line}

This folder holds a study of slopes under earthquake shaking, with every file that it needs.
It was packed by sph-slope {version}, whose solver has the digest {digest}.

1. Install sph-slope {version}. In a clone of it, here ~/sph-slope:

   python3 -m venv .venv && .venv/bin/pip install -c constraints.txt -e ".[workflow]"

2. Run the study. In the folder of this file:

   ~/sph-slope/.venv/bin/snakemake --snakefile ~/sph-slope/Snakefile --cores 2 --configfile {configuration}

   With -n it only lists what would be run. The page with the answer is then
   {page}
{results}
3. Look at the scene before it is run:

   ~/sph-slope/.venv/bin/sph check {scene} --plot scene.png

The folder {program}/ records all versions with which the study was packed. The same versions give the same
numbers to the last bit on the same kind of processor; other versions or processors may give different ones.

Contents:

{contents}
"""

RESULTS_TEXT = """
   The results are included. To continue from them, first run this command once with --touch added, since files from
   an archive look older than the program. To check that the results belong to this study and version, run

   ~/sph-slope/.venv/bin/sph explain {configuration}
"""


class Packing:
    """The files of an archive, collected from those that name them."""

    def __init__(self) -> None:
        self.roots = sorted((Path.cwd(), LIBRARY), key=lambda root: -len(root.parts))
        """folders whose files keep their places: the working folder and the program's, the inner one first"""
        self.sources: dict[str, Path] = {}
        """files by their place in the archive"""
        self.texts: dict[str, bytes] = {}
        """content of those in which names were replaced, by place"""
        self.words: dict[str, str] = {}
        """what those are that the study needs, by place"""

    def add(self, path: Path, words: str = "") -> str:
        """Place of a file in the archive; ValueError where it cannot have its place."""
        path = Path(os.path.abspath(path))
        root = next((root for root in self.roots if path.is_relative_to(root)), None)
        if root is not None:
            place = path.relative_to(root).as_posix()
        else:
            tried = (f"{FILES}/{folder}{path.name}" for folder in ("", *(f"{number}/" for number in range(2, len(self.sources) + 3))))
            place = next(name for name in tried if self.sources.get(name, path) == path)
        first = self.sources.setdefault(place, path)
        if first != path and first.read_bytes() != path.read_bytes():
            raise ValueError(f"{path}: would be {place} in the archive, and so would {first}, which differs; rename one of them")
        if place == README or PurePosixPath(place).parts[0] == PROGRAM:
            raise ValueError(f"{path}: would be {place} in the archive, which has a file or folder of its own with that name; rename it")
        if words:
            self.words.setdefault(place, words)
        return place

    def text(self, path: Path, words: str, is_scene: bool = False) -> str:
        """Place of a configuration or a scene, with all that it names; ValueError for a file that is not there, with the key."""
        place = self.add(path)
        if place in self.words:
            return place
        self.words[place] = words
        read_yaml(path)
        text, folder = path.read_bytes().decode("utf-8"), PurePosixPath(place).parent
        names: dict[Named, str] = {}
        for each in named_files(text):
            where = f"{path}: {each.key}"
            name = self.name_of(each.value, each.role, each.words, where, (path.parent, folder) if is_scene else None)
            if name != each.value:
                names[each] = name
                _check_kept(each.value, name if each.is_dimension else each.value, where)
        if names:
            try:
                self.texts[place] = renamed(text, names).encode()
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error
        return place

    def table(self, path: Path, words: str) -> str:
        """Place of a table of cases, with the files that its columns name."""
        for number, case in enumerate(read_cases([Path()], os.path.abspath(path)), 1):
            for name, value in case.items():
                if name.endswith(".file") and value not in NOTHING:
                    where = f"{path}: {name} of case {number}"
                    _check_kept(value, self.name_of(value, Role.CONTENT, words_of(name), where), where)
        return self.add(path, words)

    def name_of(self, value: str, role: Role, words: str, where: str, beside: tuple[Path, PurePosixPath] | None = None) -> str:
        """What a file is to be called where it is named by ``value``: as it is, wherever that leads to its place in the archive.

        ``beside`` is the folder of a scene, on disk and in the archive, where its files are looked for first.
        """
        folders = [Path.cwd()] if role == Role.CONTENT else [Path.cwd(), LIBRARY]
        places = [*([] if beside is None else [beside]), *((folder, PurePosixPath()) for folder in folders)]
        path = found_file([folder for folder, _ in places], value, where)
        seen_from = next(place for folder, place in places if folder / value == path)
        if role in (Role.SCENE, Role.CONFIGURATION):
            target = self.text(path, words, role == Role.SCENE)
        else:
            target = self.table(path, words) if role == Role.CASES else self.add(path, words)
        leads_there = not os.path.isabs(value) and os.path.normpath(seen_from / value) == target
        return value if leads_there else os.path.relpath(target, seen_from)

    def add_results(self, plan: Plan, scene: str) -> None:
        """Add the results of a study, whose scene is called ``scene`` in the archive; ValueError where there are none."""
        folder = Path("results", plan.study.study)
        found = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.name.startswith(".")]
        if not found:
            raise ValueError(f"--results: {folder}: holds no results; run the study first, or leave --results out")
        for path in found:
            self.add(path)
        self.texts[(folder / OWNER).as_posix()] = f"{scene}\n".encode()


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
    path = out or Path(f"{name}.zip")
    if path.suffix.lower() != ".zip":
        raise ValueError(f"--out {path}: the name must end in .zip")
    packing = Packing()
    place = packing.text(configuration, "study")
    if laid_over:
        packing.text(CONFIGURATION, "configuration whose keys the study overrides")
    scene = packing.name_of(plan.study.scene, Role.SCENE, "scene", f"{configuration}: scene")
    if results:
        packing.add_results(plan, os.path.normpath(scene))
    members = packing.sources | packing.texts
    check_writable(path, packing.sources.values())
    if results and Path(os.path.abspath(path)).is_relative_to(Path.cwd() / "results" / name):
        raise ValueError(f"--out {path}: lies among the results to be packed; choose another folder")
    members |= _program() | {README: _readme(plan, packing, place, scene, results).encode()}
    write_zip(path, {f"{name}/{each}": content for each, content in members.items()})
    return path, len(members)


def write_zip(path: Path, members: Mapping[str, Path | bytes]) -> None:
    """Write an archive, whole or not at all, of files by name: those of disk, or their content; sorted, of one date and one mode."""
    with whole(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name in sorted(members):
            member, info = members[name], zipfile.ZipInfo(name, DATE)
            info.compress_type, info.create_system, info.external_attr = zipfile.ZIP_DEFLATED, 3, 0o644 << 16  # as of Unix, everywhere
            info.file_size = len(member) if isinstance(member, bytes) else member.stat().st_size
            with io.BytesIO(member) if isinstance(member, bytes) else member.open("rb") as source, archive.open(info, "w") as target:
                shutil.copyfileobj(source, target)


def _program() -> dict[str, Path | bytes]:
    """The packages of the release, where the program is a clone, and what is in use."""
    used = {"sph": sph.__version__, "solver": solver_digest(), "python": platform.python_version()}
    for package in (*PACKAGES, "snakemake"):
        with suppress(PackageNotFoundError):  # Snakemake is an extra
            used[package] = version(package)
    text = "".join(f"{name} {found}\n" for name, found in used.items()).encode()
    constraints = LIBRARY / CONSTRAINTS
    return {f"{PROGRAM}/version.txt": text} | ({f"{PROGRAM}/{CONSTRAINTS}": constraints} if constraints.is_file() else {})


def _readme(plan: Plan, packing: Packing, configuration: str, scene: str, results: bool) -> str:
    title, folder = f"Study {plan.study.study}", f"results/{plan.study.study}"
    contents = [*sorted(packing.words.items()), *([(f"{folder}/", "results")] if results else []), (f"{PROGRAM}/", "versions")]
    width = max(len(place) for place, _ in contents)
    return README_TEXT.format(
        title=title,
        line="=" * len(title),
        version=sph.__version__,
        digest=solver_digest(),
        configuration=shlex.quote(configuration),
        page=f"{plan.folder}/report.html",
        results=RESULTS_TEXT.format(configuration=shlex.quote(configuration)) if results else "",
        scene=shlex.quote(scene),
        program=PROGRAM,
        contents="\n".join(f"   {place:<{width}}  {words}" for place, words in contents),
    )


def _check_kept(value: str, name: str, where: str) -> None:
    """ValueError for a file that is the value of a dimension and would be called otherwise in the archive."""
    if name != value:
        raise ValueError(f"{where}: {value} lies outside the working folder, and runs are named by it; move it below that folder")
