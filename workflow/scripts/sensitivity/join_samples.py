"""Put the samples of all designs of the sensitivity analysis together."""

from collections.abc import Sequence

import pandas as pd

from sph.experiments.sensitivity.design import Axis, Quantity
from sph.experiments.sensitivity.tables import read_sample, sample_columns
from sph.jobs.log import Job, job_log
from sph.storage import trajectory
from sph.study.tables import flat_dataset, write_csv


def join_samples(
    paths_to_samples: Sequence[str],
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    path_to_nc: str,
    path_to_csv: str,
) -> None:
    """The rows of every sample, in the order of the paths."""
    frame = pd.concat([read_sample(path, axes, quantities) for path in paths_to_samples], ignore_index=True)
    trajectory.write(path_to_nc, flat_dataset(frame, sample_columns(axes, quantities)))
    write_csv(frame, path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        join_samples(
            snakemake.input.samples,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.output.nc,
            snakemake.output.csv,
        )
