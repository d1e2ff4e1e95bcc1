"""Simulate one stage or run of a study."""

from collections.abc import Mapping
from typing import Any

from sph import trajectory
from sph.command.progress import reporter
from sph.scene import make_scene
from sph.solver import Until, run


def simulate(scene: Mapping[str, Any], until: Until, path_to_restart: str | None, path_to_trajectory: str, path_to_log: str) -> None:
    """Run a scene, from a restart if there is one, and write its trajectory; a run that diverges is a result."""
    with open(path_to_log, "w", encoding="utf-8") as log, reporter(path_to_trajectory, log) as report:
        result = run(make_scene(scene), until, path_to_restart, report)
        trajectory.write(path_to_trajectory, result.trajectory, result.restart)
        print(f"{path_to_trajectory}: {result.status} {result.trajectory.attrs['status_reason']}", file=log)


if __name__ == "__main__":
    simulate(
        snakemake.params.scene,  # type: ignore[name-defined]
        snakemake.params.until,  # type: ignore[name-defined]
        snakemake.input.get("restart"),  # type: ignore[name-defined]
        snakemake.output[0],  # type: ignore[name-defined]
        snakemake.log[0],  # type: ignore[name-defined]
    )
