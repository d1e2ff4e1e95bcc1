"""What a digest of sources sees: an edit of what is executed, and none of words, in a copy of the library."""

from __future__ import annotations

import ast
import os
import shutil
from pathlib import Path
from typing import NamedTuple

import pytest

import sph
from sph.solver.compiled import jit
from sph.stability import record
from sph.storage import sources as storage_sources
from sph.storage.sources import sources_digest, words
from sph.study import planned
from sph.study.planned import contents, sources

LIBRARY = Path(sph.__file__).parent


class Digests(NamedTuple):
    """Of one state of the copy."""

    compiled: str
    solver: str
    search: str
    analysis: str
    page: str
    walls: str


@pytest.fixture
def copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the digests look in the place of the library."""
    shutil.copytree(LIBRARY, tmp_path / "sph", ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "PACKAGE", tmp_path / "sph")
    monkeypatch.setattr(record, "PACKAGE", tmp_path / "sph")
    monkeypatch.setattr(record, "solver_digest", jit.solver_digest.__wrapped__)
    monkeypatch.setattr(planned, "LIBRARY", tmp_path / "sph")
    return tmp_path


def digests() -> Digests:
    return Digests(
        jit.compiled_digest.__wrapped__(),
        jit.solver_digest.__wrapped__(),
        record.search_digest(),
        sources("measures/*.py", "study/*.py", "experiments/**/*.py", "experiments/measured/*.csv"),
        sources("page/*.*"),
        contents("scene/walls.py"),
    )


def edit(copy: Path, name: str, old: str, new: str) -> None:
    """Replace the first place of a text in a file of the copy, which keeps its date."""
    file = copy / "sph" / name
    text, before = file.read_text(), file.stat()
    assert old in text, (name, old)
    file.write_text(text.replace(old, new, 1))
    os.utime(file, (before.st_atime, before.st_mtime))


EDITED_WORDS = (
    # docstrings and comments
    ("solver/physics/kernels.py", "Smoothing kernels in two dimensions", "Kernels in the plane"),
    ("solver/physics/kernels.py", "smoothing length, m", "half of the support, m"),
    ("solver/integration.py", "# Damping acts on", "# It acts on"),
    ("experiments/base.py", "from __future__", "# A comment.\nfrom __future__"),
    ("study/tables.py", "Column of words of a flat table.", "A column of words."),
    # messages of errors
    ("scene/schema.py", "would skip samples of", "does not see all samples of"),
    ("solver/restart.py", "cannot continue from this run", "this run cannot be continued"),
    # descriptions, labels, sentences
    ("scene/walls.py", "lid of the box", "cover of the box"),
    ("scene/walls.py", "Sec. 2.4; no_slip", "Section 2.4; no_slip"),
    ("scene/walls.py", "free-slip side wall", "smooth side wall"),
    ("storage/trajectory.py", "horizontal position in the frame", "horizontal place in the frame"),
    ("solver/guard.py", "has left the box", "is no longer in the box"),
    ("solver/guard.py", "particles that meet fast pass", "particles pass"),
    ("measures/metrics.py", "how the run ended", "how it ended"),
    ("stability/record.py", "The trials of a search, and what it found.", "What a search found."),
)
EXECUTED = (
    # file, edit, digests that change
    ("solver/physics/kernels.py", "1.0 + 2.0 * q", "1.0 + 2.5 * q", {"compiled", "solver", "search"}),
    ("scene/schema.py", "MAX_STEPS = ", "MAX_STEPS = 2 * ", {"solver", "search"}),
    ("scene/walls.py", '"contact side wall", reflects=True', '"contact side wall", grips=True', {"solver", "search", "walls"}),
    ("storage/trajectory.py", '"y", FRAME, "f4", "m"', '"y", FRAME, "f8", "m"', {"solver", "search"}),
    ("measures/metrics.py", "0.5 *", "0.6 *", {"analysis"}),
    ("stability/record.py", "!= digest", "== digest", {"search"}),
    ("experiments/measured/cost-accuracy.csv", "spacing", "spacings", {"analysis"}),
    ("page/page.css", "margin: ", "margin:  ", {"page"}),
    ("storage/files.py", "MAX_HIDDEN = 140", "MAX_HIDDEN = 139", set()),
    ("scene/scheme.py", '"no_slip"', '"fixed"', set()),
)


def test_words_change_no_digest(copy: Path) -> None:
    before = digests()
    for name, old, new in EDITED_WORDS:
        edit(copy, name, old, new)
    after = digests()
    assert after._replace(walls=before.walls) == before
    assert after.walls != before.walls, "of which figures write the labels"


def test_what_is_executed_changes_the_digests_of_what_it_decides(copy: Path) -> None:
    before = digests()
    assert before == digests()
    for name, old, new, changes in EXECUTED:
        edit(copy, name, old, new)
        after = digests()
        assert {field for field in Digests._fields if getattr(after, field) != getattr(before, field)} == changes, name
        before = after


def digest(folder: Path, text: str, name: str = "a.py") -> str:
    """Of one file."""
    folder.mkdir()
    (folder / name).write_text(text)
    return sources_digest([folder / name], folder)


def test_an_argument_counts_unless_it_is_a_text_in_its_place(tmp_path: Path) -> None:
    texts = [
        'key("a", "m", "b", ge=0)',
        'key("c", "m", "d", ge=0)',
        'key("a", "s", "b", ge=0)',
        'key(a, "m", "b", ge=0)',
        'other("a", "m", "b", ge=0)',
    ]
    first, words_alone, *others = (digest(tmp_path / str(number), text) for number, text in enumerate(texts))
    assert words_alone == first and len({first, *others}) == 4


def test_a_text_that_is_used_counts(tmp_path: Path) -> None:
    texts = ['x = "a"', 'x = "b"', 'x = words("a")', 'x = words("b")', 'raise ValueError("a") from b', 'raise TypeError("a") from b']
    found = [digest(tmp_path / str(number), text) for number, text in enumerate(texts)]
    assert found[2] == found[3] and len(set(found)) == 5
    assert words("a") == "a"


def test_names_and_all_that_is_no_python_count(tmp_path: Path) -> None:
    assert digest(tmp_path / "one", "1", "a.csv") != digest(tmp_path / "two", "1", "b.csv")
    assert digest(tmp_path / "three", "# 1", "a.csv") != digest(tmp_path / "four", "# 2", "a.csv")
    with pytest.raises(ValueError, match="sources: solver/gone"):
        sources("solver/gone*.py")


def test_a_text_is_parsed_once_for_all_processes_of_a_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path / "cache"))
    kept, parse = tmp_path / "cache" / storage_sources.KEPT, ast.parse
    parsed, found, number = list[bytes](), list[str](), iter(range(99))

    def counted(data: bytes) -> ast.Module:
        parsed.append(data)
        return parse(data)

    monkeypatch.setattr(ast, "parse", counted)

    def times_parsed(text: str) -> int:
        """By a new process."""
        monkeypatch.setattr(storage_sources, "_known", {})
        parsed.clear()
        found.append(digest(tmp_path / str(next(number)), text))
        return len(parsed)

    assert times_parsed("x = 1") == times_parsed("x = 1") == 1 and not kept.parent.exists(), "who compiles makes it, for the user alone"
    kept.parent.mkdir()
    assert times_parsed("x = 1") == 1 and kept.stat().st_mode & 0o777 == 0o600
    assert times_parsed("x = 1") == 0 and len(set(found)) == 1
    assert times_parsed("x = 2") == 1 and times_parsed("x = 2") == times_parsed("x = 1") == 0 and len(set(found)) == 2
    kept.chmod(0o666)
    assert times_parsed("x = 1") == 1, "another user may have written it"
    for damaged in ("", "[1, 2]", "7"):
        kept.write_text(damaged)
        assert times_parsed("x = 1") == 1
    assert found[-1] == found[0]
