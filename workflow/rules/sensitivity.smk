# Purpose: which factors decide the answer (`snakemake --cores 2 sensitivity`): screening, one at a time, indices.
# Inputs:  config: sensitivity, and the study's scene and fidelity; the sources of solver, analysis and drawing.
# Outputs: results/<study>/<fidelity>/sensitivity: runs/<design>/*.nc, samples/*.csv, factors.json, morris.csv, tornado.csv, sobol.csv,
#          cross_validation.csv, confirm.csv, sample.csv, sample.nc, figures/*
import functools
import json

SENSITIVITY = f"{RESULTS}/sensitivity"
FACTORS = f"{SENSITIVITY}/factors.json"


@functools.cache
def sensitivity_plan():
    """The designs, read once a rule of theirs is asked for; their scenes are built before the first job, not again by each."""
    from sph.analysis.sensitivity import load_sensitivity

    return load_sensitivity(
        PLAN.study.sensitivity, PLAN, FOLDERS, check=workflow.is_main_process
    )


def factors_file(wildcards):
    """The file with the factors that matter, for the designs that vary these alone."""
    return [] if wildcards.design in ("morris", "tornado") else FACTORS


def design_points(wildcards, input):
    """Values of the factors of every run of a design, by name."""
    chosen = json.loads(Path(input.factors).read_text()) if input.factors else []
    return sensitivity_plan().design(wildcards.design, chosen)


def design_runs(wildcards):
    """Files of all runs of a design."""
    chosen = []
    if factors_file(wildcards):
        with checkpoints.sensitivity_factors.get().output[0].open() as file:
            chosen = json.load(file)
    return [
        f"{SENSITIVITY}/runs/{wildcards.design}/{run}.nc"
        for run in sensitivity_plan().design(wildcards.design, chosen)
    ]


def described_sample(wildcards, input):
    """How many runs a sample has, and how many diverged."""
    from sph.analysis.sensitivity_tables import described

    return described(input.sample)


def sensitivity_axes(wildcards):
    """The factors, for a script."""
    return [axis._asdict() for axis in sensitivity_plan().axes]


def sensitivity_quantities(wildcards):
    """The metrics as they are analysed, for a script."""
    return [quantity._asdict() for quantity in sensitivity_plan().quantities]


wildcard_constraints:
    design="morris|tornado|sobol|confirm",


rule sensitivity:
    """Which factors decide the answer: tables and figures."""
    input:
        f"{SENSITIVITY}/sample.csv",
        lambda wildcards: (
            [f"{SENSITIVITY}/confirm.csv"] if sensitivity_plan().confirmed else []
        ),
        expand(
            "{sensitivity}/figures/{figure}.{kind}",
            sensitivity=SENSITIVITY,
            figure=["morris", "tornado", "sobol", "cross_validation"],
            kind=["png", "pdf"],
        ),


rule sensitivity_run:
    """Run a point of a design from the start to the end, on one core."""
    input:
        sources=SOLVER,
        factors=factors_file,
    output:
        f"{SENSITIVITY}/runs/{{design}}/{{run}}.nc",
    log:
        f"{SENSITIVITY}/logs/{{design}}/{{run}}.log",
    benchmark:
        f"{SENSITIVITY}/benchmarks/{{design}}/{{run}}.tsv"
    wildcard_constraints:
        run=".+",
    threads: 1
    params:
        scene=lambda wildcards, input: sensitivity_plan().scene(
            wildcards.design, design_points(wildcards, input)[wildcards.run]
        ),
        until="end",
    script:
        "../scripts/simulate.py"


rule sensitivity_measure:
    """Measure every run of a design."""
    input:
        sources=SOLVER + ANALYSIS,
        factors=factors_file,
        runs=design_runs,
    output:
        f"{SENSITIVITY}/samples/{{design}}.csv",
    log:
        f"{SENSITIVITY}/logs/{{design}}.log",
    params:
        points=design_points,
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/measure_sample.py"


rule sensitivity_sample:
    """All runs in one table, as netCDF and CSV."""
    input:
        sources=ANALYSIS,
        samples=lambda wildcards: expand(
            "{sensitivity}/samples/{design}.csv",
            sensitivity=SENSITIVITY,
            design=["morris", "tornado", "sobol"]
            + ["confirm"] * bool(sensitivity_plan().confirmed),
        ),
    output:
        nc=f"{SENSITIVITY}/sample.nc",
        csv=report(
            f"{SENSITIVITY}/sample.csv",
            caption="../report/sensitivity_sample.rst",
            category="Sensitivity",
        ),
    log:
        f"{SENSITIVITY}/logs/sample.log",
    params:
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
    script:
        "../scripts/join_samples.py"


