"""Make the tables and figures of a step of an experiment."""

from sph.jobs.log import Job, job_log
from sph.jobs.tables.making import make, steps

if __name__ == "__main__":
    snakemake: Job
    params = snakemake.params
    with job_log(snakemake.log[0]):
        step = steps(params.experiment)[params.step]
        make(step, dict(snakemake.input.items()), params.given, params.get("scenes", []), snakemake.output)
