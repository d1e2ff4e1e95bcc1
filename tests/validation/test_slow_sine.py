"""The amplitude between the runs that stand and those that do not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cases.slow_sine import LIMIT, V24, limit_between
from sph.scene.motion import TaperedSine
from sph.scene.schema import make_scene

VALUES = np.array([0.40, 0.44, 0.42])


def test_the_limit_lies_between_the_runs_that_stand_and_those_that_go() -> None:
    assert limit_between(VALUES, np.array([False, True, False])) == pytest.approx(0.43)
    assert limit_between(VALUES, np.array([False, True, True])) == pytest.approx(0.41)


@pytest.mark.parametrize("gone", [(True, True, True), (False, False, False), (True, False, True)])
def test_without_a_limit_there_is_none(gone: tuple[bool, ...]) -> None:
    """None stands, all stand, or the slope goes at less than what it bears."""
    assert math.isnan(limit_between(VALUES, np.array(gone)))


def test_the_sine_has_eight_natural_periods_and_whole_cycles() -> None:
    """T = 4 D / V_s of the 50 m below the crest; two cycles of increase, two at full strength and one of decrease."""
    scene = make_scene(next(iter(V24.scenes().values())))
    motion = scene.motion
    assert isinstance(motion, TaperedSine)
    speed = math.sqrt(scene.soil.youngs_modulus * 1e3 / (2.0 * (1.0 + scene.soil.poisson_ratio)) / scene.soil.density)
    assert 1.0 / motion.frequency == pytest.approx(8.0 * 4.0 * 50.0 / speed, rel=1e-4)
    cycles = np.array([motion.ramp, motion.decay_start - motion.start, motion.end - motion.start]) * motion.frequency
    assert cycles == pytest.approx([2.0, 4.0, 5.0], rel=1e-3)
    assert sum((0.423, 0.454)) / 2.0 == LIMIT
