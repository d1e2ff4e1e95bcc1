"""What the solver takes from inside numba is there, and nothing of it reaches the user's own functions."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core import codegen, compiler
from numba.core.dispatcher import Dispatcher
from packaging.requirements import Requirement

from sph.solver.compiled.jit import jit

ROOT = Path(__file__).resolve().parents[2]
LOOK = (
    f"numba {numba.__version__}: compare sph/solver/compiled/numba_internals.py with it, run all tests, raise the bound in pyproject.toml"
)
X86 = platform.machine() in ("x86_64", "AMD64")


def test_this_release_of_numba_has_been_looked_at() -> None:
    named = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    bounds = {each.name: each.specifier for each in map(Requirement, named)}
    assert numba.__version__ in bounds["numba"], LOOK
    major, minor = map(int, numba.__version__.split(".")[:2])
    assert f"{major}.{minor + 1}.0" not in bounds["numba"] and any(each.operator == "<" for each in bounds["llvmlite"]), LOOK


USED: list[tuple[Any, set[str]]] = [
    (codegen.JITCPUCodegen, {"create_library", "magic_tuple"}),
    (codegen.JITCodeLibrary, {"enable_object_caching"}),
    (compiler.Compiler, {"compile_extra"}),
    (compiler.Flags, {"no_cpython_wrapper"}),
    (Dispatcher, {"enable_caching"}),
]


@pytest.mark.parametrize(("owner", "names"), USED, ids=lambda each: getattr(each, "__name__", ""))
def test_what_is_used_of_numba_is_there(owner: type, names: set[str]) -> None:
    assert names <= set(dir(owner)), LOOK


@jit
def inner(x):  # type: ignore[no-untyped-def]
    return 2.0 * x + 1.0


@jit
def outer(x):  # type: ignore[no-untyped-def]
    return inner(x)


def test_everything_is_inlined() -> None:
    assert outer(3.0) == 7.0 and inner(3.0) == 7.0
    (inlined,), (called,) = inner.overloads.values(), outer.alone.overloads.values()
    assert inlined.fndesc.llvm_func_name not in called.library.get_llvm_str()


USERS = """
import importlib, pkgutil, sys
import llvmlite.binding as llvm
import numba

told = []
llvm.set_option = lambda name, option: told.append(option)


def settings():
    return {name: getattr(numba.config, name) for name in dir(numba.config) if name.isupper()}


before = settings()
import sph
for module in pkgutil.walk_packages(sph.__path__, "sph."):
    if not module.name.startswith("sph.solver.cuda"):  # numba-cuda has settings of its own
        importlib.import_module(module.name)
assert settings() == before, "by importing"

from sph.solver.compiled.numba_internals import PROCESSOR, codegen
from sph.solver.physics.kernels import evaluate, make_kernel

evaluate(make_kernel("cubic_spline", 1.0), 0.5)
assert settings() == before and not told, (told, "by compiling")


@numba.njit
def own(x):
    return x + 1.0


own(1.0)
(compiled,) = own.overloads.values()
assert PROCESSOR not in compiled.library.codegen.magic_tuple()[2]
print(codegen().magic_tuple()[2])
"""


def features(**chosen: str) -> str:
    """Of the processor for which the solver is compiled, in a process that sees what else numba and LLVM are told."""
    known = {name: value for name, value in os.environ.items() if name != "NUMBA_CPU_FEATURES"}
    done = subprocess.run([sys.executable, "-c", USERS], env=known | chosen, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.long
def test_the_users_own_functions_are_compiled_as_without_the_solver() -> None:
    own = features().split(",")
    assert not X86 or "+prefer-no-gather" in own and "+sse2" in own


@pytest.mark.skipif(not X86, reason="other processors have no such instructions to leave out")
@pytest.mark.long
def test_the_user_says_what_the_processor_has() -> None:
    assert features(NUMBA_CPU_FEATURES="+sse2") == "+sse2"
