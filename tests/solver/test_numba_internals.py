"""What the solver takes from inside numba is there, and nothing of it reaches the user's own functions."""

from __future__ import annotations

import inspect
import os
import platform
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core import caching, codegen, compiler
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from packaging.requirements import Requirement

from sph.solver.compiled.jit import OPTIONS, jit
from sph.solver.compiled.numba_internals import InlinedLibrary, SolverCodegen, SolverLibrary

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


OVERRIDDEN: list[tuple[type, tuple[str, ...]]] = [
    (
        codegen.JITCodeLibrary,
        (
            "_optimize_functions",
            "_optimize_final_module",
            "_finalize_final_module",
            "_finalize_dynamic_globals",
            "_verify_declare_only_symbols",
            "_ensure_finalized",
            "get_pointer_to_function",
            "codegen",
            "enable_object_caching",
        ),
    ),
    (codegen.JITCPUCodegen, ("_customize_tm_features", "_library_class", "create_library", "set_env", "_function_pass_manager")),
    (compiler.Compiler, ("compile_extra",)),
    (Dispatcher, ("enable_caching", "__call__")),
    (caching.IndexDataCacheFile, ("load", "save")),
]
TAKEN: list[tuple[Any, set[str]]] = [
    (CPUDispatcher, {"targetoptions", "pipeline_class"}),
    (caching.IndexDataCacheFile.load, {"key"}),
    (caching.IndexDataCacheFile.save, {"key", "data"}),
    (codegen.JITCodeLibrary._optimize_functions, {"ll_module"}),
]


@pytest.mark.parametrize(("owner", "names"), OVERRIDDEN, ids=lambda each: getattr(each, "__name__", ""))
def test_what_is_used_of_numba_is_there(owner: type, names: tuple[str, ...]) -> None:
    assert not [name for name in names if not hasattr(owner, name)], LOOK


@pytest.mark.parametrize(("function", "names"), TAKEN, ids=lambda each: getattr(each, "__qualname__", ""))
def test_it_is_called_as_numba_calls_it(function: Any, names: set[str]) -> None:
    assert names <= set(inspect.signature(function).parameters), LOOK


@jit
def inner(x):  # type: ignore[no-untyped-def]
    return 2.0 * x + 1.0


@numba.jit(**OPTIONS)
def outer(x):  # type: ignore[no-untyped-def]
    return inner(x)


def test_what_is_inlined_gets_no_machine_code_of_its_own() -> None:
    assert outer(3.0) == 7.0
    (inlined,), (called,) = inner.overloads.values(), outer.overloads.values()
    engine = called.library.codegen._engine
    assert isinstance(called.library, SolverLibrary) and isinstance(called.library.codegen, SolverCodegen)
    assert engine.is_symbol_defined(called.fndesc.llvm_func_name)
    assert isinstance(inlined.library, InlinedLibrary)
    assert not engine.is_symbol_defined(inlined.fndesc.llvm_func_name)
    assert inlined.fndesc.llvm_func_name not in called.library.get_llvm_str(), "inlined everywhere"
    assert inner(3.0) == 7.0, "from Python, too"


USERS = """
import importlib, pkgutil, sys
import llvmlite.binding as llvm
import numba

told = []
set_option = llvm.set_option
llvm.set_option = lambda name, option: (told.append(option), set_option(name, option))


def settings():
    return {name: getattr(numba.config, name) for name in dir(numba.config) if name.isupper()}


before = settings()
import sph
for module in pkgutil.walk_packages(sph.__path__, "sph."):
    importlib.import_module(module.name)
assert settings() == before and not told, (told, "by importing")

from sph.solver.compiled.numba_internals import PROCESSOR, VECTORISER, codegen
from sph.solver.physics.kernels import evaluate, make_kernel

evaluate(make_kernel("cubic_spline", 1.0), 0.5)
assert settings() == before, "by compiling"
last = dict(option[1:].split("=") for option in told)
assert last == {name: str(usual) for name, (_, usual) in VECTORISER.items()}, last
assert {f"-{name}={solver}" for name, (solver, _) in VECTORISER.items()} <= set(told)


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


def test_the_users_own_functions_are_compiled_as_without_the_solver() -> None:
    own = features().split(",")
    assert not X86 or "+prefer-no-gather" in own and "+sse2" in own


@pytest.mark.skipif(not X86, reason="other processors have no such instructions to leave out")
@pytest.mark.long
def test_the_user_says_what_the_processor_has() -> None:
    assert features(NUMBA_CPU_FEATURES="+sse2") == "+sse2"
