"""Screen the factors by their elementary effects."""

from collections.abc import Sequence

from sph.experiments.sensitivity.design import Axis, Quantity
from sph.experiments.sensitivity.elementary_effects import morris_table
from sph.experiments.sensitivity.tables import read_sample
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def screen_factors(
    path_to_sample: str,
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    resamples: int,
    seed: int,
    path_to_table: str,
) -> None:
    """One row a metric and factor."""
    write_csv(morris_table(read_sample(path_to_sample, axes, quantities), axes, quantities, resamples, seed), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        screen_factors(
            snakemake.input.sample,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.resamples,
            snakemake.params.seed,
            snakemake.output[0],
        )
