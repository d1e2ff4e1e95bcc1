# Purpose: simulate every run; those of a study and of the trigger share work that is done once, of other experiments each stands on its own.
# Inputs:  the scene, with the files of its ground line and motion, and the solver's sources, by their contents.
# Outputs: stages/gravity*.nc, stages/pre_failure*.nc, runs/*.nc, in the study's folder or in that of a case of the trigger;
#          runs/**/*.nc in the folder of an experiment


rule gravity:
    """Bring gravity on; shared by all runs that agree in what acts before the shaking."""
    output:
        "{folder}/stages/{gravity}.nc",
    log:
        "{folder}/logs/{gravity}.log",
    benchmark:
        "{folder}/benchmarks/{gravity}.tsv"
    resources:
        **asked(stage_scene, lambda wildcards: "gravity"),
    params:
        sources=SOLVER,
        scene=lambda wildcards: planned(stage_scene(wildcards)),
        until="gravity",
    script:
        "../scripts/simulate/simulate.py"


rule pre_failure:
    """Shake until the first failure; shared by all runs that differ in what acts after it: S_R and gamma."""
    input:
        restart=lambda wildcards: "{folder}/stages/{gravity}.nc".format(
            folder=wildcards.folder,
            gravity=PLANS(wildcards.folder).gravity_of(wildcards.pre_failure),
        ),
    output:
        "{folder}/stages/{pre_failure}.nc",
    log:
        "{folder}/logs/{pre_failure}.log",
    benchmark:
        "{folder}/benchmarks/{pre_failure}.tsv"
    priority: 10
    resources:
        **asked(stage_scene),
    params:
        sources=SOLVER,
        scene=lambda wildcards: planned(stage_scene(wildcards)),
        until="first_failure",
    script:
        "../scripts/simulate/simulate.py"


rule simulate:
    """Simulate a run from its pre-failure run to the end; one in which nothing failed is taken over as it is."""
    input:
        restart=lambda wildcards: "{folder}/stages/{pre_failure}.nc".format(
            folder=wildcards.folder,
            pre_failure=PLANS(wildcards.folder).stages(wildcards.run).pre_failure,
        ),
    output:
        RUN,
    log:
        "{folder}/logs/{run}.log",
    benchmark:
        "{folder}/benchmarks/{run}.tsv"
    wildcard_constraints:
        run="[^/]+",
    resources:
        **asked(stage_scene),
    params:
        sources=SOLVER,
        scene=lambda wildcards: planned(stage_scene(wildcards)),
        until="end",
    script:
        "../scripts/simulate/simulate.py"


rule experiment_run:
    """Run a scene of an experiment from the start to the end, or search its limit by many runs, on one core."""
    input:
        factors=lambda wildcards: (
            known_by(wildcards.run.partition("/")[0])
            if wildcards.experiment == SENSITIVITY
            else []
        ),
    output:
        "{experiment}/runs/{run}.nc",
    log:
        "{experiment}/logs/{run}.log",
    benchmark:
        "{experiment}/benchmarks/{run}.tsv"
    wildcard_constraints:
        experiment="|".join(map(re.escape, RUN_OF)),
        run=".+",
    threads: 1
    resources:
        **asked(
            lambda wildcards: asking_run(wildcards).scene,
            lambda wildcards: asking_run(wildcards).by,
        ),
    params:
        sources=lambda wildcards: (
            SOLVER if asking_run(wildcards).by == "simulation" else SEARCHING
        ),
        scene=lambda wildcards: planned(experiment_run(wildcards).scene),
        until="end",
        by=lambda wildcards: asking_run(wildcards).by,
        enforce_limit=lambda wildcards: asking_run(wildcards).enforce_limit,
    script:
        "../scripts/simulate/simulate.py"
