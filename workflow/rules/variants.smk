# Purpose: a scene in variants: what a saving of time costs in accuracy (`snakemake --cores 2 cost-accuracy`), what finer particles
#          bring (resolution), what the assumptions do (assumptions), how far runs can be pushed (robustness), and what a second spacing
#          changes in a study (spacing).
# Inputs:  config/<name>.yaml (config: experiments), whose runs are in the catalogue; study.csv.
# Outputs: results/<name>: tables and figures; spacing.csv in the folder of the study
from sph.experiments.variants import (
    assumptions,
    cost_accuracy,
    robustness,
    second_spacing,
)


include: "functions/variants.smk"


rule cost_accuracy_table:
    """Measure what each choice of the numerics costs and changes."""
    input:
        runs=files(runs_in("cost-accuracy")),
    output:
        "results/cost-accuracy/cost-accuracy.nc",
        shown(
            "results/cost-accuracy/cost-accuracy.csv",
            "Cost and accuracy",
            "every variant",
        ),
        shown(
            "results/cost-accuracy/convergence.csv",
            "Cost and accuracy",
            "order of convergence",
        ),
    log:
        "results/cost-accuracy/logs/cost_accuracy_table.log",
    params:
        **made_by(
            cost_accuracy.measure_cost_accuracy,
            table_of("cost-accuracy"),
            runs_in("cost-accuracy"),
        ),
    script:
        "../scripts/make.py"


rule cost_accuracy_figure_tradeoff:
    """Draw errors against computing time."""
    input:
        table="results/cost-accuracy/cost-accuracy.csv",
    output:
        shown(
            "results/cost-accuracy/figures/tradeoff.png",
            "Cost and accuracy",
            "figure tradeoff",
        ),
        "results/cost-accuracy/figures/tradeoff.pdf",
    log:
        "results/cost-accuracy/logs/cost_accuracy_figure_tradeoff.log",
    params:
        **made_by(cost_accuracy.draw_tradeoff, draws=True),
    script:
        "../scripts/make.py"


rule cost_accuracy_figure_convergence:
    """Draw results against the particle spacing."""
    input:
        convergence="results/cost-accuracy/convergence.csv",
        table="results/cost-accuracy/cost-accuracy.csv",
    output:
        shown(
            "results/cost-accuracy/figures/convergence.png",
            "Cost and accuracy",
            "figure convergence",
        ),
        "results/cost-accuracy/figures/convergence.pdf",
    log:
        "results/cost-accuracy/logs/cost_accuracy_figure_convergence.log",
    params:
        **made_by(cost_accuracy.draw_convergence, draws=True),
    script:
        "../scripts/make.py"


rule:
    """Tables and figures: what each choice of the numerics costs and changes."""
    name:
        "cost-accuracy"
    input:
        rules.cost_accuracy_table.output,
        rules.cost_accuracy_figure_tradeoff.output,
        rules.cost_accuracy_figure_convergence.output,


rule resolution_table:
    """Measure what finer particles bring."""
    input:
        runs=files(runs_in("resolution")),
    output:
        "results/resolution/resolution.nc",
        shown(
            "results/resolution/resolution.csv",
            "Cost and accuracy of the scheme for your own slopes",
            "every variant",
        ),
        shown(
            "results/resolution/convergence.csv",
            "Cost and accuracy of the scheme for your own slopes",
            "order of convergence",
        ),
    log:
        "results/resolution/logs/resolution_table.log",
    params:
        **made_by(
            cost_accuracy.measure_cost_accuracy,
            table_of("resolution"),
            runs_in("resolution"),
        ),
    script:
        "../scripts/make.py"


rule resolution_figure_tradeoff:
    """Draw errors against computing time."""
    input:
        table="results/resolution/resolution.csv",
    output:
        shown(
            "results/resolution/figures/tradeoff.png",
            "Cost and accuracy of the scheme for your own slopes",
            "figure tradeoff",
        ),
        "results/resolution/figures/tradeoff.pdf",
    log:
        "results/resolution/logs/resolution_figure_tradeoff.log",
    params:
        **made_by(cost_accuracy.draw_tradeoff, draws=True),
    script:
        "../scripts/make.py"


