# Purpose: simulate every run of the catalogue (sph/jobs/catalogue.py): runs, the stages that they share, searches.
# Inputs:  the scene, with the files of its ground line and motion, and the solver's sources, by their contents.
# Outputs: stages/*.nc and runs/**/*.nc in the folder of a study, of a case of its trigger, or of an experiment
import re

from sph.jobs.catalogue import ALONE
from sph.stability.record import SLOPE_LIMITS


include: "functions/run.smk"


# The runs of the draft have rules of their own, below; not on cards, which take runs together by rule.
DRAFT = PLAN.draft if PLAN.study.backend == "cpu" else None
OTHERS = f"(?!{re.escape(DRAFT.folder)}/(stages|runs)/)" if DRAFT else ""
FOLDERS = [
    f"results/{re.escape(PLAN.study.study)}/[^/]+(/trigger/[^/]+|/sensitivity)?",
    *map(re.escape, ALONE),
]


wildcard_constraints:
    folder=f"{OTHERS}({'|'.join(FOLDERS)})",
    run=".+",


rule stage:
    """Simulate a stage that runs share, from the one that it goes on from."""
    input:
        restart=parent_of(stage_row),
    output:
        "{folder}/stages/{run}.nc",
    log:
        "{folder}/logs/{run}.log",
    benchmark:
        "{folder}/benchmarks/{run}.tsv"
    wildcard_constraints:
        run="(gravity|pre_failure).*",
    priority: 20
    resources:
        **asked(stage_row),
    params:
        **simulated(stage_row, "stage"),
    script:
        "../scripts/simulate.py"


use rule stage as search with:  # of a limit of a slope by many runs: after the runs, before figures, since tables wait for it
    wildcard_constraints:
        run=f"({'|'.join(SLOPE_LIMITS)}).*",
    priority: 5
    params:
        **simulated(stage_row, "search"),


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
    priority: 10
    resources:
        **asked(run_row),
    params:
        **simulated(run_row, "simulate"),
    script:
        "../scripts/simulate.py"


if DRAFT:
    # Coarser particles give a first answer early.

    use rule stage as draft_stage with:
        wildcard_constraints:
            folder=re.escape(DRAFT.folder),
            run="(gravity|pre_failure).*",
        priority: 40

    use rule simulate as draft with:
        wildcard_constraints:
            folder=re.escape(DRAFT.folder),
        priority: 30
        params:
            **simulated(run_row, "draft"),
