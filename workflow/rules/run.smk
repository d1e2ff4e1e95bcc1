# Purpose: simulate every run of the catalogue (sph/jobs/catalogue.py): runs, the stages that they share, searches.
# Inputs:  the scene, with the files of its ground line and motion, and the solver's sources, by their contents.
# Outputs: stages/*.nc and runs/**/*.nc in the folder of a study, of a case of its trigger, or of an experiment
import re

from sph.jobs.catalogue import ALONE
from sph.study.runs import SIMULATION


wildcard_constraints:
    folder="|".join(
        [f"results/{re.escape(PLAN.study.study)}/[^/]+(/trigger/[^/]+|/sensitivity)?"]
        + list(map(re.escape, ALONE))
    ),
    run=".+",


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


rule stage:
    """Simulate a stage that runs share, from the one that it goes on from; or search a limit of a slope by many runs."""
    input:
        restart=parent_of(stage_row),
    output:
        "{folder}/stages/{run}.nc",
    log:
        "{folder}/logs/{run}.log",
    benchmark:
        "{folder}/benchmarks/{run}.tsv"
    priority: 10
    resources:
        **asked(stage_row),
    params:
        **simulated(stage_row),
    script:
        "../scripts/simulate.py"


rule simulate:
    """Simulate a run, from the stage that it goes on from."""
    input:
        restart=parent_of(run_row),
    output:
        "{folder}/runs/{run}.nc",
    log:
        "{folder}/logs/{run}.log",
    benchmark:
        "{folder}/benchmarks/{run}.tsv"
    resources:
        **asked(run_row),
    params:
        **simulated(run_row),
    script:
        "../scripts/simulate.py"
