"""The same run in other pieces: stages, checkpoints, threads, other frames and samples."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import yaml
from answers import (
    Case,
    common,
    first_failure,
    same_metrics,
    same_state,
    same_to_rounding,
    same_until,
    with_trajectory,
)
from comparison import same_bits, same_variables
from relation import default_walls, relation, shaken
from scenes import GRAVITY_STAGE, SERIES_INTERVAL, TIME_STEP

from sph.scene.schema import make_scene
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Result, Run, run
from sph.storage import trajectory
from sph.study.plan import load_study


@relation()
def run_in_stages(case: Case, chance: np.random.Generator) -> None:
    """To the end of the gravity stage, on to the first failure and on to the end, through files: the bits of a run without a stop."""
    gravity, pre_failure = case.folder / "gravity.nc", case.folder / "pre_failure.nc"
    run_to_file(case.scene, gravity, "gravity")
    paused = run_to_file(case.scene, pre_failure, "first_failure", gravity)
    same_bits(case.result, run(case.scene, restart=pre_failure) if paused.status == "paused" else paused)


@relation()
def run_killed_and_given_again(case: Case, chance: np.random.Generator) -> None:
    """A run that stops after any sample but its last and goes on from its checkpoint: the bits of a run without a stop."""
    left = int(chance.integers(1, case.result.trajectory.sizes["sample"] - 1))
    path = case.folder / "checkpoint.nc"

    def keep(result: Callable[[], Result]) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            trajectory.write(path, (state := result()).stored, state.stored_restart)
            raise KeyboardInterrupt

    with suppress(KeyboardInterrupt):
        Run(case.scene).go(checkpoint=keep)
    again = Run(case.scene)
    again.resume(path)
    same_bits(case.result, again.go())


@relation()
def restart_of_another_scene(case: Case, chance: np.random.Generator) -> None:
    """A scene that goes on from the gravity stage of another is refused, or has the bits of a run without a stop."""
    layers = case.data.get("layers", {})
    both = {name: {"region": {"kind": "elevation", "top": 1e4}, "soil": {"cohesion": c}} for name, c in (("a", 10.0), ("b", 90.0))}
    pairs = [
        (case.data, case.changed({"soil.cohesion": case.data["soil"]["cohesion"] + 5.0})),
        (case.data, case.changed({"coupling.S_R": 0.33, "coupling.gamma": 7.0, "coupling.fluid_tension_limit": 3.0})),
        (case.data, case.changed({"motion": {"kind": "ricker", "amplitude": 4.0, "frequency": 4.0, "peak": 1.5}, "duration": 4.0})),
        (case.data, case.changed({"gravity.damping": 10.0})),
        (case.data, {**case.data, "probes": {"B": "toe", **case.data["probes"]}}),
        (case.data, {**case.data, "layers": dict(reversed(layers.items()))}),
    ]
    if default_walls(case):
        pairs.append(({**case.data, "layers": both}, {**case.data, "layers": dict(reversed(both.items()))}))
    first, second = pairs[int(chance.integers(len(pairs)))]
    path = case.folder / "gravity_of_another.nc"
    run_to_file(make_scene(first), path, "gravity")
    case.others[:] = [first, second]
    try:
        result = run(make_scene(second), restart=path)
    except ValueError as error:
        assert "cannot continue from this run" in str(error), error
        return
    same_bits(run(make_scene(second)), result)


@relation()
def two_threads(case: Case, chance: np.random.Generator) -> None:
    """One thread or two, each with rows of particles of its own (a finer lattice than the other relations have): the same bits."""
    finer = case.changed({"numerics.spacing": 0.5 * case.scene.numerics.spacing, "numerics.time_step": 0.5 * TIME_STEP, "duration": 1.5})
    same_bits(case.run(finer), case.run(finer, threads=2))


@relation()
def other_frames(case: Case, chance: np.random.Generator) -> None:
    """Frames at another interval, which need not divide the gravity stage, the shaking or the duration: the same bits of the state and of
    what both store, and the same metrics, but for those of frames."""
    result = case.run(case.changed({"outputs.frame_interval": SERIES_INTERVAL * int(chance.integers(1, 150))}))
    same_state(case.result, result)
    same_variables(*common(case.result.trajectory, result.trajectory))
    of_frames = {
        "time_step_ratio",
        "reached_side",
        "reached_side_time",
        "time_to_rest",
    }  # the last by the frame about a second before the end
    same_metrics(case.result.trajectory, result.trajectory, of_frames)


@relation()
def other_samples(case: Case, chance: np.random.Generator) -> None:
    """Samples at another interval: the same bits of the state, and of frames and samples that both have."""
    interval = float(chance.choice([TIME_STEP, 0.05, 0.125, 0.25]))
    result = case.run(case.changed({"outputs.series_interval": interval, "outputs.frame_interval": 2.0 * interval}))
    same_state(case.result, result)
    same_variables(*common(case.result.trajectory, result.trajectory))


@relation()
def longer_run(case: Case, chance: np.random.Generator) -> None:
    """A run that goes on for longer: the same bits up to the end of the shorter one."""
    result = case.run(case.changed({"duration": case.scene.duration + 0.5 * float(chance.integers(1, 3))}))
    same_until(case.result.trajectory, result.trajectory, case.scene.duration + TIME_STEP)


@relation()
def early_stop(case: Case, chance: np.random.Generator) -> None:
    """A run that ends once the soil is at rest: the bits of the run that goes on, up to there."""
    result = case.run(case.changed({"early_stop": {"speed": 0.1, "window": 0.25, "solid_weight": 0.9}}))
    end = float(result.trajectory["sample_time"][-1])
    same_until(case.result.trajectory, result.trajectory, end + TIME_STEP)
    assert end < case.scene.duration or result.status == case.result.status


@relation()
def more_probes(case: Case, chance: np.random.Generator) -> None:
    """Probes added before and after the others: the same bits of all else, and of the probes that were there."""
    other = {**case.data, "probes": {"Z": "toe", **case.data["probes"], "B": case.data["probes"]["A"]}}
    result = case.run(other)
    same_bits(case.result, with_trajectory(result, result.trajectory.isel(probe=[1])))
    again = result.trajectory.isel(probe=[2])
    same_variables(case.result.trajectory.drop_vars("probe"), again.drop_vars("probe"))
    same_metrics(case.result.trajectory, result.trajectory)


@relation()
def step_that_need_not_adapt(case: Case, chance: np.random.Generator) -> None:
    """An adaptive time step where the step is below its limit throughout: the bits of a fixed one."""
    ds = case.result.trajectory
    largest = float((ds["time_step"] / ds["time_step_limit"]).max())
    if largest < 0.98:
        same_bits(case.result, case.run(case.changed({"numerics.adaptive_step": {"courant": 0.99}})))


@relation()
def wider_neighbour_lists(case: Case, chance: np.random.Generator) -> None:
    """Neighbour lists with a wider margin: the same to rounding, since rows are summed in another order."""
    result = case.run(case.changed({"numerics.neighbour_skin": float(chance.uniform(0.35, 1.0))}))
    same_to_rounding(case.result, result, case.scene)


@relation()
def what_acts_later(case: Case, chance: np.random.Generator) -> None:
    """S_R and gamma have no effect before the first failure, the motion none before the end of the gravity stage: the same bits."""
    changes = {"coupling.S_R": float(chance.uniform()), "coupling.gamma": float(chance.uniform(0.0, 100.0))}
    result = case.run(case.changed(changes))
    assert first_failure(result) == first_failure(case.result)
    same_until(case.result.trajectory, result.trajectory, first_failure(case.result))
    still = case.run(case.changed({"motion": {"kind": "none"}}))
    same_until(case.result.trajectory, still.trajectory, GRAVITY_STAGE)


@relation(shaken("tapered_sine", "velocity_pulse"))
def study_against_single_runs(case: Case, chance: np.random.Generator) -> None:
    """The runs of a study go on from shared stages: each has the bits of the scene run alone, whatever the order of the grid's values."""
    path = case.folder / "study_scene.yaml"
    path.write_text(yaml.safe_dump(case.data, sort_keys=False))
    own = str(case.data["motion"]["amplitude"])
    ratios, amplitudes = ["0.10", "0.9"], [own, "8.5" if float(own) != 8.5 else "6.5"]
    study = {"study": "s", "scene": path.name, "fidelity": "draft", "fidelities": {"draft": {}}}
    plans = [
        load_study({**study, "grid": {"S_R": s, "soil.cohesion": ["5", "40"], "amplitude": a}}, [case.folder])
        for s, a in ((ratios, amplitudes), (ratios[::-1], amplitudes[::-1]))
    ]
    assert sorted(plans[0].study.runs) == sorted(plans[1].study.runs)
    name = str(chance.choice(sorted(plans[0].study.runs)))
    scenes = [make_scene(plan.shared.runs[name].scene) for plan in plans]
    case.others[:] = [name]
    assert scenes[0].model_dump_json() == scenes[1].model_dump_json()
    settled = plans[0].shared.gravity_of(name)
    shaken = next(row for row in plans[0].shared if row.file == plans[0].shared.runs[name].parent)
    gravity, pre_failure = case.folder / "study_gravity.nc", case.folder / "study_pre_failure.nc"
    run_to_file(make_scene(settled.scene), gravity, "gravity")
    run_to_file(make_scene(shaken.scene), pre_failure, "first_failure", gravity)
    same_bits(run(scenes[0]), run(scenes[0], restart=pre_failure))
