"""Compare what a back-analysis predicts with runs, and draw both."""

from collections.abc import Sequence

import xarray as xr

from sph.experiments.sensitivity.back_analysis import BACK_ANALYSIS, confirmed_table, point_columns, problem_of
from sph.experiments.sensitivity.design import Axis, Observation, Quantity, chosen_factors
from sph.experiments.sensitivity.tables import read_sample
from sph.figures import save
from sph.figures.back_analysis import figure_back_analysis
from sph.jobs.log import Job, job_log
from sph.study.tables import read_csv, write_csv


def confirm_back(
    path_to_factors: str,
    path_to_sample: str,
    path_to_result: str,
    path_to_points: str,
    path_to_posterior: str,
    path_to_runs: str,
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    sought: Sequence[str],
    observations: Sequence[Observation],
    note: str,
    path_to_csv: str,
    paths_to_pictures: Sequence[str],
) -> None:
    """A row a run and metric, and the figure of the back-analysis."""
    problem = problem_of(axes, sought or chosen_factors(path_to_factors), observations)
    points = read_csv(path_to_points, point_columns(axes), "the points of a back-analysis")
    confirmed = confirmed_table(points, read_sample(path_to_runs, axes, quantities), problem)
    write_csv(confirmed, path_to_csv)
    with xr.open_dataset(path_to_posterior) as posterior:
        drawn = figure_back_analysis(
            read_csv(path_to_result, BACK_ANALYSIS, "a back-analysis"),
            posterior.to_dataframe(),
            confirmed,
            read_sample(path_to_sample, axes, quantities),
            problem,
            note,
        )
    save(drawn, *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        confirm_back(
            snakemake.input.factors,
            snakemake.input.sample,
            snakemake.input.result,
            snakemake.input.points,
            snakemake.input.posterior,
            snakemake.input.runs,
            snakemake.params.axes,
            snakemake.params.quantities,
            snakemake.params.sought,
            snakemake.params.observations,
            f"fidelity {snakemake.params.fidelity} · {snakemake.params.described}",
            snakemake.output.csv,
            [snakemake.output.png, snakemake.output.pdf],
        )
