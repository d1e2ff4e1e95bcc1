# Purpose: what goes into a study (Figs. 1-3), the strength used before the shaking, its results against its dimensions and some profiles.
# Inputs:  the runs each figure shows (config: figures.runs), study.csv; the drawing code.
# Outputs: figures/fig1 to fig3, mobilised, study, profiles, PNG and PDF


rule figure:
    """Draw what goes into a run, geometry, motion and initial particles, or the strength that it uses before the shaking."""
    input:
        runs=lambda wildcards: expand(
            RUN,
            folder=RESULTS,
            run=PLAN.study.figure_files[wildcards.figure],
        ),
    output:
        png=report(
            f"{RESULTS}/figures/{{figure}}.png",
            caption="../report/figure.rst",
            category="Figures",
            labels={"shows": "{figure}"},
        ),
        pdf=f"{RESULTS}/figures/{{figure}}.pdf",
    log:
        f"{RESULTS}/logs/{{figure}}.log",
    wildcard_constraints:
        figure="fig[1-3]|mobilised",
    params:
        sources=SOLVER + DRAWING,
        figure=lambda wildcards: wildcards.figure,
        caption=lambda wildcards: caption_of(RUN_FIGURES[wildcards.figure]),
        scenes=lambda wildcards: [
            planned(PLAN.run_scene(run))
            for run in PLAN.study.figure_files[wildcards.figure]
        ],
        titles=[],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/figures/draw_figure.py"


rule study_figure:
    """Draw a figure of all runs."""
    input:
        table=f"{RESULTS}/study.csv",
    output:
        png=report(
            f"{RESULTS}/figures/{{figure}}.png",
            caption="../report/study_figure.rst",
            category="Figures",
            labels={"shows": "all runs, {figure}"},
        ),
        pdf=f"{RESULTS}/figures/{{figure}}.pdf",
    log:
        f"{RESULTS}/logs/figure_{{figure}}.log",
    wildcard_constraints:
        figure="|".join(STUDY_FIGURES),
    params:
        sources=DRAWING,
        caption=lambda wildcards: caption_of(STUDY_FIGURES[wildcards.figure]),
        layout=lambda wildcards: PLAN.layout._replace(labels=()),
        dimensions=lambda wildcards: PLAN.dimensions,
        probe=PLAN.study.metrics.probe,
        note=lambda wildcards: PLAN.note,
    script:
        "../scripts/figures/draw_study.py"


rule profiles:
    """Draw profiles at the end of some runs."""
    input:
        runs=lambda wildcards: expand(RUN, folder=RESULTS, run=PLAN.study.profile_runs),
    output:
        png=report(
            f"{RESULTS}/figures/profiles.png",
            caption="../report/profiles.rst",
            category="Figures",
            labels={"shows": "profiles"},
        ),
        pdf=f"{RESULTS}/figures/profiles.pdf",
    log:
        f"{RESULTS}/logs/profiles.log",
    params:
        sources=SOLVER + DRAWING,
        figure="profiles",
        scenes=lambda wildcards: [
            planned(PLAN.run_scene(run)) for run in PLAN.study.profile_runs
        ],
        titles=lambda wildcards: [[title] for title in PLAN.profile_titles],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/figures/draw_figure.py"
