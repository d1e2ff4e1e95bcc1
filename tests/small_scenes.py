"""Scenes of a few dozen to a few hundred particles, as mappings, for tests and their scripts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from sph.measures.metrics import PROBE, MetricSettings
from sph.scene.schema import Scene
from sph.solver.terms import Terms
from sph.study.plan import Plan
from sph.study.schema import Study

SceneBuilder = Callable[[dict[str, Any]], Scene]
"""Makes a scene from dotted overrides."""

SLOPE: dict[str, Any] = {
    "scheme": "paper",
    "name": "small_slope",
    "duration": 3.0,
    "geometry": {"shape": "slope"},
    "gravity": {"ramp": 0.5, "duration": 1.0},
    "motion": {"kind": "tapered_sine", "amplitude": 8.0, "start": 1.0, "ramp": 0.5, "decay_start": 2.0, "end": 2.5},
    "numerics": {"spacing": 5.0, "time_step": 1e-3},
    "outputs": {"frame_interval": 0.25, "series_interval": 0.01},
}
"""The paper's slope with 163 particles, shaken to failure within three seconds."""

FEW: dict[str, Any] = {
    "numerics": {"spacing": 8.0, "smoothing_ratio": 1.3, "time_step": 1e-3},
    "duration": 0.002,
    "gravity": {"ramp": 0.001, "duration": 0.001},
    "motion": {"start": 0.001, "ramp": 0.1, "decay_start": 0.2, "end": 0.3},
    "outputs": {"frame_interval": 0.001, "series_interval": 0.001},
}
"""Makes of ``SLOPE`` 79 particles for two steps."""

FREE_BLOCK: dict[str, Any] = {
    "scheme": "paper",
    "name": "free_block",
    "duration": 1.0,
    "geometry": {"shape": "block", "width": 10.0, "height": 10.0},
    "walls": {"base": "none", "sides": "none"},
    "soil": {"cohesion": 1e6},
    "gravity": {"acceleration": 0.0, "ramp": 0.0, "duration": 0.01, "damping": 0.0},
    "numerics": {"spacing": 1.0, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
}
"""A block that floats: no walls, no gravity, too strong to yield."""

ABOVE_A_WALL: dict[str, Any] = {
    "walls.base": "fixed",
    "geometry": {
        "shape": "bodies",
        "width": 10.0,
        "height": 30.0,
        "bodies": [{"kind": "polygon", "points": [[0.0, 10.0], [10.0, 10.0], [10.0, 20.0], [0.0, 20.0]]}],
    },
}
"""Lifts ``FREE_BLOCK`` by 10 m from a wall that it never feels, so that the solver's variant is that of ``SLOPE``."""

TWO_BODIES: dict[str, Any] = {
    "shape": "bodies",
    "width": 6.0,
    "height": 4.0,
    "bodies": [
        {"kind": "polygon", "points": [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]},
        {"kind": "ring", "centre": [4.0, 2.0], "outer_radius": 1.5, "inner_radius": 0.5},
    ],
}
"""A triangle and a ring in a box."""

NOTHING: dict[str, Any] = {
    "damping": {"ratio": 0.0, "frequencies": [0.001, 50.0]},
    "water": {"pressure": "carried", "r_u": 0.0},
}
"""Damping and water without effect, for scenes that share the compiled variant of others that are damped or wet."""

PAPER = Path(__file__).parents[1] / "config" / "scenes" / "paper.yaml"
DRAFT: dict[str, Any] = {"numerics": {"spacing": 1.6666667, "smoothing_ratio": 1.3, "time_step": 2e-3}}
"""The paper's slope as the fidelity draft has it, but for the tolerance of its gradients: 959 particles, a second a run."""


def some_terms(**given: Any) -> Terms:
    """``Terms`` of which only those given are there; the rest is None."""
    return Terms(**(dict.fromkeys(Terms._fields) | given))


def study_plan(fidelities: dict[str, Any] | None = None, probe: str = PROBE) -> Plan:
    """A study of ``SLOPE``, for an experiment that takes fidelities and probe from it."""
    known = fidelities or {"paper": {}}
    study = Study(
        study="small",
        scene="slope.yaml",
        fidelity=next(iter(known)),
        grid={"S_R": ("0.10",)},
        fidelities=known,
        metrics=MetricSettings(probe=probe),
    )
    return Plan(study, SLOPE, "slope.yaml")
