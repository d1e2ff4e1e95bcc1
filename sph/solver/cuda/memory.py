"""Records of several runs in the memory of a card.

A kernel takes at most some kilobytes of arguments, and each costs time at every launch.  So the leaves of a record (arrays and numbers, at
any depth) are gathered by type and shape: one array (runs, leaves, ...) holds all that are alike, of all runs.  ``Pack.source`` is the
expression that puts the record of run ``r`` together again from them, in the kernel; what is None stays None.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

Key = tuple[str, tuple[int, ...]]
"""Type and shape of leaves."""


def leaves(record: Any) -> Iterator[np.ndarray]:
    """The arrays and numbers of a record in order, numbers as arrays without dimensions."""
    if hasattr(record, "_fields"):
        for member in record:
            yield from leaves(member)
    elif record is not None:
        yield np.asarray(record)


def structure(record: Any) -> Any:
    """What runs that lie in one pack have in common: classes, types and shapes."""
    if hasattr(record, "_fields"):
        return (type(record).__name__, *map(structure, record))
    return None if record is None else _key(np.asarray(record))


def _key(leaf: np.ndarray) -> Key:
    return leaf.dtype.str, leaf.shape


class Pack:
    """Room for a record of each run; ``record`` is one of them, of which types and shapes count."""

    def __init__(self, name: str, record: Any, runs: int) -> None:
        self.runs, self.keys, self.classes = runs, [], {}  # type: ignore[var-annotated]
        self.at: list[tuple[int, int]] = []
        """group, and place in it, of each leaf"""
        self.count: list[int] = []
        self.name = name
        self.source = self._source(record)
        self.host: list[np.ndarray] = []
        self.card: list[Any] = []

    def _source(self, record: Any) -> str:
        if record is None:
            return "None"
        if hasattr(record, "_fields"):
            kind = type(record).__name__
            self.classes[kind] = type(record)
            return f"{kind}({', '.join(map(self._source, record))})"
        key = _key(np.asarray(record))
        if key not in self.keys:
            self.keys.append(key)
            self.count.append(0)
        group = self.keys.index(key)
        self.at.append((group, self.count[group]))
        self.count[group] += 1
        return f"{self.name}{group}[r, {self.at[-1][1]}]"

    @property
    def arguments(self) -> list[str]:
        """Names of the arrays in ``source``."""
        return [f"{self.name}{group}" for group in range(len(self.keys))]

    @property
    def shapes(self) -> list[tuple[int, ...]]:
        """Shapes of the arrays; what absent terms keep is empty and takes the room of one number."""
        return [(self.runs, count, *(max(size, 1) for size in shape)) for count, (_, shape) in zip(self.count, self.keys, strict=True)]

    @property
    def size(self) -> int:
        """Bytes of all runs."""
        return sum(math.prod(shape) * np.dtype(kind).itemsize for shape, (kind, _) in zip(self.shapes, self.keys, strict=True))

    def allocate(self, cuda: Any, on_host: bool = True) -> None:
        """Make the arrays on the card, and beside them those through which the processor reads and writes them."""
        kinds = [np.dtype(kind) for kind, _ in self.keys]
        self.host = [np.zeros(shape, kind) for shape, kind in zip(self.shapes, kinds, strict=True)] if on_host else []
        self.card = [cuda.device_array(shape, kind) for shape, kind in zip(self.shapes, kinds, strict=True)]

    def put(self, run: int, record: Any) -> None:
        """Write the record of a run; ``up`` brings it to the card."""
        for (group, place), leaf in zip(self.at, leaves(record), strict=True):
            if leaf.size:
                self.host[group][run, place] = leaf

    def take(self, run: int, record: Any) -> None:
        """Read the arrays of a run, which ``down`` has brought, into those of a record."""
        for (group, place), leaf in zip(self.at, leaves(record), strict=True):
            if leaf.size:
                leaf[...] = self.host[group][run, place]

    def up(self) -> None:
        """Copy all to the card."""
        for there, here in zip(self.card, self.host, strict=True):
            there.copy_to_device(here)

    def down(self) -> None:
        """Copy all from the card."""
        for there, here in zip(self.card, self.host, strict=True):
            there.copy_to_host(here)
