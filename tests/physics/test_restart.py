"""A run that is paused, resumed and branched equals an uninterrupted one bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comparison import VARIANTS, same_bits
from small_scenes import FEW, SceneBuilder

from sph.scene.configuration import flat
from sph.solver.run import Result, Run, run
from sph.solver.terms import TERMS
from sph.storage import trajectory

PRE_FAILURE = {"coupling.S_R": 0.5, "coupling.gamma": 1.0}
BRANCH = {"coupling.S_R": 0.1, "coupling.gamma": 100.0, "name": "branch"}


def paused(path: Path, result: Result) -> Path:
    assert result.status == "paused"
    trajectory.write(path, result.trajectory, result.restart)
    return path


@pytest.mark.parametrize("variant", ["default", *(pytest.param(name, marks=pytest.mark.long) for name in VARIANTS if name != "default")])
def test_pre_failure_run_and_branch_equal_an_unbranched_run(tmp_path: Path, small_slope: SceneBuilder, variant: str) -> None:
    extra = VARIANTS[variant]
    pre_failure, branch = small_slope(PRE_FAILURE | extra), small_slope(BRANCH | extra)
    at_rest = paused(tmp_path / "gravity.nc", run(small_slope(PRE_FAILURE | extra | {"motion.amplitude": 1.0}), until="gravity"))
    first = run(pre_failure, until="first_failure", restart=at_rest)
    assert not first.trajectory["failed"].values.any()
    at_failure = paused(tmp_path / "first_failure.nc", first)
    branched = run(branch, restart=at_failure)
    unbranched = run(branch)
    failed = float(branched.trajectory["failed_fraction"][-1])
    assert branched.status == "complete" and failed > 0.1, "the branch must fail for the test to mean something"
    assert np.nanmin(branched.trajectory["t_f"].values) > pre_failure.gravity.duration
    same_bits(branched, unbranched)


@pytest.mark.parametrize("variant", ["default", pytest.param("all states", marks=pytest.mark.long)])
def test_a_run_that_goes_on_in_the_middle_of_a_collapse_equals_an_uninterrupted_one(
    tmp_path: Path, small_slope: SceneBuilder, variant: str
) -> None:
    # Taken up again where some soil has lost nearly all of its strength and some is losing it.
    scene = small_slope({"coupling.S_R": 0.1, "coupling.gamma": 5.0} | VARIANTS[variant])
    kept = {term.name for term in TERMS if term.state and term.wanted(scene)}
    assert kept == ({"cyclic_pore_pressure", "initial_arrangement", "interface", "seams", "slip"} if variant == "all states" else set())
    middle = tmp_path / "middle.nc"

    def keep(result: Callable[[], Result]) -> None:
        beta = (state := result()).restart["beta"].values
        if np.count_nonzero(beta < 0.1) > 10 and np.any((beta > 0.1) & (beta < 1)) and not middle.exists():
            trajectory.write(middle, state.trajectory, state.restart)

    whole = Run(scene).go(checkpoint=keep)
    begun = trajectory.read_restart(middle)
    assert begun.attrs["step"] < whole.restart.attrs["step"]
    assert variant == "default" or begun["excess_pressure"].values.max() > 0.0, "pore pressure that shaking has raised goes on as well"
    same_bits(run(scene, restart=middle), whole)


@pytest.mark.uncompiled
def test_the_states_of_all_terms_go_on(tmp_path: Path, small_slope: SceneBuilder) -> None:
    """As above for a few steps, too few for a collapse."""
    few = {name: value for name, value in flat(FEW).items() if name != "duration"} | {"duration": 0.005}
    scene, middle = small_slope(VARIANTS["all states"] | few), tmp_path / "middle.nc"

    def keep(result: Callable[[], Result]) -> None:
        if (state := result()).restart.attrs["step"] == 3:
            trajectory.write(middle, state.trajectory, state.restart)

    whole = Run(scene).go(checkpoint=keep)
    same_bits(run(scene, restart=middle), whole)
    assert all(whole.restart[name].values.any() for name in ("stretch", "intact", "seam_normal"))


def test_branches_differ(tmp_path: Path, small_slope: SceneBuilder) -> None:
    strong, weak = (run(small_slope({"coupling.S_R": s, "coupling.gamma": 100.0})).trajectory for s in (0.9, 0.1))
    a, b = (float(ds["probe_displacement_y"][-1, 0]) for ds in (strong, weak))
    assert b < a
    # Up to the first failure they are the same, bit for bit.
    t_f = np.nanmin(weak["t_f"].values)
    before = weak["sample_time"].values < t_f
    np.testing.assert_array_equal(strong["kinetic_energy"].values[before], weak["kinetic_energy"].values[before])


@pytest.fixture(scope="module")
def gravity_file(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    return paused(tmp_path_factory.mktemp("restart") / "gravity.nc", run(small_slope(PRE_FAILURE), until="gravity"))


@pytest.fixture(scope="module")
def failed_file(tmp_path_factory: pytest.TempPathFactory, small_slope: SceneBuilder) -> Path:
    path = tmp_path_factory.mktemp("restart") / "failed.nc"
    result = run(small_slope(PRE_FAILURE))
    assert result.status == "complete" and result.trajectory["failed"].values.any()
    trajectory.write(path, result.trajectory, result.restart)
    return path


@pytest.mark.parametrize(
    "overrides",
    [
        {"soil.density": 2000.0},
        {"numerics.time_step": 5e-4},
        {"numerics.gradient_correction": {"min_determinant": 0.3}},
        {"walls.sides": "free_slip", "walls.layers": 4},
        {"gravity.damping": 10.0},
        {"damping": None},
        {"outputs.series_interval": 0.05},
        {"probes": {"B": "toe"}},
        {"geometry.slope_angle": 45.0},
    ],
    ids=lambda o: next(iter(o)),
)
def test_other_scenes_are_refused_by_key(gravity_file: Path, small_slope: SceneBuilder, overrides: dict[str, Any]) -> None:
    with pytest.raises(ValueError) as raised:
        run(small_slope(PRE_FAILURE | overrides), restart=gravity_file)
    message = str(raised.value)
    assert "gravity.nc" in message
    key, value = next(iter(overrides.items()))
    assert key in message
    if isinstance(value, float):
        assert str(value) in message


def test_every_differing_key_is_named(gravity_file: Path, small_slope: SceneBuilder) -> None:
    with pytest.raises(ValueError) as raised:
        run(small_slope(PRE_FAILURE | {"soil.density": 2000.0, "soil.cohesion": 10.0}), restart=gravity_file)
    assert "soil.density" in str(raised.value) and "soil.cohesion" in str(raised.value)


def test_motion_may_change_before_the_shaking_only(tmp_path: Path, gravity_file: Path, small_slope: SceneBuilder) -> None:
    assert run(small_slope(PRE_FAILURE | {"motion.amplitude": 7.0}), restart=gravity_file).status == "complete"
    later = paused(tmp_path / "later.nc", run(small_slope(PRE_FAILURE), until="first_failure", restart=gravity_file))
    with pytest.raises(ValueError, match=r"motion\.amplitude"):
        run(small_slope(PRE_FAILURE | {"motion.amplitude": 7.0}), restart=later)


def test_strength_may_not_change_after_a_failure(failed_file: Path, small_slope: SceneBuilder) -> None:
    for change in ({"coupling.S_R": 0.1}, {"coupling.gamma": 100.0}, {"coupling.fluid_tension_limit": 5.0}):
        with pytest.raises(ValueError, match=next(iter(change))):
            run(small_slope(PRE_FAILURE | change | {"duration": 3.5}), restart=failed_file)


def test_strength_may_not_change_after_a_failure_between_frames(tmp_path: Path, small_slope: SceneBuilder) -> None:
    # A checkpoint after the first failure but before the next frame, which is the first to show it.
    kept: list[Result] = []

    def keep(result: Callable[[], Result]) -> None:
        if not kept and float((state := result()).trajectory["failed_fraction"][-1]) > 0:
            kept.append(state)

    Run(small_slope(PRE_FAILURE)).go(checkpoint=keep)
    assert not kept[0].trajectory["failed"].values.any()
    trajectory.write(tmp_path / "between.nc", kept[0].trajectory, kept[0].restart)
    with pytest.raises(ValueError, match=r"coupling\.S_R"):
        run(small_slope(PRE_FAILURE | {"coupling.S_R": 0.1}), restart=tmp_path / "between.nc")


def test_a_longer_duration_goes_on(failed_file: Path, small_slope: SceneBuilder) -> None:
    longer = small_slope(PRE_FAILURE | {"duration": 3.5, "name": "longer", "title": "longer"})
    same_bits(run(longer, restart=failed_file), run(longer))


def test_a_shorter_duration_than_reached_is_refused(failed_file: Path, small_slope: SceneBuilder) -> None:
    with pytest.raises(ValueError, match="duration"):
        run(small_slope(PRE_FAILURE | {"duration": 2.75}), restart=failed_file)


def test_unfailed(tmp_path: Path, small_slope: SceneBuilder) -> None:
    calm = small_slope({"motion.amplitude": 0.0, "soil.cohesion": 1e4})
    for until in ("end", "first_failure"):
        result = run(calm, until=until)  # type: ignore[arg-type]
        assert result.status == "unfailed"
        assert float(result.trajectory["failed_fraction"].max()) == 0
        assert np.isnan(result.trajectory["t_f"].values).all()


def test_cost_is_added_up(gravity_file: Path, small_slope: SceneBuilder) -> None:
    earlier = trajectory.read(gravity_file).attrs
    result = run(small_slope(PRE_FAILURE), restart=gravity_file).trajectory
    n = result.sizes["particle"]
    assert result.attrs["particle_steps"] == 3000 * n
    assert earlier["particle_steps"] == 1000 * n
    assert result.attrs["wall_time_s"] > earlier["wall_time_s"]


def test_a_diverged_run_stays_diverged(tmp_path: Path, small_slope: SceneBuilder, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its branches are results of the same status; they neither go on nor come back to life."""
    monkeypatch.setattr("sph.solver.guard.MAX_SPEED_RATIO", 1e-9)
    stopped = run(small_slope(PRE_FAILURE), until="first_failure")
    assert stopped.status == "diverged"
    trajectory.write(tmp_path / "diverged.nc", stopped.trajectory, stopped.restart)
    monkeypatch.undo()
    branch = run(small_slope(BRANCH), restart=tmp_path / "diverged.nc")
    assert branch.status == "diverged"
    assert branch.trajectory.attrs["status_reason"] == stopped.trajectory.attrs["status_reason"] != ""
    assert branch.restart.attrs["step"] == stopped.restart.attrs["step"]
