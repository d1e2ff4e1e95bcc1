# Purpose: simulate every point of the grid, work that points share done once.
# Inputs:  the scene; the solver's sources.
# Outputs: stages/gravity.nc, stages/amplitude-*.nc, runs/*.nc


rule gravity:
    """Bring gravity on; shared by all runs."""
    input:
        sources=SOLVER,
    output:
        f"{RESULTS}/stages/gravity.nc",
    log:
        f"{RESULTS}/logs/gravity.log",
    benchmark:
        f"{RESULTS}/benchmarks/gravity.tsv"
    params:
        scene=PLAN.scene(),
        until="gravity",
    script:
        "../scripts/simulate.py"


rule trunk:
    """Shake at one amplitude until the first failure; shared by all S_R and gamma."""
    input:
        sources=SOLVER,
        restart=f"{RESULTS}/stages/gravity.nc",
    output:
        f"{RESULTS}/stages/amplitude-{{amplitude}}.nc",
    log:
        f"{RESULTS}/logs/amplitude-{{amplitude}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/amplitude-{{amplitude}}.tsv"
    priority: 10
    params:
        scene=lambda wildcards: PLAN.scene(amplitude=wildcards.amplitude),
        until="first_failure",
    script:
        "../scripts/simulate.py"


rule simulate:
    """Run one point of the grid from its trunk to the end; a trunk in which nothing failed is taken over as it is."""
    input:
        sources=SOLVER,
        restart=f"{RESULTS}/stages/amplitude-{{amplitude}}.nc",
    output:
        RUN,
    log:
        f"{RESULTS}/logs/{GRID.wildcard_pattern}.log",
    benchmark:
        f"{RESULTS}/benchmarks/{GRID.wildcard_pattern}.tsv"
    params:
        scene=lambda wildcards: PLAN.scene(**wildcards),
        until="end",
    script:
        "../scripts/simulate.py"
