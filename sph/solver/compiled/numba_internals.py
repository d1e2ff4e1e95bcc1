"""All that the solver takes from inside numba, which a release of numba may change: how its functions become machine code, and the cache.

The rest of the solver uses what numba documents.  ``pyproject.toml`` bounds the releases, and
``tests/solver/test_numba_internals.py`` says what to look at when another one comes.

* The solver has a code generator of its own, with options of the processor and of LLVM that the user's functions do not get.
* Functions that are only ever inlined get no machine code: numba makes it of every function when it has compiled it, and looks up its
  address, but nobody calls them.  Of what is inlined not a bit changes.
* One process at a time reads or writes the files of the cache.
"""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import platform
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache, update_wrapper
from pathlib import Path
from typing import Any

import llvmlite.binding
import numba
from llvmlite import ir
from numba.core import cgutils
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher

VECTORISER = {"runtime-memory-check-threshold": (1000, 8), "force-vector-interleave": (1, 0)}
"""Options of LLVM's vectoriser while it works on the solver, and otherwise: how many pairs of arrays it may test for overlap before a
loop (that over the stress state touches some twenty arrays, and with the usual limit of 8 stays scalar); one vector a turn, since rows of
neighbours are short, and what does not fill a turn is done one by one (a fifth at 19 neighbours)."""
PROCESSOR = ",+prefer-no-gather,+prefer-256-bit"
"""Eight single loads are faster than the processor's own gather of eight (by a third on Zen 4), and half vectors fill more rows."""


@contextmanager
def _vectoriser() -> Iterator[None]:
    """The vectoriser's options for the solver; numba compiles in one thread at a time."""
    for name, (solver, _) in VECTORISER.items():
        llvmlite.binding.set_option("sph", f"-{name}={solver}")
    try:
        yield
    finally:
        for name, (_, usual) in VECTORISER.items():
            llvmlite.binding.set_option("sph", f"-{name}={usual}")


class SolverLibrary(JITCodeLibrary):
    """Code of one function, with what is inlined into it."""

    def _optimize_final_module(self) -> None:
        with _vectoriser():
            super()._optimize_final_module()


class InlinedLibrary(JITCodeLibrary):
    """Code of one function, ready to be linked into others.

    It is tidied, without which loops that it is inlined into do not vectorise (numba counts references to arrays, and finds only here that
    it need not), but optimised with those others alone; and it is no machine code.
    """

    def _optimize_functions(self, module: Any) -> None:
        """As numba does, but for those that are only declared."""
        module.data_layout = self._codegen._data_layout
        for function in module.functions:
            if not function.is_declaration:
                manager, builder = self._codegen._function_pass_manager()
                manager.run(function, builder)

    def _optimize_final_module(self) -> None:
        """Nothing."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """No address."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> InlinedLibrary:
        """Where the function's environment is set: here, by doing nothing."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Without machine code nobody reads it."""


class SolverCodegen(JITCPUCodegen):
    """Makes machine code of the solver; the user's functions have numba's own."""

    _library_class = SolverLibrary

    def _customize_tm_features(self) -> str:
        """Of the processor, as the user or else numba says, the latter with ``PROCESSOR``."""
        features = str(super()._customize_tm_features())
        chosen = numba.config.CPU_FEATURES is not None  # type: ignore[attr-defined]
        return features if chosen or platform.machine() not in ("x86_64", "AMD64") else features + PROCESSOR


@cache
def codegen() -> SolverCodegen:
    """The one of this process."""
    return SolverCodegen("sph")


class SolverCompiler(Compiler):
    """numba's compiler, into a ``SolverLibrary``."""

    def compile_extra(self, func: Any) -> Any:
        """The result of compiling a function."""
        self.state.library = codegen().create_library(func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


class InlinedCompiler(Compiler):
    """numba's compiler, into an ``InlinedLibrary``."""

    def compile_extra(self, func: Any) -> Any:
        """The result of compiling a function."""
        self.state.library = InlinedLibrary(codegen(), func.__qualname__)
        return super().compile_extra(func)


class _InlinedDispatcher(CPUDispatcher):
    """A function compiled into those that call it, without the wrapper for calls from Python: such a call makes one.

    ``numba.jit`` gives no function that can be called without a wrapper, and ``overload`` types what may be None otherwise.
    """

    outer: Any

    def __call__(self, *arguments: Any) -> Any:
        return self.outer(*arguments)


def inlined_dispatcher(function: Callable[..., Any], inlined: dict[str, Any], called: dict[str, Any]) -> Any:
    """A function that is compiled by the options ``inlined`` into those that call it, and by ``called`` for calls from Python."""
    options = {name: value for name, value in inlined.items() if name != "pipeline_class"}
    dispatcher = _InlinedDispatcher(function, targetoptions=options, pipeline_class=inlined["pipeline_class"])
    dispatcher.outer = numba.jit(**called)(lambda *given: dispatcher(*given))
    return update_wrapper(dispatcher, function)


def cache_in(compiled: Any, folder: Path, alone: Callable[[], AbstractContextManager[Any]]) -> None:
    """Have numba keep the machine code of a compiled function in a folder, and read or write its files only within ``alone()``.

    Without this it reads the list of variants, adds its own and writes the list again, whatever other processes do.
    """
    earlier, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder)  # type: ignore[attr-defined]
    try:
        compiled.enable_caching()
    finally:
        numba.config.CACHE_DIR = earlier  # type: ignore[attr-defined]
    compiled._cache._cache_file = _OneAtATime(compiled._cache._cache_file, alone)


class _OneAtATime:
    """numba's files of a function."""

    def __init__(self, files: Any, alone: Callable[[], AbstractContextManager[Any]]) -> None:
        self.files, self.alone = files, alone

    def load(self, key: Any) -> Any:
        """The code of a variant, None if it is not there."""
        with self.alone():
            return self.files.load(key)

    def save(self, key: Any, data: Any) -> None:
        """Add the code of a variant."""
        with self.alone():
            self.files.save(key, data)


def describe_array(c: Any, array: Any, place: Any) -> Any:
    """Write an array's place and shape, without owning it, by numba's own function; not 0 for what is no array."""
    kind = ir.FunctionType(ir.IntType(32), [c.pyapi.pyobj, c.pyapi.voidptr])
    describe = cgutils.get_or_insert_function(c.builder.module, kind, "numba_adapt_ndarray")
    return c.builder.call(describe, [array, c.builder.bitcast(place, c.pyapi.voidptr)])
