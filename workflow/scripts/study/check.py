"""Test the slopes of a study without shaking, and by limit equilibrium, beside its runs."""

from collections.abc import Mapping
from typing import TextIO

from sph.checks.messages import line
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned, digest
from sph.study.preflight import stop_for_errors, study_equilibrium, study_findings, study_stability, tell, write_preflight


def check(path_to_csv: str, log: TextIO, planned: Mapping[str, Planned], size: int, tested: bool, stops: bool) -> None:
    """One row per finding of the planned scenes, by run; ``size`` runs has the study, whose slopes are ``tested`` or not.

    ValueError for an error if it ``stops`` the study: the workflow then starts no further job.
    """
    scenes = {run: each.build() for run, each in planned.items()}
    if len(scenes) < size:
        print(f"checks {len(scenes)} of {size} runs, spread evenly through the study", file=log)
    rows = study_findings(scenes)
    for row in rows:
        print(f"{row.worst_run}: {line(row.finding)}", file=log)
    stability = study_stability(scenes, lambda line: print(line, file=log, flush=True)) if tested else []
    tell(stability)
    if stops:
        stop_for_errors(rows + stability)
    limits = study_equilibrium(scenes, stability, lambda line: print(line, file=log, flush=True))
    tell(limits)
    write_preflight(path_to_csv, rows + stability + limits)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0], of=digest(snakemake.params.given["planned"])) as log:
        check(snakemake.output[0], log, **snakemake.params.given, stops=snakemake.params.stops)
