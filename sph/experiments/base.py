"""What experiments share."""

from __future__ import annotations

from typing import Any, NamedTuple


class Run(NamedTuple):
    """A run of an experiment: whole, from the start to the end, on one core."""

    scene: dict[str, Any]
    """as a mapping"""
    by: str = "simulation"
    """or the search that makes many runs of the scene (``sph.stability.record.SEARCHES``)"""
    enforce_limit: bool = True
    """whether a time step above its limit is refused"""
