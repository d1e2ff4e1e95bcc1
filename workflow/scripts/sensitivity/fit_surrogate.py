"""Fit the surrogate to the sample, cross-validate it and compute the Sobol' indices."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.sensitivity.design import Axis, Quantity, SobolSettings, chosen_factors
from sph.experiments.sensitivity.surrogate import sobol_tables
from sph.experiments.sensitivity.tables import read_sample
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def fit_surrogate(
    path_to_sample: str,
    path_to_factors: str,
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    settings: Mapping[str, Any],
    seed: int,
    path_to_indices: str,
    path_to_validation: str,
) -> None:
    """Indices, a row a metric and factor, and predictions of unseen runs, a row a metric and run."""
    sample, chosen = read_sample(path_to_sample, axes, quantities), chosen_factors(path_to_factors)
    varied = [axis for axis in axes if axis.name in chosen]
    indices, validation = sobol_tables(sample, varied, quantities, SobolSettings(**settings), seed)
    write_csv(indices, path_to_indices)
    write_csv(validation, path_to_validation)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        fit_surrogate(
            snakemake.input.sample,
            snakemake.input.factors,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.settings,
            snakemake.params.seed,
            snakemake.output.indices,
            snakemake.output.validation,
        )
