"""Make the tables and figures of a step of an experiment."""

from sph.experiments.registry import EXPERIMENTS
from sph.experiments.steps import make, steps
from sph.jobs.log import Job, job_log

if __name__ == "__main__":
    snakemake: Job
    params = snakemake.params
    with job_log(snakemake.log[0]):
        experiment = EXPERIMENTS[params.step[0]]
        given, scenes = params.given
        make(experiment, steps(experiment)[params.step[1]], dict(snakemake.input.items()), given, scenes, snakemake.output)
