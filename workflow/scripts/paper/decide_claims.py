"""Decide the paper's claims from a study."""

from collections.abc import Mapping
from typing import Any

from sph.jobs.log import Job, job_log
from sph.paper.claims import ClaimSettings, write_claims
from sph.study.tables import read_study


def decide(path_to_study: str, settings: Mapping[str, Any], path_to_claims: str) -> None:
    """Write the table of claims: statement, test, measured number, verdict."""
    write_claims(read_study(path_to_study), path_to_claims, ClaimSettings(**settings))


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        decide(
            snakemake.input.study,
            snakemake.params.settings,
            snakemake.output[0],
        )
