# Purpose: Figures 1-7 of the paper.
# Inputs:  the runs each figure shows (config: figures, claims.amplitude); the drawing code.
# Outputs: figures/fig1 to fig7, PNG and PDF


rule figure:
    """Draw a figure: 1-3 show what goes in, 4-5 profiles at the end, 6-7 the motion of particle A."""
    input:
        sources=SOLVER + DRAWING,
        runs=lambda wildcards: [
            RUN.format(folder=RESULTS, **point)
            for _, point in PLAN.study.figure_runs(int(wildcards.number))
        ],
    output:
        png=report(
            f"{RESULTS}/figures/fig{{number}}.png",
            caption="../report/figure.rst",
            category="Figures",
            labels={"shows": "Figure {number}"},
        ),
        pdf=f"{RESULTS}/figures/fig{{number}}.pdf",
    log:
        f"{RESULTS}/logs/fig{{number}}.log",
    wildcard_constraints:
        number="[1-7]",
    params:
        titles=lambda wildcards: [
            list(titles) for titles, _ in PLAN.study.figure_runs(int(wildcards.number))
        ],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/draw_figure.py"
