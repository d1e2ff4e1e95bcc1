# Purpose: figures of a study: of some of its runs (what goes in, the strength used before the shaking, profiles, those of the paper) and of all.
# Inputs:  the runs each figure shows (config: figures, claims), study.csv; the drawing code.
# Outputs: figures/*, PNG and PDF
from sph.experiments.paper.figures import FIGURES as OF_THE_PAPER
from sph.figures import MARKED, RUN_FIGURES, STUDY_FIGURES
from sph.study.schema import PROFILES

# Drawn together: a process takes as long to start as to draw some.
OF_RUNS = {name: (RUN_FIGURES | OF_THE_PAPER)[name] for name in PLAN.study.figure_files}
OF_ALL = {
    name: of for name, of in STUDY_FIGURES.items() if name not in PLAN.study.left_out
}
DRAWN = {
    run.file: run for name in PLAN.study.figure_files for run in PLAN.figure_runs(name)
}
# Figures that other studies have.
REFUSED = (RUN_FIGURES | OF_THE_PAPER | STUDY_FIGURES).keys() - {*OF_RUNS, *OF_ALL}


include: "functions/figures.smk"


rule figure:
    """Draw the figures of one run, or of some."""
    input:
        runs=[*DRAWN],
    output:
        **pictures(OF_RUNS, "{}"),
    log:
        f"{RESULTS}/logs/figures.log",
    params:
        **told(
            lambda wildcards: {
                "scenes": {file: planned(run.scene) for file, run in DRAWN.items()},
                "figures": {
                    name: (
                        [run.file for run in PLAN.figure_runs(name)],
                        PLAN.figure_titles(name),
                    )
                    for name in OF_RUNS
                },
                "fidelity": PLAN.study.fidelity,
                # of what the figures show alone, since they are drawn again for another
                "marked": {
                    key: value
                    for key, value in {
                        "places": PLAN.study.metrics.places,
                        "field": PLAN.study.figures.field,
                        "others": PLAN.other_shakings,
                    }.items()
                    if any(key in MARKED.get(name, ()) for name in OF_RUNS)
                },
                "choice": PLAN.profile_choice if PROFILES in OF_RUNS else {},
            }
        ),
        sources=SOLVER + DRAWING + sources("experiments/paper/*.py"),
        about=captions(OF_RUNS),
    script:
        "../scripts/figures/draw_figures.py"


rule study_figure:
    """Draw the figures of all runs."""
    input:
        table=f"{RESULTS}/study.csv",
    output:
        **pictures(OF_ALL, "all runs, {}"),
    log:
        f"{RESULTS}/logs/study_figures.log",
    params:
        **told(
            lambda wildcards: {
                "names": [*OF_ALL],
                "layout": PLAN.layout._replace(labels=()),
                "dimensions": PLAN.drawn_dimensions,
                "probe": PLAN.study.metrics.probe,
                "note": PLAN.note,
            }
        ),
        sources=DRAWING,
        about=captions(OF_ALL),
    script:
        "../scripts/figures/draw_study.py"


rule no_figure:
    """Refuse a figure that the study does not have, with the reason."""
    input:
        lambda wildcards: PLAN.figure_runs(wildcards.figure),
    output:
        f"{RESULTS}/figures/{{figure}}.{{kind}}",
    wildcard_constraints:
        figure="|".join(REFUSED),
        kind="png|pdf",
