"""Check the scenes of a study and test its slopes without shaking, before any run."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TextIO

from sph.checks.messages import line
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.preflight import Row, study_findings, study_stability, write_preflight


def preflight(path_to_csv: str, log: TextIO, planned: Mapping[str, Planned], size: int, searches: Sequence[str] | None) -> None:
    """One row per finding of the planned scenes, by run; ``size`` runs has the study, of whose slopes the limits ``searches`` are searched,
    or which are not tested at all (None).

    Errors and warnings are said at once.
    """
    scenes = {run: each.build() for run, each in planned.items()}
    if len(scenes) < size:
        print(f"checks {len(scenes)} of {size} runs, spread evenly through the study", file=log)
    rows = study_findings(scenes)
    for row in rows:
        print(f"{row.worst_run}: {line(row.finding)}", file=log)
    tell(rows)
    stability = [] if searches is None else study_stability(scenes, lambda line: print(line, file=log, flush=True), searches)
    tell(stability)
    write_preflight(path_to_csv, rows + stability)


def tell(rows: Iterable[Row]) -> None:
    """Show what is more than a note where the study was started."""
    for row in rows:
        if row.finding.counts:
            print(f"{row.worst_run}: {line(row.finding)}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        preflight(snakemake.output[0], log, **snakemake.params.given)
