# Purpose: simulate every run of the catalogue (sph/jobs/catalogue.py): runs, the stages that they share, searches.
# Inputs:  the scene, with the files of its ground line and motion, and the solver's sources, by their contents.
# Outputs: stages/*.nc and runs/**/*.nc in the folder of a study, of a case of its trigger, or of an experiment
import re

from sph.jobs.catalogue import ALONE


include: "functions/run.smk"


wildcard_constraints:
    folder="|".join(
        [f"results/{re.escape(PLAN.study.study)}/[^/]+(/trigger/[^/]+|/sensitivity)?"]
        + list(map(re.escape, ALONE))
    ),
    run=".+",


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
        **simulated(stage_row, "stage"),
        checked=checked,
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
        **simulated(run_row, "simulate"),
        checked=checked,
    script:
        "../scripts/simulate.py"
