"""Write the ends of brackets that are run again at another fidelity."""

from collections.abc import Mapping
from typing import Any

from sph.experiments.trigger.critical import bracket_ends, read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def want_confirmation(
    path_to_critical: str, path_to_points: str, confirm: Mapping[str, Any], searched: Searched, path_to_ends: str
) -> None:
    """The ends that exist of the brackets of a class, for chosen cases and values."""
    chosen = (confirm["collapse_class"], confirm["cases"], confirm["at"], searched)
    write_csv(bracket_ends(read_critical(path_to_critical), read_points(path_to_points), *chosen), path_to_ends)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        want_confirmation(
            snakemake.input.critical,
            snakemake.input.points,
            snakemake.params.confirm,
            snakemake.params.searched,
            snakemake.output[0],
        )
