# Purpose: how far the solver can be pushed: keys at the ends of their ranges (`snakemake --cores 2 extremes`).
# Inputs:  config: extremes; the sources of solver, analysis and drawing.
# Outputs: results/extremes: runs/<sweep>/<case>/<value>_<repeat>.nc, extremes.csv, figures/extremes
import functools

from sph.experiments.robustness import (
    FOLDER as EXTREMES,
    TIME_STEP_FOLDER,
    load_extremes,
)

SWEEPS = functools.cache(functools.partial(load_extremes, PLAN.study.extremes, FOLDERS))
EXPERIMENTS[EXTREMES] = lambda name: Run(
    SWEEPS().runs[name], enforce_limit=not name.startswith(TIME_STEP_FOLDER)
)


rule extremes:
    """The sweeps: table and figure."""
    input:
        f"{EXTREMES}/extremes.csv",
        expand(
            "{extremes}/figures/extremes.{kind}",
            extremes=EXTREMES,
            kind=["png", "pdf"],
        ),


rule extremes_table:
    """Measure every run."""
    input:
        runs=lambda wildcards: [f"{EXTREMES}/runs/{run}.nc" for run in SWEEPS().runs],
    output:
        report(
            f"{EXTREMES}/extremes.csv",
            caption="../report/extremes.rst",
            category="Extremes",
            labels={"shows": "every run"},
        ),
    log:
        f"{EXTREMES}/logs/extremes.log",
    params:
        sources=SOLVER + ANALYSIS,
        scenes=lambda wildcards: {
            name: planned(scene) for name, scene in SWEEPS().runs.items()
        },
        rows=lambda wildcards: [row._asdict() for row in SWEEPS().rows],
    script:
        "../scripts/robustness/measure_extremes.py"


rule extremes_figure:
    """Draw the sweeps: status and checks of every run."""
    input:
        table=f"{EXTREMES}/extremes.csv",
    output:
        png=report(
            f"{EXTREMES}/figures/extremes.png",
            caption="../report/extremes.rst",
            category="Extremes",
            labels={"shows": "figure"},
        ),
        pdf=f"{EXTREMES}/figures/extremes.pdf",
    log:
        f"{EXTREMES}/logs/figure.log",
    params:
        sources=DRAWING,
    script:
        "../scripts/robustness/draw_extremes.py"
