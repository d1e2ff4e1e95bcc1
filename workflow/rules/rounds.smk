# Purpose: what follows from results: the rounds of the searches for critical intensities (`snakemake --cores 2 trigger`; `fragility` over
#          motions, `confirm` at another fidelity, `maps` over some dimensions), and the designs of the sensitivity analysis
#          (`snakemake --cores 2 sensitivity`; `back_analysis`: which values of the factors agree with what was observed).
# Inputs:  config/trigger.yaml, config/sensitivity.yaml (config: experiments); runs of the catalogue; tables of earlier rounds.
# Outputs: <folder>/trigger/rounds/*.csv; <folder>/sensitivity: samples/*.csv, factors.json, back_analysis.csv, back_analysis.nc,
#          back_points.csv, back_posterior.nc.  What is made of them: tables.smk
from sph.figures.trigger import MAPS
from sph.paper.study import PaperStudy

FIGURE_KINDS = ["png", "pdf"]


wildcard_constraints:
    search="trigger|maps",
    round="[0-9]+",
    design="morris|tornado|sobol|confirm|back",


rule trigger:
    """Critical intensities: tables and figure, of the paper's study the claim."""
    input:
        lambda wildcards: in_trigger(
            *["trigger.nc", "trigger.csv", "points.csv"],
            *[f"figures/trigger.{kind}" for kind in FIGURE_KINDS],
            *["claim.csv"] * isinstance(PLAN.study, PaperStudy),
        ),


rule fragility:
    """Fragility curves over the values of the search: fits, curves and figure."""
    input:
        lambda wildcards: in_trigger(
            *["trigger.csv", "points.csv", "fragility_fit.csv"],
            *["fragility_measures.csv", "exceedance.csv"],
            *["fragility_annual.csv"] * bool(CATALOGUE.trigger.trigger.hazard),
        ),


rule confirm:
    """The ends of brackets at another fidelity."""
    input:
        lambda wildcards: in_trigger("confirm.csv"),


rule maps:
    """Maps over some dimensions and the intensity: tables and figures."""
    input:
        lambda wildcards: in_trigger(
            *["maps.csv", "cells.csv", "shares.csv"],
            *[f"figures/{name}.{kind}" for name in MAPS for kind in FIGURE_KINDS],
        ),


checkpoint want_points:
    """The points that a round of a search wants, from those of the rounds before it."""
    input:
        points=earlier_points,
    output:
        f"{TRIGGER}/rounds/{{search}}-{{round}}-wanted.csv",
    log:
        f"{TRIGGER}/logs/{{search}}-{{round}}-wanted.log",
    params:
        **of_step("trigger", "want_points"),
        given=lambda wildcards: {
            "lattices": [
                lattice.model_dump()
                for lattice in CATALOGUE.trigger.lattices(wildcards.search)
            ],
            "classes": CATALOGUE.trigger.classes(wildcards.search),
            "number": int(wildcards.round),
        },
    script:
        "../scripts/make.py"


rule measure_points:
    """Measure the runs of a round and add them to those of the rounds before it."""
    input:
        points=earlier_points,
        wanted=f"{TRIGGER}/rounds/{{search}}-{{round}}-wanted.csv",
        runs=lambda wildcards: [run.file for run in wanted_runs(wildcards)],
    output:
        f"{TRIGGER}/rounds/{{search}}-{{round}}-points.csv",
    log:
        f"{TRIGGER}/logs/{{search}}-{{round}}-points.log",
    params:
        **of_step("trigger", "measure_points"),
        scenes=lambda wildcards: [planned(run.scene) for run in wanted_runs(wildcards)],
        given={"settings": PLAN.study.metrics.model_dump()},
    script:
        "../scripts/make.py"


checkpoint want_confirmation:
    """The ends of brackets that are run again at another fidelity."""
    input:
        critical=f"{TRIGGER}/trigger.csv",
        points=f"{TRIGGER}/points.csv",
    output:
        f"{TRIGGER}/rounds/confirm-wanted.csv",
    log:
        f"{TRIGGER}/logs/confirm-wanted.log",
    params:
        **of_step("trigger", "want_confirmation"),
        given=lambda wildcards: {
            "confirm": CATALOGUE.trigger.confirm,
            "searched": CATALOGUE.trigger.dimensions,
        },
    script:
        "../scripts/make.py"


