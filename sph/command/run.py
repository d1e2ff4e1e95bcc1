"""What ``sph run`` does: a new run, one that goes on, or one that is repeated from the trajectory that holds its scene.

A run that continued from a stage, as those of a study do, is repeated from the start: what may differ between a stage and the run that
continues it (see ``sph.solver.run.check_restart``) has no effect before the stage ends, so that both give the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sph.checks.after_run import found_after
from sph.checks.finding import codes
from sph.checks.messages import line
from sph.checks.scene import findings
from sph.command.given import earlier_run, read_given
from sph.command.outputs import check_writable
from sph.command.terminal import say
from sph.jobs.exit_codes import DIVERGED
from sph.jobs.progress import reporter
from sph.output.run import Run
from sph.scene.names import check_known
from sph.scene.schema import Scene
from sph.scene.strict_json import parse_json
from sph.solver.backends import backend_of
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Until
from sph.storage import trajectory
from sph.storage.netcdf import Group, read_attributes
from sph.storage.trajectory import Status
from sph.study.planned import differing


def run(
    path: Path,
    changes: Mapping[str, Any],
    out: Path | None,
    restart: Path | None,
    until: str | None,
    threads: int,
    checkpoint: float | None,
    overwrite: bool,
    backend: str = "cpu",
) -> tuple[str, int]:
    """Simulate the scene in a file with changes; what came of it, and the exit code."""
    check_known("--until", [until], ("end", "gravity", "first_failure"))
    earlier = earlier_run(path)
    made_by = backend_of(backend)
    if made_by is not None and threads > 1:
        raise ValueError(f"--threads {threads}: threads are of the processor; leave it out with --backend {backend}")
    scene, inputs = read_given(path, changes, earlier)
    out = out or Path(f"{scene.name}.nc")
    check_writable(out, [*inputs, *([restart] if restart else [])])
    if not overwrite:
        check_of_scene(out, scene)
    repeats = earlier is not None and not changes and until is None
    told = findings(scene)
    say(*(line(each) for each in told if each.counts))
    with reporter(scene.name, scene) as report:
        result = run_to_file(
            scene,
            out,
            until or stopped_at(earlier),  # type: ignore[arg-type]
            restart,
            report,
            threads,
            checkpoint,
            say,
            enforce_limit=not repeats,  # what was allowed to run with a step above its limit may be repeated
            attrs={"findings": codes(told)},
            backend=made_by,
        )
    made = Run(result.stored, scene)
    if made.time_step_ratio > 1.0:
        say(above_limit(made))
    if result.status not in (Status.DIVERGED, Status.PAUSED):
        say(*(line(each) for each in found_after(made)))
    if earlier is not None and repeats:
        say(compare(earlier, result.stored, path))
    reason = f" ({made.attrs['status_reason']})" if made.attrs["status_reason"] else ""
    speed = made.attrs["particle_steps_per_second"] / 1e6
    text = f"{out}: {result.status}{reason}, {made.attrs['wall_time_s']:.1f} s, {speed:.2f} M particle-steps/s"
    return text, DIVERGED if result.status == Status.DIVERGED else 0


def above_limit(run: Run) -> str:
    """That the time step exceeded its limit as measured during a run; a step that adapts does so at the next frame only."""
    ratio, adaptive = run.time_step_ratio, run.scene.numerics.adaptive_step
    if adaptive is None:
        remedy = "choose a smaller step, or let it adapt (numerics.adaptive_step={})"
        return f"numerics.time_step was {ratio:.2f} times the stability limit measured during the run; {remedy}"
    frames = int(np.count_nonzero(run["time_step"] > run["time_step_limit"]))
    return (
        f"the time step was up to {ratio:.2f} times its limit in {frames} of {len(run['time'])} frames, at which it was shortened; if the "
        "energy budget does not close (energy-open), choose a shorter outputs.frame_interval, or "
        f"numerics.adaptive_step.courant={adaptive.courant / ratio:.2f}"
    )


def check_of_scene(path: Path, scene: Scene) -> None:
    """ValueError where a file holds the run of another scene, with the first key that differs; one that cannot be read may be replaced."""
    try:
        attrs = read_attributes(path)
        differ = differing(attrs, scene, path) if "scene" in attrs else []
    except (OSError, RuntimeError, ValueError):
        return
    if differ:
        more = f" and {len(differ) - 1} more" if len(differ) > 1 else ""
        raise ValueError(
            f"--out {path}: holds the run of another scene ({differ[0]}{more}); name another file, or replace it with --overwrite"
        )


def stopped_at(earlier: Group | None) -> Until:
    """The stage up to which a trajectory was to be simulated; ``end`` for a new scene.

    A paused run whose last sample is that at the end of the gravity stage has the same bits whichever stage it was told to stop at.
    """
    if earlier is None or earlier.attrs.get("status") != trajectory.Status.PAUSED:
        return "end"
    scene = trajectory.scene_of(earlier)
    at_gravity = scene.steps(float(earlier["sample_time"].values[-1])) == scene.steps(scene.gravity.duration)
    return "gravity" if at_gravity else "first_failure"


def compare(earlier: Group, again: Group, path: Path) -> str:
    """Whether a repeated run has the bits of the earlier one, in words; if not, what was not the same."""
    names = [name for name in trajectory.BY_NAME if name in again]
    differ = [name for name in names if name not in earlier or not _same(earlier[name].values, again[name].values)]
    if not differ:
        return f"every variable is identical to that of {path}, bit for bit"
    old, new = (
        parse_json(run.attrs.get("versions", "{}")) | {"machine": run.attrs.get("machine"), "--backend": run.attrs.get("backend", "cpu")}
        for run in (earlier, again)
    )
    other = ", ".join(f"{name} {old.get(name)} there and {new[name]} here" for name in new if old.get(name) != new[name])
    return f"differs from {path} in {', '.join(differ)}: {other or 'made by other sources or on another processor'}"


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
