# Purpose: what the jobs that simulate are given.
# Inputs:  the rows of the catalogue.
# Outputs: functions for the directives of ../run.smk and of other rules that simulate
from sph.study.runs import SIMULATION


def asked_of(row):
    """What the job of a row is given."""
    settings = ("until", "by", "extrapolates", "enforce_limit")
    return {"scene": planned(row.scene)} | {
        name: getattr(row, name) for name in settings
    }


def stage_row(wildcards):
    """The row of a stage in the catalogue."""
    return CATALOGUE.row(f"{wildcards.folder}/stages/{wildcards.run}.nc")


def run_row(wildcards):
    """The row of a run, or of a search, in the catalogue."""
    return CATALOGUE.row(f"{wildcards.folder}/runs/{wildcards.run}.nc")


def parent_of(row):
    """The stage that a row, by a function of the wildcards, goes on from."""
    return lambda wildcards: row(wildcards).parent or []


def simulated(row):
    """Parameters of the job of a row, by a function of the wildcards."""
    return {
        **told(lambda wildcards: asked_of(row(wildcards))),
        "sources": lambda wildcards: (
            SOLVER if row(wildcards).by == SIMULATION else SEARCHING
        ),
    }
