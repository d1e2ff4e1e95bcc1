"""Tabulate the metrics at both ends of every factor."""

from collections.abc import Sequence

from sph.experiments.sensitivity.design import Axis, Quantity
from sph.experiments.sensitivity.tables import read_sample, tornado_table
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def measure_tornado(path_to_sample: str, axes: Sequence[Axis], quantities: Sequence[Quantity], path_to_table: str) -> None:
    """One row a metric and factor."""
    write_csv(tornado_table(read_sample(path_to_sample, axes, quantities), axes, quantities), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_tornado(
            snakemake.input.sample,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.output[0],
        )
