"""Write the points that a round of a search wants."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.design import Lattice
from sph.experiments.trigger.points import no_points, read_points, wanted_points
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def want_points(
    path_to_points: str | None, lattices: Sequence[Mapping[str, Any]], classes: Sequence[str], number: int, path_to_wanted: str
) -> None:
    """Corners of the cells divided ``number`` times that are not among the points of earlier rounds."""
    searched = [Lattice(**data) for data in lattices]
    points = read_points(path_to_points) if path_to_points else no_points()
    write_csv(wanted_points(searched, points, classes, number), path_to_wanted)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        want_points(
            snakemake.input.get("points"),
            snakemake.params.lattices,
            snakemake.params.classes,
            int(snakemake.wildcards.round),
            snakemake.output[0],
        )
