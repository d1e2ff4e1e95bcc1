"""Functions that are only ever inlined into others.

numba makes machine code of every function when it has compiled it, and looks up its address.  Nobody calls the functions that are inlined
into all that call them, so that this is left out here; of what is inlined not a bit changes.  ``tests/solver/test_jit_cache.py`` tells if
a version of numba no longer takes this way.
"""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


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


class InlinedCompiler(Compiler):
    """numba's compiler, into an ``InlinedLibrary``."""

    def compile_extra(self, func: Any) -> Any:
        """The result of compiling a function."""
        self.state.library = InlinedLibrary(self.state.targetctx.codegen(), func.__qualname__)
        return super().compile_extra(func)
