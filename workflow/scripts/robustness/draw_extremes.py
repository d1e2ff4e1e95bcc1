"""Draw the runs at the ends of their keys' ranges."""

from collections.abc import Sequence

from sph.experiments.robustness import read_extremes
from sph.figures import save
from sph.figures.extremes import figure_extremes
from sph.jobs.log import Job, job_log


def draw_extremes(path_to_table: str, paths_to_pictures: Sequence[str]) -> None:
    """One panel a check."""
    save(figure_extremes(read_extremes(path_to_table)), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_extremes(snakemake.input.table, [snakemake.output.png, snakemake.output.pdf])
