# Purpose: simulate every point of the grid, work that points share done once.
# Inputs:  the scene; the solver's sources.
# Outputs: stages/gravity.nc, stages/amplitude-*.nc, runs/*.nc, in the study's folder or in that of a case of the trigger


rule gravity:
    """Bring gravity on; shared by all runs."""
    input:
        sources=SOLVER,
    output:
        "{folder}/stages/gravity.nc",
    log:
        "{folder}/logs/gravity.log",
    benchmark:
        "{folder}/benchmarks/gravity.tsv"
    resources:
        **asked(stage_scene, lambda wildcards: "gravity"),
    params:
        scene=stage_scene,
        until="gravity",
    script:
        "../scripts/simulate.py"


rule trunk:
    """Shake at one amplitude until the first failure; shared by all S_R and gamma."""
    input:
        sources=SOLVER,
        restart="{folder}/stages/gravity.nc",
    output:
        "{folder}/stages/amplitude-{amplitude}.nc",
    log:
        "{folder}/logs/amplitude-{amplitude}.log",
    benchmark:
        "{folder}/benchmarks/amplitude-{amplitude}.tsv"
    priority: 10
    resources:
        **asked(stage_scene),
    params:
        scene=stage_scene,
        until="first_failure",
    script:
        "../scripts/simulate.py"


rule simulate:
    """Run one point of the grid from its trunk to the end; a trunk in which nothing failed is taken over as it is."""
    input:
        sources=SOLVER,
        restart="{folder}/stages/amplitude-{amplitude}.nc",
    output:
        RUN,
    log:
        f"{{folder}}/logs/{GRID.wildcard_pattern}.log",
    benchmark:
        f"{{folder}}/benchmarks/{GRID.wildcard_pattern}.tsv"
    resources:
        **asked(stage_scene),
    params:
        scene=stage_scene,
        until="end",
    script:
        "../scripts/simulate.py"
