# Purpose: the experiments whose runs stand alone, each a target: what a saving of time costs in accuracy (`snakemake --cores 2 trade`;
#          `resolution` for the scheme of one's own slopes), what the answers rest on (`limits`), how far the solver can be pushed (`extremes`).
# Inputs:  config/<name>.yaml (config: experiments); the sources of solver, analysis and drawing.
# Outputs: results/<name>: runs/**/*.nc, tables, figures/*
import functools

from sph.scene.names import check_known
from sph.experiments.registry import EXPERIMENTS, NAMES
from sph.figures import experiment_figures

check_known("config: experiments", PLAN.study.experiments, NAMES)


def shown(path, title, label, own):
    """A result in the report, with a caption of its own where there is one; without a label it stays out."""
    if not label:
        return path
    known = (SPH.parent / "workflow" / "report" / f"{own}.rst").is_file()
    return report(
        path,
        caption=f"../report/{own if known else 'experiment'}.rst",
        category=title,
        labels={"shows": label},
    )


for experiment in EXPERIMENTS.values():
    name, title, folder = experiment.name, experiment.title, experiment.folder
    figures = experiment_figures(name)
    # Read and checked once a rule of the experiment is asked for.
    design = functools.cache(
        functools.partial(experiment.load, PLAN.study.file_of(name), PLAN, FOLDERS)
    )
    RUN_OF[folder] = lambda run, design=design: design().runs[run]

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
            lambda wildcards, design=design, folder=folder: [
                f"{folder}/runs/{run}.nc" for run in design().runs
            ],
        output:
            [
                shown(
                    f"{folder}/{file}", title, table.shows, f"{name}_{Path(file).stem}"
                )
                for file, table in experiment.tables.items()
            ],
        log:
            f"{folder}/logs/{name}.log",
        params:
            sources=SOLVER + ANALYSIS,
            experiment=name,
            about=experiment.about,
            parameters=lambda wildcards, design=design: design().parameters,
            scenes=lambda wildcards, design=design: {
                key: planned(run.scene) for key, run in design().runs.items()
            },
            settings=PLAN.study.metrics.model_dump(),
        script:
            "../scripts/experiments/measure.py"

    for figure in figures:
        # The log of the name of the experiment is that of its tables.
        own = figure == name

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
                png=shown(
                    f"{folder}/figures/{figure}.png",
                    title,
                    "figure" if own else f"figure {figure}",
                    f"{name}_figure",
                ),
                pdf=f"{folder}/figures/{figure}.pdf",
            log:
                f"{folder}/logs/{'figure' if own else figure}.log",
            params:
                sources=DRAWING,
                experiment=name,
                about=experiment.about,
                figure=figure,
            script:
                "../scripts/experiments/draw.py"
