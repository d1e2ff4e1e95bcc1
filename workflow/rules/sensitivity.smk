# Purpose: which factors decide the answer (`snakemake --cores 2 sensitivity`): screening, one at a time, indices; which values of theirs
#          agree with what was observed (`snakemake --cores 2 back_analysis`).
# Inputs:  config/sensitivity.yaml (config: experiments), the study's scene and fidelity; the sources of solver, analysis and drawing.
# Outputs: results/<study>/<fidelity>/sensitivity: runs/<design>/*.nc, samples/*.csv, factors.json, morris.csv, tornado.csv, sobol.csv,
#          cross_validation.csv, confirm.csv, back_analysis.csv, back_analysis.nc, back_points.csv, back_posterior.nc, back_confirmed.csv,
#          sample.csv, sample.nc, figures/*
import functools

from sph.experiments.sensitivity.design import (
    BACK,
    BACK_FILE,
    FACTORS_FILE,
    chosen_factors,
    chosen_points,
    load_sensitivity,
)
from sph.experiments.sensitivity.tables import described

SENSITIVITY = f"{RESULTS}/sensitivity"
FACTORS = f"{SENSITIVITY}/{FACTORS_FILE}"
BACK_POINTS = f"{SENSITIVITY}/{BACK_FILE}"
ALL_FACTORS = ("morris", "tornado")  # designs that vary every factor
SAMPLE_OF = {
    "morris": "morris",
    "tornado": "tornado",
    "sobol": "sobol",
    "cross_validation": "sobol",
}
# Read once a rule of the analysis is asked for; its scenes are built before the first job, not again by each.
DESIGNS = functools.cache(
    lambda: load_sensitivity(
        PLAN.experiment_file("sensitivity"),
        PLAN,
        FOLDERS,
        check=workflow.is_main_process,
    )
)
RUN_OF[SENSITIVITY] = lambda name: Run(DESIGNS().run_scene(name, varied))


wildcard_constraints:
    design="morris|tornado|sobol|confirm|back",


rule sensitivity:
    """Which factors decide the answer: tables and figures."""
    input:
        f"{SENSITIVITY}/sample.csv",
        lambda wildcards: (
            [f"{SENSITIVITY}/confirm.csv"] if DESIGNS().confirmed else []
        ),
        expand(
            "{sensitivity}/figures/{figure}.{kind}",
            sensitivity=SENSITIVITY,
            figure=SAMPLE_OF,
            kind=["png", "pdf"],
        ),
        lambda wildcards: (
            rules.back_analysis.input if DESIGNS().settings.back_analysis else []
        ),


rule back_analysis:
    """Which values of the factors agree with what was observed: tables and figure."""
    input:
        expand(
            "{sensitivity}/{file}",
            sensitivity=SENSITIVITY,
            file=["back_analysis.csv", "back_analysis.nc", "back_confirmed.csv"]
            + ["figures/back_analysis.png", "figures/back_analysis.pdf"],
        ),


rule sensitivity_measure:
    """Measure every run of a design."""
    input:
        factors=lambda wildcards: known_by(wildcards.design),
        runs=lambda wildcards: [
            f"{SENSITIVITY}/runs/{wildcards.design}/{run}.nc"
            for run in DESIGNS().design(wildcards.design, varied(wildcards.design))
        ],
    output:
        f"{SENSITIVITY}/samples/{{design}}.csv",
    log:
        f"{SENSITIVITY}/logs/{{design}}.log",
    params:
        sources=SOLVER + ANALYSIS,
        points=lambda wildcards: DESIGNS().design(
            wildcards.design, varied(wildcards.design)
        ),
        scenes=lambda wildcards: [
            planned(scene)
            for scene in DESIGNS().scenes(wildcards.design, varied(wildcards.design))
        ],
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/sensitivity/measure_sample.py"


