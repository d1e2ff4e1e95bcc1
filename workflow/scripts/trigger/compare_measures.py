"""Fit fragility curves in other measures of the shaking than the intensity that is searched."""

from collections.abc import Mapping, Sequence

from sph.experiments.trigger.critical import read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.efficiency import measures_table, motion_measures
from sph.experiments.trigger.points import Key
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.tables import write_csv


def compare_measures(
    path_to_critical: str, scenes: Mapping[Key, Planned], periods: Sequence[float], highest: float, searched: Searched, path_to_table: str
) -> None:
    """One row a case, class and measure, from the scenes shaken at the ``highest`` intensity."""
    motions = {at: motion_measures(scene.build(), periods) for at, scene in scenes.items()}
    write_csv(measures_table(read_critical(path_to_critical), motions, highest, searched), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        compare_measures(
            snakemake.input.critical,
            snakemake.params.scenes,
            snakemake.params.periods,
            snakemake.params.highest,
            snakemake.params.searched,
            snakemake.output[0],
        )
