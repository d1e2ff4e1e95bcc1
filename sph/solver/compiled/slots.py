"""Functions that are chosen by the type of a record, and thereby the physics that a scene has.

One of several kernels, yield surfaces or laws has a place, and so has every term of physics, which may leave it empty: there stands the
record of its coefficients, or None.  numba knows the type of the record when it compiles the caller, so that only the function that
belongs to it is compiled, into the caller; of what a scene does not have nothing is.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Protocol, cast

import numba
import numpy as np
from numba import types
from numba.extending import overload

from sph.solver.compiled.jit import OPTIONS, jit

Function = Callable[..., Any]


class Slot(Protocol):
    """A function whose first argument chooses its body."""

    def __call__(self, *arguments: Any) -> Any:
        """The result of the body for the first argument's type."""

    def of(self, *records: type) -> Callable[[Function], Function]:
        """Mark the body for a record, or for several."""


def slot(function: Function) -> Slot:
    """A function of a record and more.

    Its own body is the case without a record, None; ``@function.of(Record)`` gives that of a record, or of several, with the same
    arguments.  All return the same type.
    """
    own: dict[type, Function] = {type(None): function}

    @functools.wraps(function)
    def from_python(*arguments: Any) -> Any:
        return (own[type(arguments[0])] if numba.config.DISABLE_JIT else compiled)(*arguments)  # type: ignore[attr-defined]

    compiled = jit(lambda *arguments: from_python(*arguments))

    @functools.wraps(function)
    def choose(*types: Any) -> Function:
        return own[record_of(types[0])]

    def of(*records: type) -> Callable[[Function], Function]:
        def give(body: Function) -> Function:
            own.update(dict.fromkeys(records, body))
            return body

        return give

    overload(from_python, jit_options=OPTIONS, strict=False)(choose)  # type: ignore[arg-type]
    from_python.of = of  # type: ignore[attr-defined]
    return cast(Slot, from_python)


def record_of(kind: Any) -> type:
    """Class of the record that a numba type stands for; that of None where it stands for none."""
    return getattr(kind, "instance_class", type(None))


def records_in(kind: Any) -> dict[str, type]:
    """Classes of the records in the fields of a record, given by itself or by its numba type, for which code is compiled."""
    of_type = isinstance(kind, types.Type)
    return {name: record_of(member) if of_type else type(member) for name, member in fields_of(kind).items()}


def fields_of(kind: Any) -> dict[str, Any]:
    """Fields of a record, or of its numba type, by name."""
    return dict(kind._asdict()) if hasattr(kind, "_asdict") else dict(zip(kind.fields, kind.types, strict=True))


@slot
def with_numbers(record: Any, table: np.ndarray, k: int, first: int) -> Any:
    """A record of the same type with the numbers of row k of a table from column ``first`` on."""


@slot
def neighbours_of(pairs: Any, start: int, end: int) -> range:
    """Places of a row's neighbours in the lists: one after the other, for a thread that takes whole rows.

    The one place that says so: rows that lie side by side, for as many threads, have a stride.
    """
    return range(start, end)
