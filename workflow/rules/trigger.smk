# Purpose: the shaking that triggers failure: critical intensities (`snakemake --cores 2 trigger`), the ends of their brackets at
#          another fidelity (`snakemake --cores 2 confirm`), maps over some dimensions and the intensity (`snakemake --cores 2 maps`).
# Inputs:  config/trigger.yaml (config: experiments); stages and runs of its cases (simulate.smk); the sources of analysis and drawing.
# Outputs: <folder>/trigger: rounds/*.csv, trigger.nc, trigger.csv, points.csv, claim.csv (of the paper's study), fragility_*.csv, exceedance.csv, confirm.csv,
#          maps.csv, cells.csv, shares.csv, figures/*; <folder>/trigger/<case>: stages and runs
from sph.figures.trigger import MAPS
from sph.experiments.trigger.design import SEARCHED
from sph.paper.study import PaperStudy


wildcard_constraints:
    search="trigger|maps",
    round="[0-9]+",


rule trigger:
    """Critical intensities: tables and figure, of the paper's study the claim."""
    input:
        lambda wildcards: expand(
            "{folder}/trigger/{file}",
            folder=TRIGGER().folder,
            file=["trigger.nc", "trigger.csv", "points.csv"]
            + ["figures/trigger.png", "figures/trigger.pdf"]
            + ["claim.csv"] * isinstance(PLAN.study, PaperStudy),
        ),


rule fragility:
    """Fragility curves over the values of the search: fits, curves and figure."""
    input:
        lambda wildcards: expand(
            "{folder}/trigger/{file}",
            folder=TRIGGER().folder,
            file=["trigger.csv", "points.csv", "fragility_fit.csv"]
            + ["fragility_measures.csv", "exceedance.csv"]
            + ["fragility_annual.csv"] * bool(TRIGGER().trigger.hazard),
        ),


rule confirm:
    """The ends of brackets at another fidelity."""
    input:
        lambda wildcards: f"{TRIGGER().folder}/trigger/confirm.csv",


rule maps:
    """Maps over some dimensions and the intensity: tables and figures."""
    input:
        lambda wildcards: expand(
            "{folder}/trigger/{file}",
            folder=TRIGGER().folder,
            file=["maps.csv", "cells.csv", "shares.csv"],
        ),
        lambda wildcards: expand(
            "{folder}/trigger/figures/{figure}.{kind}",
            folder=TRIGGER().folder,
            figure=list(MAPS),
            kind=["png", "pdf"],
        ),


checkpoint want_points:
    """The points that a round of a search wants, from those of the rounds before it."""
    input:
        points=branch(
            lambda wildcards: int(wildcards.round) > 0,
            then=lambda wildcards: TRIGGER().points(
                wildcards.search, int(wildcards.round) - 1
            ),
        ),
    output:
        "{folder}/trigger/rounds/{search}-{round}-wanted.csv",
    log:
        "{folder}/trigger/logs/{search}-{round}-wanted.log",
    params:
        sources=ANALYSIS,
        lattices=lambda wildcards: [
            lattice.model_dump() for lattice in TRIGGER().lattices(wildcards.search)
        ],
        classes=lambda wildcards: TRIGGER().classes(wildcards.search),
    script:
        "../scripts/trigger/want_points.py"


rule measure_points:
    """Measure the runs of a round and add them to those of the rounds before it."""
    input:
        earlier=branch(
            lambda wildcards: int(wildcards.round) > 0,
            then=lambda wildcards: TRIGGER().points(
                wildcards.search, int(wildcards.round) - 1
            ),
        ),
        wanted="{folder}/trigger/rounds/{search}-{round}-wanted.csv",
        runs=lambda wildcards: TRIGGER().runs(
            checkpoints.want_points.get(**wildcards).output[0], RUN
        ),
    output:
        "{folder}/trigger/rounds/{search}-{round}-points.csv",
    log:
        "{folder}/trigger/logs/{search}-{round}-points.log",
    params:
        sources=ANALYSIS,
        scenes=lambda wildcards: TRIGGER().planned(
            checkpoints.want_points.get(**wildcards).output[0]
        ),
        settings=PLAN.study.metrics.model_dump(),
    script:
        "../scripts/trigger/measure_points.py"


rule searched_points:
    """All points of a search: those of its last round."""
    input:
        lambda wildcards: TRIGGER().points(SEARCHED[wildcards.table]),
    output:
        "{folder}/trigger/{table}.csv",
    log:
        "{folder}/trigger/logs/{table}.log",
    wildcard_constraints:
        table="|".join(SEARCHED),
    script:
        "../scripts/trigger/keep_points.py"


