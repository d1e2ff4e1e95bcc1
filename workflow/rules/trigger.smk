# Purpose: the shaking at which a slope fails (`snakemake --cores 2 trigger`), the probability of it (fragility), brackets repeated at
#          another fidelity (confirm), and maps (maps).
# Inputs:  config/trigger.yaml (config: experiments); runs of the catalogue, which follow from the tables of earlier rounds.
# Outputs: trigger/ in the folder of the study at the fidelity of the search: tables, figures, and the points of every round in rounds/
from sph.experiments.trigger import measure as searches
from sph.experiments.trigger.design import SEARCHED
from sph.experiments.trigger.figures import MAPPED
from sph.study.searches import slope_searches


include: "functions/trigger.smk"


wildcard_constraints:
    search="trigger|maps",
    round="[0-9]+",


checkpoint want_points:
    """List the points of a round of a search."""
    input:
        points=earlier_points,
    output:
        "{folder}/trigger/rounds/{search}-{round}-wanted.csv",
    log:
        "{folder}/trigger/logs/{search}-{round}-wanted.log",
    params:
        **made_by(
            searches.want_points,
            lambda wildcards: {
                "lattices": CATALOGUE.trigger.lattices(wildcards.search),
                "classes": CATALOGUE.trigger.classes(wildcards.search),
                "number": int(wildcards.round),
            },
        ),
    script:
        "../scripts/make.py"


rule measure_points:
    """Measure the runs of a round of a search."""
    input:
        wanted="{folder}/trigger/rounds/{search}-{round}-wanted.csv",
        points=earlier_points,
        runs=files(wanted_in_round),
    output:
        "{folder}/trigger/rounds/{search}-{round}-points.csv",
    log:
        "{folder}/trigger/logs/{search}-{round}-points.log",
    params:
        **made_by(
            searches.measure_points,
            lambda wildcards: {"settings": SETTINGS},
            wanted_in_round,
        ),
    script:
        "../scripts/make.py"


rule searched_points:
    """Keep all points of a search, of those for critical intensities or of the maps."""
    input:
        points=lambda wildcards: CATALOGUE.trigger.points(SEARCHED[wildcards.table]),
    output:
        "{folder}/trigger/{table}.csv",
    log:
        "{folder}/trigger/logs/{table}.log",
    wildcard_constraints:
        table="|".join(SEARCHED),
    params:
        **made_by(searches.searched_points),
    script:
        "../scripts/make.py"


rule trigger_table:
    """Find the critical intensities, with the estimates of simpler methods."""
    input:
        lambda wildcards: sorted(
            {search.file for search in CATALOGUE.trigger.searches.values()}
        ),
        points="{folder}/trigger/points.csv",
    output:
        "{folder}/trigger/trigger.nc",
        shown("{folder}/trigger/trigger.csv", "Trigger", "critical intensities"),
    log:
        "{folder}/trigger/logs/trigger_table.log",
    params:
        **made_by(
            searches.trigger_table,
            lambda wildcards: {
                "searches": slope_searches(CATALOGUE.trigger.searches),
                "scenes": CATALOGUE.trigger.shaken,
                "classes": CATALOGUE.trigger.classes("trigger"),
                "settings": SETTINGS,
                "searched": CATALOGUE.trigger.dimensions,
                "highest": CATALOGUE.trigger.trigger.intensity.highest,
                "facts": CATALOGUE.trigger.facts,
            },
            searches=True,
        ),
    script:
        "../scripts/make.py"


rule trigger_figure:
    """Draw the critical intensities."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        shown("{folder}/trigger/figures/trigger.png", "Trigger", "figure"),
        "{folder}/trigger/figures/trigger.pdf",
    log:
        "{folder}/trigger/logs/trigger_figure.log",
    params:
        **made_by(searches.draw_trigger, brackets, draws=True),
    script:
        "../scripts/make.py"


rule fragility_table:
    """Fit the fragility to the brackets."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        shown("{folder}/trigger/fragility_fit.csv", "Trigger", "fits"),
        "{folder}/trigger/fragility_curves.csv",
        shown(
            "{folder}/trigger/figures/fragility.png",
            "Trigger",
            "figure of the fragility",
        ),
        "{folder}/trigger/figures/fragility.pdf",
    log:
        "{folder}/trigger/logs/fragility_table.log",
    params:
        **made_by(searches.fragility_table, brackets, draws=True),
    script:
        "../scripts/make.py"


rule fragility_measures:
    """Fit the fragility in other measures of the shaking."""
    input:
        critical="{folder}/trigger/trigger.csv",
    output:
        shown(
            "{folder}/trigger/fragility_measures.csv",
            "Trigger",
            "measures of the shaking",
        ),
    log:
        "{folder}/trigger/logs/fragility_measures.log",
    params:
        **made_by(
            searches.fragility_measures,
            lambda wildcards: {
                "scenes": CATALOGUE.trigger.shaken,
                "periods": CATALOGUE.trigger.trigger.periods,
                "highest": CATALOGUE.trigger.trigger.intensity.highest,
                "searched": CATALOGUE.trigger.dimensions,
            },
        ),
    script:
        "../scripts/make.py"


rule fragility_annual:
    """Join the fragility with the hazard of the site."""
    input:
        critical="{folder}/trigger/trigger.csv",
        hazard=lambda wildcards: CATALOGUE.trigger.hazard_file,
    output:
        shown("{folder}/trigger/fragility_annual.csv", "Trigger", "annual frequencies"),
    log:
        "{folder}/trigger/logs/fragility_annual.log",
    params:
        **made_by(
            searches.fragility_annual,
            lambda wildcards: {
                "span": (
                    CATALOGUE.trigger.trigger.intensity.lowest,
                    CATALOGUE.trigger.trigger.intensity.highest,
                ),
                "searched": CATALOGUE.trigger.dimensions,
            },
        ),
    script:
        "../scripts/make.py"


