"""Bracket the critical intensities, with the pseudo-static estimate and the sliding block's beside them."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.critical import block_estimates, coarser_cases, critical_columns, critical_table
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.points import Key, read_points
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.storage import trajectory
from sph.study.planned import Planned
from sph.study.searches import SlopeSearch, yield_accelerations
from sph.study.tables import flat_dataset, write_csv


def measure_trigger(
    path_to_points: str,
    searches: Mapping[Key, SlopeSearch],
    scenes: Mapping[Key, Planned],
    classes: Sequence[str],
    settings: Mapping[str, Any],
    searched: Searched,
    highest: float,
    attrs: Mapping[str, Any],
    paths_to_tables: Sequence[str],
) -> None:
    """One row a case, value of the other dimensions and class; ``attrs`` go into the netCDF, the first of the tables.

    By case and these values: the ``scenes``, shaken at the ``highest`` intensity, and the ``searches`` for their yield accelerations.
    """
    built = {at: scene.build() for at, scene in scenes.items()}
    estimates = block_estimates(built, yield_accelerations(searches), classes, MetricSettings(**settings), searched, highest)
    first = {at[0]: scene for at, scene in reversed(built.items())}
    table = critical_table(read_points(path_to_points), classes, estimates, searched, coarser_cases(first))
    trajectory.write(paths_to_tables[0], flat_dataset(table, critical_columns(searched), attrs))
    write_csv(table, paths_to_tables[1])


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_trigger(
            snakemake.input.points,
            snakemake.params.searches,
            snakemake.params.scenes,
            snakemake.params.classes,
            snakemake.params.settings,
            snakemake.params.searched,
            snakemake.params.highest,
            snakemake.params.attrs,
            [snakemake.output.nc, snakemake.output.csv],
        )
