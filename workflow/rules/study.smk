# Purpose: from runs to numbers.
# Inputs:  runs/*.nc; the analysis' sources.
# Outputs: stages/yield_acceleration.nc, study.nc, study.csv, claims.csv


rule yield_acceleration:
    """Search the constant acceleration at which the slope fails: the strength of the sliding block beside every run."""
    input:
        sources=SEARCHING,
    output:
        "{folder}/stages/yield_acceleration.nc",
    log:
        "{folder}/logs/yield_acceleration.log",
    benchmark:
        "{folder}/benchmarks/yield_acceleration.tsv"
    resources:
        **asked(stage_scene, lambda wildcards: "yield_acceleration"),
    params:
        scene=stage_scene,
        by="yield_acceleration",
    script:
        "../scripts/simulate.py"


rule study:
    """Measure every run and put the metrics into one table, as netCDF and CSV."""
    input:
        sources=SEARCHING + ANALYSIS,
        yields=f"{RESULTS}/stages/yield_acceleration.nc",
        runs=expand(
            "{results}/runs/{point}.nc", results=RESULTS, point=GRID.instance_patterns
        ),
    output:
        nc=f"{RESULTS}/study.nc",
        csv=report(
            f"{RESULTS}/study.csv",
            caption="../report/study.rst",
            category="Tables",
            labels={"shows": "every run"},
        ),
    log:
        f"{RESULTS}/logs/study.log",
    benchmark:
        f"{RESULTS}/benchmarks/study.tsv"
    params:
        points=PLAN.study.points.to_dict("records"),
        settings=PLAN.study.metrics.model_dump(),
        name=PLAN.study.study,
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/measure_study.py"


rule claims:
    """Decide the paper's twelve claims by numbers."""
    input:
        sources=ANALYSIS,
        study=f"{RESULTS}/study.nc",
    output:
        report(
            f"{RESULTS}/claims.csv",
            caption="../report/claims.rst",
            category="Tables",
            labels={"shows": "the claims"},
        ),
    log:
        f"{RESULTS}/logs/claims.log",
    params:
        settings=PLAN.study.claims.model_dump(),
    script:
        "../scripts/decide_claims.py"
