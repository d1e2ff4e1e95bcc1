"""A run whose soil has come to rest after the shaking ends there, and loses nothing by it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from comparison import same_bits
from small_scenes import SceneBuilder

from sph.experiments.paper.figures import figure_strength_histories
from sph.figures import figure_geometry, figure_motion, figure_profiles, plot_trajectory
from sph.measures.metrics import measure
from sph.output.run import Run
from sph.solver.early_stop import rest_reason
from sph.solver.initial_state import initial_state
from sph.solver.particles import place_particles
from sph.solver.run import Result, run
from sph.solver.state import FAILED
from sph.storage import trajectory

SLIDE = {"duration": 8.0, "coupling.S_R": 0.5, "coupling.gamma": 100.0}
STOP = {"early_stop.speed": 0.02, "early_stop.window": 0.5}
END_OF_SHAKING = 2.5


@pytest.fixture(scope="module")
def stopped(small_slope: SceneBuilder) -> Result:
    return run(small_slope(SLIDE | STOP))


@pytest.fixture(scope="module")
def whole(small_slope: SceneBuilder) -> Result:
    return run(small_slope(SLIDE))


def written(path: Path, result: Result) -> Path:
    trajectory.write(path, result.trajectory, result.restart)
    return path


def same_end(one: Result, other: Result) -> None:
    same_bits(one, other)
    assert one.trajectory.attrs["status_reason"] == other.trajectory.attrs["status_reason"]


def speeds(ds: xr.Dataset) -> np.ndarray:
    """Larger of the soil's root-mean-square speed and the probe's at every sample, m/s."""
    soil_mass = ds["mass"].values[ds["kind"].values == 0].sum()
    probe = np.hypot(ds["probe_velocity_x"].values, ds["probe_velocity_y"].values)[:, 0]
    return np.maximum(np.sqrt(2 * ds["kinetic_energy"].values / soil_mass), probe)


def test_it_stops_after_the_first_window_at_rest(stopped: Result, whole: Result) -> None:
    ds = stopped.trajectory
    end = float(ds["sample_time"][-1])
    assert stopped.status == "complete"
    assert ds.attrs["status_reason"] == f"at rest since {end - 0.5:.2f} s, stopped at {end:.2f} s"
    assert end < 0.6 * float(whole.trajectory["sample_time"][-1]), "it must save something for the test to mean something"
    time, slow = ds["sample_time"].values, speeds(ds) < 0.02
    assert time[-1] - 0.5 >= END_OF_SHAKING
    assert slow[-51:].all()
    assert not slow[-52], "the sample before the window is the last that moves"


def test_up_to_the_stop_it_is_the_whole_run(stopped: Result, whole: Result) -> None:
    n = stopped.trajectory.sizes["sample"]
    for name in ("kinetic_energy", "probe_displacement_y", "dissipated_energy"):
        np.testing.assert_array_equal(stopped.trajectory[name].values, whole.trajectory[name].values[:n])


def test_the_last_frame_is_the_stop(stopped: Result) -> None:
    times = stopped.trajectory["time"].values
    assert times[-1] == stopped.trajectory["sample_time"].values[-1] == stopped.restart.attrs["step"] * 1e-3
    assert times[-1] % 0.25 > 1e-6, "the stop must fall between frames for the test to mean something"
    np.testing.assert_array_equal(times[:-1], 0.25 * np.arange(times.size - 1))
    np.testing.assert_array_equal(stopped.trajectory["x"].values[-1], stopped.restart["x"].values.astype("f4"))


def test_metrics_hardly_change(stopped: Result, whole: Result) -> None:
    # What is left to move is slower than 2 cm/s and slowing down: A by 0.3 mm and the run-out by 0.2 mm in the paper's scene
    # (S_R 0.10, 0.25, 0.50); here 0.03 and 0.2 mm.
    early, full = measure(stopped.trajectory), measure(whole.trajectory)
    for name in ("displacement_vertical", "displacement_horizontal", "runout", "deposit_height"):
        assert early[name] == pytest.approx(full[name], abs=1e-3), name
    for name in ("collapse_class", "status", "still_moving", "onset_time", "peak_speed", "displacement_vertical_end_of_shaking"):
        assert early[name] == full[name], name


def test_figures_can_be_drawn(stopped: Result, whole: Result) -> None:
    both = {"stopped": Run(stopped.trajectory), "whole": Run(whole.trajectory)}
    figures = [figure_geometry(both["stopped"]), figure_motion(both["stopped"]), plot_trajectory(both["stopped"])]
    figures += [figure_profiles(both), figure_strength_histories({"both": both})]
    for figure in figures:
        figure.canvas.draw()
    assert "until at rest, 8 s at most" in figures[0].get_supxlabel()


def test_without_failure_it_is_unfailed(small_slope: SceneBuilder) -> None:
    for until in ("end", "first_failure"):
        result = run(small_slope(SLIDE | STOP | {"soil.cohesion": 1e4}), until=until)  # type: ignore[arg-type]
        assert result.status == "unfailed"
        assert END_OF_SHAKING + 0.5 <= float(result.trajectory["sample_time"][-1]) < END_OF_SHAKING + 1.0
        assert result.trajectory.attrs["status_reason"].startswith("at rest since ")


def test_without_shaking_it_counts_from_the_end_of_the_gravity_stage(small_slope: SceneBuilder) -> None:
    calm = small_slope(SLIDE | STOP | {"motion.kind": "none"})
    assert run(calm, until="gravity").status == "paused"
    assert run(calm).trajectory.attrs["status_reason"] == "at rest since 1.00 s, stopped at 1.50 s"


def test_a_branch_stops_where_an_unbranched_run_does(tmp_path: Path, small_slope: SceneBuilder, stopped: Result) -> None:
    pre_failure = small_slope(SLIDE | {"coupling.S_R": 0.1, "early_stop": {"speed": 0.5, "window": 0.1}})
    paused = run(pre_failure, until="first_failure")
    assert paused.status == "paused"
    same_end(run(small_slope(SLIDE | STOP), restart=written(tmp_path / "pre_failure.nc", paused)), stopped)


def test_a_run_paused_within_the_window_stops_where_an_unbranched_one_does(
    tmp_path: Path, small_slope: SceneBuilder, stopped: Result
) -> None:
    within = round(float(stopped.trajectory["sample_time"][-1]) - 0.2, 2)
    first = run(small_slope(SLIDE | STOP | {"duration": within}))
    assert first.trajectory.attrs["status_reason"] == ""
    same_end(run(small_slope(SLIDE | STOP), restart=written(tmp_path / "within.nc", first)), stopped)


def test_a_stopped_run_does_not_run_on(tmp_path: Path, small_slope: SceneBuilder, stopped: Result) -> None:
    path = written(tmp_path / "stopped.nc", stopped)
    same_end(run(small_slope(SLIDE | STOP), restart=path), stopped)
    same_end(run(small_slope(SLIDE | STOP | {"duration": 9.0}), restart=path), stopped)


def test_another_early_stop_is_refused_once_it_could_have_acted(tmp_path: Path, small_slope: SceneBuilder, stopped: Result) -> None:
    with pytest.raises(ValueError, match=r"early_stop\.speed: 0\.02 .*None"):
        run(small_slope(SLIDE), restart=written(tmp_path / "stopped.nc", stopped))


def test_a_loss_of_strength_under_way_is_waited_for(small_slope: SceneBuilder) -> None:
    # With gamma = 0.1 1/s the paper's slope (S_R 0.25) stands at the end of the shaking, A moved by 1.5 cm, and has
    # collapsed 25 s later, A moved by 4.4 m.
    scene = small_slope(SLIDE | STOP)
    particles = place_particles(scene)
    state = initial_state(particles, scene)
    still = {"kinetic_energy": [0.0] * 301} | {f"probe_velocity_{axis}": [np.zeros(1)] * 301 for axis in "xy"}
    assert rest_reason(scene, 3000, still, state, 1.0) == "at rest since 2.50 s, stopped at 3.00 s"
    state.phase[3], state.beta[3] = FAILED, 0.06
    assert rest_reason(scene, 3000, still, state, 1.0) == ""
    state.beta[3] = 0.05
    assert rest_reason(scene, 3000, still, state, 1.0) != ""
