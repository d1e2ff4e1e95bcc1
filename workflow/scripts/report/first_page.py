"""Write the page of a study's runs before the searches for limits of its slopes."""

import sys
from pathlib import Path

from sph.command.page import SoFar
from sph.jobs.log import Job, job_log

if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        page = SoFar(snakemake.params.plan, Path())
        page.renew(growing=False)
        print(f"{page.said}; to be read until report.html takes its place", file=sys.stderr)
