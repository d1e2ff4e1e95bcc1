"""Compare the ends of brackets with the same points at another fidelity."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.critical import confirm_table, read_ends
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings, measure
from sph.study.planned import Planned
from sph.study.tables import write_csv


def confirm_trigger(
    path_to_ends: str,
    path_to_points: str,
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    settings: Mapping[str, Any],
    searched: Searched,
    path_to_csv: str,
) -> None:
    """One row an end; paths and planned scenes in the ends' order."""
    metrics = [measure(scene.read(path), MetricSettings(**settings)) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    write_csv(confirm_table(read_ends(path_to_ends), read_points(path_to_points), metrics, searched), path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        confirm_trigger(
            snakemake.input.ends,
            snakemake.input.points,
            snakemake.input.get("runs", []),
            snakemake.params.scenes,
            snakemake.params.settings,
            snakemake.params.searched,
            snakemake.output[0],
        )