rule trigger_table:
    """Bracket the critical intensities, with the pseudo-static estimate and the sliding block's."""
    input:
        points="{folder}/trigger/points.csv",
        yields=lambda wildcards: sorted(
            {search.file for search in TRIGGER().searches.values()}
        ),
    output:
        nc="{folder}/trigger/trigger.nc",
        csv=report(
            "{folder}/trigger/trigger.csv",
            caption="../report/trigger.rst",
            category="Trigger",
            labels={"shows": "critical intensities"},
        ),
    log:
        "{folder}/trigger/logs/trigger.log",
    params:
        sources=SEARCHING + ANALYSIS,
        scenes=lambda wildcards: TRIGGER().shaken,
        searches=lambda wildcards: TRIGGER().searches,
        classes=lambda wildcards: TRIGGER().classes("trigger"),
        settings=PLAN.study.metrics.model_dump(),
        searched=lambda wildcards: TRIGGER().dimensions,
        highest=lambda wildcards: TRIGGER().trigger.intensity.highest,
        attrs=lambda wildcards: TRIGGER().facts,
    script:
        "../scripts/trigger/measure_trigger.py"


rule fragility_table:
    """Fit fragility curves to the critical intensities, and draw them."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        fits=report(
            "{folder}/trigger/fragility_fit.csv",
            caption="../report/fragility.rst",
            category="Fragility",
            labels={"shows": "fits"},
        ),
        curves="{folder}/trigger/fragility_curves.csv",
        png=report(
            "{folder}/trigger/figures/fragility.png",
            caption="../report/fragility.rst",
            category="Fragility",
            labels={"shows": "figure"},
        ),
        pdf="{folder}/trigger/figures/fragility.pdf",
    log:
        "{folder}/trigger/logs/fragility.log",
    params:
        sources=DRAWING,
        searched=lambda wildcards: TRIGGER().dimensions,
        note=lambda wildcards: f"{TRIGGER().note()} · brackets to {TRIGGER().tolerance}",
    script:
        "../scripts/trigger/measure_fragility.py"


rule fragility_measures:
    """Fit fragility curves in other measures of the shaking, and compare their dispersions."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        report(
            "{folder}/trigger/fragility_measures.csv",
            caption="../report/fragility.rst",
            category="Fragility",
            labels={"shows": "measures of the shaking"},
        ),
    log:
        "{folder}/trigger/logs/measures.log",
    params:
        sources=ANALYSIS,
        scenes=lambda wildcards: TRIGGER().shaken,
        periods=lambda wildcards: TRIGGER().trigger.periods,
        highest=lambda wildcards: TRIGGER().trigger.intensity.highest,
        searched=lambda wildcards: TRIGGER().dimensions,
    script:
        "../scripts/trigger/compare_measures.py"


rule fragility_annual:
    """How often a year each class is reached, from the fragility and the hazard of the site."""
    input:
        critical="{folder}/trigger/trigger.csv",
        hazard=lambda wildcards: TRIGGER().hazard_file,
    output:
        report(
            "{folder}/trigger/fragility_annual.csv",
            caption="../report/fragility.rst",
            category="Fragility",
            labels={"shows": "annual frequencies"},
        ),
    log:
        "{folder}/trigger/logs/annual.log",
    params:
        sources=ANALYSIS,
        span=lambda wildcards: (
            TRIGGER().trigger.intensity.lowest,
            TRIGGER().trigger.intensity.highest,
        ),
        searched=lambda wildcards: TRIGGER().dimensions,
    script:
        "../scripts/trigger/measure_annual.py"


rule exceedance:
    """Share of the motions whose run-out or displacement exceeds a length: table and figure."""
    input:
        points="{folder}/trigger/points.csv",
    output:
        csv=report(
            "{folder}/trigger/exceedance.csv",
            caption="../report/exceedance.rst",
            category="Fragility",
            labels={"shows": "exceedance of run-out and displacement"},
        ),
        png=report(
            "{folder}/trigger/figures/exceedance.png",
            caption="../report/exceedance.rst",
            category="Fragility",
            labels={"shows": "figure of the exceedance"},
        ),
        pdf="{folder}/trigger/figures/exceedance.pdf",
    log:
        "{folder}/trigger/logs/exceedance.log",
    params:
        sources=DRAWING,
        scenes=lambda wildcards: TRIGGER().shaken,
        searched=lambda wildcards: TRIGGER().dimensions,
        note=lambda wildcards: TRIGGER().note(),
    script:
        "../scripts/trigger/measure_exceedance.py"


