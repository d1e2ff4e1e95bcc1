"""The cache of compiled code: keyed by the sources, and safe when processes compile at the same time."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numba
import pytest

import sph
from sph.jobs.progress import compiling
from sph.solver.compiled.jit import COMPILED, before_compiling, compile_lock

PACKAGE = Path(sph.__file__).parent


def environment(root: Path, **extra: str) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"} | extra


COMPILES = {"jit", "entry", "slot", "of", "overload"}
"""Decorators of functions that become machine code; ``of`` is that of a slot."""


def jitted(tree: ast.Module) -> list[ast.FunctionDef]:
    """Functions of a file that become machine code."""

    def name(mark: ast.expr) -> str:
        mark = mark.func if isinstance(mark, ast.Call) else mark
        return mark.id if isinstance(mark, ast.Name) else mark.attr if isinstance(mark, ast.Attribute) else ""

    return [node for node in tree.body if isinstance(node, ast.FunctionDef) and {name(mark) for mark in node.decorator_list} & COMPILES]


def test_the_list_of_compiled_files_is_complete() -> None:
    trees = {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text()) for path in PACKAGE.rglob("*.py")}
    needed = set()
    for file, tree in trees.items():
        functions = jitted(tree)
        if functions:
            used = {node.id for function in functions for node in ast.walk(function) if isinstance(node, ast.Name)}
            needed |= {file, *(imported for imported, names in imports(tree) if used & names)}
    assert {
        "solver/physics/kernels.py",
        "solver/state.py",
        "solver/physics/capped_viscosity.py",
        "stability/limit_equilibrium.py",
    } <= needed
    assert not {file for file in needed if not any(Path(file).is_relative_to(listed) for listed in COMPILED)}


def imports(tree: ast.Module) -> list[tuple[str, set[str]]]:
    """Files of the solver that a file imports from, with the names."""
    nodes = [node for node in tree.body if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sph.solver.")]
    return [
        (str(node.module).removeprefix("sph.").replace(".", "/") + ".py", {name.asname or name.name for name in node.names})
        for node in nodes
    ]


PLACE = """
import sys
from sph.solver.compiled.jit import cache_folder, compile_lock, compiled_digest
from sph.solver.physics.kernels import evaluate
import numba
with compile_lock():
    pass
print(evaluate.stats.cache_path)
print(cache_folder())
print(compiled_digest())
print(numba.config.CACHE_DIR)
"""


@pytest.mark.parametrize("name", ["SPH_CACHE_DIR", "XDG_CACHE_HOME", "HOME"])
@pytest.mark.parametrize("relative", [False, pytest.param(True, marks=pytest.mark.long)])
def test_cache_folder_follows_the_environment(tmp_path: Path, name: str, relative: bool) -> None:
    """An empty variable is none: the working folder is no place for compiled code."""
    empty = dict.fromkeys(("SPH_CACHE_DIR", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"), "")
    given = {name: "place" if relative and name != "HOME" else str(tmp_path / "place")}
    done = subprocess.run(
        [sys.executable, "-c", PLACE],
        env=environment(PACKAGE.parent, **empty | given),
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )
    used, folder, digest, own = done.stdout.split("\n")[:4]
    place = tmp_path / "place" / {"SPH_CACHE_DIR": "", "XDG_CACHE_HOME": "sph", "HOME": ".cache/sph"}[name] / digest
    assert Path(folder) == place and Path(used).parent == place / "shared"
    assert own == "", "the user's own functions are cached where they were"
    assert [path.name for path in tmp_path.iterdir()] == ["place"]


# ---------------------------------------------------------------- compiled here, or loaded


DIGEST = """
import hashlib, json, sys
from sph.solver.integration import advance
from sph.scene.schema import make_scene
from sph.solver.run import run
from sph.jobs.progress import reporter

scene = make_scene(json.loads(sys.argv[1]))
with reporter("test", scene) as report:
    result = run(scene, report=report)
print(sum(advance.stats.cache_misses.values()), hashlib.sha256(b"".join(a.values.tobytes() for a in result.restart.values())).hexdigest())
"""


class Cached(NamedTuple):
    """A scene's code in a cache of its own."""

    cache: Path
    scene: str

    def start(self) -> subprocess.Popen[str]:
        """A process that runs the scene."""
        return subprocess.Popen(
            [sys.executable, "-c", DIGEST, self.scene],
            env=environment(PACKAGE.parent, SPH_CACHE_DIR=str(self.cache)),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


def outcome(process: subprocess.Popen[str]) -> tuple[str, str]:
    """How many variants of ``advance`` a process compiled, and the digest of its result."""
    out, error = process.communicate(timeout=300)
    assert process.returncode == 0, error
    compiled, digest = out.split()
    assert error.count("test: compiling the solver") == int(compiled), "compiling is said before it is done, once"
    return compiled, digest


@pytest.mark.long
def test_processes_that_start_at_once_compile_once_and_have_the_same_bits(tmp_path: Path, small_slope: Callable[..., Any]) -> None:
    """The first process on a machine compiles all terms of the default scene, the others wait and load; so do those of later."""
    cached = Cached(tmp_path, json.dumps(small_slope({"duration": 1.2}).model_dump(mode="json")))
    found = [outcome(process) for process in [cached.start(), cached.start()]]
    found.append(outcome(cached.start()))
    assert sorted(compiled for compiled, _ in found) == ["0", "0", "1"] and found[2][0] == "0"
    assert len({digest for _, digest in found}) == 1


# ---------------------------------------------------------------- the folder


WAIT = "import sys\nfrom sph.solver.compiled.jit import compile_lock\nwith compile_lock(sys.argv[1]): pass"


def test_only_the_same_variant_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that compiles holds up those that want the same, which then load it, and no others."""
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path))
    with compile_lock("walls"):
        same, other = (
            subprocess.Popen([sys.executable, "-c", WAIT, variant], env=environment(PACKAGE.parent)) for variant in ("walls", "layers")
        )
        assert other.wait(timeout=60) == 0
        with pytest.raises(subprocess.TimeoutExpired):
            same.wait(timeout=3)
    assert same.wait(timeout=60) == 0


def test_a_cache_folder_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder should be")
    done = subprocess.run(
        [sys.executable, "-c", "from sph.solver.compiled.jit import compile_lock\nwith compile_lock(): pass"],
        env=environment(PACKAGE.parent, SPH_CACHE_DIR=str(tmp_path / "cache")),
        capture_output=True,
        text=True,
    )
    last = done.stderr.splitlines()[-1]
    assert str(tmp_path / "cache") in last and "set SPH_CACHE_DIR" in last


def test_how_long_a_variant_took_to_compile_is_told_the_next_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SPH_CACHE_DIR", str(tmp_path))
    told: list[float | None] = []
    for variant in ("walls", "walls", "walls, damping"):
        function = numba.njit(lambda x: x + 1)
        with before_compiling(function, variant, told.append):
            assert function(1) == 2 and function(2) == 3
    assert told[0] is None and told[1] is not None and told[1] >= 0 and told[2:] == [None]
    assert "with walls, once per machine (it took 12 s last time)" in compiling("walls", 12.3)
    (tmp_path / "compiling.json").write_text("damaged")
    damaged = numba.njit(lambda x: x)
    with before_compiling(damaged, "walls", told.append):
        assert damaged(1) == 1 and told[3:] == [None]
