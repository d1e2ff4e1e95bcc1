"""The limit of the time step measured during a run, and the step that adapts to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_scenes import SceneBuilder

from sph.solver.run import run
from sph.solver.simulation import Simulation
from sph.solver.time_step import PresentLimit, lattice_wave_number, limits
from sph.storage import trajectory

ADAPTIVE = {
    "numerics.spacing": 2.5,
    "numerics.smoothing_ratio": 2.3,
    "numerics.time_step": 0.01,
    "numerics.adaptive_step": {"courant": 0.8},
    "coupling.S_R": 0.1,
    "coupling.gamma": 100.0,
}


BARE = {"damping": None, "numerics.artificial_viscosity": None}


def lattice(free_block: SceneBuilder, ratio: float, **numerics: Any) -> tuple[float, float]:
    """Measured and theoretical limit of a free lattice without damping, s."""
    extra = {f"numerics.{name}": value for name, value in numerics.items()}
    simulation = Simulation(free_block(BARE | {"geometry.width": 30.0, "geometry.height": 30.0, "numerics.smoothing_ratio": ratio} | extra))
    simulation.prepare()
    simulation.measure_limit(200)
    return simulation.limit, 2.0 / (simulation.scene.soil.p_wave_speed * lattice_wave_number(simulation.scene))


@pytest.mark.usefixtures("without_steps")
@pytest.mark.parametrize("ratio", [1.3, 2.3])
def test_measured_limit_of_a_lattice_is_the_theoretical_one(free_block: SceneBuilder, ratio: float) -> None:
    # The iteration approaches from the safe side of nothing stiffer; a finite block is nearly as stiff as the infinite lattice.
    limit, theory = lattice(free_block, ratio)
    assert limit <= theory
    assert limit == pytest.approx(theory, rel=0.01)


@pytest.mark.long
@pytest.mark.usefixtures("without_steps")
def test_corrected_gradients_are_stiffer_at_a_free_surface(free_block: SceneBuilder) -> None:
    limit, theory = lattice(free_block, 1.3, gradient_correction={"min_determinant": 0.3})
    assert limit < 0.8 * theory, "the theory of the lattice does not see it"


@pytest.mark.long
@pytest.mark.usefixtures("without_steps")
def test_a_step_above_the_limit_measured_at_the_start_is_refused(free_block: SceneBuilder) -> None:
    limit, theory = lattice(free_block, 1.3, gradient_correction={"min_determinant": 0.3})
    step = 0.5 * (limit + theory)
    keys = {"numerics.time_step": step, "numerics.gradient_correction": {"min_determinant": 0.3}, "duration": step}
    scene = free_block(BARE | {"geometry.width": 30.0, "geometry.height": 30.0, "numerics.smoothing_ratio": 1.3} | keys
                       | {"outputs.series_interval": step, "outputs.frame_interval": step, "gravity.duration": step})  # fmt: skip
    with pytest.raises(ValueError, match=r"numerics.time_step: .*limit measured"):
        run(scene)


def test_a_stiffer_mode_lowers_the_limit(free_block: SceneBuilder) -> None:
    scene = free_block({})
    present = PresentLimit(scene)
    lattice = min(limit.seconds for limit in limits(scene))
    omega = scene.soil.p_wave_speed * lattice_wave_number(scene)
    assert present.seconds(omega) == lattice
    assert present.seconds(4.0 * omega) < 0.5 / omega
    assert present.seconds(0.1 * omega) == lattice, "never above the lattice's"


def test_an_adaptive_step_keeps_to_the_limit(small_slope: SceneBuilder) -> None:
    ds = run(small_slope(ADAPTIVE)).trajectory
    assert ds.attrs["status"] == "complete"
    step, limit = ds["time_step"].values, ds["time_step_limit"].values
    # The step after a frame is that of its limit; the limit may fall until the next frame by what the courant number leaves.
    assert np.all(step[1:] <= 0.8 * limit[:-1])
    assert np.all(step <= limit)
    parts = 0.01 / step
    np.testing.assert_allclose(parts, np.round(parts), rtol=1e-12)
    # No more parts than needed.
    assert np.round(parts[1:]).min() > 1, "the limit must matter for the test to mean something"
    assert np.all(0.01 / (np.round(parts[1:]) - 1) > 0.8 * limit[:-1])


def test_an_adaptive_step_gives_the_result_of_a_small_fixed_one(small_slope: SceneBuilder) -> None:
    adaptive = run(small_slope(ADAPTIVE)).trajectory
    fixed = run(small_slope(ADAPTIVE | {"numerics.time_step": 5e-4, "numerics.adaptive_step": None})).trajectory
    a, b = (float(ds["probe_displacement_y"][-1, 0]) for ds in (adaptive, fixed))
    # Steps of 5 ms against 0.5 ms: the time of failure is known to a step, which the shaking turns into some per cent.
    assert a == pytest.approx(b, rel=0.05)


def test_an_adaptive_run_may_start_from_computed_stress(small_slope: SceneBuilder) -> None:
    keys = {"gravity.initial_stress": "geostatic", "gravity.ramp": 0.0, "duration": 1.0}
    adaptive = run(small_slope(ADAPTIVE | keys)).trajectory
    fixed = run(small_slope(ADAPTIVE | keys | {"numerics.time_step": 1e-3, "numerics.adaptive_step": None})).trajectory
    assert adaptive["time_step"].values.min() < 0.01, "the step must be divided for the test to mean something"
    # The stress imposed does not depend on the step; it is returned to the yield surface before the first one.
    np.testing.assert_array_equal(adaptive["stress_yy"].values[0], fixed["stress_yy"].values[0])
    assert np.abs(adaptive["velocity_y"].values[0]).max() == 0.0


def test_a_paused_adaptive_run_goes_on_bit_for_bit(tmp_path: Path, small_slope: SceneBuilder) -> None:
    scene = small_slope(ADAPTIVE)
    first = run(scene, until="gravity")
    path = tmp_path / "gravity.nc"
    trajectory.write(path, first.trajectory, first.restart)
    resumed, through = run(scene, restart=path), run(scene)
    for name, values in through.restart.items():
        assert resumed.restart[name].values.tobytes() == values.values.tobytes(), name
    np.testing.assert_array_equal(resumed.trajectory["time_step"], through.trajectory["time_step"])


@pytest.mark.long
def test_a_fixed_step_above_the_measured_limit_is_seen(small_slope: SceneBuilder) -> None:
    # Undamped, at h = 2.3 spacings, the debris has modes stiffer than the lattice's, which the step stays just below.  Damping and
    # viscosity of nothing, so that the variant is that of tests/regression.
    step = 0.009
    keys = {
        "numerics.spacing": 2.5, "numerics.smoothing_ratio": 2.3, "numerics.time_step": step, "coupling.S_R": 0.1, "coupling.gamma": 100.0,
        "coupling.solid_after_failure": "elastic_plastic",
        "duration": 1120 * step, "gravity.duration": 112 * step, "motion.start": 112 * step,
        "outputs.series_interval": 2 * step, "outputs.frame_interval": 28 * step,
    }  # fmt: skip
    scene = small_slope({"damping.ratio": 0.0, "numerics.artificial_viscosity.alpha": 0.0} | keys)
    lattice_limit = min(limit.seconds for limit in limits(scene))
    ds = run(scene).trajectory
    ratio = (ds["time_step"] / ds["time_step_limit"]).values
    assert ratio[0] == pytest.approx(step / lattice_limit, rel=0.02)
    assert ratio[0] < 1.0 < ratio.max()
