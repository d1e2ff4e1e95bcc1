"""The cache of compiled code is executed: it is its user's alone, or refused before anything in it is read or made."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from sph.solver.compiled import private
from sph.solver.compiled.jit import cache_folder, compile_lock
from sph.solver.compiled.private import for_user_alone, make_private, refuse_shared

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owners here")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache of some sources, with a file of code, as it is made."""
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path / "cache"))
    make_private(cache_folder())
    with for_user_alone():
        (cache_folder() / "code").mkdir()
        (cache_folder() / "code" / "f.1.nbc").write_bytes(b"code")
    return cache_folder()


def refused(folder: Path) -> str:
    """What is said; nothing was made."""
    before = sorted(folder.rglob("*"))
    with pytest.raises(OSError) as error, compile_lock("walls"):
        pass
    assert sorted(folder.rglob("*")) == before
    said = str(error.value)
    assert said.startswith(f"{folder}: compiled code cannot be kept there") and "set SPH_CACHE_DIR to a folder" in said
    return said


def test_a_private_folder_is_used(folder: Path) -> None:
    with compile_lock("walls"):
        pass
    assert list(folder.glob("*/lock"))


@pytest.mark.parametrize("bit", [stat.S_IWGRP, stat.S_IWOTH], ids=["group", "others"])
@pytest.mark.parametrize("name", ["..", ".", "code", "code/f.1.nbc"])
def test_what_others_may_write_is_refused(folder: Path, name: str, bit: int) -> None:
    place = (folder / name).resolve()
    place.chmod(place.stat().st_mode | bit)
    said = refused(folder)
    assert f"others may write to {place}, mode {stat.S_IMODE(place.stat().st_mode):o}: chmod -R go-w '{place}'" in said
    subprocess.run(["chmod", "-R", "go-w", place], check=True)
    refuse_shared(folder)


def to_another(place: Path) -> None:
    os.chown(place, 12345, -1, follow_symlinks=False)


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="root alone gives files away")
@pytest.mark.parametrize("name", ["..", ".", "code", "code/f.1.nbc"])
def test_what_another_user_owns_is_refused(folder: Path, name: str) -> None:
    place = (folder / name).resolve()
    to_another(place)
    assert f"{place} belongs to user 12345, not to 0" in refused(folder)


def test_a_folder_of_root_is_not_ones_own(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its parent may be root's: here whoever made both stands for root."""
    owner = os.getuid()
    monkeypatch.setattr(private, "ROOT", owner)
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    assert f"{folder} belongs to user {owner}, not to {owner + 1}" in refused(folder)
    monkeypatch.setattr(private, "ROOT", owner + 2)
    assert f"/cache belongs to user {owner}, not to {owner + 1}" in refused(folder) or "the link " in refused(folder)


def test_a_parent_with_the_sticky_bit_is_roots(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As /tmp, in which none may take away what another has made."""
    folder.parent.chmod(0o1777)
    monkeypatch.setattr(private, "ROOT", os.getuid())
    refuse_shared(folder)
    monkeypatch.setattr(private, "ROOT", os.getuid() + 1)
    assert "others may write" in refused(folder)
    folder.parent.chmod(0o777)
    monkeypatch.setattr(private, "ROOT", os.getuid())
    assert "others may write" in refused(folder)


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="root alone gives files away")
@pytest.mark.parametrize("chained", [False, True], ids=["on the way", "behind another"])
def test_a_link_of_another_user_is_refused(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chained: bool) -> None:
    link = tmp_path / "link"
    link.symlink_to(folder.parent)
    if chained:
        (tmp_path / "own").symlink_to("link")
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path / ("own" if chained else "link")))
    with compile_lock():
        pass
    to_another(link)
    assert f"the link {link} belongs to user 12345, not to 0" in refused(cache_folder())


def test_a_link_of_ones_own_leads_to_a_folder_that_is_judged(folder: Path, tmp_path: Path) -> None:
    """Not only the folder in which the link lies."""
    behind = tmp_path / "open" / "behind"
    make_private(behind)
    folder.rename(tmp_path / "moved")
    folder.symlink_to(behind)
    with compile_lock():
        pass
    behind.parent.chmod(0o777)
    assert f"others may write to {behind.parent}" in refused(folder)


@pytest.mark.long
def test_what_is_made_is_private_whatever_the_umask(tmp_path: Path) -> None:
    """With rights for all by default, code is compiled, kept and loaded again."""
    script = (
        "import os; os.umask(0)\n"
        "from sph.solver.compiled.jit import compile_lock\n"
        "from sph.solver.physics.kernels import evaluate, make_kernel\n"
        "with compile_lock('kernel'): evaluate(make_kernel('cubic_spline', 1.0), 0.5)\n"
        "print(sum(evaluate.stats.cache_hits.values()))\n"
        "open('result', 'w').close()"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT), "SPH_CACHE_DIR": str(tmp_path / "new" / "cache")}
    found = [
        subprocess.run([sys.executable, "-c", script], env=environment, cwd=tmp_path, check=True, capture_output=True, text=True).stdout
        for _ in range(2)
    ]
    assert found == ["0\n", "1\n"]
    made = [tmp_path / "new", *(tmp_path / "new").rglob("*")]
    assert any(path.suffix == ".nbc" for path in made)
    assert not [path for path in made if path.stat().st_mode & private.OTHERS]
    assert all(stat.S_IMODE(path.stat().st_mode) == 0o700 for path in made if path.is_dir())
    assert (tmp_path / "result").stat().st_mode & private.OTHERS, "other files have the rights that their user gives"


def test_a_loop_of_links_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cache").symlink_to("other")
    (tmp_path / "other").symlink_to("cache")
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path / "cache"))
    with pytest.raises(OSError, match="cannot be kept"), compile_lock():
        pass


def test_systems_without_users_are_not_asked(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder.chmod(0o777)
    monkeypatch.delattr(os, "getuid")
    refuse_shared(folder)