rule sensitivity_sample:
    """All runs in one table, as netCDF and CSV."""
    input:
        samples=lambda wildcards: expand(
            "{sensitivity}/samples/{design}.csv",
            sensitivity=SENSITIVITY,
            design=["morris", "tornado", "sobol"]
            + ["confirm"] * bool(DESIGNS().confirmed)
            + [BACK] * bool(DESIGNS().settings.back_analysis),
        ),
    output:
        nc=f"{SENSITIVITY}/sample.nc",
        csv=report(
            f"{SENSITIVITY}/sample.csv",
            caption="../report/sensitivity_sample.rst",
            category="Sensitivity",
            labels={"shows": "every run"},
        ),
    log:
        f"{SENSITIVITY}/logs/sample.log",
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
    script:
        "../scripts/sensitivity/join_samples.py"


rule sensitivity_morris:
    """Elementary effects of all factors."""
    input:
        sample=f"{SENSITIVITY}/samples/morris.csv",
    output:
        report(
            f"{SENSITIVITY}/morris.csv",
            caption="../report/sensitivity_morris.rst",
            category="Sensitivity",
            labels={"shows": "Morris screening"},
        ),
    log:
        f"{SENSITIVITY}/logs/morris_table.log",
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        resamples=lambda wildcards: DESIGNS().settings.morris.resamples,
        seed=lambda wildcards: DESIGNS().settings.seed,
        described=lambda wildcards, input: described(input.sample),
    script:
        "../scripts/sensitivity/screen_factors.py"


checkpoint sensitivity_factors:
    """The factors that matter: those of the configuration, or those that the screening finds."""
    input:
        lambda wildcards: (
            [] if DESIGNS().settings.sobol.factors else f"{SENSITIVITY}/morris.csv"
        ),
    output:
        FACTORS,
    log:
        f"{SENSITIVITY}/logs/factors.log",
    params:
        factors=lambda wildcards: DESIGNS().settings.sobol.factors,
        sought=lambda wildcards: DESIGNS().sought,
        share=lambda wildcards: DESIGNS().settings.sobol.share,
    script:
        "../scripts/sensitivity/choose_factors.py"


rule sensitivity_tornado:
    """The metrics at both ends of every factor."""
    input:
        sample=f"{SENSITIVITY}/samples/tornado.csv",
    output:
        report(
            f"{SENSITIVITY}/tornado.csv",
            caption="../report/sensitivity_tornado.rst",
            category="Sensitivity",
            labels={"shows": "one factor at a time"},
        ),
    log:
        f"{SENSITIVITY}/logs/tornado_table.log",
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        described=lambda wildcards, input: described(input.sample),
    script:
        "../scripts/sensitivity/measure_tornado.py"


rule sensitivity_sobol:
    """Fit and cross-validate the surrogate, and compute the indices with it."""
    input:
        factors=FACTORS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
    output:
        indices=report(
            f"{SENSITIVITY}/sobol.csv",
            caption="../report/sensitivity_sobol.rst",
            category="Sensitivity",
            labels={"shows": "Sobol' indices"},
        ),
        validation=f"{SENSITIVITY}/cross_validation.csv",
    log:
        f"{SENSITIVITY}/logs/sobol_table.log",
    benchmark:
        f"{SENSITIVITY}/benchmarks/sobol_table.tsv"
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        settings=lambda wildcards: DESIGNS().settings.sobol.model_dump(),
        seed=lambda wildcards: DESIGNS().settings.seed,
        described=lambda wildcards, input: described(input.sample),
    script:
        "../scripts/sensitivity/fit_surrogate.py"


