"""How the solver is compiled, and where compiled code is kept.

numba's on-disk cache has two traps: it does not see edits in imported files, and when two
processes compile different variants of one function at the same time a third can be handed the
wrong one.  Three measures answer them: the cache folder is named after a digest of the solver's
sources and numba's version; compiling and loading happen under a lock between processes
(``compile_lock``); and every run checks that the variant it got reports the terms it asked for
(``sph.integration.active_terms``).
"""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba

FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Reordering of sums so that loops vectorise; NaN and infinity keep their meaning for the guard."""


def solver_digest() -> str:
    """Digest of the solver's sources (the files beside this one) and numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of the compiled code: ``$SPH_CACHE_DIR`` or the user's cache, then the digest."""
    home = os.environ.get("SPH_CACHE_DIR") or Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "sph"
    return Path(home) / solver_digest()


numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]


def jit(function: Callable[..., Any]) -> Any:
    """Compile for the solver: cached, inlined, sums may be reordered, division by zero gives infinity.

    Inlining makes code compiled here and code loaded from the cache give the same bits; without it they differ in
    rounding from the first step (a test compares them), probably because a function called from the cached object
    is optimised apart from the one compiled here, with sums in another order.
    """
    return numba.njit(cache=True, fastmath=FASTMATH, error_model="numpy", forceinline=True)(function)


@contextmanager
def compile_lock() -> Iterator[None]:
    """Let one process at a time compile or load from the cache."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "lock", "w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
