"""Draw a figure of all runs of a study."""

from collections.abc import Sequence

from sph.figures import STUDY_FIGURES, save
from sph.jobs.log import Job, job_log
from sph.study.dimensions import Dimension
from sph.study.tables import Layout, read_table


def draw_study(
    path_to_table: str,
    paths_to_pictures: Sequence[str],
    name: str,
    layout: Layout,
    dimensions: Sequence[Dimension],
    probe: str,
    note: str,
) -> None:
    """Draw a figure of ``STUDY_FIGURES`` from the study's table."""
    save(STUDY_FIGURES[name](read_table(path_to_table, layout), dimensions, probe, note), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_study(snakemake.input.table, snakemake.output, **snakemake.params.given)
