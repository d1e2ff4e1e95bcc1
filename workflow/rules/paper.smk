# Purpose: what the paper concludes and shows; a study over other dimensions than the paper's is refused.
# Inputs:  study.nc, the runs each figure shows (config: figures, claims); the paper's sources, analysis and drawing.
# Outputs: claims.csv; figures/fig4 to fig7, PNG and PDF
from sph.paper.study import paper_study

OF_PAPER = functools.partial(paper_study, PLAN.study)


rule claims:
    """Decide the paper's twelve claims by numbers."""
    input:
        study=lambda wildcards: OF_PAPER("the claims") and f"{RESULTS}/study.nc",
    output:
        report(
            f"{RESULTS}/claims.csv",
            caption="../report/claims.rst",
            category="Tables",
            labels={"shows": "the claims"},
        ),
    log:
        f"{RESULTS}/logs/claims.log",
    params:
        sources=ANALYSIS + PAPER,
        settings=lambda wildcards: OF_PAPER("the claims").claims.model_dump(),
    script:
        "../scripts/paper/decide_claims.py"


rule paper_figure:
    """Draw one of the paper's figures: 4-5 show profiles at the end, 6-7 the motion of particle A."""
    input:
        runs=lambda wildcards: expand(
            RUN,
            folder=RESULTS,
            run=OF_PAPER("Figures 4 to 7").figure_files[f"fig{wildcards.number}"],
        ),
    output:
        png=report(
            f"{RESULTS}/figures/fig{{number}}.png",
            caption="../report/paper_figure.rst",
            category="Figures",
            labels={"shows": "Figure {number}"},
        ),
        pdf=f"{RESULTS}/figures/fig{{number}}.pdf",
    log:
        f"{RESULTS}/logs/fig{{number}}.log",
    wildcard_constraints:
        number="[4-7]",
    params:
        sources=SOLVER + DRAWING + PAPER,
        figure=lambda wildcards: f"fig{wildcards.number}",
        scenes=lambda wildcards: [
            planned(PLAN.scene(**point))
            for _, point in OF_PAPER("Figures 4 to 7").figure_runs(
                int(wildcards.number)
            )
        ],
        titles=lambda wildcards: [
            list(titles)
            for titles, _ in OF_PAPER("Figures 4 to 7").figure_runs(
                int(wildcards.number)
            )
        ],
        fidelity=PLAN.study.fidelity,
    script:
        "../scripts/figures/draw_figure.py"
