"""Tabulate the metrics at both ends of every factor."""

from collections.abc import Sequence

from sph.command.job import job_log
from sph.experiments.sensitivity.design import Axis, Quantity
from sph.experiments.sensitivity.tables import read_sample, tornado_table
from sph.study.tables import write_csv


def measure_tornado(path_to_sample: str, axes: Sequence[Axis], quantities: Sequence[Quantity], path_to_table: str) -> None:
    """One row a metric and factor."""
    write_csv(tornado_table(read_sample(path_to_sample, axes, quantities), axes, quantities), path_to_table)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        measure_tornado(
            snakemake.input.sample,  # type: ignore[name-defined]
            snakemake.params.axes,  # type: ignore[name-defined]
            snakemake.params.quantities,  # type: ignore[name-defined]
            snakemake.output[0],  # type: ignore[name-defined]
        )
