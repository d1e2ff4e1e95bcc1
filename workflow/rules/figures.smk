# Purpose: figures of a study: of some of its runs (what goes in, the strength used before the shaking, profiles, those of the paper) and of all.
# Inputs:  the runs each figure shows (config: figures, claims), study.csv; the drawing code.
# Outputs: figures/*, PNG and PDF
from sph.paper.figures import FIGURES as DRAWN


rule figure:
    """Draw a figure of one run, or of some."""
    input:
        runs=lambda wildcards: [run.file for run in figure_runs(wildcards)],
    output:
        list(made(RESULTS, "Figures", {"figures/{figure}": "{figure}"})),
    log:
        f"{RESULTS}/logs/{{figure}}.log",
    wildcard_constraints:
        figure="|".join([*RUN_FIGURES, *PAPER_FIGURES]),
    params:
        sources=lambda wildcards: (
            SOLVER + DRAWING + PAPER * (wildcards.figure in PAPER_FIGURES)
        ),
        figure=lambda wildcards: wildcards.figure,
        about=lambda wildcards: caption_of((RUN_FIGURES | DRAWN)[wildcards.figure]),
        scenes=lambda wildcards: [planned(run.scene) for run in figure_runs(wildcards)],
        titles=lambda wildcards: PLAN.figure_titles(wildcards.figure),
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/figures/draw_figure.py"


rule study_figure:
    """Draw a figure of all runs."""
    input:
        table=f"{RESULTS}/study.csv",
    output:
        list(made(RESULTS, "Figures", {"figures/{figure}": "all runs, {figure}"})),
    log:
        f"{RESULTS}/logs/figure_{{figure}}.log",
    wildcard_constraints:
        figure="|".join(STUDY_FIGURES),
    params:
        sources=DRAWING,
        about=lambda wildcards: caption_of(STUDY_FIGURES[wildcards.figure]),
        layout=lambda wildcards: PLAN.layout._replace(labels=()),
        dimensions=lambda wildcards: PLAN.dimensions,
        probe=PLAN.study.metrics.probe,
        note=lambda wildcards: PLAN.note,
    script:
        "../scripts/figures/draw_study.py"
