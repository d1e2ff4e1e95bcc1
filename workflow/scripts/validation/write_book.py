"""Put all reference cases into one table and the verification book."""

import sys

from sph.jobs.log import Job, job_log

if __name__ == "__main__":
    snakemake: Job
    sys.path.append(snakemake.params.tests)
    from cases.suite import write_suite

    with job_log(snakemake.log[0]):
        write_suite(snakemake.input.tables, snakemake.input.pictures, snakemake.input.get("runs", ()), *snakemake.output)
