"""Scenes too large to run, and numbers at the ends of their ranges: refused with key, value and what to do, before anything is made."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.scene.loading import make_loading
from sph.scene.motion import linear_ramp
from sph.scene.schema import MAX_PARTICLES, MAX_STEPS
from sph.solver.particles import place_particles
from sph.solver.simulation import Simulation
from sph.solver.time_step import _damped, check_time_step, limits
from sph.stability.standing import FailureRule, static_scene

TOO_LARGE = [
    # override, and the words its refusal must hold: key, value, what there would be, what to do
    ({"numerics.spacing": 1e-3}, ["numerics.spacing: 0.001 m", "particles", "103.4", "at most 5,000,000", "larger spacing"]),
    ({"geometry.slope_angle": 0.01, "numerics.spacing": 0.5}, ["numerics.spacing: 0.5 m", "143328 x 35 m", "smaller geometry"]),
    ({"numerics.spacing": 0.03, "numerics.smoothing_ratio": 5.0}, ["numerics.smoothing_ratio: 5.0", "pairs", "larger numerics.spacing"]),
    ({"duration": 1e4, "numerics.time_step": 1e-9}, ["numerics.time_step: 1e-09 s", "10,000,000,000,000 steps", "duration: 10000.0 s"]),
    (
        {"outputs.series_interval": 1e-6, "numerics.time_step": 1e-6},
        ["outputs.series_interval: 1e-06 s", "1,000,000 samples", "duration: 3.0 s"],
    ),
    ({"numerics.spacing": 0.05, "outputs.frame_interval": 0.01}, ["outputs.frame_interval: 0.01 s", "200,000,000", "duration: 3.0 s"]),
]


@pytest.mark.parametrize(("overrides", "words"), TOO_LARGE, ids=lambda v: next(iter(v)))
def test_a_scene_too_large_to_run_is_refused(small_slope: SceneBuilder, overrides: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as raised:
        small_slope(overrides)
    for word in words:
        assert word in str(raised.value)


def test_nothing_is_allocated_before_the_refusal(small_slope: SceneBuilder, tmp_path: Path) -> None:
    """Loads of 1e13 steps would take 320 TB; a process that may take half a gigabyte beyond its libraries refuses them."""
    data = small_slope({}).model_dump(mode="json")
    data["duration"], data["numerics"]["time_step"] = 1e4, 1e-9
    path = tmp_path / "huge.yaml"
    path.write_text(json.dumps(data))
    limit = 4 * 2**30
    done = subprocess.run(
        [sys.executable, "-m", "sph.command.cli", "run", str(path)],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert done.returncode == 2 and "numerics.time_step: 1e-09 s" in done.stderr and "Traceback" not in done.stderr


def test_the_limits_leave_room_for_the_finest_variant(small_slope: SceneBuilder) -> None:
    # 0.1 m: 0.29 million particles; a minute of shaking at 1e-5 s: 6 million steps.
    fine = small_slope({"numerics.spacing": 0.1, "numerics.time_step": 1e-5, "duration": 60.0, "outputs.frame_interval": 0.25})
    columns, rows = fine.lattice
    assert columns * rows < MAX_PARTICLES / 10 and fine.steps(fine.duration) < MAX_STEPS / 3


def test_the_lattice_is_the_one_that_is_filled(small_slope: SceneBuilder, free_block: SceneBuilder) -> None:
    for scene in (small_slope({}), free_block({}), free_block({"geometry.width": 9.49}), free_block({"geometry.width": 9.51})):
        particles, dx = place_particles(scene), scene.numerics.spacing
        soil = particles.kind == 0
        assert scene.lattice == (round(particles.x[soil].max() / dx + 0.5), round(particles.y[soil].max() / dx + 0.5))


OUT_OF_RANGE = [
    ({"geometry.slope_angle": 5e-324}, "geometry.slope_angle"),
    ({"numerics.spacing": 1e-300}, "numerics.spacing"),
    ({"numerics.time_step": 1e-320}, "numerics.time_step"),
    ({"outputs.frame_interval": 1e308}, "outputs.frame_interval"),
    ({"soil.density": 1e-300}, "soil.density"),
    ({"soil.youngs_modulus": 5e-324}, "soil.youngs_modulus"),
    ({"motion.end": 1e308}, "motion.end"),
    ({"damping.frequencies": [1e-320, 1.0]}, "damping.frequencies.0"),
    ({"damping.frequencies": [1.0, 1e308]}, "damping.frequencies.1"),
    ({"gravity.duration": 0.0, "gravity.ramp": 0.0}, "gravity.duration"),
    ({"numerics.adaptive_step": {"courant": 1e-320}}, "numerics.adaptive_step.courant"),
    ({"numerics.short_range_repulsion.range": 1e-320}, "numerics.short_range_repulsion.range"),
    ({"numerics.gradient_correction": {"min_determinant": 1e-320}}, "numerics.gradient_correction.min_determinant"),
    ({"numerics.smoothing_ratio": 0.6, "numerics.smoothing_length_is": "support"}, "numerics.smoothing_ratio: 0.6"),
    ({"gravity.initial_stress": {"pressure": -1e6}, "soil.youngs_modulus": 1e5}, "gravity.initial_stress.pressure: -1000000.0 kPa"),
    ({"initial_velocity": {"along": "x", "position": [0.0], "x": [1e308], "y": [0.0]}}, "initial_velocity.x.0"),
    ({"probes": {"A": [1e308, 1e308]}}, "probes.A"),
    ({"title": "two\nlines"}, "title"),
    ({"title": "\x1b[31m"}, "title"),
    ({"title": "x" * 201}, "title"),
]


@pytest.mark.parametrize(("overrides", "key"), OUT_OF_RANGE, ids=lambda v: v if isinstance(v, str) else "")
def test_numbers_beyond_what_the_model_can_do_are_refused(small_slope: SceneBuilder, overrides: dict[str, Any], key: str) -> None:
    with pytest.raises(ValueError, match="scene: ") as raised:
        small_slope(overrides)
    assert key in str(raised.value)


def test_an_adaptive_step_of_too_many_parts_is_refused(small_slope: SceneBuilder) -> None:
    stiff = {"numerics.adaptive_step": {}, "soil.density": 1e-3, "soil.youngs_modulus": 1e9}
    with pytest.raises(ValueError, match=r"numerics.adaptive_step: .*20,000,000.*duration: 3.0 s"):
        check_time_step(small_slope(stiff))
    check_time_step(small_slope({"numerics.adaptive_step": {}}))


def test_limits_at_the_ends_of_the_ranges_are_positive(small_slope: SceneBuilder) -> None:
    # The difference of two near numbers would be 0 where damping is strong.
    extreme = {"soil.density": 1e-3, "soil.youngs_modulus": 1e9, "damping": {"ratio": 0.5, "frequencies": [1e-3, 2e-3]}}
    for scene in (small_slope(extreme), small_slope({"soil.density": 1e5, "soil.youngs_modulus": 1e-6})):
        assert all(0.0 < limit.seconds < math.inf for limit in limits(scene))
    assert _damped(1e12, 1.0) == pytest.approx(2e-12, rel=1e-12)
    assert _damped(0.0, 4.0) == 0.5


def test_a_ramp_next_to_nothing_is_a_step(small_slope: SceneBuilder) -> None:
    with np.errstate(all="raise"):
        assert linear_ramp(np.array([-1.0, 0.0, 1.0]), 5e-324).tolist() == [0.0, 0.0, 1.0]
        assert np.isfinite(make_loading(small_slope({"gravity.ramp": 5e-324, "motion.ramp": 5e-324})).ground).all()


def test_a_search_in_next_to_no_gravity_is_refused(small_slope: SceneBuilder) -> None:
    for gravity in (5e-324, 1e-12):
        with pytest.raises(ValueError, match=r"gravity.acceleration: .*10 sqrt"):
            static_scene(small_slope({"gravity.acceleration": gravity, "numerics.spacing": 1.0}), FailureRule())


@pytest.mark.parametrize("limit", [0.0, 1e-12])
def test_a_step_that_adapts_without_end_ends_the_run(small_slope: SceneBuilder, limit: float) -> None:
    simulation = Simulation(small_slope({"numerics.adaptive_step": {}}))
    simulation.limit = 1e-4
    assert not simulation.adapt()
    assert simulation.substeps == 13  # 1e-3 / (0.8 * 1e-4) = 12.5
    simulation.limit = limit
    assert "limit of the time step fell" in simulation.adapt()
    assert simulation.substeps == 13
