"""Decide the paper's claim on the amplitude that triggers failure."""

from sph.experiments.trigger.critical import read_critical
from sph.jobs.log import Job, job_log
from sph.paper.claims import decide_trigger
from sph.study.tables import write_csv

if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        write_csv(decide_trigger(read_critical(snakemake.input.critical)), snakemake.output[0])