rule trigger_claim:
    """Decide the paper's claim on the critical amplitudes."""
    input:
        critical=lambda wildcards: OF_PAPER("the claims")
        and f"{wildcards.folder}/trigger/trigger.csv",
    output:
        report(
            "{folder}/trigger/claim.csv",
            caption="../report/trigger_claim.rst",
            category="Trigger",
            labels={"shows": "the paper's claim"},
        ),
    log:
        "{folder}/trigger/logs/claim.log",
    params:
        sources=ANALYSIS + PAPER,
    script:
        "../scripts/paper/decide_trigger.py"


checkpoint want_confirmation:
    """The ends of brackets that are run again at another fidelity."""
    input:
        critical="{folder}/trigger/trigger.csv",
        points="{folder}/trigger/points.csv",
    output:
        "{folder}/trigger/rounds/confirm-wanted.csv",
    log:
        "{folder}/trigger/logs/confirm-wanted.log",
    params:
        sources=ANALYSIS,
        confirm=lambda wildcards: TRIGGER().confirm,
        searched=lambda wildcards: TRIGGER().dimensions,
    script:
        "../scripts/trigger/want_confirmation.py"


rule confirm_table:
    """Compare the ends of brackets at both fidelities."""
    input:
        points="{folder}/trigger/points.csv",
        ends="{folder}/trigger/rounds/confirm-wanted.csv",
        runs=lambda wildcards: TRIGGER().runs(
            checkpoints.want_confirmation.get(**wildcards).output[0],
            RUN,
            TRIGGER().confirm["fidelity"],
        ),
    output:
        report(
            "{folder}/trigger/confirm.csv",
            caption="../report/trigger_confirm.rst",
            category="Trigger",
            labels={"shows": "confirmed brackets"},
        ),
    log:
        "{folder}/trigger/logs/confirm.log",
    params:
        sources=ANALYSIS,
        scenes=lambda wildcards: TRIGGER().planned(
            checkpoints.want_confirmation.get(**wildcards).output[0],
            TRIGGER().confirm["fidelity"],
        ),
        settings=PLAN.study.metrics.model_dump(),
        searched=lambda wildcards: TRIGGER().dimensions,
    script:
        "../scripts/trigger/confirm_trigger.py"


rule map_tables:
    """The cells of the maps, and the shares of the values searched that reach each class."""
    input:
        points="{folder}/trigger/maps.csv",
    output:
        cells="{folder}/trigger/cells.csv",
        shares=report(
            "{folder}/trigger/shares.csv",
            caption="../report/map_shares.rst",
            category="Maps",
            labels={"shows": "shares of each class"},
        ),
    log:
        "{folder}/trigger/logs/cells.log",
    params:
        sources=ANALYSIS,
        lattices=lambda wildcards: [
            lattice.model_dump() for lattice in TRIGGER().lattices("maps")
        ],
        classes=lambda wildcards: TRIGGER().classes("maps"),
        levels=lambda wildcards: TRIGGER().levels("maps"),
        searched=lambda wildcards: TRIGGER().dimensions,
    script:
        "../scripts/trigger/measure_maps.py"


rule trigger_figure:
    """Draw the critical intensities."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        png=report(
            "{folder}/trigger/figures/trigger.png",
            caption="../report/trigger_figure.rst",
            category="Trigger",
            labels={"shows": "figure"},
        ),
        pdf="{folder}/trigger/figures/trigger.pdf",
    log:
        "{folder}/trigger/logs/figure-trigger.log",
    params:
        sources=DRAWING,
        figure="trigger",
        searched=lambda wildcards: TRIGGER().dimensions,
        note=lambda wildcards: (
            f"{TRIGGER().note()} · brackets to {TRIGGER().tolerance}"
        ),
    script:
        "../scripts/trigger/draw_trigger.py"


rule map_figure:
    """Draw a map, or the shares."""
    input:
        points="{folder}/trigger/maps.csv",
        shares="{folder}/trigger/shares.csv",
    output:
        png=report(
            "{folder}/trigger/figures/{figure}.png",
            caption="../report/map_figure.rst",
            category="Maps",
            labels={"shows": "figure {figure}"},
        ),
        pdf="{folder}/trigger/figures/{figure}.pdf",
    log:
        "{folder}/trigger/logs/figure-{figure}.log",
    wildcard_constraints:
        figure="|".join(MAPS),
    params:
        sources=DRAWING,
        figure=lambda wildcards: wildcards.figure,
        searched=lambda wildcards: TRIGGER().dimensions,
        note=lambda wildcards: TRIGGER().note("maps"),
    script:
        "../scripts/trigger/draw_trigger.py"
