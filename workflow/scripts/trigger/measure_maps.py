"""Write the cells of the maps, and the shares of the values searched that reach each class."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.design import Lattice, Searched
from sph.experiments.trigger.maps import class_shares, map_cells
from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def measure_maps(
    path_to_points: str,
    lattices: Sequence[Mapping[str, Any]],
    classes: Sequence[str],
    levels: int,
    searched: Searched,
    path_to_cells: str,
    path_to_shares: str,
) -> None:
    """One row a cell that is not divided; one a class and interval of intensities."""
    cells = map_cells([Lattice(**data) for data in lattices], read_points(path_to_points), classes, levels, searched)
    write_csv(cells, path_to_cells)
    write_csv(class_shares(cells, searched), path_to_shares)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_maps(
            snakemake.input.points,
            snakemake.params.lattices,
            snakemake.params.classes,
            snakemake.params.levels,
            snakemake.params.searched,
            snakemake.output.cells,
            snakemake.output.shares,
        )
