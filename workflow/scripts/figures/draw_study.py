"""Draw the figures of all runs of a study."""

from collections.abc import Sequence

from sph.figures import STUDY_FIGURES, save
from sph.jobs.log import Job, job_log
from sph.study.dimensions import Dimension
from sph.study.tables import Layout, read_table


def draw_study(
    path_to_table: str,
    paths_to_png: Sequence[str],
    paths_to_pdf: Sequence[str],
    names: Sequence[str],
    layout: Layout,
    dimensions: Sequence[Dimension],
    probe: str,
    note: str,
) -> None:
    """Draw figures of ``STUDY_FIGURES``, by name, from the study's table."""
    table = read_table(path_to_table, layout)
    for name, *pictures in zip(names, paths_to_png, paths_to_pdf, strict=True):
        save(STUDY_FIGURES[name](table, dimensions, probe, note), *pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_study(snakemake.input.table, snakemake.output.png, snakemake.output.pdf, **snakemake.params.given)
