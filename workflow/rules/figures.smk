# Purpose: Figures 1-7 of the paper.
# Inputs:  the runs each figure shows (config: figures, claims.amplitude); the drawing code.
# Outputs: figures/fig1 to fig7, PNG and PDF


rule scene_figure:
    """Figs. 1-3: geometry, motion and initial particles, from the trunk at the amplitude of the figures."""
    input:
        sources=SOLVER + DRAWING,
        runs=f"{RESULTS}/stages/amplitude-{PLAN.study.reference_amplitude}.nc",
    output:
        png=report(
            f"{RESULTS}/figures/fig{{number}}.png",
            caption="../report/figure.rst",
            category="Figures",
            labels={"figure": "{number}", "format": "PNG"},
        ),
        pdf=f"{RESULTS}/figures/fig{{number}}.pdf",
    log:
        f"{RESULTS}/logs/fig{{number}}.log",
    wildcard_constraints:
        number="[1-3]",
    params:
        titles=[[]],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/draw_figure.py"


rule result_figure:
    """Figs. 4-7: profiles at the end and motion of particle A, for the runs the paper compares."""
    input:
        sources=SOLVER + DRAWING,
        runs=lambda wildcards: [
            RUN.format(**point)
            for _, point in PLAN.study.figure_runs(int(wildcards.number))
        ],
    output:
        png=report(
            f"{RESULTS}/figures/fig{{number}}.png",
            caption="../report/figure.rst",
            category="Figures",
            labels={"figure": "{number}", "format": "PNG"},
        ),
        pdf=f"{RESULTS}/figures/fig{{number}}.pdf",
    log:
        f"{RESULTS}/logs/fig{{number}}.log",
    wildcard_constraints:
        number="[4-7]",
    params:
        titles=lambda wildcards: [
            list(titles) for titles, _ in PLAN.study.figure_runs(int(wildcards.number))
        ],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/draw_figure.py"
