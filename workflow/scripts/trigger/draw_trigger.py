"""Draw the critical amplitudes, or a map."""

from collections.abc import Sequence

from sph.experiments.trigger.critical import read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.maps import read_shares
from sph.experiments.trigger.points import read_points
from sph.figures import save
from sph.figures.trigger import FIGURES
from sph.jobs.log import Job, job_log

READERS = {"critical": read_critical, "shares": read_shares, "points": read_points}


def draw_trigger(figure: str, tables: dict[str, str], searched: Searched, note: str, paths_to_pictures: Sequence[str]) -> None:
    """Draw one of ``FIGURES``; ``tables`` are paths by the names of the tables."""
    table, draw = FIGURES[figure]
    save(draw(READERS[table](tables[table]), searched, note), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_trigger(
            snakemake.params.figure,
            {name: str(path) for name, path in snakemake.input.items()},
            snakemake.params.searched,
            snakemake.params.note,
            [snakemake.output.png, snakemake.output.pdf],
        )
