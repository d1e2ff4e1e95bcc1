"""All that the solver takes from inside numba, which a release of numba may change: the processor's features, and arrays in records.

The rest of the solver uses what numba documents.  ``pyproject.toml`` bounds the releases, and
``tests/solver/test_numba_internals.py`` says what to look at when another one comes.
"""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import platform
from functools import cache
from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils
from numba.core.codegen import JITCPUCodegen, get_host_cpu_features
from numba.core.compiler import Compiler

PROCESSOR = ",+prefer-no-gather,+prefer-256-bit"
"""Eight single loads are faster than the processor's own gather of eight, and half vectors fill more rows of neighbours: on Zen 4 the
first is worth 18 to 25 % of the speed, the second 8 to 12 % (paper's scene and long box, in turns).  LLVM's options for vectors
(one vector a turn, more tests for overlap of arrays) were worth 9 and 4 % at most and went."""


@cache
def codegen() -> JITCPUCodegen:
    """numba's code generator for a processor with ``PROCESSOR``, unless the user says what it has; other functions keep their own."""
    chosen = numba.config.CPU_FEATURES  # type: ignore[attr-defined]
    if chosen is None and platform.machine() in ("x86_64", "AMD64"):
        numba.config.CPU_FEATURES = get_host_cpu_features() + PROCESSOR  # type: ignore[attr-defined]
    try:
        return JITCPUCodegen("sph")
    finally:
        numba.config.CPU_FEATURES = chosen  # type: ignore[attr-defined]


class SolverCompiler(Compiler):
    """numba's compiler for that processor."""

    def compile_extra(self, func: Any) -> Any:
        """The result of compiling a function."""
        self.state.library = codegen().create_library(func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


class InlinedCompiler(SolverCompiler):
    """The same for functions that others inline: without the code for calls from Python, which takes a quarter of the time."""

    def compile_extra(self, func: Any) -> Any:
        """The result of compiling a function; called from Python it crashes."""
        self.state.flags.no_cpython_wrapper = True
        return super().compile_extra(func)


def describe_array(c: Any, array: Any, place: Any) -> Any:
    """Write an array's place and shape, without owning it, by numba's own function; not 0 for what is no array."""
    kind = ir.FunctionType(ir.IntType(32), [c.pyapi.pyobj, c.pyapi.voidptr])
    describe = cgutils.get_or_insert_function(c.builder.module, kind, "numba_adapt_ndarray")
    return c.builder.call(describe, [array, c.builder.bitcast(place, c.pyapi.voidptr)])