rule sensitivity_confirm:
    """The first points of the Sobol' sample beside the same ones at another fidelity."""
    input:
        sample=f"{SENSITIVITY}/samples/sobol.csv",
        confirmed=f"{SENSITIVITY}/samples/confirm.csv",
    output:
        report(
            f"{SENSITIVITY}/confirm.csv",
            caption="../report/sensitivity_confirm.rst",
            category="Sensitivity",
            labels={"shows": "confirmed points"},
        ),
    log:
        f"{SENSITIVITY}/logs/confirm_table.log",
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        fidelities=lambda wildcards: DESIGNS().fidelities,
        described=lambda wildcards, input: described(input.sample),
    script:
        "../scripts/sensitivity/confirm_sample.py"


rule sensitivity_figure:
    """Draw a table of the sensitivity analysis."""
    input:
        factors=FACTORS,
        table=lambda wildcards: f"{SENSITIVITY}/{wildcards.figure}.csv",
        indices=lambda wildcards: (
            f"{SENSITIVITY}/sobol.csv"
            if wildcards.figure == "cross_validation"
            else []
        ),
        sample=lambda wildcards: f"{SENSITIVITY}/samples/{SAMPLE_OF[wildcards.figure]}.csv",
    output:
        png=report(
            f"{SENSITIVITY}/figures/{{figure}}.png",
            caption="../report/sensitivity_figure.rst",
            category="Sensitivity",
            labels={"shows": "figure {figure}"},
        ),
        pdf=f"{SENSITIVITY}/figures/{{figure}}.pdf",
    log:
        f"{SENSITIVITY}/logs/figures/{{figure}}.log",
    wildcard_constraints:
        figure="|".join(SAMPLE_OF),
    params:
        sources=DRAWING,
        axes=lambda wildcards: DESIGNS().axes,
        described=lambda wildcards, input: described(input.sample),
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/sensitivity/draw_sensitivity.py"


checkpoint back_analysis_points:
    """The values of the factors that agree with what was observed, and the points that runs confirm."""
    input:
        factors=FACTORS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
        indices=f"{SENSITIVITY}/sobol.csv",
        validation=f"{SENSITIVITY}/cross_validation.csv",
    output:
        csv=report(
            f"{SENSITIVITY}/back_analysis.csv",
            caption="../report/back_analysis.rst",
            category="Back-analysis",
            labels={"shows": "values and intervals"},
        ),
        nc=f"{SENSITIVITY}/back_analysis.nc",
        points=BACK_POINTS,
        posterior=f"{SENSITIVITY}/back_posterior.nc",
    log:
        f"{SENSITIVITY}/logs/back_analysis.log",
    params:
        sources=ANALYSIS,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        sought=lambda wildcards: DESIGNS().sought,
        observations=lambda wildcards: DESIGNS().observations,
    script:
        "../scripts/sensitivity/analyse_back.py"


rule back_analysis_confirmed:
    """Runs at the best point and at the ends of the intervals beside what was predicted there: table and figure."""
    input:
        factors=FACTORS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
        result=f"{SENSITIVITY}/back_analysis.csv",
        points=BACK_POINTS,
        posterior=f"{SENSITIVITY}/back_posterior.nc",
        runs=f"{SENSITIVITY}/samples/{BACK}.csv",
    output:
        csv=report(
            f"{SENSITIVITY}/back_confirmed.csv",
            caption="../report/back_analysis.rst",
            category="Back-analysis",
            labels={"shows": "runs that confirm"},
        ),
        png=report(
            f"{SENSITIVITY}/figures/back_analysis.png",
            caption="../report/back_analysis.rst",
            category="Back-analysis",
            labels={"shows": "figure"},
        ),
        pdf=f"{SENSITIVITY}/figures/back_analysis.pdf",
    log:
        f"{SENSITIVITY}/logs/back_confirmed.log",
    params:
        sources=DRAWING,
        axes=lambda wildcards: DESIGNS().axes,
        quantities=lambda wildcards: DESIGNS().quantities,
        sought=lambda wildcards: DESIGNS().sought,
        observations=lambda wildcards: DESIGNS().observations,
        described=lambda wildcards, input: described(input.sample),
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/sensitivity/confirm_back.py"
