"""Simulate one stage or run of a study, or search the limit of a scene by many runs; short runs share the job."""

from sph.jobs.ahead import take_up
from sph.jobs.log import Job

if __name__ == "__main__":
    snakemake: Job
    own, *others = snakemake.params.given
    if not take_up(own):
        # Most jobs of a study of short runs end before this import, which takes longer than such a run.
        from sph.jobs.simulation import work

        work(own, others, snakemake.threads)
