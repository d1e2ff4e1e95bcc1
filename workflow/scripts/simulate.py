"""Simulate one stage or run of a study, or search the limit of a scene by many runs."""

from typing import TextIO

from sph.checks.finding import codes
from sph.checks.messages import line
from sph.checks.scene import findings
from sph.jobs.log import Job, job_log
from sph.jobs.progress import reporter
from sph.solver.checkpoint import run_to_file
from sph.solver.run import Until
from sph.stability.record import search_to_file
from sph.study.planned import Planned
from sph.study.runs import SIMULATION


def simulate(
    planned: Planned,
    until: Until,
    path_to_restart: str | None,
    path_to_trajectory: str,
    log: TextIO,
    enforce_limit: bool,
    threads: int,
) -> None:
    """Run a scene, from its checkpoint or a restart if there is one, and write its trajectory; a run that diverges is a result."""

    def say(text: str) -> None:
        print(text, file=log)

    built = planned.build()
    found = findings(built)
    with reporter(path_to_trajectory, built, log) as report:
        for each in found:
            if each.counts:
                say(line(each))
        result = run_to_file(
            built,
            path_to_trajectory,
            until,
            path_to_restart,
            report,
            threads,
            say=say,
            enforce_limit=enforce_limit,
            attrs={"findings": codes(found)},
        )
    print(f"{path_to_trajectory}: {result.status} {result.stored.attrs['status_reason']}", file=log)


def find_limit(planned: Planned, by: str, path_to_trials: str, log: TextIO, extrapolates: bool) -> None:
    """Search a limit of a scene at its spacing or, if it ``extrapolates``, at two, from the trials of a search that was killed."""
    search_to_file(planned.build(), by, path_to_trials, lambda trial: print(*trial, file=log, flush=True), extrapolates)


if __name__ == "__main__":
    snakemake: Job
    given, out = snakemake.params.given, snakemake.output[0]
    with job_log(snakemake.log[0]) as log:
        if given["by"] == SIMULATION:
            earlier = snakemake.input.get("restart") or None
            simulate(given["scene"], given["until"], earlier, out, log, given["enforce_limit"], snakemake.threads)
        else:
            find_limit(given["scene"], given["by"], out, log, given["extrapolates"])
