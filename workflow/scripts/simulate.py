"""Simulate one stage or run of a study, or search the limit of a scene by many runs."""

from collections.abc import Mapping
from typing import Any

from sph import trajectory
from sph.command.progress import reporter
from sph.scene import make_scene
from sph.solver import Until, run
from sph.stability.record import run_search


def simulate(
    scene: Mapping[str, Any], until: Until, path_to_restart: str | None, path_to_trajectory: str, path_to_log: str, enforce_limit: bool
) -> None:
    """Run a scene, from a restart if there is one, and write its trajectory; a run that diverges is a result."""
    with open(path_to_log, "w", encoding="utf-8") as log, reporter(path_to_trajectory, log) as report:
        result = run(make_scene(scene), until, path_to_restart, report, enforce_limit=enforce_limit)
        trajectory.write(path_to_trajectory, result.trajectory, result.restart)
        print(f"{path_to_trajectory}: {result.status} {result.trajectory.attrs['status_reason']}", file=log)


def find_limit(scene: Mapping[str, Any], by: str, path_to_trials: str, path_to_log: str) -> None:
    """Search the strength at which a scene just stands, and write the trials."""
    with open(path_to_log, "w", encoding="utf-8") as log:
        trials = run_search(scene, by, lambda trial: print(*trial, file=log, flush=True))
    trajectory.write(path_to_trials, trials)


if __name__ == "__main__":
    scene, by = snakemake.params.scene, snakemake.params.get("by", "simulation")  # type: ignore[name-defined]
    out, log = snakemake.output[0], snakemake.log[0]  # type: ignore[name-defined]
    if by == "simulation":
        enforce = snakemake.params.get("enforce_limit", True)  # type: ignore[name-defined]
        simulate(scene, snakemake.params.until, snakemake.input.get("restart"), out, log, enforce)  # type: ignore[name-defined]
    else:
        find_limit(scene, by, out, log)
