"""How the solver is compiled, and where compiled code is kept.

numba's on-disk cache has two traps: it does not see edits in imported files, and when two
processes compile different variants of one function at the same time a third can be handed the
wrong one.  Three measures answer them: the cache folder is named after a digest of the compiled
sources and numba's version; each variant of the solver has a folder of its own in it, which one process
at a time uses (``compile_lock``); and every run checks that the variant it got reports the terms it asked
for (``sph.solver.terms.active_terms``).

Nor does numba ask whose files it executes: a folder that another user owns or can write to is refused (``private``).
"""

from __future__ import annotations

import gc
import hashlib
import json
import os
import tempfile
import time as clock
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numba
import numpy as np
from filelock import FileLock
from numba.core import event
from numba.core.registry import CPUDispatcher

from sph.solver.compiled.numba_internals import InlinedCompiler, SolverCompiler
from sph.solver.compiled.private import PRIVATE, for_user_alone, make_private, refuse_shared
from sph.storage.sources import sources_digest

FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Reordering of sums so that loops vectorise; NaN and infinity keep their meaning for the guard."""

PACKAGE = Path(__file__).resolve().parents[2]
SOURCES = ("scene", "solver", "storage/trajectory.py")
"""Folders and files of the package in which everything lies that decides the results of a run, given all keys of its scene."""
FILLING = "scene/scheme.py"
"""Left out: the defaults that a scheme fills in decide no run whose scene is stored with all its keys."""
COMPILED = (
    "solver/boundaries",
    "solver/compiled",
    "solver/cuda",
    "solver/integration.py",
    "solver/moves.py",
    "solver/neighbours.py",
    "solver/physics",
    "solver/renewal.py",
    "solver/state.py",
    "solver/terms.py",
    "solver/time_step.py",
    "stability/limit_equilibrium.py",
)
"""Where the text is that becomes machine code: jitted functions, and names that they use (a test holds the list against the sources)."""


@cache
def compiled_digest() -> str:
    """Digest of what the files that are compiled say to the machine, and of numba's version."""
    return _digest(COMPILED)


@cache
def solver_digest() -> str:
    """Digest of what all sources that decide a run (``SOURCES``) say to the machine, and of numba's version."""
    return _digest(SOURCES)


def _digest(names: Iterable[str]) -> str:
    """Of what files and folders say to the machine, not to people (``sph.storage.sources``)."""
    paths = {path for place in (PACKAGE / name for name in names) for path in (place.rglob("*.py") if place.is_dir() else [place])}
    return sources_digest(paths - {PACKAGE / FILLING}, PACKAGE, numba.__version__)


REMEDY = "set SPH_CACHE_DIR to a folder that you, and nobody else, can write to"


def cache_folder() -> Path:
    """Folder of the compiled code: ``$SPH_CACHE_DIR`` or the user's cache, then the digest; OSError where neither is known."""
    chosen, users = os.environ.get("SPH_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")
    try:
        home = Path(chosen) if chosen else (Path(users) if users else Path.home() / ".cache") / "sph"
    except RuntimeError as error:
        raise OSError(f"compiled code cannot be kept: this user has no home folder; {REMEDY}") from error
    return home.absolute() / compiled_digest()


OPTIONS: dict[str, Any] = {
    "nogil": True, "fastmath": FASTMATH, "error_model": "numpy", "forceinline": True,
    "no_cfunc_wrapper": True, "pipeline_class": InlinedCompiler,
}  # fmt: skip
"""Sums may be reordered, division by zero gives infinity; everything is inlined.

Inlining makes code compiled here and code loaded from the cache give the same bits; without it they differ in rounding from the first
step (a test compares them), probably because a function called from the cached object is optimised apart from the one compiled
here, with sums in another order.
"""
_entries: list[Any] = []
"""Functions whose compiled code is kept."""


class Inlined(CPUDispatcher):
    """A function that compiled functions inline."""

    @cached_property
    def alone(self) -> Any:
        """The same function for calls from Python."""
        return _for_calls(self.py_func)

    def __call__(self, *arguments: Any) -> Any:
        return self.alone(*arguments)


def jit(function: Callable[..., Any]) -> Any:
    """Compile for the solver, into the functions that call this one; a call from Python compiles it once more, which is not kept."""
    compiled = numba.njit(**OPTIONS)(function)
    if not numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        compiled.__class__ = Inlined
    return compiled


