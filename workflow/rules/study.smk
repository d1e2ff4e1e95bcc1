# Purpose: what is found of the slopes beside the runs; from runs to numbers.
# Inputs:  the scenes of the study, runs/*.nc; the analysis' sources.
# Outputs: checked.csv, preflight.csv, parts/*.csv, study.nc, study.csv
from sph.stability.record import SAFETY
from sph.study.preflight import preflight_searches
from sph.study.searches import slope_searches


rule check:
    """Test whether the slopes stand unshaken, and by limit equilibrium: begun first, beside the runs, since an error stops the study."""
    output:
        f"{RESULTS}/checked.csv",
    log:
        f"{RESULTS}/logs/check.log",
    benchmark:
        f"{RESULTS}/benchmarks/check.tsv"
    priority: 100
    retries: 0
    resources:
        **asked(lambda wildcards: PLAN.slope._replace(by=SAFETY)),
    params:
        **told(
            lambda wildcards: {
                "planned": planned_slopes(),
                "size": len(PLAN.study.runs),
                "tested": preflight_searches(PLAN) is not None,
            }
        ),
        # made with the input: nothing that asks for the tests again
        stops=lambda wildcards, input: PLAN.study.on_error == "stop",
        sources=SEARCHING + ANALYSIS,
    script:
        "../scripts/study/check.py"


rule preflight:
    """Search the limits of the slopes, and put them beside what was found in the scenes."""
    input:
        checked=f"{RESULTS}/checked.csv",
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
    resources:
        **asked(lambda wildcards: PLAN.slope._replace(by=SAFETY)),
    params:
        **told(
            lambda wildcards: {
                "planned": planned_slopes(),
                "searches": preflight_searches(PLAN),
            }
        ),
        sources=SEARCHING + ANALYSIS,
    script:
        "../scripts/study/preflight.py"


rule measure:
    """Measure the runs of a part of the study."""
    input:
        yields=lambda wildcards: sorted(
            {search.file for search in searched_in(wildcards.part).values()}
        ),
        runs=lambda wildcards: [run.file for run in PLAN.part(wildcards.part)],
    output:
        f"{RESULTS}/parts/{{part}}.csv",
    log:
        f"{RESULTS}/logs/part-{{part}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/part-{{part}}.tsv"
    wildcard_constraints:
        part="[0-9]+",
    params:
        **told(
            lambda wildcards: {
                "points": {run.id: run.point for run in PLAN.part(wildcards.part)},
                "scenes": [planned(run.scene) for run in PLAN.part(wildcards.part)],
                "searches": slope_searches(searched_in(wildcards.part)),
                "layout": PLAN.layout._replace(labels=()),
                "settings": PLAN.study.metrics.model_dump(),
            }
        ),
        sources=SEARCHING + ANALYSIS,
    script:
        "../scripts/study/measure_study.py"


rule study:
    """Put the metrics of all runs into one table, as netCDF and CSV."""
    input:
        run=lambda wildcards: PLAN.part("0001")[0].file,
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
        **told(
            lambda wildcards: {
                "planned": planned(PLAN.part("0001")[0].scene),
                "layout": PLAN.layout,
                "attrs": {
                    "title": PLAN.study.study,
                    "fidelity": PLAN.study.fidelity,
                },
            }
        ),
        sources=ANALYSIS,
    script:
        "../scripts/study/join_study.py"
