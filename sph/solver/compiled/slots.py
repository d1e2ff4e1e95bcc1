"""Functions that are chosen by the type of a record: one of several kernels, yield surfaces or laws has the place.

numba knows the type of the record when it compiles the caller, so that only the function that belongs to it is compiled, into the caller.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numba
from numba.extending import overload

from sph.solver.compiled.jit import INLINED, OPTIONS

Function = Callable[..., Any]


def slot(function: Function) -> Any:
    """A function of a record and more, whose body is the record's own: ``@function.of(Record)`` gives it, with the same arguments."""
    own: dict[type, Function] = {}

    @functools.wraps(function)
    def from_python(*arguments: Any) -> Any:
        return (own[type(arguments[0])] if numba.config.DISABLE_JIT else compiled)(*arguments)  # type: ignore[attr-defined]

    compiled = numba.jit(**OPTIONS)(lambda *arguments: from_python(*arguments))

    @functools.wraps(function)
    def choose(*types: Any) -> Function:
        return own[types[0].instance_class]

    def of(record: type) -> Callable[[Function], Function]:
        return lambda body: own.setdefault(record, body)

    overload(from_python, jit_options=INLINED)(choose)  # type: ignore[arg-type]
    from_python.of = of  # type: ignore[attr-defined]
    return from_python


@slot
def with_numbers(record, table, k, first):  # type: ignore[no-untyped-def]
    """A record of the same type with the numbers of row k of a table from column ``first`` on."""
