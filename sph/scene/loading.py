"""Ground motion and gravity as histories sampled at the time steps (Sec. 3.2, Fig. 2)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.gravity import GravityStage
from sph.scene.ground_motion import GroundMotion
from sph.scene.motion import linear_ramp, vertical_acceleration
from sph.scene.schema import Scene

MAX_INTERVAL = 1e-3
"""Longest interval between the samples of a scene's motion, s."""


class Loading(NamedTuple):
    """Loads at every time step; the box's frame is used, so shaking is a body force."""

    time: np.ndarray  # (steps + 1,) s
    ground: np.ndarray  # (steps + 1,) horizontal acceleration of the box, m/s2; positive drives the soil towards the toe
    vertical: np.ndarray  # (steps + 1,) vertical acceleration of the box, m/s2; positive upwards, presses the soil down
    gravity: np.ndarray  # (steps + 1,) downward acceleration, m/s2
    extra_damping: np.ndarray  # (steps + 1,) mass-proportional damping of the gravity stage, 1/s


def gravity_history(stage: GravityStage, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gravity (m/s2) and the extra damping of the gravity stage (1/s) at times (s)."""
    time = np.asarray(time, dtype=float)
    fade = linear_ramp(time - 2.0 * stage.duration / 3.0, stage.duration / 3.0)
    return stage.acceleration * linear_ramp(time, stage.ramp), stage.damping * (1.0 - fade)


def make_loading(scene: Scene, substeps: int = 1) -> Loading:
    """Histories for the whole run; one entry a step or part of a step, so a restarted run reads the same numbers."""
    time = np.arange(scene.steps(scene.duration) * substeps + 1) * (scene.numerics.time_step / substeps)
    gravity, extra = gravity_history(scene.gravity, time)
    return Loading(time, scene.motion.acceleration(time), vertical_acceleration(scene.motion, time), gravity, extra)


def loading_of(scene: Scene) -> Loading:
    """A scene's loads over its duration, at the time steps or parts of them no longer than ``MAX_INTERVAL``."""
    return make_loading(scene, substeps=math.ceil(scene.numerics.time_step / MAX_INTERVAL - 1e-9))


def motion_of(scene: Scene) -> GroundMotion:
    """A scene's horizontal motion over its duration, sampled as by ``loading_of``."""
    loading = loading_of(scene)
    return GroundMotion(loading.time, loading.ground)
