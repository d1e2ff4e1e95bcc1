# Purpose: which parameters decide the results (`snakemake --cores 2 sensitivity`), and their values that agree with what was observed
#          (back_analysis).
# Inputs:  config/sensitivity.yaml (config: experiments); runs of the catalogue, some of which follow from tables of earlier steps.
# Outputs: sensitivity/ in the folder of the study: tables, figures, and the runs of every design in samples/
from sph.experiments.sensitivity import measure as analysis


include: "functions/sensitivity.smk"


SAMPLED = f"{RESULTS}/sensitivity"


wildcard_constraints:
    design="morris|tornado|sobol|confirm|back",


rule sensitivity_measure:
    """Measure the runs of a design."""
    input:
        lambda wildcards: CATALOGUE.sensitivity.known_by(wildcards.design) or [],
        runs=files(sampled_runs),
    output:
        f"{SAMPLED}/samples/{{design}}.csv",
    log:
        f"{SAMPLED}/logs/{{design}}.log",
    params:
        **made_by(
            analysis.measure_sample,
            lambda wildcards: {
                **axes(wildcards),
                "design": wildcards.design,
                "points": CATALOGUE.sensitivity.design(
                    wildcards.design, chosen_for(wildcards)
                ),
                "settings": SETTINGS,
            },
            sampled_runs,
        ),
    script:
        "../scripts/make.py"


rule sensitivity_sample:
    """Join the runs of all designs."""
    input:
        samples=all_samples,
    output:
        f"{SAMPLED}/sample.nc",
        shown(f"{SAMPLED}/sample.csv", "Sensitivity", "every run"),
    log:
        f"{SAMPLED}/logs/sensitivity_sample.log",
    params:
        **made_by(analysis.join_samples, axes),
    script:
        "../scripts/make.py"


rule sensitivity_morris:
    """Screen the factors by elementary effects."""
    input:
        sample=f"{SAMPLED}/samples/morris.csv",
    output:
        shown(f"{SAMPLED}/morris.csv", "Sensitivity", "Morris screening"),
    log:
        f"{SAMPLED}/logs/sensitivity_morris.log",
    params:
        **made_by(
            analysis.screen_factors,
            lambda wildcards: {
                **axes(wildcards),
                "resamples": CATALOGUE.sensitivity.settings.morris.resamples,
                "seed": CATALOGUE.sensitivity.settings.seed,
            },
        ),
    script:
        "../scripts/make.py"


checkpoint sensitivity_factors:
    """Choose the factors that matter."""
    input:
        screening=lambda wildcards: (
            []
            if CATALOGUE.sensitivity.settings.sobol.factors
            else f"{SAMPLED}/morris.csv"
        ),
    output:
        f"{SAMPLED}/factors.json",
    log:
        f"{SAMPLED}/logs/sensitivity_factors.log",
    params:
        **made_by(
            analysis.choose_factors,
            lambda wildcards: {
                "factors": CATALOGUE.sensitivity.settings.sobol.factors,
                "sought": CATALOGUE.sensitivity.sought,
                "share": CATALOGUE.sensitivity.settings.sobol.share,
            },
        ),
    script:
        "../scripts/make.py"


rule sensitivity_tornado:
    """Measure what each factor does at both ends of its range."""
    input:
        sample=f"{SAMPLED}/samples/tornado.csv",
    output:
        shown(f"{SAMPLED}/tornado.csv", "Sensitivity", "one factor at a time"),
    log:
        f"{SAMPLED}/logs/sensitivity_tornado.log",
    params:
        **made_by(analysis.measure_tornado, axes),
    script:
        "../scripts/make.py"


rule sensitivity_sobol:
    """Compute Sobol' indices through a surrogate."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        factors=f"{SAMPLED}/factors.json",
    output:
        shown(f"{SAMPLED}/sobol.csv", "Sensitivity", "Sobol' indices"),
        f"{SAMPLED}/cross_validation.csv",
    log:
        f"{SAMPLED}/logs/sensitivity_sobol.log",
    params:
        **made_by(
            analysis.fit_surrogate,
            lambda wildcards: {
                **axes(wildcards),
                "settings": CATALOGUE.sensitivity.settings.sobol,
                "seed": CATALOGUE.sensitivity.settings.seed,
            },
        ),
    script:
        "../scripts/make.py"


rule sensitivity_confirm:
    """Compare points with those at another fidelity."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        confirming=f"{SAMPLED}/samples/confirm.csv",
    output:
        shown(f"{SAMPLED}/confirm.csv", "Sensitivity", "confirmed points"),
    log:
        f"{SAMPLED}/logs/sensitivity_confirm.log",
    params:
        **made_by(
            analysis.confirm_sample,
            lambda wildcards: {
                **axes(wildcards),
                "fidelities": CATALOGUE.sensitivity.fidelities,
            },
        ),
    script:
        "../scripts/make.py"


