"""Records of arrays that compiled functions take by reference."""

from __future__ import annotations

import pickle
import re
import sys
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numba.core.registry import cpu_target

from sph.solver.compiled.jit import jit
from sph.solver.compiled.records import Record, by_reference


class Pair(NamedTuple):
    """Numbers, by value."""

    left: float
    right: float


@by_reference
class Inner(NamedTuple):
    """A record in a record."""

    weights: np.ndarray
    scale: float


@by_reference
class Outer(NamedTuple):
    """Fields of all kinds."""

    x: np.ndarray
    table: np.ndarray
    phase: np.ndarray
    count: int
    wanted: bool
    single: np.floating[Any]
    pair: Pair
    inner: Inner
    absent: None
    maybe: Inner | None


def made(n: int = 5, maybe: bool = True) -> Outer:
    inner = Inner(np.arange(float(n)), 0.5)
    table = np.arange(3.0 * n).reshape(3, n)
    return Outer(
        np.ones(n), table, np.arange(n, dtype=np.uint8), n, True, np.float32(0.1), Pair(3.0, 4.0), inner, None, inner if maybe else None
    )


@jit
def of_maybe(inner):  # type: ignore[no-untyped-def]
    if inner is None:
        return -1.0
    else:
        return inner.scale * inner.weights.sum()


@jit
def everything(record, i):  # type: ignore[no-untyped-def]
    record.x[i] += record.table[2, i] + record.inner.weights[i] * record.inner.scale
    return (
        record.x[i],
        record.table.shape,
        record.phase[i],
        record.count,
        record.wanted,
        record.single,
        record.pair.left - record.pair.right,
        record.absent is None,
        of_maybe(record.maybe),
    )


@pytest.mark.parametrize("maybe", [True, False])
def test_compiled_code_reads_and_writes_what_python_does(maybe: bool) -> None:
    compiled, plain = made(maybe=maybe), made(maybe=maybe)
    for i in range(5):
        assert everything(compiled, i) == everything.py_func(plain, i)
        assert np.array_equal(compiled.x, plain.x)
    assert compiled.x[4] == 1.0 + 14.0 + 2.0


def test_a_record_is_one_argument_of_a_short_name() -> None:
    kind = numba.typeof(made())
    context = cpu_target.target_context
    counts = [len(context.call_conv.get_function_type(numba.float64, [each]).args) for each in (kind, numba.typeof(Pair(1.0, 2.0)))]
    assert counts[1] - counts[0] == 1, "two numbers are two arguments, ten fields one"
    assert len(str(kind)) < 30


def test_types_of_other_fields_differ() -> None:
    record = made()
    others = record._replace(maybe=None), record._replace(phase=np.zeros(5)), record._replace(count=2.0)
    kinds = [numba.typeof(each) for each in (record, *others)]
    assert len(set(kinds)) == len({str(kind) for kind in kinds}) == 4
    assert numba.typeof(made(7)) == kinds[0]
    assert pickle.loads(pickle.dumps(kinds[0])) == kinds[0] and isinstance(kinds[0], Record)


@by_reference
class Fields(NamedTuple):
    """Two fields of the same particles."""

    v: np.ndarray
    a: np.ndarray


def test_loops_over_a_record_vectorise() -> None:
    """Without loads marked as constant every write could change the table, and the loop would read it again each time."""

    @jit
    def kick(record, dt):  # type: ignore[no-untyped-def]
        for i in range(np.uint64(record.v.size)):
            record.v[i] += record.a[i] * dt

    record = Fields(np.zeros(100), np.arange(100.0))
    kick(record, 0.5)
    assert np.array_equal(record.v, 0.5 * np.arange(100.0))
    assert re.search(r"fmul .*<\d+ x double>", kick.alone.inspect_llvm(kick.alone.signatures[0]))


def test_nothing_is_owned() -> None:
    """Calls leave no reference behind."""
    record = Fields(np.zeros(10), np.ones(10))
    before = sys.getrefcount(record.v), sys.getrefcount(record)
    for _ in range(10):
        everything(made(), 0)
        total(record)
    assert (sys.getrefcount(record.v), sys.getrefcount(record)) == before


@jit
def total(record):  # type: ignore[no-untyped-def]
    return record.v.sum() + record.a.sum()
