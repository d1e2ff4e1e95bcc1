"""Measure the runs at the ends of their keys' ranges."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.robustness import Row, extremes_table
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure_extremes(
    paths_to_runs: Mapping[str, str], scenes: Mapping[str, Planned], rows: Sequence[Mapping[str, Any]], path_to_csv: str
) -> None:
    """One row a value and case; paths and planned scenes by the name of the run."""
    table = extremes_table([Row(**row) for row in rows], lambda name: scenes[name].read(paths_to_runs[name]))
    write_csv(table, path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_extremes(
            dict(zip(snakemake.params.scenes, snakemake.input.runs, strict=True)),
            snakemake.params.scenes,
            snakemake.params.rows,
            snakemake.output[0],
        )
