"""Draw a figure of an experiment."""

from collections.abc import Sequence
from pathlib import Path

from sph.experiments.registry import EXPERIMENTS
from sph.figures import experiment_figures, save
from sph.jobs.log import Job, job_log
from sph.study.tables import read_csv


def draw(experiment: str, figure: str, paths_to_tables: Sequence[str], paths_to_pictures: Sequence[str]) -> None:
    """A figure by its name, from the experiment's tables."""
    known = EXPERIMENTS[experiment].tables
    tables = {Path(path).name: read_csv(path, known[Path(path).name].columns, f"experiment {experiment}") for path in paths_to_tables}
    save(experiment_figures(experiment)[figure](tables), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw(
            snakemake.params.experiment,
            snakemake.params.figure,
            snakemake.input,
            snakemake.output,
        )