rule resolution_figure_convergence:
    """Draw results against the particle spacing."""
    input:
        convergence="results/resolution/convergence.csv",
        table="results/resolution/resolution.csv",
    output:
        shown(
            "results/resolution/figures/convergence.png",
            "Cost and accuracy of the scheme for your own slopes",
            "figure convergence",
        ),
        "results/resolution/figures/convergence.pdf",
    log:
        "results/resolution/logs/resolution_figure_convergence.log",
    params:
        **made_by(cost_accuracy.draw_convergence, draws=True),
    script:
        "../scripts/make.py"


rule resolution:
    """Tables and figures: what finer particles bring."""
    input:
        rules.resolution_table.output,
        rules.resolution_figure_tradeoff.output,
        rules.resolution_figure_convergence.output,


rule assumptions_table:
    """Measure what each assumption does."""
    input:
        runs=files(runs_in("assumptions")),
    output:
        shown("results/assumptions/assumptions.csv", "Assumptions", "every change"),
    log:
        "results/assumptions/logs/assumptions_table.log",
    params:
        **made_by(
            assumptions.measure_assumptions,
            table_of("assumptions"),
            runs_in("assumptions"),
        ),
    script:
        "../scripts/make.py"


rule assumptions:
    """The table of the assumptions."""
    input:
        rules.assumptions_table.output,


rule robustness_table:
    """Check runs at the ends of the ranges of keys."""
    input:
        runs=files(runs_in("robustness")),
    output:
        shown("results/robustness/robustness.csv", "Robustness", "every run"),
    log:
        "results/robustness/logs/robustness_table.log",
    params:
        **made_by(
            robustness.measure_robustness,
            table_of("robustness"),
            runs_in("robustness"),
        ),
    script:
        "../scripts/make.py"


rule robustness_figure:
    """Draw the checks of every run."""
    input:
        table="results/robustness/robustness.csv",
    output:
        shown(
            "results/robustness/figures/robustness.png",
            "Robustness",
            "figure robustness",
        ),
        "results/robustness/figures/robustness.pdf",
    log:
        "results/robustness/logs/robustness_figure.log",
    params:
        **made_by(robustness.draw_robustness, draws=True),
    script:
        "../scripts/make.py"


rule robustness:
    """The table of the robustness and its figure."""
    input:
        rules.robustness_table.output,
        rules.robustness_figure.output,


checkpoint deciding_runs:
    """Find the runs that decide in what shaking the slope fails, which are repeated with finer particles where not all are."""
    input:
        study=f"{RESULTS}/study.csv",
    output:
        f"{RESULTS}/{second_spacing.DECIDING}",
    log:
        f"{RESULTS}/logs/deciding_runs.log",
    params:
        **made_by(second_spacing.deciding_runs, lambda wildcards: named_runs()),
    script:
        "../scripts/make.py"


rule spacing_table:
    """Compare runs of the study with those at a second spacing."""
    input:
        study=f"{RESULTS}/study.csv",
        runs=files(second_runs),
    output:
        shown(f"{RESULTS}/spacing.csv", "Spacing", "what a second spacing changes"),
    log:
        f"{RESULTS}/logs/spacing_table.log",
    params:
        **made_by(
            second_spacing.spacing_table,
            lambda wildcards: {
                **named_runs(),
                "spacings": CATALOGUE.design("spacing").spacings,
                "settings": SETTINGS,
            },
            second_runs,
        ),
    script:
        "../scripts/make.py"


rule spacing:
    """What a second spacing changes."""
    input:
        rules.spacing_table.output,


# Names of targets until version 0.3 (sph.experiments.variants.design.EARLIER).
rule trade:
    """An earlier name of a target."""
    input:
        rules.cost_accuracy_table.output,
        rules.cost_accuracy_figure_tradeoff.output,
        rules.cost_accuracy_figure_convergence.output,
    message:
        "trade is called cost-accuracy now: snakemake --cores 2 cost-accuracy"


rule limits:
    """An earlier name of a target."""
    input:
        rules.assumptions_table.output,
    message:
        "limits is called assumptions now: snakemake --cores 2 assumptions"


rule extremes:
    """An earlier name of a target."""
    input:
        rules.robustness_table.output,
        rules.robustness_figure.output,
    message:
        "extremes is called robustness now: snakemake --cores 2 robustness"
