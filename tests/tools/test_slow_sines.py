"""What the table of the slow sines stands on: natural period, column, rigid block, and the measured rows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cases.slow_sine import LIMIT
from sph.scene.configuration import read_scene
from sph.scene.gravity import GRAVITY
from sph.scene.motion import TaperedSine
from sph.scene.schema import make_scene
from sph.stability.newmark import sliding_block
from tools.slow_sine import SCENE, block_limit, damping_at, mean_amplification, read_slow_sine, shaken


def test_a_column_on_a_rigid_base_amplifies_as_its_closed_form() -> None:
    """Undamped tan(kD) / kD: 0.41421 / 0.39270 at four natural periods; 1 under a static load; 1 / (4 kD damping) or so in resonance."""
    assert mean_amplification(4.0, 0.0) == pytest.approx(0.41421 / 0.39270, rel=1e-4)
    assert mean_amplification(1e4, 0.05) == pytest.approx(1.0, abs=1e-6)
    assert mean_amplification(1.0, 0.01) == pytest.approx(1.0 / (0.5 * math.pi * 0.5 * math.pi * 0.01), rel=0.01)


def test_the_damping_is_that_of_the_pair() -> None:
    scene = make_scene(read_scene(SCENE))
    assert [damping_at(scene, frequency) for frequency in (2.0, 8.0, 4.0)] == pytest.approx([0.05, 0.05, 0.04])


def test_at_its_limit_the_block_slips_by_what_is_asked() -> None:
    scene = shaken(dict(read_scene(SCENE)), 8.0, LIMIT)
    assert isinstance(scene.motion, TaperedSine)
    k, time = block_limit(scene, 0.05), np.linspace(scene.motion.start, scene.motion.end, 20_001)
    slip = sliding_block(time, k * GRAVITY * scene.motion.acceleration(time) / scene.motion.amplitude, LIMIT * GRAVITY).permanent
    assert slip == pytest.approx(0.05, rel=0.01) and k > LIMIT


def test_the_table_is_whole() -> None:
    """Every bracket is closed, and the slower the sine the nearer the block's limit to k_c."""
    table = read_slow_sine()
    assert (table["lower"] < table["upper"]).all()
    same = table[(table["slip_at_peak"] == 0.05) & (table["S_R"] == 0.5)].sort_values("period_ratio")
    assert same["block_peak"].is_monotonic_decreasing and (same["block_peak"] < same["block_residual"]).all()