rule sensitivity_morris:
    """Elementary effects of all factors."""
    input:
        sources=ANALYSIS,
        sample=f"{SENSITIVITY}/samples/morris.csv",
    output:
        report(
            f"{SENSITIVITY}/morris.csv",
            caption="../report/sensitivity_morris.rst",
            category="Sensitivity",
        ),
    log:
        f"{SENSITIVITY}/logs/morris_table.log",
    params:
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
        resamples=lambda wildcards: sensitivity_plan().settings.morris.resamples,
        seed=lambda wildcards: sensitivity_plan().settings.seed,
        described=described_sample,
    script:
        "../scripts/screen_factors.py"


checkpoint sensitivity_factors:
    """The factors that matter: those of the configuration, or those that the screening finds."""
    input:
        lambda wildcards: (
            []
            if sensitivity_plan().settings.sobol.factors
            else f"{SENSITIVITY}/morris.csv"
        ),
    output:
        FACTORS,
    log:
        f"{SENSITIVITY}/logs/factors.log",
    params:
        factors=lambda wildcards: sensitivity_plan().settings.sobol.factors,
        share=lambda wildcards: sensitivity_plan().settings.sobol.share,
    script:
        "../scripts/choose_factors.py"


rule sensitivity_tornado:
    """The metrics at both ends of every factor."""
    input:
        sources=ANALYSIS,
        sample=f"{SENSITIVITY}/samples/tornado.csv",
    output:
        report(
            f"{SENSITIVITY}/tornado.csv",
            caption="../report/sensitivity_tornado.rst",
            category="Sensitivity",
        ),
    log:
        f"{SENSITIVITY}/logs/tornado_table.log",
    params:
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
        described=described_sample,
    script:
        "../scripts/measure_tornado.py"


rule sensitivity_sobol:
    """Fit and cross-validate the surrogate, and compute the indices with it."""
    input:
        sources=ANALYSIS,
        factors=FACTORS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
    output:
        indices=report(
            f"{SENSITIVITY}/sobol.csv",
            caption="../report/sensitivity_sobol.rst",
            category="Sensitivity",
        ),
        validation=f"{SENSITIVITY}/cross_validation.csv",
    log:
        f"{SENSITIVITY}/logs/sobol_table.log",
    benchmark:
        f"{SENSITIVITY}/benchmarks/sobol_table.tsv"
    params:
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
        settings=lambda wildcards: sensitivity_plan().settings.sobol.model_dump(),
        seed=lambda wildcards: sensitivity_plan().settings.seed,
        described=described_sample,
    script:
        "../scripts/fit_surrogate.py"


rule sensitivity_confirm:
    """The first points of the Sobol' sample beside the same ones at another fidelity."""
    input:
        sources=ANALYSIS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
        confirmed=f"{SENSITIVITY}/samples/confirm.csv",
    output:
        report(
            f"{SENSITIVITY}/confirm.csv",
            caption="../report/sensitivity_confirm.rst",
            category="Sensitivity",
        ),
    log:
        f"{SENSITIVITY}/logs/confirm_table.log",
    params:
        axes=sensitivity_axes,
        quantities=sensitivity_quantities,
        fidelities=lambda wildcards: sensitivity_plan().fidelities,
        described=described_sample,
    script:
        "../scripts/confirm_sample.py"


rule sensitivity_figure:
    """Draw a table of the sensitivity analysis."""
    input:
        sources=DRAWING,
        factors=FACTORS,
        table=lambda wildcards: f"{SENSITIVITY}/{wildcards.figure}.csv",
        indices=lambda wildcards: (
            f"{SENSITIVITY}/sobol.csv"
            if wildcards.figure == "cross_validation"
            else []
        ),
        sample=lambda wildcards: (
            f"{SENSITIVITY}/samples/{wildcards.figure.replace('cross_validation', 'sobol')}.csv"
        ),
    output:
        png=report(
            f"{SENSITIVITY}/figures/{{figure}}.png",
            caption="../report/sensitivity_figure.rst",
            category="Sensitivity",
            labels={"figure": "{figure}"},
        ),
        pdf=f"{SENSITIVITY}/figures/{{figure}}.pdf",
    log:
        f"{SENSITIVITY}/logs/figures/{{figure}}.log",
    wildcard_constraints:
        figure="morris|tornado|sobol|cross_validation",
    params:
        axes=sensitivity_axes,
        described=described_sample,
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/draw_sensitivity.py"
