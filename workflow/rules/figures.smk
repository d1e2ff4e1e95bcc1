# Purpose: figures of a study: of some of its runs (what goes in, the strength used before the shaking, profiles, those of the paper) and of all.
# Inputs:  the runs each figure shows (config: figures, claims), study.csv; the drawing code.
# Outputs: figures/*, PNG and PDF
from sph.experiments.paper.figures import FIGURES as OF_THE_PAPER
from sph.figures import RUN_FIGURES, STUDY_FIGURES, WITH_PLACES

OF_RUNS = RUN_FIGURES | OF_THE_PAPER


rule figure:
    """Draw a figure of one run, or of some."""
    input:
        runs=lambda wildcards: [run.file for run in PLAN.figure_runs(wildcards.figure)],
    output:
        shown(f"{RESULTS}/figures/{{figure}}.png", "Figures", "{figure}"),
        f"{RESULTS}/figures/{{figure}}.pdf",
    log:
        f"{RESULTS}/logs/{{figure}}.log",
    wildcard_constraints:
        figure="|".join(OF_RUNS),
    params:
        **told(
            lambda wildcards: {
                "name": wildcards.figure,
                "scenes": [
                    planned(run.scene) for run in PLAN.figure_runs(wildcards.figure)
                ],
                "titles": PLAN.figure_titles(wildcards.figure),
                "fidelity": PLAN.study.fidelity,
                "marked": (
                    {
                        "places": PLAN.study.metrics.places,
                        "field": PLAN.study.figures.field,
                    }
                    if wildcards.figure in WITH_PLACES
                    else {}
                ),
            }
        ),
        sources=SOLVER + DRAWING + sources("experiments/paper/*.py"),
        about=lambda wildcards: caption_of(OF_RUNS[wildcards.figure]),
    script:
        "../scripts/figures/draw_figure.py"


rule study_figure:
    """Draw a figure of all runs."""
    input:
        table=f"{RESULTS}/study.csv",
    output:
        shown(f"{RESULTS}/figures/{{figure}}.png", "Figures", "all runs, {figure}"),
        f"{RESULTS}/figures/{{figure}}.pdf",
    log:
        f"{RESULTS}/logs/figure_{{figure}}.log",
    wildcard_constraints:
        figure="|".join(STUDY_FIGURES),
    params:
        **told(
            lambda wildcards: {
                "name": wildcards.figure,
                "layout": PLAN.layout._replace(labels=()),
                "dimensions": PLAN.dimensions,
                "probe": PLAN.study.metrics.probe,
                "note": PLAN.note,
            }
        ),
        sources=DRAWING,
        about=lambda wildcards: caption_of(STUDY_FIGURES[wildcards.figure]),
    script:
        "../scripts/figures/draw_study.py"
