"""Keep the points of a search's last round as its table."""

from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv

if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        write_csv(read_points(snakemake.input[0]), snakemake.output[0])