rule exceedance:
    """Count the motions whose run-out or displacement exceeds a length."""
    input:
        points="{folder}/trigger/points.csv",
    output:
        shown(
            "{folder}/trigger/exceedance.csv",
            "Trigger",
            "exceedance of run-out and displacement",
        ),
        shown(
            "{folder}/trigger/widths.csv",
            "Trigger",
            "widths that debris does not pass",
        ),
        shown(
            "{folder}/trigger/figures/exceedance.png",
            "Trigger",
            "figure of the exceedance",
        ),
        "{folder}/trigger/figures/exceedance.pdf",
    log:
        "{folder}/trigger/logs/exceedance.log",
    params:
        **made_by(
            searches.reach,
            lambda wildcards: {
                "scenes": CATALOGUE.trigger.shaken,
                "searched": CATALOGUE.trigger.dimensions,
                "note": CATALOGUE.trigger.note(),
            },
            draws=True,
        ),
    script:
        "../scripts/make.py"


checkpoint want_confirmation:
    """List the ends of brackets that are repeated at another fidelity."""
    input:
        critical="{folder}/trigger/trigger.csv",
        points="{folder}/trigger/points.csv",
    output:
        "{folder}/trigger/rounds/confirm-wanted.csv",
    log:
        "{folder}/trigger/logs/want_confirmation.log",
    params:
        **made_by(
            searches.want_confirmation,
            lambda wildcards: {
                "confirm": CATALOGUE.trigger.confirm,
                "searched": CATALOGUE.trigger.dimensions,
            },
        ),
    script:
        "../scripts/make.py"


rule confirm_table:
    """Compare the ends of brackets with those at another fidelity."""
    input:
        points="{folder}/trigger/points.csv",
        ends="{folder}/trigger/rounds/confirm-wanted.csv",
        runs=files(confirming_runs),
    output:
        shown("{folder}/trigger/confirm.csv", "Trigger", "confirmed brackets"),
    log:
        "{folder}/trigger/logs/confirm_table.log",
    params:
        **made_by(
            searches.confirm_ends,
            lambda wildcards: {
                "settings": SETTINGS,
                "searched": CATALOGUE.trigger.dimensions,
            },
            confirming_runs,
        ),
    script:
        "../scripts/make.py"


rule map_tables:
    """Bound the share of the values with which each class is reached."""
    input:
        points="{folder}/trigger/maps.csv",
    output:
        "{folder}/trigger/cells.csv",
        shown("{folder}/trigger/shares.csv", "Trigger", "shares of each class"),
    log:
        "{folder}/trigger/logs/map_tables.log",
    params:
        **made_by(
            searches.map_tables,
            lambda wildcards: {
                "lattices": CATALOGUE.trigger.lattices("maps"),
                "classes": CATALOGUE.trigger.classes("maps"),
                "levels": CATALOGUE.trigger.levels("maps"),
                "searched": CATALOGUE.trigger.dimensions,
            },
        ),
    script:
        "../scripts/make.py"


rule map_figure_shares:
    """Draw the shares."""
    input:
        shares="{folder}/trigger/shares.csv",
    output:
        shown("{folder}/trigger/figures/shares.png", "Trigger", "figure of the shares"),
        "{folder}/trigger/figures/shares.pdf",
    log:
        "{folder}/trigger/logs/map_figure_shares.log",
    params:
        **made_by(searches.draw_shares, mapped, draws=True),
    script:
        "../scripts/make.py"


rule map_figure:
    """Draw the map of the class or of another quantity."""
    input:
        points="{folder}/trigger/maps.csv",
    output:
        shown(
            "{folder}/trigger/figures/map-{quantity}.png",
            "Trigger",
            "figure map-{quantity}",
        ),
        "{folder}/trigger/figures/map-{quantity}.pdf",
    log:
        "{folder}/trigger/logs/map_figure_{quantity}.log",
    wildcard_constraints:
        quantity="|".join(["class", *MAPPED]),
    params:
        **made_by(
            searches.draw_map,
            lambda wildcards: {"name": wildcards.quantity, **mapped(wildcards)},
            draws=True,
        ),
    script:
        "../scripts/make.py"


rule trigger:
    """The shaking at which the slope fails; for the paper's study also its claim on that."""
    input:
        searched_files(
            "trigger.nc",
            "trigger.csv",
            "points.csv",
            "figures/trigger.png",
            "figures/trigger.pdf",
        ),
        claim_on_trigger,


rule fragility:
    """The probability that the slope fails, over the motions of the search."""
    input:
        searched_files(
            "trigger.csv",
            "points.csv",
            "fragility_fit.csv",
            "fragility_measures.csv",
            "exceedance.csv",
            "widths.csv",
        ),
        lambda wildcards: (
            [CATALOGUE.trigger.file("fragility_annual.csv")]
            if CATALOGUE.trigger.trigger.hazard
            else []
        ),


rule confirm:
    """Brackets repeated at another fidelity."""
    input:
        searched_files("confirm.csv"),


rule maps:
    """Maps over the dimensions of the search and the shaking."""
    input:
        searched_files(
            "maps.csv",
            "cells.csv",
            "shares.csv",
            *expand(
                "figures/{name}.{suffix}",
                name=["shares", "map-class", *(f"map-{name}" for name in MAPPED)],
                suffix=["png", "pdf"],
            ),
        ),
