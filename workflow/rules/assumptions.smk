# Purpose: what the answers rest on: box, walls, motion, damping, each changed alone (`snakemake --cores 2 limits`).
# Inputs:  config: limits; the sources of solver and analysis.
# Outputs: results/limits: runs/<change>/<case>.nc, limits.csv
import functools

from sph.experiments.assumptions import FOLDER as LIMITS, load_limits

CHANGES = functools.cache(
    functools.partial(load_limits, PLAN.study.limits, FOLDERS, PLAN.study.metrics.probe)
)
EXPERIMENTS[LIMITS] = lambda name: Run(CHANGES().runs[name])


rule limits:
    """What the answers rest on."""
    input:
        f"{LIMITS}/limits.csv",


rule limits_table:
    """Measure every run against the scene as it is."""
    input:
        runs=lambda wildcards: [f"{LIMITS}/runs/{run}.nc" for run in CHANGES().runs],
    output:
        report(
            f"{LIMITS}/limits.csv",
            caption="../report/limits.rst",
            category="Limits",
            labels={"shows": "every change"},
        ),
    log:
        f"{LIMITS}/logs/limits.log",
    params:
        sources=SOLVER + ANALYSIS,
        rows=lambda wildcards: CHANGES().rows,
        scenes=lambda wildcards: [planned(scene) for scene in CHANGES().runs.values()],
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/assumptions/measure_limits.py"
