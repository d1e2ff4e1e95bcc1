"""Put the tables of all reference cases together."""

from collections.abc import Sequence

import pandas as pd

from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv
from sph.validation.table import read_validation


def join_cases(paths_to_cases: Sequence[str], path_to_table: str) -> None:
    """The rows of every case, in the order of the paths."""
    write_csv(pd.concat([read_validation(path) for path in paths_to_cases], ignore_index=True), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        join_cases(snakemake.input, snakemake.output[0])
