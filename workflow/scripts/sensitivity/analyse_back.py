"""Find the values of the factors that agree with what was observed."""

from collections.abc import Sequence

from sph.experiments.sensitivity.back_analysis import BACK_ANALYSIS, back_tables, posterior_columns, problem_of
from sph.experiments.sensitivity.design import Axis, Observation, Quantity, chosen_factors
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL
from sph.experiments.sensitivity.tables import read_sample
from sph.jobs.log import Job, job_log
from sph.storage import trajectory
from sph.study.tables import flat_dataset, read_csv, write_csv


def analyse_back(
    path_to_factors: str,
    path_to_sample: str,
    path_to_indices: str,
    path_to_validation: str,
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    sought: Sequence[str],
    observations: Sequence[Observation],
    path_to_csv: str,
    path_to_nc: str,
    path_to_points: str,
    path_to_posterior: str,
) -> None:
    """One row a factor, as CSV and netCDF; the points to be confirmed by runs; the points of the posterior."""
    chosen = chosen_factors(path_to_factors)
    varied = [axis for axis in axes if axis.name in chosen]
    problem = problem_of(axes, sought or chosen, observations)
    table, points, posterior = back_tables(
        problem,
        varied,
        read_sample(path_to_sample, axes, quantities),
        read_csv(path_to_indices, SOBOL, "Sobol' indices"),
        read_csv(path_to_validation, CROSS_VALIDATION, "a cross-validation"),
    )
    write_csv(table, path_to_csv)
    trajectory.write(path_to_nc, flat_dataset(table, BACK_ANALYSIS))
    write_csv(points, path_to_points)
    trajectory.write(path_to_posterior, flat_dataset(posterior, posterior_columns(problem)))


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        analyse_back(
            snakemake.input.factors,
            snakemake.input.sample,
            snakemake.input.indices,
            snakemake.input.validation,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.sought,
            snakemake.params.observations,
            snakemake.output.csv,
            snakemake.output.nc,
            snakemake.output.points,
            snakemake.output.posterior,
        )
