"""The limits of a scene's time step in the lattice, computed once for scenes that differ in what they do not depend on."""

from __future__ import annotations

from sph.scene.schema import Scene
from sph.solver.compiled.jit import compile_lock
from sph.solver.optional import Limit
from sph.solver.time_step import limits

UNLIKE = ("name", "title", "duration", "motion", "outputs", "probes")
"""Keys in which scenes of a study often differ, and which the limits do not depend on."""
_known: dict[str, list[Limit]] = {}
"""Limits by all other keys: a study may have ten thousand scenes."""


def step_limits(scene: Scene) -> list[Limit]:
    """The limits of ``sph.solver.time_step``, the acoustic one first; their reasons are those of a scene with the same limits."""
    key = scene.model_dump_json(exclude=dict.fromkeys(UNLIKE, True) | {"coupling": {"S_R", "gamma"}})
    if key not in _known:
        with compile_lock(required=False):
            _known[key] = limits(scene)
    return _known[key]