_for_calls: Callable[[Callable[..., Any]], Any] = numba.njit(**OPTIONS | {"pipeline_class": SolverCompiler})


def entry(function: Callable[..., Any]) -> Any:
    """Compile for calls from Python; what is compiled under ``compile_lock`` is kept.

    Importing this package needs no folder that can be written.
    """
    compiled = _for_calls(function)
    if not numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        _entries.append(compiled)
    return compiled


@contextmanager
def before_compiling(function: Any, variant: str, tell: Callable[[float | None], None]) -> Iterator[None]:
    """Call ``tell`` before a variant of an entry is compiled because the cache does not hold it.

    It is given the time (s) that this took last on this machine, None if it is not known, and the time it takes now is kept.
    """
    with event.install_listener("numba:compile", _Once(function, variant, tell)):
        yield


class _Once(event.Listener):
    """Calls back at the first event of a function, and keeps how long that takes."""

    def __init__(self, function: Any, variant: str, tell: Callable[[float | None], None]) -> None:
        self.function, self.variant, self.tell = function, variant, tell
        self.started, self.kept = 0.0, False

    def on_start(self, event: Any) -> None:
        if event.data["dispatcher"] is self.function and not self.started:
            self.started = clock.monotonic()
            self.tell(_compile_times().get(self.variant))

    def on_end(self, event: Any) -> None:
        if event.data["dispatcher"] is self.function and not self.kept:
            self.kept = True
            place = cache_folder().parent / TIMES
            # A folder that cannot be written is refused where code is to be kept in it.
            with suppress(OSError), FileLock(place.with_suffix(".lock"), mode=PRIVATE), for_user_alone():
                place.write_text(json.dumps(_compile_times() | {self.variant: round(clock.monotonic() - self.started, 1)}))


TIMES = "compiling.json"
"""How long variants took to compile on this machine, s; in the folder of all cache folders, so that new sources do not lose it."""


def _compile_times() -> dict[str, float]:
    try:
        return dict(json.loads((cache_folder().parent / TIMES).read_bytes()))
    except (OSError, ValueError, TypeError):
        return {}


@jit
def rows(first: int, last: int) -> range:
    """Range of rows as unsigned numbers: signed indices are tested for wrap-around, and loops with that test do not vectorise."""
    return range(np.uint64(first), np.uint64(max(first, last)))


_locked = False


@contextmanager
def compile_lock(variant: str = "", required: bool = True) -> Iterator[None]:
    """Compile or load entries for a variant of the solver, or those that all share; one process at a time for each variant.

    Others that want the same one wait and load it; those of other variants compile beside it.  Within another lock it does nothing.
    OSError names the folder and the remedy if compiled code cannot be kept there, or others may change it; if that is not ``required``,
    what is compiled serves this process alone.
    """
    global _locked
    with ExitStack() as stack:
        if not _locked:
            try:
                stack.enter_context(_kept(variant))
            except OSError:
                if required:
                    raise
            stack.callback(_unlock)
            _locked = True
        yield


def _unlock() -> None:
    global _locked
    _locked = False


@contextmanager
def _kept(variant: str) -> Iterator[None]:
    """Have numba keep the code of all entries in the variant's folder; where it could not write, it would choose another without a word."""
    home = cache_folder()
    folder = home / (hashlib.sha256(variant.encode()).hexdigest()[:16] if variant else "shared")
    try:
        make_private(home)
        refuse_shared(home)
        make_private(folder)
        with ExitStack() as stack:
            stack.enter_context(FileLock(folder / "lock", mode=PRIVATE))
            for place in (folder, *folder.glob("*/")):
                tempfile.TemporaryFile(dir=place).close()
            stack.enter_context(for_user_alone())
            earlier, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder)  # type: ignore[attr-defined]
            stack.callback(setattr, numba.config, "CACHE_DIR", earlier)
            for compiled in _entries:
                compiled.enable_caching()
            stack.enter_context(_no_collection())
            yield
    except OSError as error:
        raise OSError(f"{home}: compiled code cannot be kept there ({error.strerror or error}); mend that, or {REMEDY}") from error


@contextmanager
def _no_collection() -> Iterator[None]:
    """Without Python's search for cycles, which takes a twelfth of the time to compile and finds next to nothing."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
