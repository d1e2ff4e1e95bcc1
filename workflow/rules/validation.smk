# Purpose: the reference cases (tests/cases): problems with a known answer, each result beside the value that it has to meet.
# Inputs:  tests/cases: the scenes of every case at every resolution; the solver's sources, by their contents.
# Outputs: results/validation: runs/<case>/<run>/<level>.nc, cases/<case>.csv, figures/<case>, validation.csv, book.md, book.pdf


include: "functions/validation.smk"


wildcard_constraints:
    case="V[0-9]+",
    variant="[^/]+",
    level="[^/]+",


rule validation_run:
    """Simulate a run of a reference case, or search the limit of its slope."""
    output:
        "results/validation/runs/{case}/{variant}/{level}.nc",
    log:
        "results/validation/logs/{case}/{variant}/{level}.log",
    benchmark:
        "results/validation/benchmarks/{case}/{variant}/{level}.tsv"
    resources:
        **asked(case_run),
    params:
        **simulated(case_run, "validation_run"),
    script:
        "../scripts/simulate.py"


rule validation_case:
    """Compare a reference case with its known answer at every resolution, and draw it."""
    input:
        runs=lambda wildcards: list(runs_of_case(wildcards.case)),
    output:
        shown("results/validation/cases/{case}.csv", "Validation", ""),
        shown("results/validation/figures/{case}.png", "Validation", "case {case}"),
        "results/validation/figures/{case}.pdf",
    log:
        "results/validation/logs/{case}.log",
    params:
        tests=str(SPH.parent / "tests"),
        sources=DRAWING + SEARCHING + (sources("../tests/cases/*.py") if CASES else ""),
        about="A reference case: what is computed at every resolution beside the value that it has to meet.",
    script:
        "../scripts/validation/measure_case.py"


rule validation:
    """Put all reference cases into one table and the verification book."""
    input:
        unpack(whole_suite),
    output:
        shown("results/validation/validation.csv", "Validation", "all cases"),
        "results/validation/book.md",
        "results/validation/book.pdf",
    log:
        "results/validation/logs/validation.log",
    params:
        tests=str(SPH.parent / "tests"),
        sources=DRAWING + (contents("../tests/cases/*.py") if CASES else ""),
        about="Reference cases: every quantity beside the value that it has to meet, with its error, tolerance, order of convergence and verdict.",
    script:
        "../scripts/validation/write_book.py"
