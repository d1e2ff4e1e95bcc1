"""Measure the runs of a round of a search and add them to those of earlier rounds."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.points import measured_points, no_points, read_points, read_wanted
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings, measure
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure_points(
    path_to_earlier: str | None,
    path_to_wanted: str,
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    settings: Mapping[str, Any],
    path_to_points: str,
) -> None:
    """One row a point; paths and planned scenes in the order of the wanted points."""
    earlier = read_points(path_to_earlier) if path_to_earlier else no_points()
    metrics = [measure(scene.read(path), MetricSettings(**settings)) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    write_csv(measured_points(earlier, read_wanted(path_to_wanted), metrics), path_to_points)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_points(
            snakemake.input.get("earlier"),
            snakemake.input.wanted,
            snakemake.input.get("runs", []),
            snakemake.params.scenes,
            snakemake.params.settings,
            snakemake.output[0],
        )
