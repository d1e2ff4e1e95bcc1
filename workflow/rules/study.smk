# Purpose: what is found before any run; from runs to numbers.
# Inputs:  the scenes of the study, runs/*.nc; the analysis' sources.
# Outputs: preflight.csv, stages/yield_acceleration*.nc, parts/*.csv, study.nc, study.csv;
#          stages/factor_of_safety*.nc where they are asked for, which the page then shows


rule preflight:
    """Look at the scenes and test the slope unshaken: the first job of a study."""
    output:
        report(
            f"{RESULTS}/preflight.csv",
            caption="../report/preflight.rst",
            category="Tables",
            labels={"shows": "findings before the runs"},
        ),
    log:
        f"{RESULTS}/logs/preflight.log",
    benchmark:
        f"{RESULTS}/benchmarks/preflight.tsv"
    priority: 100
    resources:
        **asked(lambda wildcards: PLAN.slope, lambda wildcards: SAFETY),
    params:
        sources=SEARCHING + ANALYSIS,
        scenes=lambda wildcards: {
            name: planned(PLAN.run_scene(name))
            for name in PLAN.study.shown_runs(MOST_SCENES)
        },
        size=len(PLAN.study.runs),
        searches=lambda wildcards: preflight_searches(bool(PLAN.searches)),
    script:
        "../scripts/study/preflight.py"


rule slope_limit:
    """Search a limit of a slope: its yield acceleration, which the sliding block beside its runs has, or its factor of safety; extrapolated."""
    output:
        "{folder}/stages/{limit}.nc",
    log:
        "{folder}/logs/{limit}.log",
    benchmark:
        "{folder}/benchmarks/{limit}.tsv"
    wildcard_constraints:
        limit=f"({'|'.join(SLOPE_LIMITS)})(_[^/]+)?",
    resources:
        **asked(stage_scene, lambda wildcards: searched_limit(wildcards.limit)),
    params:
        sources=SEARCHING,
        scene=lambda wildcards: planned(stage_scene(wildcards)),
        by=lambda wildcards: searched_limit(wildcards.limit),
        extrapolates=True,
    script:
        "../scripts/simulate/simulate.py"


rule measure:
    """Measure the runs of a part of the study."""
    input:
        yields=lambda wildcards: sorted(
            {search.file for search in PLAN.part_searches(wildcards.part).values()}
        ),
        runs=lambda wildcards: expand(
            RUN, folder=RESULTS, run=PLAN.part(wildcards.part)
        ),
    output:
        f"{RESULTS}/parts/{{part}}.csv",
    log:
        f"{RESULTS}/logs/part-{{part}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/part-{{part}}.tsv"
    wildcard_constraints:
        part="[0-9]+",
    params:
        sources=SEARCHING + ANALYSIS,
        points=lambda wildcards: PLAN.part(wildcards.part),
        scenes=lambda wildcards: [
            planned(PLAN.run_scene(run)) for run in PLAN.part(wildcards.part)
        ],
        searches=lambda wildcards: PLAN.part_searches(wildcards.part),
        layout=lambda wildcards: PLAN.layout._replace(labels=()),
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/study/measure_study.py"


rule study:
    """Put the metrics of all runs into one table, as netCDF and CSV."""
    input:
        run=lambda wildcards: RUN.format(
            folder=RESULTS, run=next(iter(PLAN.study.runs))
        ),
        parts=lambda wildcards: expand(
            "{results}/parts/{part}.csv", results=RESULTS, part=PLAN.parts
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
        sources=ANALYSIS,
        scene=lambda wildcards: planned(PLAN.run_scene(next(iter(PLAN.study.runs)))),
        layout=lambda wildcards: PLAN.layout,
        name=PLAN.study.study,
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/study/join_study.py"
