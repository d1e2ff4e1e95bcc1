# Purpose: the experiments whose runs stand alone, each a target: what a saving of time costs in accuracy (`snakemake --cores 2 trade`;
#          `resolution` for the scheme of one's own slopes), what the answers rest on (`limits`), how far the solver can be pushed (`extremes`).
# Inputs:  config/<name>.yaml (config: experiments); the sources of solver, analysis and drawing.
# Outputs: results/<name>: runs/**/*.nc, tables, figures/*
from sph.scene.names import check_known
from sph.experiments.registry import EXPERIMENTS, NAMES
from sph.figures import experiment_figures

check_known("config: experiments", PLAN.study.experiments, NAMES)


for experiment in EXPERIMENTS.values():
    name, title, folder = experiment.name, experiment.title, experiment.folder
    figures = experiment_figures(name)

    rule:
        """An experiment: tables and figures."""
        name:
            name
        input:
            expand("{folder}/{table}", folder=folder, table=experiment.tables),
            expand(
                "{folder}/figures/{figure}.{kind}",
                folder=folder,
                figure=figures,
                kind=["png", "pdf"],
            ),

    rule:
        """Measure every run of an experiment."""
        name:
            f"{name}_table"
        input:
            lambda wildcards, name=name: [
                run.file for run in CATALOGUE.alone(name).values()
            ],
        output:
            list(
                made(
                    folder,
                    title,
                    {file: table.shows for file, table in experiment.tables.items()},
                )
            ),
        log:
            f"{folder}/logs/{name}.log",
        params:
            sources=SOLVER + ANALYSIS,
            experiment=name,
            about=experiment.about,
            parameters=lambda wildcards, name=name: CATALOGUE.design(name).parameters,
            scenes=lambda wildcards, name=name: {
                key: planned(run.scene) for key, run in CATALOGUE.alone(name).items()
            },
            settings=PLAN.study.metrics.model_dump(),
        script:
            "../scripts/experiments/measure.py"

    for figure in figures:

        rule:
            """Draw a figure of an experiment."""
            name:
                f"{name}_figure_{figure}"
            input:
                [
                    f"{folder}/{file}"
                    for file in experiment.tables
                    if file.endswith(".csv")
                ],
            output:
                list(made(folder, title, {f"figures/{figure}": f"figure {figure}"})),
            log:
                f"{folder}/logs/figure_{figure}.log",
            params:
                sources=DRAWING,
                experiment=name,
                about=caption_of(figures[figure]),
                figure=figure,
            script:
                "../scripts/experiments/draw.py"
