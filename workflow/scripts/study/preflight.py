"""Look at the scenes of a study and test its slope unshaken, before any run."""

from collections.abc import Mapping
from typing import TextIO

from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.preflight import study_findings, study_stability, write_preflight


def preflight(planned: Mapping[str, Planned], size: int, path_to_csv: str, log: TextIO) -> None:
    """One row a finding of the planned scenes, by run; ``size`` runs has the study."""
    scenes = {run: each.build() for run, each in planned.items()}
    if len(scenes) < size:
        print(f"looks at {len(scenes)} of {size} runs, evenly through the study", file=log)
    rows = study_findings(scenes)
    for row in rows:
        print(f"{row.first_run}: {row.finding.line()}", file=log)
    rows += study_stability(scenes, lambda line: print(line, file=log, flush=True))
    write_preflight(path_to_csv, rows)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        preflight(snakemake.params.scenes, snakemake.params.size, snakemake.output[0], log)
