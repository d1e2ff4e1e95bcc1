"""Ending a run once its soil has come to rest after the shaking.

When the shaking is over only gravity drives the soil, and soil that has stood still for a while and has no strength left to
lose stays where it is.  With a slow loss of strength (gamma of 0.1 1/s) the paper's slope stands for seconds after the shaking
and collapses later, hence the second condition.  The test reads the recorded series and the state, which a restart holds
in full: a resumed run stops at the sample at which an uninterrupted one does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sph.scene.motion import NoMotion
from sph.scene.schema import Scene
from sph.solver.state import FAILED
from sph.solver.terms import State


def quiet_from(scene: Scene) -> float:
    """Time from which on the loads are constant: the end of the shaking, or of the gravity stage without one, s."""
    return scene.gravity.duration if isinstance(scene.motion, NoMotion) else scene.motion.end


def rest_reason(scene: Scene, step: int, series: Mapping[str, Sequence[Any]], state: State, soil_mass: float) -> str:
    """Why a run may end at ``step``, in words with times; empty where it may not.

    ``series`` holds the samples up to this step by name, ``soil_mass`` is in kg.  At rest: through the whole window, which begins
    when the shaking is over, the soil (by its mass-weighted root-mean-square speed) and every probe are slower than the limit,
    and no failed particle has more of its solid state left than the limit, where it fades with time.
    """
    if scene.early_stop is None:
        return ""
    since = step - scene.steps(scene.early_stop.window)
    if since < scene.steps(quiet_from(scene)):
        return ""
    fades = any(material.gamma > 0 for material in scene.materials)
    if fades and state.beta[state.phase == FAILED].max(initial=0.0) > scene.early_stop.solid_weight:
        return ""
    samples = slice(-1 - round(scene.early_stop.window / scene.outputs.series_interval), None)
    soil = math.sqrt(2.0 * max(series["kinetic_energy"][samples]) / soil_mass)
    probes = np.hypot(series["probe_velocity_x"][samples], series["probe_velocity_y"][samples])
    if not max(soil, float(probes.max(initial=0.0))) < scene.early_stop.speed:
        return ""
    dt = scene.numerics.time_step
    return f"at rest since {since * dt:.2f} s, stopped at {step * dt:.2f} s"
