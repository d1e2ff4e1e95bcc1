"""Search the limits of a study's slopes, beside its runs."""

from collections.abc import Mapping, Sequence
from typing import TextIO

from sph.jobs.log import Job, job_log
from sph.study.planned import Planned, digest
from sph.study.preflight import read_preflight, study_limits, tell, write_preflight


def preflight(path_to_checked: str, path_to_csv: str, log: TextIO, planned: Mapping[str, Planned], searches: Sequence[str] | None) -> None:
    """What was found before the runs, and the limits of the slopes of the planned scenes, by run; None searches none of them."""
    rows = read_preflight(path_to_checked)
    scenes = {run: each.build() for run, each in planned.items()}
    limits = study_limits(scenes, rows, lambda line: print(line, file=log, flush=True), searches or ())
    tell(limits)
    write_preflight(path_to_csv, rows + limits)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0], of=digest(snakemake.params.given["planned"])) as log:
        preflight(snakemake.input.checked, snakemake.output[0], log, **snakemake.params.given)
