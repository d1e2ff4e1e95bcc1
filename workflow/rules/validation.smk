# Purpose: the reference cases: does the solver give the numbers that are known? (`snakemake --cores 2 validation`)
# Inputs:  config/validation.yaml (config: experiments); the sources of solver, analysis and drawing.
# Outputs: results/validation: runs/<case>/<run>/<level>.nc, cases/*.csv, figures/*, validation.csv, book.md, book.pdf
from sph.validation.suite import FOLDER as VALIDATION

VALIDATING = DRAWING + sources("validation/*.py")


wildcard_constraints:
    case="V[0-9]+",


rule validation:
    """The reference cases: table, figures and the verification book."""
    input:
        f"{VALIDATION}/validation.csv",
        f"{VALIDATION}/book.md",
        f"{VALIDATION}/book.pdf",
        lambda wildcards: expand(
            "{validation}/figures/{case}.{kind}",
            validation=VALIDATION,
            case=CATALOGUE.suite.cases,
            kind=["png", "pdf"],
        ),


rule validation_case:
    """Measure a case on all its levels, and draw it."""
    input:
        runs=lambda wildcards: [
            run.file for run in CATALOGUE.suite.files(wildcards.case)
        ],
    output:
        csv=f"{VALIDATION}/cases/{{case}}.csv",
        png=report(
            f"{VALIDATION}/figures/{{case}}.png",
            caption="../report/validation_figure.rst",
            category="Validation",
            labels={"shows": "case {case}"},
        ),
        pdf=f"{VALIDATION}/figures/{{case}}.pdf",
    log:
        f"{VALIDATION}/logs/{{case}}.log",
    params:
        sources=SEARCHING + VALIDATING,
        suite=lambda wildcards: CATALOGUE.suite.plan(wildcards.case),
    script:
        "../scripts/validation/measure_case.py"


rule validation_table:
    """All cases in one table."""
    input:
        lambda wildcards: expand(
            "{validation}/cases/{case}.csv",
            validation=VALIDATION,
            case=CATALOGUE.suite.cases,
        ),
    output:
        report(
            f"{VALIDATION}/validation.csv",
            caption="../report/validation.rst",
            category="Validation",
            labels={"shows": "all cases"},
        ),
    log:
        f"{VALIDATION}/logs/validation.log",
    script:
        "../scripts/validation/join_cases.py"


rule validation_book:
    """The verification book: a page a case."""
    input:
        table=f"{VALIDATION}/validation.csv",
        runs=lambda wildcards: [
            run.file
            for case in CATALOGUE.suite.cases
            for run in CATALOGUE.suite.files(case)
        ],
        pictures=lambda wildcards: expand(
            "{validation}/figures/{case}.png",
            validation=VALIDATION,
            case=CATALOGUE.suite.cases,
        ),
    output:
        f"{VALIDATION}/book.md",
        f"{VALIDATION}/book.pdf",
    log:
        f"{VALIDATION}/logs/book.log",
    params:
        sources=SEARCHING + VALIDATING,
        plans=lambda wildcards: [
            CATALOGUE.suite.plan(case) for case in CATALOGUE.suite.cases
        ],
    script:
        "../scripts/validation/write_book.py"