rule sensitivity_figure_morris:
    """Draw the screening."""
    input:
        sample=f"{SAMPLED}/samples/morris.csv",
        factors=f"{SAMPLED}/factors.json",
        screening=f"{SAMPLED}/morris.csv",
    output:
        shown(f"{SAMPLED}/figures/morris.png", "Sensitivity", "figure morris"),
        f"{SAMPLED}/figures/morris.pdf",
    log:
        f"{SAMPLED}/logs/sensitivity_figure_morris.log",
    params:
        **made_by(analysis.draw_morris, drawn, draws=True),
    script:
        "../scripts/make.py"


rule sensitivity_figure_tornado:
    """Draw what each factor does at both ends of its range."""
    input:
        sample=f"{SAMPLED}/samples/tornado.csv",
        tornado=f"{SAMPLED}/tornado.csv",
    output:
        shown(f"{SAMPLED}/figures/tornado.png", "Sensitivity", "figure tornado"),
        f"{SAMPLED}/figures/tornado.pdf",
    log:
        f"{SAMPLED}/logs/sensitivity_figure_tornado.log",
    params:
        **made_by(analysis.draw_tornado, drawn, draws=True),
    script:
        "../scripts/make.py"


rule sensitivity_figure_sobol:
    """Draw the indices."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        indices=f"{SAMPLED}/sobol.csv",
    output:
        shown(f"{SAMPLED}/figures/sobol.png", "Sensitivity", "figure sobol"),
        f"{SAMPLED}/figures/sobol.pdf",
    log:
        f"{SAMPLED}/logs/sensitivity_figure_sobol.log",
    params:
        **made_by(analysis.draw_sobol, drawn, draws=True),
    script:
        "../scripts/make.py"


rule sensitivity_figure_cross_validation:
    """Draw the cross-validation of the surrogate."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        validation=f"{SAMPLED}/cross_validation.csv",
        indices=f"{SAMPLED}/sobol.csv",
    output:
        shown(
            f"{SAMPLED}/figures/cross_validation.png",
            "Sensitivity",
            "figure cross_validation",
        ),
        f"{SAMPLED}/figures/cross_validation.pdf",
    log:
        f"{SAMPLED}/logs/sensitivity_figure_cross_validation.log",
    params:
        **made_by(analysis.draw_cross_validation, drawn, draws=True),
    script:
        "../scripts/make.py"


checkpoint back_analysis_points:
    """Find the values that agree with what was observed."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        factors=f"{SAMPLED}/factors.json",
        indices=f"{SAMPLED}/sobol.csv",
        validation=f"{SAMPLED}/cross_validation.csv",
    output:
        shown(f"{SAMPLED}/back_analysis.csv", "Sensitivity", "back-analysis"),
        f"{SAMPLED}/back_analysis.nc",
        f"{SAMPLED}/back_points.csv",
        f"{SAMPLED}/back_posterior.nc",
    log:
        f"{SAMPLED}/logs/back_analysis_points.log",
    params:
        **made_by(analysis.analyse_back, observed),
    script:
        "../scripts/make.py"


rule back_analysis_confirmed:
    """Compare runs at points of a back-analysis with what was predicted."""
    input:
        sample=f"{SAMPLED}/samples/sobol.csv",
        factors=f"{SAMPLED}/factors.json",
        result=f"{SAMPLED}/back_analysis.csv",
        confirmable=f"{SAMPLED}/back_points.csv",
        posterior=f"{SAMPLED}/back_posterior.nc",
        confirming=f"{SAMPLED}/samples/back.csv",
    output:
        shown(
            f"{SAMPLED}/back_confirmed.csv",
            "Sensitivity",
            "runs that confirm a back-analysis",
        ),
        shown(
            f"{SAMPLED}/figures/back_analysis.png",
            "Sensitivity",
            "figure of the back-analysis",
        ),
        f"{SAMPLED}/figures/back_analysis.pdf",
    log:
        f"{SAMPLED}/logs/back_analysis_confirmed.log",
    params:
        **made_by(
            analysis.confirm_back,
            lambda wildcards: {
                **observed(wildcards),
                "fidelity": CATALOGUE.sensitivity.fidelities[0],
            },
            draws=True,
        ),
    script:
        "../scripts/make.py"


rule back_analysis:
    """Values of the parameters that agree with what was observed."""
    input:
        f"{SAMPLED}/back_analysis.csv",
        f"{SAMPLED}/back_analysis.nc",
        rules.back_analysis_confirmed.output,


rule sensitivity:
    """The sensitivity analysis, with a back-analysis where the configuration asks for one."""
    input:
        rules.sensitivity_figure_morris.output,
        rules.sensitivity_figure_tornado.output,
        rules.sensitivity_figure_sobol.output,
        rules.sensitivity_figure_cross_validation.output,
        f"{SAMPLED}/sample.csv",
        lambda wildcards: (
            rules.sensitivity_confirm.output if CATALOGUE.sensitivity.confirmed else []
        ),
        lambda wildcards: (
            rules.back_analysis.input
            if CATALOGUE.sensitivity.settings.back_analysis
            else []
        ),
