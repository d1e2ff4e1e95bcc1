"""Compare points of a sample with the same ones at another fidelity."""

from collections.abc import Sequence

from sph.experiments.sensitivity.design import Axis, Quantity
from sph.experiments.sensitivity.tables import confirmation_table, read_sample
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def confirm_sample(
    path_to_sample: str,
    path_to_confirmed: str,
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    fidelities: tuple[str, str],
    path_to_table: str,
) -> None:
    """One row a metric and point."""
    sample, confirmed = (read_sample(path, axes, quantities) for path in (path_to_sample, path_to_confirmed))
    write_csv(confirmation_table(sample, confirmed, quantities, fidelities), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        confirm_sample(
            snakemake.input.sample,
            snakemake.input.confirmed,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.fidelities,
            snakemake.output[0],
        )
