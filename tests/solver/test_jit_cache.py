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
    solver = PACKAGE / "solver"
    trees = {path.relative_to(solver).as_posix(): ast.parse(path.read_text()) for path in solver.rglob("*.py")}
    needed = set()
    for file, tree in trees.items():
        functions = jitted(tree)
        if functions:
            used = {node.id for function in functions for node in ast.walk(function) if isinstance(node, ast.Name)}
            needed |= {file, *(imported for imported, names in imports(tree) if used & names)}
    assert {"physics/kernels.py", "boundaries/free_field.py", "state.py", "terms.py", "physics/capped_viscosity.py"} <= needed
    listed = {path.removeprefix("solver/") for path in COMPILED}
    assert not {file for file in needed if file not in listed and file.split("/")[0] not in listed}
    assert not any(jitted(ast.parse(path.read_text())) for path in PACKAGE.rglob("*.py") if not path.is_relative_to(solver))


def imports(tree: ast.Module) -> list[tuple[str, set[str]]]:
    """Files of the solver that a file imports from, with the names."""
    nodes = [node for node in tree.body if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sph.solver.")]
    return [
        (str(node.module).removeprefix("sph.solver.").replace(".", "/") + ".py", {name.asname or name.name for name in node.names})
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


# ---------------------------------------------------------------- the race

WORKER = """
import fcntl, hashlib, json, os, sys, time
from pathlib import Path
from numba.core import caching

role, scene_json = sys.argv[1:]  # "first" or "second" to compile, "load"
outside = []

from sph.solver.terms import active_terms
from sph.scene.schema import make_scene
from sph.solver.run import Run

meetings = Path(os.environ["SPH_CACHE_DIR"])
met = None


def lock_is_free(folder):
    with open(folder / "lock", "w") as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True


def meet(name):
    # Wait until the other process saves the same function; with a lock it never comes, and the wait is given up.
    global met
    if met is False:
        return
    own, other = (meetings / f"{name}.{who}" for who in (("first", "second") if role == "first" else ("second", "first")))
    own.touch()
    end = time.time() + (3.0 if met is None else 1.0)
    while not other.exists() and time.time() < end:
        time.sleep(0.002)
    met = bool(met) or other.exists()
    if not met:
        own.unlink()


def save(self, key, data):
    # numba's own steps, in the order that hurts: both read the index, the second's index is the last, the
    # first's data are the last.
    name = self._index_name.split("-")[0]
    if lock_is_free(Path(self._index_path).parents[1]):
        outside.append(name)
    meet(name)
    overloads = self._load_index()
    data_name = overloads.get(key)
    if data_name is None:
        data_name = next(n for n in map(self._data_name, range(1, 99)) if n not in set(overloads.values()))
        overloads[key] = data_name
        time.sleep(0.15 if met and role == "second" else 0.05 if met else 0.0)
        self._save_index(overloads)
    time.sleep(0.2 if met and role == "first" else 0.0)
    self._save_data(data_name, data)
    time.sleep(0.1 if met and role == "second" else 0.0)


if role != "load":
    caching.IndexDataCacheFile.save = save

run = Run(make_scene(json.loads(scene_json)))
result = run.go()
digest = hashlib.sha256()
for name in ("x", "y", "velocity_x", "velocity_y", "stress_xx", "stress_xy", "density", "elastic_energy"):
    digest.update(result.trajectory[name].values.tobytes())
print(json.dumps({
    "asked": result.trajectory.attrs["active_terms"].split(),
    "compiled": [bool(t) for t in active_terms(run.simulation.terms)],
    "digest": digest.hexdigest(),
    "saved outside the lock": sorted(set(outside)),
}))
"""


def start(scene: dict[str, Any], role: str, cache: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", WORKER, role, json.dumps(scene)],
        env=environment(PACKAGE.parent, SPH_CACHE_DIR=str(cache)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def outcome(process: subprocess.Popen[str]) -> dict[str, Any]:
    out, error = process.communicate(timeout=300)
    assert process.returncode == 0, error
    return json.loads(out.splitlines()[-1])


@pytest.fixture(scope="module")
def race(tmp_path_factory: pytest.TempPathFactory, free_block: Callable[..., Any]) -> list[dict[str, Any]]:
    """Two variants compiled at the same time into one fresh cache, then both loaded from it.

    Without the lock of ``sph.solver.compiled.jit.compile_lock`` the order forced in ``save`` breaks the loading processes.
    """
    cache = tmp_path_factory.mktemp("cache")
    bare = {
        "duration": 0.02,
        "geometry": {"shape": "block", "width": 4.0, "height": 4.0},
        "gravity.acceleration": 9.81,
        "damping": None,
        "numerics.artificial_viscosity": None,
        "numerics.short_range_repulsion": None,
    }
    scenes = [free_block(bare | {"numerics.kernel": kernel}).model_dump(mode="json") for kernel in ("cubic_spline", "wendland_c2")]
    compiling = [start(scene, role, cache) for scene, role in zip(scenes, ("first", "second"), strict=True)]
    found = [outcome(process) for process in compiling]
    loading = [start(scene, "load", cache) for scene in scenes]
    return found + [outcome(process) for process in loading]


@pytest.mark.long
def test_each_process_gets_the_variant_it_asked_for(race: list[dict[str, Any]]) -> None:
    cubic, wendland, cubic_loaded, wendland_loaded = race
    assert cubic["compiled"] == cubic_loaded["compiled"]
    assert not cubic_loaded["compiled"][0], "Wendland code where the cubic spline was asked for"
    assert wendland_loaded["compiled"][0], "cubic spline code where Wendland was asked for"
    assert "wendland_c2" in wendland_loaded["asked"]
    # Code from the cache does what the code compiled in the process's own memory did, bit for bit.
    assert cubic_loaded["digest"] == cubic["digest"]
    assert wendland_loaded["digest"] == wendland["digest"]
    assert cubic["digest"] != wendland["digest"]


@pytest.mark.long
def test_nothing_is_saved_to_the_cache_outside_the_lock(race: list[dict[str, Any]]) -> None:
    for process in race[:2]:
        assert process["saved outside the lock"] == []


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
    digest: str

    def run(self) -> tuple[str, str]:
        """How many variants of ``advance`` a process compiled, and the digest of its result."""
        done = subprocess.run(
            [sys.executable, "-c", DIGEST, self.scene],
            env=environment(PACKAGE.parent, SPH_CACHE_DIR=str(self.cache)),
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        compiled, digest = done.stdout.split()
        assert done.stderr.count("test: compiling the solver") == int(compiled), "compiling is said before it is done, once"
        return compiled, digest


@pytest.fixture(scope="module")
def cached(tmp_path_factory: pytest.TempPathFactory, small_slope: Callable[..., Any]) -> Cached:
    """All terms of the default scene, compiled."""
    scene = json.dumps(small_slope({"duration": 1.2}).model_dump(mode="json"))
    first = Cached(tmp_path_factory.mktemp("cache"), scene, "")
    compiled, digest = first.run()
    assert compiled == "1", "the first must compile for the tests to mean something"
    return first._replace(digest=digest)


@pytest.mark.long
def test_compiled_and_loaded_code_give_the_same_bits(cached: Cached) -> None:
    """The first process on a machine compiles, the others of a study load."""
    assert cached.run() == ("0", cached.digest)


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
