"""Draw a figure of the sensitivity analysis."""

from collections.abc import Sequence

from sph.experiments.sensitivity.design import Axis, chosen_factors
from sph.experiments.sensitivity.elementary_effects import MORRIS
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL
from sph.experiments.sensitivity.tables import TORNADO
from sph.figures import save
from sph.figures.sensitivity import figure_cross_validation, figure_morris, figure_sobol, figure_tornado
from sph.jobs.log import Job, job_log
from sph.study.tables import read_csv


def draw_sensitivity(
    figure: str,
    path_to_table: str,
    path_to_indices: str,
    path_to_factors: str,
    axes: Sequence[Axis],
    note: str,
    paths_to_pictures: Sequence[str],
) -> None:
    """Draw 'morris', 'tornado', 'sobol' or 'cross_validation' from the table of that name; the last needs the indices, too."""
    if figure == "morris":
        drawn = figure_morris(read_csv(path_to_table, MORRIS, "a screening"), axes, chosen_factors(path_to_factors), note)
    elif figure == "tornado":
        drawn = figure_tornado(read_csv(path_to_table, TORNADO, "a tornado"), axes, note)
    elif figure == "sobol":
        drawn = figure_sobol(read_csv(path_to_table, SOBOL, "Sobol' indices"), axes, note)
    else:
        table = read_csv(path_to_table, CROSS_VALIDATION, "a cross-validation")
        drawn = figure_cross_validation(table, read_csv(path_to_indices, SOBOL, "Sobol' indices"), note)
    save(drawn, *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_sensitivity(
            snakemake.wildcards.figure,
            snakemake.input.table,
            snakemake.input.indices,
            snakemake.input.factors,
            snakemake.params.axes,
            f"fidelity {snakemake.params.fidelity} · {snakemake.params.described}",
            [snakemake.output.png, snakemake.output.pdf],
        )
