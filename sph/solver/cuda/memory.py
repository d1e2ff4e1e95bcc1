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
        self.sources: dict[str, str] = {}
        """the same of each member, by its path"""
        self.source = self._source(record)
        self.host: list[np.ndarray] = []
        self.card: list[Any] = []

    def _source(self, record: Any, path: str = "") -> str:
        self.sources[path] = found = self._found(record, path)
        return found

    def _found(self, record: Any, path: str) -> str:
        if record is None:
            return "None"
        if hasattr(record, "_fields"):
            kind = type(record).__name__
            self.classes[kind] = type(record)
            members = (self._source(member, f"{path}.{name}".lstrip(".")) for name, member in zip(record._fields, record, strict=True))
            return f"{kind}({', '.join(members)})"
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
        self.host = [cuda.pinned_array(shape, kind) for shape, kind in zip(self.shapes, kinds, strict=True)] if on_host else []
        self.card = [cuda.device_array(shape, kind) for shape, kind in zip(self.shapes, kinds, strict=True)]

    def put(self, run: int, record: Any) -> None:
        """Write the record of a run; ``up`` brings it to the card."""
        for (group, place), leaf in zip(self.at, leaves(record), strict=True):
            if leaf.size:
                self.host[group][run, place] = leaf

    def views(self, run: int, record: Any) -> Any:
        """A record like that of a run, with its values, whose arrays are the memory that ``up`` and ``down`` copy."""
        places = iter(self.at)

        def view(member: Any) -> Any:
            if hasattr(member, "_fields"):
                return type(member)(*map(view, member))
            if member is None:
                return None
            group, place = next(places)
            if not member.size:
                return member
            self.host[group][run, place] = member
            return self.host[group][run, place]

        return view(record)

    def up(self) -> None:
        """Copy all to the card."""
        for there, here in zip(self.card, self.host, strict=True):
            there.copy_to_device(here)

    def down(self) -> None:
        """Copy all from the card."""
        for there, here in zip(self.card, self.host, strict=True):
            there.copy_to_host(here)
