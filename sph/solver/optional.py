"""What an optional term of physics is: its name, the keys of a scene that ask for it, and its record of coefficients.

A term has a file of its own, which ends with its ``TERM``; ``sph.solver.terms`` lists them.  In compiled code a term is its record or None;
numba types the two differently, so that a term which is absent is not compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from sph.scene.schema import Scene
from sph.solver.particles import Particles
from sph.solver.physics.kernels import Kernel, Lattice


class Limit(NamedTuple):
    """One limit of the time step."""

    name: str
    seconds: float
    reason: str


class Damping(NamedTuple):
    """How a term damps the stiffest mode, which lowers the limit of the time step."""

    ratio: float
    """added to the mode's damping ratio, doubled"""
    name: str
    """of the limit"""
    reason: str


class Arrays(NamedTuple):
    """Arrays that a term keeps, under their own names, in the state of a run or with the pairs."""

    record: Any
    """named tuple of them, which says what they are"""
    make: Callable[..., Any]
    """they themselves: of the state at the start, from the scene and its particles; of the pairs, from the numbers of particles and
    pairs and the type of kernel gradients"""
    dims: tuple[str, ...] = ("particle",)
    """names of their dimensions in a restart, the last of these for arrays of fewer"""


class Term(NamedTuple):
    """An optional term; its name is that of its field in ``Terms``, and stands in files and messages."""

    name: str
    keys: str
    """keys of a scene that ask for it, and what it is for"""
    wanted: Callable[[Scene], bool]
    make: Callable[[Scene, Particles, Kernel, float], Any]
    """its coefficients for a scene that wants it, its particles, its kernel and a time step (s); all floats or arrays, so that one scene
    compiles one variant"""
    state: Arrays | None = None
    """what it keeps of the state: saved, copied, restarted with it; empty in a scene without the term"""
    pairs: Arrays | None = None
    """what it keeps with the pairs, likewise"""
    in_pairs: bool = False
    """whether the lists of neighbours depend on it"""
    damping: Callable[[Scene, Lattice, float], Damping] | None = None
    """what a scene's term adds to the damping of the stiffest mode of the initial lattice, whose angular frequency is given, rad/s"""