rule confirm_table:
    """Compare the ends of brackets at both fidelities."""
    input:
        points=f"{TRIGGER}/points.csv",
        ends=f"{TRIGGER}/rounds/confirm-wanted.csv",
        runs=lambda wildcards: [run.file for run in confirming_runs(wildcards)],
    output:
        list(made(TRIGGER, "Trigger", {"confirm.csv": "confirmed brackets"})),
    log:
        f"{TRIGGER}/logs/confirm.log",
    params:
        **of_step("trigger", "confirm_table"),
        scenes=lambda wildcards: [
            planned(run.scene) for run in confirming_runs(wildcards)
        ],
        given=lambda wildcards: {
            "settings": PLAN.study.metrics.model_dump(),
            "searched": CATALOGUE.trigger.dimensions,
        },
    script:
        "../scripts/make.py"


rule sensitivity:
    """Which factors decide the answer: tables and figures."""
    input:
        f"{SENSITIVITY}/sample.csv",
        lambda wildcards: (
            [f"{SENSITIVITY}/confirm.csv"] if CATALOGUE.sensitivity.confirmed else []
        ),
        expand(
            "{sensitivity}/figures/{figure}.{kind}",
            sensitivity=SENSITIVITY,
            figure=["morris", "tornado", "sobol", "cross_validation"],
            kind=FIGURE_KINDS,
        ),
        lambda wildcards: (
            rules.back_analysis.input
            if CATALOGUE.sensitivity.settings.back_analysis
            else []
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
        known=known_by,
        runs=lambda wildcards: [run.file for run in sampled_runs(wildcards)],
    output:
        f"{SENSITIVITY}/samples/{{design}}.csv",
    log:
        f"{SENSITIVITY}/logs/{{design}}.log",
    params:
        **of_step("sensitivity", "sensitivity_measure"),
        scenes=lambda wildcards: [planned(run.scene) for run in sampled_runs(wildcards)],
        given=lambda wildcards: {
            "design": wildcards.design,
            "points": CATALOGUE.sensitivity.design(
                wildcards.design, varied(wildcards.design)
            ),
            "axes": CATALOGUE.sensitivity.axes,
            "quantities": CATALOGUE.sensitivity.quantities,
            "settings": PLAN.study.metrics.model_dump(),
        },
    script:
        "../scripts/make.py"


checkpoint sensitivity_factors:
    """The factors that matter: those of the configuration, or those that the screening finds."""
    input:
        screening=lambda wildcards: (
            []
            if CATALOGUE.sensitivity.settings.sobol.factors
            else f"{SENSITIVITY}/morris.csv"
        ),
    output:
        FACTORS,
    log:
        f"{SENSITIVITY}/logs/factors.log",
    params:
        **of_step("sensitivity", "sensitivity_factors"),
        given=lambda wildcards: {
            "factors": CATALOGUE.sensitivity.settings.sobol.factors,
            "sought": CATALOGUE.sensitivity.sought,
            "share": CATALOGUE.sensitivity.settings.sobol.share,
        },
    script:
        "../scripts/make.py"


checkpoint back_analysis_points:
    """The values of the factors that agree with what was observed, and the points that runs confirm."""
    input:
        factors=FACTORS,
        sample=f"{SENSITIVITY}/samples/sobol.csv",
        indices=f"{SENSITIVITY}/sobol.csv",
        validation=f"{SENSITIVITY}/cross_validation.csv",
    output:
        csv=shown(f"{SENSITIVITY}/back_analysis.csv", "Sensitivity", "back-analysis"),
        nc=f"{SENSITIVITY}/back_analysis.nc",
        points=BACK_POINTS,
        posterior=f"{SENSITIVITY}/back_posterior.nc",
    log:
        f"{SENSITIVITY}/logs/back_analysis.log",
    params:
        **of_step("sensitivity", "back_analysis_points"),
        given=lambda wildcards: steps("sensitivity")["back_analysis_points"].given(
            CATALOGUE.sensitivity
        ),
    script:
        "../scripts/make.py"
