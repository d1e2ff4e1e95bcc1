"""Draw a figure of the ladder."""

from collections.abc import Sequence

from sph.experiments.cost_accuracy.convergence import CONVERGENCE
from sph.experiments.cost_accuracy.table import read_trade
from sph.figures import save
from sph.figures.trade import figure_convergence, figure_tradeoff
from sph.jobs.log import Job, job_log
from sph.study.tables import read_csv


def draw_trade(figure: str, path_to_table: str, path_to_convergence: str, paths_to_pictures: Sequence[str]) -> None:
    """Draw 'tradeoff', error against cost, or 'convergence', results against spacing."""
    table = read_trade(path_to_table)
    if figure == "tradeoff":
        drawn = figure_tradeoff(table)
    else:
        drawn = figure_convergence(read_csv(path_to_convergence, CONVERGENCE, "orders of convergence"), table)
    save(drawn, *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_trade(
            snakemake.wildcards.figure,
            snakemake.input.table,
            snakemake.input.convergence,
            [snakemake.output.png, snakemake.output.pdf],
        )
