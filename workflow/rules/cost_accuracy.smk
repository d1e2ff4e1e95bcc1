# Purpose: the ladder: what each saving of computing time costs in accuracy (`snakemake --cores 2 trade`).
# Inputs:  the ladder (config: trade); the sources of solver, analysis and drawing.
# Outputs: results/trade: runs/*.nc, trade.nc, trade.csv, convergence.csv, figures/tradeoff, figures/convergence
import functools

from sph.experiments.cost_accuracy.design import FOLDER as TRADE, load_trade

# Read and checked once a rule of the ladder is asked for.
LADDER = functools.cache(
    functools.partial(
        load_trade,
        PLAN.study.trade,
        PLAN.study.fidelities,
        FOLDERS,
        PLAN.study.metrics.probe,
    )
)
EXPERIMENTS[TRADE] = lambda name: Run(LADDER().runs[name])


rule trade:
    """The ladder: table, order of convergence and figures."""
    input:
        f"{TRADE}/trade.nc",
        f"{TRADE}/trade.csv",
        f"{TRADE}/convergence.csv",
        expand(
            "{trade}/figures/{figure}.{kind}",
            trade=TRADE,
            figure=["tradeoff", "convergence"],
            kind=["png", "pdf"],
        ),


rule trade_table:
    """Measure every run of the ladder: costs, deviations from the reference, order of convergence."""
    input:
        runs=lambda wildcards: [f"{TRADE}/runs/{run}.nc" for run in LADDER().runs],
    output:
        nc=f"{TRADE}/trade.nc",
        csv=report(
            f"{TRADE}/trade.csv",
            caption="../report/trade.rst",
            category="Ladder",
            labels={"shows": "every rung"},
        ),
        convergence=report(
            f"{TRADE}/convergence.csv",
            caption="../report/trade_convergence.rst",
            category="Ladder",
            labels={"shows": "order of convergence"},
        ),
    log:
        f"{TRADE}/logs/trade.log",
    params:
        sources=SOLVER + ANALYSIS,
        scenes=lambda wildcards: {
            name: planned(scene) for name, scene in LADDER().runs.items()
        },
        rows=lambda wildcards: [row._asdict() for row in LADDER().rows],
        baseline=lambda wildcards: LADDER().trade.baseline,
        convergence=lambda wildcards: LADDER().trade.convergence,
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/cost_accuracy/measure_trade.py"


rule trade_figure:
    """Draw the ladder: error against cost, or results against spacing."""
    input:
        table=f"{TRADE}/trade.csv",
        convergence=f"{TRADE}/convergence.csv",
    output:
        png=report(
            f"{TRADE}/figures/{{figure}}.png",
            caption="../report/trade_figure.rst",
            category="Ladder",
            labels={"shows": "figure {figure}"},
        ),
        pdf=f"{TRADE}/figures/{{figure}}.pdf",
    log:
        f"{TRADE}/logs/{{figure}}.log",
    wildcard_constraints:
        figure="tradeoff|convergence",
    params:
        sources=SOLVER + DRAWING,
    script:
        "../scripts/cost_accuracy/draw_trade.py"
