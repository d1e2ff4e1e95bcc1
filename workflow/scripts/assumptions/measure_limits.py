"""Measure what a change of one choice does."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.assumptions import limits_table
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure_limits(
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    rows: Sequence[tuple[str, str]],
    settings: Mapping[str, Any],
    path_to_csv: str,
) -> None:
    """One row a change and case; paths and planned scenes in the rows' order."""
    runs = [scene.read(path) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    write_csv(limits_table([(change, case) for change, case in rows], runs, MetricSettings(**settings)), path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_limits(
            snakemake.input.runs,
            snakemake.params.scenes,
            snakemake.params.rows,
            snakemake.params.settings,
            snakemake.output[0],
        )
