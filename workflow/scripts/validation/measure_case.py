"""Compare a reference case with its known answer at every resolution, and draw it."""

import sys

from sph.figures import save
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv

if __name__ == "__main__":
    snakemake: Job
    sys.path.append(snakemake.params.tests)
    from cases.suite import measure_case

    with job_log(snakemake.log[0]):
        table, figure = measure_case(snakemake.wildcards.case, snakemake.input.runs)
        write_csv(table, snakemake.output[0])
        save(figure, *snakemake.output[1:])
